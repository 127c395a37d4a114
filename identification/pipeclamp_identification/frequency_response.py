"""The frequency response of a coupled system: steady states by harmonic balance, co-simulations as dots on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeclamp.errors import UserError
from pipeclamp.files import write_whole
from pipeclamp.parameter_file import Interval, LawFile, law_of
from pipeclamp.pipe import ReducedPipe, reduce
from pipeclamp.pipe_description import read_pipe
from pipeclamp.realise.stepping import CONDITIONS_FIRST, clamp_equations, conditions_of
from pipeclamp.symbols import CELSIUS, condition_symbol
from pipeclamp.toml_file import unknown
from pipeclamp_fmu.build import clamp_model, condition_parameter
from pipeclamp_identification.cosim import finished, law_in
from pipeclamp_identification.detached_branches import detached_branches
from pipeclamp_identification.excitation import require_kind, sine_amplitude
from pipeclamp_identification.harmonic_balance import FollowedResponse, SteadyState, SteadySystem, half_range
from pipeclamp_identification.response_dots import MOST_HALVINGS, Dot, Rest, co_simulated
from pipeclamp_identification.steady_clamp import SteadyClamp
from pipeclamp_identification.system import ClampSource, ResponseTable, SystemDescription, read_system
from pipeclamp_identification.tables import pl
from pipeclamp_identification.trust_mark import DOUBT

Progress = Callable[[str], None]

AROUND = 0.7
"""Of the excitation's frequency: where the response begins unless told, and the inverse of where it ends."""


@dataclass(frozen=True)
class Curve:
    """A frequency response at one temperature of the clamps and one level of the excitation.

    Attributes:
        temperature: degC; None where each clamp has its own.
        level: factor on the excitation's amplitude.
        followed: states along the curve, round its turning points.
        detached: branches that nothing joins to it in its range.
    """

    temperature: float | None
    level: float
    followed: FollowedResponse
    detached: tuple[tuple[SteadyState, ...], ...] = ()

    @property
    def pieces(self) -> tuple[tuple[SteadyState, ...], ...]:
        """All pieces, the detached ones last."""
        return (*self.followed.pieces, *self.detached)

    @property
    def states(self) -> tuple[SteadyState, ...]:
        """The states of all pieces."""
        return tuple(state for piece in self.pieces for state in piece)


@dataclass(frozen=True)
class FrequencyResponse:
    """All curves of a system and the co-simulations on them.

    Attributes:
        name: of the system.
        clamp_names: those with a law; probe_names: of the pipe. `amplitudes` are in this order.
        excitation: what shakes the pipe, in words.
        curves, dots: what was found.
        ranges: what each clamp's law holds data for, by condition, in the order of clamp_names.
    """

    name: str
    clamp_names: tuple[str, ...]
    probe_names: tuple[str, ...]
    excitation: str
    curves: tuple[Curve, ...]
    dots: tuple[Dot, ...]
    ranges: tuple[Mapping[str, Interval], ...]

    @property
    def points(self) -> tuple[str, ...]:
        """Names of all clamps and probes."""
        return (*self.clamp_names, *self.probe_names)

    def summary(self) -> str:
        """Give peaks, unstable branches and how well the two ways agree, for a person to read."""
        lines = [f"system {self.name!r}, level 1: {self.excitation}"]
        for curve in self.curves:
            peaks = [max((amplitudes_of(s)[i], s.frequency) for s in curve.states) for i in range(len(self.points))]
            peak_text = ", ".join(
                f"{name} {peak:.4g} mm at {frequency:.4g} Hz"
                for name, (peak, frequency) in zip(self.points, peaks, strict=True)
            )
            unstable = [state.frequency for state in curve.states if not state.stable]
            branch = f"; unstable from {min(unstable):.4g} to {max(unstable):.4g} Hz" if unstable else ""
            broken = "" if curve.followed.whole else f"; {curve.followed.reach()}"
            apart = "".join(f"; {_about_detached(piece)}" for piece in curve.detached)
            lines.append(f"{label(curve.temperature, curve.level)}: peak {peak_text}{branch}{apart}{broken}")
        lines += self.about_ranges()
        lines += self._about_dots() if self.dots else []
        return "\n".join(lines)

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
        good = [dot.difference for dot in self.dots if dot.settled and dot.trusted]
        lines = [
            f"{len(self.dots)} co-simulations in steps of {min(steps):.3g} to {max(steps):.3g} ms; those that settled "
            f"and can be trusted ({len(good)}) differ by at most {max(good, default=0.0):.2%} from the stable branches"
        ]
        doubtful = [dot for dot in self.dots if not dot.trusted]
        if doubtful:
            places = "; ".join(f"{label(dot.temperature, dot.level)}, {dot.frequency:.4g} Hz" for dot in doubtful)
            lines.append(
                f"{DOUBT}: {len(doubtful)} co-simulations, drawn as crosses: 1/{2**MOST_HALVINGS} of step_s "
                f"is still too long a step for them; use a smaller step_s or scheme = 'implicit' ({places})"
            )
        return lines


def _about_detached(branch: Sequence[SteadyState]) -> str:
    """Say where a branch lies that nothing joins to the others."""
    frequencies = [state.frequency for state in branch]
    stable = "" if any(state.stable for state in branch) else " (all of it unstable)"
    return f"a branch apart from {min(frequencies):.4g} to {max(frequencies):.4g} Hz{stable}"


def label(temperature: float | None, level: float) -> str:
    """Name a curve."""
    return f"{'' if temperature is None else f'{temperature:g} °C, '}level {level:g}"


def amplitudes_of(state: SteadyState) -> tuple[float, ...]:
    """Give half the peak-to-peak displacement of each clamp and probe, mm."""
    return tuple(half_range(np.vstack([state.clamps, state.probes])).tolist())


def run_response(path: Path, progress: Progress | None = None) -> FrequencyResponse:
    """Give the frequency response of the system that a file describes.

    Args:
        path: SYSTEM.toml; paths in it are relative to its folder.
        progress: told what is being done.

    Raises:
        UserError: the system can't be read or built, has no sine, no law or nothing to show, or a co-simulation fails.
    """
    tell = progress or (lambda what: None)
    description = read_system(path)
    table = response_table(description, str(path))
    if description.pipe.file is None:
        raise UserError(f"{path}: pipe: a response needs the pipe's equations; expected file = 'PIPE.toml', not an FMU")
    pipe = reduce(read_pipe(path.parent / description.pipe.file))
    require_kind(description.excitation, pipe.excitation, str(path))
    if not description.clamps and not pipe.probe_names:
        raise UserError(
            f"{path}: there is neither a clamp nor a probe whose motion could be shown; expected one of them"
        )
    # Refuses what can't serve before anything is built.
    steady_system(description, pipe, path.parent, None, 1.0, table.harmonics, str(path))
    curves: list[Curve] = []
    dots: list[Dot] = []
    with finished(description, path.parent) as ready:
        for temperature in table.temperatures_C or (None,):
            for level in table.levels:
                tell(label(temperature, level))
                place = str(path)
                system = steady_system(description, pipe, path.parent, temperature, level, table.harmonics, place)
                curve = _curve(system, table, temperature, level, place)
                curves.append(curve)
                for frequency in _dot_frequencies(table):
                    tell(f"{label(temperature, level)}, co-simulation at {frequency:.4g} Hz")
                    passed = [state for piece in curve.pieces for state in system.crossings(piece, frequency)]
                    stable = [Rest(amplitudes_of(state), -state.growth) for state in passed if state.stable]
                    dots.append(co_simulated(ready, temperature, level, frequency, stable, path))
    excitation = description.excitation
    amount = excitation.model_dump(include={"acceleration_m_s2", "displacement_mm", "force_N"}, exclude_none=True)
    return FrequencyResponse(
        description.name,
        tuple(clamp.at for clamp in description.clamps),
        pipe.probe_names,
        ", ".join(f"{name} = {value:g}" for name, value in amount.items()),
        tuple(curves),
        tuple(dots),
        tuple(_ranges(law_in(path.parent, str(clamp.law))) for clamp in description.clamps),
    )


def response_table(description: SystemDescription, where: str) -> ResponseTable:
    """Give what a system says of its response, or what follows from its excitation; `where` is named in errors.

    Raises:
        UserError: the excitation is a record.
    """
    excitation = description.excitation
    if excitation.kind == "record":
        raise UserError(f"{where}: excitation: a record has no frequency response; expected kind = 'sine' or 'sweep'")
    if description.response is not None:
        return description.response
    first, last = excitation.frequency_Hz or excitation.from_Hz, excitation.frequency_Hz or excitation.to_Hz
    assert first is not None and last is not None, "the description holds this"
    low, high = min(first, last), max(first, last)
    return ResponseTable(from_Hz=AROUND * low, to_Hz=high / AROUND)


def steady_clamp(source: ClampSource, folder: Path, temperature: float | None, where: str) -> SteadyClamp:
    """Give a clamp of a system as harmonic balance needs it; a temperature in degC stands in for its own.

    Raises:
        UserError: it is an FMU, whose equations can't be read, or is given a condition that its law doesn't follow.
    """
    if source.law is None:
        raise UserError(f"{where}: clamp {source.at!r}: a response needs the law's equations; expected law, not an FMU")
    file = law_in(folder, source.law)
    given = source.mode == "given"
    law = law_of(file)
    model = clamp_model(file)
    further = {entry.name: entry.scale * entry.start for entry in model.further}
    scales = {entry.name: entry.scale for entry in model.further}
    for column, value in source.conditions.items():
        name, setting = condition_parameter(column, value)
        if name not in further:
            raise UserError(
                f"{where}: clamp {source.at!r}: conditions: {column}: law {source.law} doesn't follow it; leave it out "
                "or take a law with an effect that does"
            )
        further[name] = scales[name] * setting
    named = conditions_of(clamp_equations(law.structure))[len(CONDITIONS_FIRST) :]
    return SteadyClamp(
        law,
        (source.temperature_C if temperature is None else temperature) + CELSIUS,
        source.amplitude_mm if given else None,
        source.frequency_Hz if given else None,
        (file.range["A"].minimum, file.range["A"].maximum),
        (file.range["f"].minimum, file.range["f"].maximum),
        dict(zip(named, further.values(), strict=True)),
        ranges={
            name: (interval.minimum, interval.maximum)
            for name, interval in _ranges(file).items()
            if name in ("T", *named)
        },
    )


def _ranges(file: LawFile) -> dict[str, Interval]:
    """Give what a law's data hold, by the names that its equations give the conditions."""
    own = ("A", "f", "T", "rho", "N")
    return {name if name in own else str(condition_symbol(name)): interval for name, interval in file.range.items()}


def steady_clamps(
    description: SystemDescription, pipe: ReducedPipe, folder: Path, temperature: float | None, where: str
) -> list[tuple[int, SteadyClamp]]:
    """Give the clamps of a system and which of the pipe's each is; arguments as of `steady_system`.

    Raises:
        UserError: a clamp is at no place of the pipe, or is an FMU.
    """
    clamps = []
    for source in description.clamps:
        if source.at not in pipe.clamp_names:
            raise UserError(f"{where}: clamps: {unknown(source.at, list(pipe.clamp_names), 'clamp')}")
        clamps.append((pipe.clamp_names.index(source.at), steady_clamp(source, folder, temperature, where)))
    return clamps


def steady_system(
    description: SystemDescription, pipe: ReducedPipe, folder: Path, temperature: float | None, level: float,
    harmonics: int, where: str,
) -> SteadySystem:  # fmt: skip
    """Give a described system as harmonic balance needs it; `where` is named in errors.

    Raises:
        UserError: a clamp is at no place of the pipe, or is an FMU.
    """
    clamps = steady_clamps(description, pipe, folder, temperature, where)
    excitation = description.excitation
    return SteadySystem(pipe, clamps, lambda frequency: level * sine_amplitude(excitation, frequency), harmonics)


def _curve(system: SteadySystem, table: ResponseTable, temperature: float | None, level: float, where: str) -> Curve:
    """Follow one curve, and seek what is detached from it.

    Raises:
        UserError: it is found at neither end.
    """
    followed = system.followed(table.from_Hz, table.to_Hz)
    if not followed.pieces:
        raise UserError(
            f"{where}: {label(temperature, level)}: no steady state is found at {table.from_Hz:g} Hz nor at "
            f"{table.to_Hz:g} Hz; try other ends of [response]"
        )
    detached = detached_branches(system, followed.pieces, table.from_Hz, table.to_Hz)
    return Curve(temperature, level, followed, detached)


def _dot_frequencies(table: ResponseTable) -> Sequence[float]:
    """Give frequencies inside the range, evenly spread."""
    return np.linspace(table.from_Hz, table.to_Hz, table.dots + 2)[1:-1].tolist() if table.dots else ()


def write_response(response: FrequencyResponse, path: Path) -> None:
    """Write curves and dots as CSV, whole or not at all: a row each, "name [unit]" as header.

    Raises:
        UserError: the folder can't be written.
    """
    rows = []
    for curve in response.curves:
        for number, state in ((n, state) for n, piece in enumerate(curve.pieces, 1) for state in piece):
            row = _row("curve", curve.temperature, curve.level, state.frequency, amplitudes_of(state), response)
            row |= {"piece": number, "stable": float(state.stable), "growth [1/s]": state.growth}
            for name, (amplitude, frequency), force, beyond in zip(
                response.clamp_names, state.conditions.tolist(), half_range(state.forces).tolist(), state.beyond,
                strict=True,
            ):  # fmt: skip
                row |= {f"{name}.A_used [mm]": amplitude, f"{name}.f_used [Hz]": frequency, f"{name}.f [N]": force}
                row[f"{name}.inRange [1 yes, 0 no]"] = float(not beyond)
            rows.append(row)
    for dot in response.dots:
        row = _row("co-simulation", dot.temperature, dot.level, dot.frequency, dot.amplitudes, response)
        rows.append(row | {"settled": float(dot.settled), "trusted": float(dot.trusted), "step [s]": dot.step})
    write_whole(path, pl.from_dicts(rows, infer_schema_length=None).write_csv())


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
