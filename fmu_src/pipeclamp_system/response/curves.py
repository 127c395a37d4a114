"""Curves of a frequency response, and the co-simulations on them, as they were found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

from pipeclamp_models.law.file import Interval
from pipeclamp_system.response.dots import Dot
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE
from pipeclamp_system.steady.states import FollowedResponse, SteadyState, amplitudes_of, in_a_row


@dataclass(frozen=True)
class Curve:
    """A frequency response at one temperature of the clamps and one level of the excitation.

    Attributes:
        temperature: degC; None where each clamp has its own.
        level: factor on the excitation's amplitude.
        followed: states along the curve, round its turning points.
        detached: branches that nothing joins to it in its range.
        leaving: branches that leave it, or one of those.
        sought_whole: whether they were sought to the end; else there may be more.
    """

    temperature: float | None
    level: float
    followed: FollowedResponse
    detached: tuple[tuple[SteadyState, ...], ...] = ()
    leaving: tuple[tuple[SteadyState, ...], ...] = ()
    sought_whole: bool = True

    @property
    def pieces(self) -> tuple[tuple[SteadyState, ...], ...]:
        """All pieces, the detached ones last."""
        return (*self.followed.pieces, *self.leaving, *self.detached)

    @property
    def states(self) -> tuple[SteadyState, ...]:
        """The states of all pieces, and those that were found in time."""
        return in_a_row(*self.pieces, *self.followed.in_time)


@dataclass(frozen=True)
class FrequencyResponse:
    """All curves of a system and the co-simulations on them.

    Attributes:
        name: of the system.
        clamp_names: those with a law; probe_names: of the pipe. `amplitudes` are in this order.
        excitation: what shakes the pipe, in words.
        curves, dots: what was found.
        ranges: what each clamp's law holds data for, by condition, in the order of clamp_names.
        stated_harmonics: whether their number was told; else each motion has as many as it asks for.
        leaves_rest: that clamps push the pipe out of its rest, at each temperature at which they do, in words.
    """

    name: str
    clamp_names: tuple[str, ...]
    probe_names: tuple[str, ...]
    excitation: str
    curves: tuple[Curve, ...]
    dots: tuple[Dot, ...]
    ranges: tuple[Mapping[str, Interval], ...]
    stated_harmonics: bool = False
    leaves_rest: tuple[str, ...] = ()

    @property
    def points(self) -> tuple[str, ...]:
        """Names of all clamps and probes."""
        return (*self.clamp_names, *self.probe_names)

    @property
    def left_out(self) -> bool:
        """Whether harmonics that are left out would move a motion by more than can be overlooked."""
        return any(
            state.truncated > DOUBTFUL_SHARE for curve in self.curves for piece in curve.pieces for state in piece
        )

    @property
    def doubtful_dots(self) -> tuple[Dot, ...]:
        """The co-simulations that aren't to be trusted."""
        return tuple(dot for dot in self.dots if not dot.trusted)


def stretches(
    pieces: Iterable[Sequence[SteadyState]], told: Callable[[SteadyState], bool]
) -> list[tuple[float, float]]:
    """Give least and largest frequency (Hz) of each stretch of which something is told; those that overlap are one."""
    found: list[tuple[float, float]] = []
    for piece in pieces:
        for is_told, states in groupby(piece, key=told):
            if is_told:
                frequencies = [state.frequency for state in states]
                found.append((min(frequencies), max(frequencies)))
    apart: list[tuple[float, float]] = []
    for low, high in sorted(found):
        if apart and low <= apart[-1][1]:
            apart[-1] = apart[-1][0], max(high, apart[-1][1])
        else:
            apart.append((low, high))
    return apart


def label(temperature: float | None, level: float) -> str:
    """Name a curve."""
    return f"{'' if temperature is None else f'{temperature:g} °C, '}level {level:g}"


def peaks_of(curve: Curve) -> list[tuple[float, float]]:
    """Give the amplitude (mm) and the frequency (Hz) of a curve's highest state at each clamp and probe."""
    points = range(len(amplitudes_of(curve.states[0])))
    return [max((amplitudes_of(state)[point], state.frequency) for state in curve.states) for point in points]
