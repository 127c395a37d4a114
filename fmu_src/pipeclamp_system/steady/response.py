"""The frequency response of a coupled system: steady states by harmonic balance, co-simulations as dots on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import groupby, repeat
from pathlib import Path

import numpy as np

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.tables import pl
from pipeclamp_models.law.file import Interval
from pipeclamp_system.cosim.building import finished, law_in
from pipeclamp_system.cosim.static_stability import about_rest
from pipeclamp_system.description.system import ResponseTable, SystemDescription
from pipeclamp_system.description.trust_mark import doubt
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.described import ranges_of, read_responding, steady_system
from pipeclamp_system.steady.detached import detached_branches, leaving_branches
from pipeclamp_system.steady.dots import MOST_HALVINGS, Dot, Rest, co_simulated
from pipeclamp_system.steady.equivalent import LEAST_LOSS_FACTOR
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE
from pipeclamp_system.steady.states import (
    FollowedResponse,
    SteadyState,
    Unsteady,
    about_missing,
    half_range,
    in_a_row,
    span,
)

LACK_OF_DAMPING = (
    "where it isn't bounded, a curve ends as a clamp moves farther than the pipe is long, while pipe and clamps take "
    f"up less than steel does by itself (loss factor {LEAST_LOSS_FACTOR:g}); branches apart aren't sought then. Give "
    "the pipe the damping that it has ([damping] in its file), or its clamps a law with damping"
)
"""Said of a response that nothing bounds."""

SEARCH_TIMES, LEAST_SEARCH, MOST_SEARCH = 4.0, 1.5e6, 8e6
"""Times the work of the curve itself that may be done to seek further branches, the least that may be, and the most of
all: some minutes."""

SEARCH_ENDED = (
    "further branches were not sought to the end, which takes more work than is allowed: there may be more; a narrower "
    "range of [response] is sought through"
)
"""Said of a curve whose search was cut short."""

AT_AN_END = " (where the range ends)"
"""Said of what is highest there: a resonance may lie beyond."""

UNBOUNDED = " (where it isn't bounded)"
"""Likewise: a curve that rises there without end is followed no farther."""


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


AMOUNTS = {
    "acceleration_m_s2": "acceleration {:g} m/s²",
    "displacement_mm": "displacement {:g} mm",
    "force_N": "force {:g} N",
}
"""What shakes the pipe at level 1, in words, by the key of a system's excitation."""


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

    def summary(self) -> str:
        """Give peaks, unstable branches and how well the two ways agree, for a person to read."""
        lines = [f"system {self.name!r}, level 1: {self.excitation}"]
        for curve in self.curves:
            peaks = peaks_of(curve)
            frequencies = [state.frequency for state in curve.states]
            ends = dict.fromkeys(frequencies, "") | {end(frequencies): AT_AN_END for end in (min, max)}
            ends |= {state.frequency: UNBOUNDED for state in curve.states if state.unbounded}
            peak_text = ", ".join(
                # the highest of the states that were found, no more
                f"{name} {peak:.3g} mm at {frequency:.3g} Hz{ends[frequency]}"
                for name, (peak, frequency) in zip(self.points, peaks, strict=True)
            )
            unstable = _spans(stretches(curve.pieces, lambda state: not (state.stable or state.neutral)))
            neutral = _spans(stretches(curve.pieces, lambda state: state.neutral))
            branch = f"; unstable {unstable}" if unstable else ""
            branch += f"; neither stable nor unstable, as nothing damps it, {neutral}" if neutral else ""
            broken = about_missing(curve.followed)
            apart = "".join(
                f"; {about(piece)}"
                for about, of_kind in ((_about_leaving, curve.leaving), (_about_detached, curve.detached))
                for piece in of_kind
            )
            lines.append(
                f"{label(curve.temperature, curve.level)}: peak {peak_text}{branch}{apart}{broken}"
                f"{_about_search(curve)}"
            )
        lines += [LACK_OF_DAMPING] if any(curve.followed.unbounded for curve in self.curves) else []
        lines += [f"warning: {words}" for words in self.leaves_rest]
        lines += self._about_harmonics()
        lines += self.about_ranges()
        lines += self._about_dots() if self.dots else []
        return "\n".join(lines)

    def _about_harmonics(self) -> list[str]:
        """Say how many harmonics were balanced, and what is left out."""
        if not self.clamp_names:
            return []
        states = [state for curve in self.curves for piece in curve.pieces for state in piece]
        if not states:
            return []
        counts = [state.harmonics for state in states]
        span = f"{min(counts)}" if min(counts) == max(counts) else f"{min(counts)} to {max(counts)}"
        worst = max(states, key=lambda state: state.truncated)
        line = (
            f"harmonics balanced: {span}; those that are left out would move {worst.truncated:.1%} of the motion at "
            f"most, at {worst.frequency:.4g} Hz"
        )
        if worst.truncated <= DOUBTFUL_SHARE:
            return [line]
        pieces = [piece for curve in self.curves for piece in curve.pieces]
        doubtful = _spans(stretches(pieces, lambda state: state.truncated > DOUBTFUL_SHARE))
        more = "the force steps there, or more can't be balanced; co-simulate there"
        if self.stated_harmonics:
            more = "leave harmonics out of [response], so that they follow the motion"
        return [doubt(f"{line}; more than {DOUBTFUL_SHARE:.0%} {doubtful}: {more}")]

    def about_ranges(self) -> list[str]:
        """Say where a clamp's law is used beyond the range of its data."""
        lines = []
        states = [state for curve in self.curves for state in curve.states]
        for index, (name, ranges) in enumerate(zip(self.clamp_names, self.ranges, strict=True)):
            beyond = [state.beyond[index] for state in states if state.beyond[index]]
            if not beyond:
                continue
            parts = []
            for condition, interval in ranges.items():
                values = [found[condition] for found in beyond if condition in found]
                if values:
                    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
                    parts.append(
                        f"{condition} = {low if low == high else f'{low} to {high}'} {interval.unit} "
                        f"(data: {interval.minimum:.4g} to {interval.maximum:.4g})"
                    )
            share = f"{len(beyond) / len(states):.0%} of the curves' points"
            lines.append(f"{name}: its law is used beyond the range of its data in {share}: {', '.join(parts)}")
        return lines

    def _about_dots(self) -> list[str]:
        """Say how well the co-simulations agree, in which steps, and which of them aren't to be trusted."""
        steps = [1e3 * dot.step for dot in self.dots]
        sound = [dot for dot in self.dots if dot.settled and dot.trusted]
        good = [dot.difference for dot in sound if dot.repeats and dot.has_branch]
        lines = [
            f"{counted(len(self.dots), 'co-simulation')} in steps of {min(steps):.3g} to {max(steps):.3g} ms; "
            f"those that settled and can be trusted ({len(good)}) differ by at most {max(good, default=0.0):.2%} from "
            "the stable branches"
        ]
        odd = [dot for dot in sound if not dot.repeats]
        if odd:
            lines.append(
                f"{len(odd)} co-simulations don't repeat from cycle to cycle: subharmonic or irregular motion, which "
                f"no curve holds ({_places(odd)})"
            )
        alone = [dot for dot in sound if dot.repeats and not dot.has_branch]
        if alone:
            lines.append(
                f"{len(alone)} co-simulations settle where no stable branch was found: one is missing there "
                f"({_places(alone)})"
            )
        doubtful = self.doubtful_dots
        if doubtful:
            places = _places(doubtful)
            lines.append(
                doubt(
                    f"{len(doubtful)} co-simulations, drawn as crosses: 1/{2**MOST_HALVINGS} of step_s "
                    f"is still too long a step for them; use a smaller step_s or scheme = 'implicit' ({places})"
                )
            )
        return lines


def _places(dots: Sequence[Dot]) -> str:
    """Say where dots lie."""
    return "; ".join(f"{label(dot.temperature, dot.level)}, {dot.frequency:.4g} Hz" for dot in dots)


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


def _spans(ranges: Iterable[tuple[float, float]]) -> str:
    """Say ranges of frequencies, Hz."""
    return ", ".join(span(low, high) for low, high in ranges)


def _about_search(curve: Curve) -> str:
    """Say that further branches were not sought to the end."""
    return "" if curve.sought_whole else f"; {SEARCH_ENDED}"


def _about_detached(branch: Sequence[SteadyState]) -> str:
    """Say where a branch lies that nothing joins to the others."""
    return f"a branch apart {_where(branch)}"


def _about_leaving(branch: Sequence[SteadyState]) -> str:
    """Say where a branch lies that leaves another one, and how far it is off the middle."""
    off = max(float(np.abs(state.clamps[:, 0]).max()) for state in branch)
    return f"a less symmetric branch {_where(branch)}, off the middle by up to {off:.2g} mm at a clamp"


def _where(branch: Sequence[SteadyState]) -> str:
    """Say which frequencies a branch spans, and whether none of it is stable."""
    frequencies = [state.frequency for state in branch]
    stable = "" if any(state.stable or state.neutral for state in branch) else " (all of it unstable)"
    return f"{span(min(frequencies), max(frequencies))}{stable}"


def label(temperature: float | None, level: float) -> str:
    """Name a curve."""
    return f"{'' if temperature is None else f'{temperature:g} °C, '}level {level:g}"


def amplitudes_of(state: SteadyState) -> tuple[float, ...]:
    """Give half the peak-to-peak displacement of each clamp and probe, mm."""
    return tuple(half_range(np.vstack([state.clamps, state.probes])).tolist())


def peaks_of(curve: Curve) -> list[tuple[float, float]]:
    """Give the amplitude (mm) and the frequency (Hz) of a curve's highest state at each clamp and probe."""
    points = range(len(amplitudes_of(curve.states[0])))
    return [max((amplitudes_of(state)[point], state.frequency) for state in curve.states) for point in points]


def run_response(path: Path, progress: Progress = silent, *, dots: bool = True) -> FrequencyResponse:
    """Give the frequency response of the system that a file describes.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        progress: told what is being done.
        dots: whether it is co-simulated too, as often as the file asks for.

    Raises:
        UserError: the system can't be read or built, has no sine, no law or nothing to show, or a co-simulation fails.
    """
    asked = read_responding(path)
    description, table, pipe = asked.description, asked.table, asked.pipe
    curves: list[Curve] = []
    found: list[Dot] = []
    leaves_rest: list[str] = []
    frequencies = _dot_frequencies(table) if dots else ()
    with finished(description, path.parent) if frequencies else nullcontext(description) as ready:
        for temperature in table.temperatures_C or (None,):
            leaves_rest.append(about_rest(_at_temperature(description, temperature), path.parent, str(path)))
            for level in table.levels:
                progress(label(temperature, level))
                place = str(path)
                system = steady_system(description, pipe, path.parent, temperature, level, table.harmonics, place)

                def tell(what: str, where: str = label(temperature, level)) -> None:
                    progress(f"{where}, {what}")

                curve = curve_of(system, table, temperature, level, place, tell)
                curves.append(curve)
                for frequency in frequencies:
                    progress(f"{label(temperature, level)}, co-simulation at {frequency:.4g} Hz")
                    passed = [state for piece in curve.pieces for state in system.crossings(piece, frequency)]
                    passed += _marched_at(system, curve.followed, frequency)
                    stable = [
                        Rest(amplitudes_of(state), -state.growth, state.truncated) for state in passed if state.stable
                    ]
                    found.append(co_simulated(ready, temperature, level, frequency, stable, path))
    excitation = description.excitation
    amount = excitation.model_dump(include={"acceleration_m_s2", "displacement_mm", "force_N"}, exclude_none=True)
    return FrequencyResponse(
        description.name,
        tuple(clamp.at for clamp in description.clamps),
        pipe.probe_names,
        ", ".join(AMOUNTS[name].format(value) for name, value in amount.items()),
        tuple(curves),
        tuple(found),
        tuple(ranges_of(law_in(path.parent, str(clamp.law))) for clamp in description.clamps),
        table.harmonics is not None,
        tuple(dict.fromkeys(words for words in leaves_rest if words)),
    )


def _at_temperature(description: SystemDescription, temperature: float | None) -> SystemDescription:
    """Give a system with all its clamps at a temperature, degC; None for their own."""
    if temperature is None:
        return description
    clamps = tuple(clamp.model_copy(update={"temperature_C": temperature}) for clamp in description.clamps)
    return description.model_copy(update={"clamps": clamps})


def _marched_at(system: SteadySystem, followed: FollowedResponse, frequency: float) -> list[SteadyState]:
    """Give the steady states at a frequency (Hz) among those that were found in time."""
    passed = [way for way in followed.in_time if way[0].frequency <= frequency <= way[-1].frequency]
    marched = [system.marched(frequency)] if passed else []
    found = [system.state_in_time(one) for one in marched if one is not None and one.round == 1]
    return found + [min(way, key=lambda state: abs(state.frequency - frequency)) for way in passed[1:]]


def curve_of(
    system: SteadySystem, table: ResponseTable, temperature: float | None, level: float, where: str,
    tell: Progress = silent,
) -> Curve:  # fmt: skip
    """Follow one curve, and seek what is detached from it.

    Raises:
        UserError: no steady state is found.
    """
    followed = system.followed(table.from_Hz, table.to_Hz, tell)
    if not followed.states:
        raise UserError(
            f"{where}: {label(temperature, level)}: no steady state is found from {table.from_Hz:g} to "
            f"{table.to_Hz:g} Hz{_at_most(followed.unsteady)}; run its sines in time by `pipeclamp cosim`"
        )
    if followed.in_time:  # a branch apart begins in the balance, which gives none there
        return Curve(temperature, level, followed)
    first, last = table.from_Hz, table.to_Hz
    with system.work.at_most(float(np.clip(SEARCH_TIMES * system.work.done, LEAST_SEARCH, MOST_SEARCH))):
        if followed.unbounded:  # without damping there is no end of branches: only those between resonances are sought
            detached = detached_branches(system, followed.pieces, first, last, over_levels=False, tell=tell)
            return Curve(temperature, level, followed, detached, sought_whole=not system.work.used_up)
        tell("branches that leave it")
        leaving = leaving_branches(system, followed.pieces, first, last)
        detached = detached_branches(system, followed.pieces, first, last, leaving, tell=tell)
        leaving += leaving_branches(system, detached, first, last)
        return Curve(temperature, level, followed, detached, leaving, sought_whole=not system.work.used_up)


def _at_most(unsteady: Sequence[Unsteady]) -> str:
    """Say how far motions go that don't repeat."""
    if not unsteady:
        return ""
    return f": no motion repeats, and they go as far as {max(max(one.high) for one in unsteady):.3g} mm"


def _dot_frequencies(table: ResponseTable) -> Sequence[float]:
    """Give frequencies inside the range, evenly spread."""
    return np.linspace(table.from_Hz, table.to_Hz, table.dots + 2)[1:-1].tolist() if table.dots else ()


def write_response(
    response: FrequencyResponse, path: Path, beside: Sequence[Mapping[str, float]] | None = None
) -> None:
    """Write curves and dots as CSV, whole or not at all: `response_frame`.

    Raises:
        UserError: the folder can't be written.
    """
    write_whole(path, response_frame(response, beside).write_csv())


def response_frame(response: FrequencyResponse, beside: Sequence[Mapping[str, float]] | None = None) -> pl.DataFrame:
    """Give curves and dots, a row each, with "name [unit]" as header.

    Args:
        response: curves and dots.
        beside: further columns of each state of the curves, in their order, by header.
    """
    rows: list[dict[str, float | str | None]] = []
    further = iter(beside if beside is not None else repeat({}))
    for curve in response.curves:
        for number, state in ((n, state) for n, piece in enumerate(curve.pieces, 1) for state in piece):
            row = _state_row("curve", curve, state, response)
            rows.append({**row, "piece": number, "harmonics": state.harmonics, **next(further)})
        rows += [
            {**_state_row("in time", curve, state, response), "piece": number, "cycles": state.cycles}
            for number, way in enumerate(curve.followed.in_time, len(curve.pieces) + 1)
            for state in way
        ]
        for one in curve.followed.unsteady:
            row = _row("in time, unsteady", curve.temperature, curve.level, one.frequency, one.high, response)
            row |= {f"{name}.s_least [mm]": low for name, low in zip(response.points, one.low, strict=True)}
            rows.append({**row, "repeats": 0.0, "cycles": one.cycles, "comes round in [cycles]": one.round or None})
    for dot in response.dots:
        row = _row("co-simulation", dot.temperature, dot.level, dot.frequency, dot.amplitudes, response)
        row |= {"settled": float(dot.settled), "trusted": float(dot.trusted), "repeats": float(dot.repeats)}
        row |= {"step [s]": dot.step}
        rows.append(row | {"truncated [1]": dot.truncated})
    return pl.from_dicts(rows, infer_schema_length=None)


def _state_row(
    kind: str, curve: Curve, state: SteadyState, response: FrequencyResponse
) -> dict[str, float | str | None]:
    row = _row(kind, curve.temperature, curve.level, state.frequency, amplitudes_of(state), response)
    row |= {
        "stable": None if state.neutral else float(state.stable),
        "growth [1/s]": state.growth,
        "truncated [1]": state.truncated,
    }
    means = np.concatenate([state.clamps[:, 0].real, state.probes[:, 0].real])
    row |= {f"{name}.mean [mm]": mean for name, mean in zip(response.points, means.tolist(), strict=True)}
    for name, (amplitude, frequency), force, beyond in zip(
        response.clamp_names, state.conditions.tolist(), half_range(state.forces).tolist(), state.beyond, strict=True
    ):
        row |= {f"{name}.A_used [mm]": amplitude, f"{name}.f_used [Hz]": frequency, f"{name}.f [N]": force}
        row[f"{name}.inRange [1 yes, 0 no]"] = float(not beyond)
    return row


def _row(
    kind: str, temperature: float | None, level: float, frequency: float, amplitudes: Sequence[float],
    response: FrequencyResponse,
) -> dict[str, float | str | None]:  # fmt: skip
    row: dict[str, float | str | None] = {
        "kind": kind,
        "temperature [degC]": temperature,
        "level": level,
        "frequency [Hz]": frequency,
    }
    return row | {f"{name}.s [mm]": value for name, value in zip(response.points, amplitudes, strict=True)}
