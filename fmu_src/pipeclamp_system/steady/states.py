"""Steady states of pipe and clamps, and the response that they make."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_system.steady.clamp import SAMPLES_PER_CYCLE, sampled

CLOSE_ENDS_SHARE = 1e-3
"""Share of the frequency by which two curves end apart that nothing bounds, and end at one resonance."""

RUN_IT = "; run sines there in time by `pipeclamp cosim`"
"""Said where steady states are missing."""

NEUTRAL_GROWTH = 1e-6
"""Share by which a disturbance changes in a cycle and still is kept: steel by itself takes 6e-5 of it at least."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A periodic motion of pipe and clamps.

    Attributes:
        frequency: of the excitation, Hz.
        clamps: harmonics of each clamp's displacement, mm, (clamps, h), h being H + 1 or more: what a step of force
            makes beyond H is there too.
        probes: harmonics of each probe's displacement, mm, (probes, h).
        forces: harmonics of the force into each clamp, N, (clamps, H + 1).
        conditions: A (mm) and f (Hz) that each clamp's law was taken for, (clamps, 2).
        growth: of the disturbance that grows fastest, 1/s; below 0 where the motion is stable.
        truncated: rms of the harmonics that are left out, as a share of that of the motion, where it is largest.
        beyond: each clamp's conditions that lie beyond its law's data, by name: A (mm), f (Hz), T (K), further ones.
        side: of a curve's state, as of `Solution`: it changes where a branch leaves the curve.
        cycles: that were marched where the motion was found in time; its harmonics aren't balanced then, its growth is
            the rate at which it came to repeat, and truncated is what halving the steps changed. None: it is balanced.
        unbounded: whether nothing bounds it, as of `DrivenPipe.unbounded`: a curve ends there.
    """

    frequency: float
    clamps: ComplexArray
    probes: ComplexArray
    forces: ComplexArray
    conditions: Array
    growth: float
    truncated: float
    beyond: tuple[Mapping[str, float], ...]
    side: int = 0
    cycles: int | None = None
    unbounded: bool = False

    @property
    def harmonics(self) -> int:
        """H, up to which the motion is balanced."""
        return int(self.forces.shape[1]) - 1

    @property
    def balanced(self) -> ComplexArray:
        """The harmonics of each clamp's displacement that are balanced, mm, (clamps, H + 1)."""
        return self.clamps[:, : self.harmonics + 1]

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return self.growth < 0

    @property
    def neutral(self) -> bool:
        """Whether small disturbances neither grow nor die out, for lack of damping: beside rounding."""
        return abs(self.growth) <= NEUTRAL_GROWTH * self.frequency


@dataclass(frozen=True, eq=False)
class Unsteady:
    """A motion that isn't the same in each cycle of the excitation.

    Attributes:
        frequency: of the excitation, Hz.
        round: cycles in which it comes round; 0 where it doesn't.
        cycles: that were marched.
        low, high: smallest and largest half peak-to-peak displacement of a cycle, mm, of the clamps, then the probes.
    """

    frequency: float
    round: int
    cycles: int
    low: tuple[float, ...]
    high: tuple[float, ...]


def in_a_row(*pieces: tuple[SteadyState, ...]) -> tuple[SteadyState, ...]:
    """Give the states of all pieces of a response."""
    return tuple(chain.from_iterable(pieces))


@dataclass(frozen=True, eq=False)
class FollowedResponse:
    """A frequency response as far as it could be followed.

    Attributes:
        pieces: states from end to end; or what was followed from each end until it was given up, the lower one first.
        whole: whether it is one piece from end to end.
        in_time: states that were found in time where it was given up: upwards in frequency, then where it differs
            what was found downwards.
        unsteady: motions there that aren't the same in each cycle.
    """

    pieces: tuple[tuple[SteadyState, ...], ...]
    whole: bool
    in_time: tuple[tuple[SteadyState, ...], ...] = ()
    unsteady: tuple[Unsteady, ...] = ()

    @property
    def states(self) -> tuple[SteadyState, ...]:
        """The states of all pieces, and those that were found in time."""
        return in_a_row(*self.pieces, *self.in_time)

    @property
    def complete(self) -> bool:
        """Whether a steady motion is known from end to end."""
        return self.whole or bool(self.in_time and not self.unsteady)

    @property
    def unbounded(self) -> tuple[float, ...]:
        """Frequencies, Hz, at which a piece ends as nothing bounds it, from the lowest on."""
        return tuple(sorted(state.frequency for state in in_a_row(*self.pieces) if state.unbounded))

    def reach(self) -> str:
        """Say which frequencies the pieces reach."""
        frequencies = [[state.frequency for state in piece] for piece in self.pieces]
        ranges = " and ".join(f"from {min(piece):.4g} to {max(piece):.4g} Hz" for piece in frequencies)
        return f"followed {ranges} only: what lies {'between them' if len(self.pieces) > 1 else 'beyond'} is missing"


def half_range(harmonics: ComplexArray) -> Array:
    """Give half the peak-to-peak value of motions given by their harmonics, (points,)."""
    return np.asarray(np.ptp(sampled(harmonics, SAMPLES_PER_CYCLE), axis=1) / 2)


def amplitudes_of(state: SteadyState) -> tuple[float, ...]:
    """Give half the peak-to-peak displacement of each clamp and probe, mm."""
    return tuple(half_range(np.vstack([state.clamps, state.probes])).tolist())


def span(low: float, high: float) -> str:
    """Say a range of frequencies, Hz."""
    return f"at {low:.4g} Hz" if f"{low:.4g}" == f"{high:.4g}" else f"from {low:.4g} to {high:.4g} Hz"


def about_missing(followed: FollowedResponse) -> str:
    """Say what isn't balanced, and what was found there in time."""
    if followed.whole:
        return ""
    if followed.unbounded:
        return f"; {about_unbounded(followed)}"
    found, unsteady = [state for way in followed.in_time for state in way], followed.unsteady
    if not found and not unsteady:
        return f"; {followed.reach()}{RUN_IT}"
    frequencies = [state.frequency for state in found] + [one.frequency for one in unsteady]
    words = f"; found in time {span(min(frequencies), max(frequencies))}, where nothing is balanced: "
    if found:
        error = max(state.truncated for state in found)
        words += f"{len(found)} motions that repeat, to {error:.2%}"
    for way in followed.in_time[1:]:
        words += f"; another one {span(way[0].frequency, way[-1].frequency)}, downwards in frequency"
    for again in dict.fromkeys(one.round for one in unsteady):
        own = [one for one in unsteady if one.round == again]
        how = f"comes round in {again} cycles only" if again else "doesn't come round"
        at = span(min(one.frequency for one in own), max(one.frequency for one in own))
        high = max(max(one.high) for one in own)
        words += f"; the motion {how} at {len(own)} frequencies {at}, and goes as far as {high:.3g} mm"
    return words


def about_unbounded(followed: FollowedResponse) -> str:
    """Say where nothing bounds a response; curves that end there from both sides are no farther apart than rounding."""
    apart: list[float] = []
    for frequency in followed.unbounded:
        apart += [] if apart and frequency <= (1 + CLOSE_ENDS_SHARE) * apart[-1] else [frequency]
    return f"not bounded about {' and '.join(f'{frequency:.4g} Hz' for frequency in apart)}, for lack of damping"
