"""The coupled model at the sines of a measurement: what its probes should have shown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeclamp_identification.on_pipe.instrument import Instrument
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription, PipeMeasurement, SteadyMeasurement
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.pipe.description import PipeDescription, Place, read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce, reduce_likewise
from pipeclamp_system.description.measured_table import DRIVES, Drive
from pipeclamp_system.description.system import SystemDescription, read_system
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.steady.harmonics import packed, resized
from pipeclamp_system.steady.points import Balanced, Operation, balance, fundamentals
from pipeclamp_system.steady.states import SteadyState

Complex = NDArray[np.complex128]
Rows = NDArray[np.intp]

SAME_LEVEL = 0.06
"""Sines whose excitation differs by less, as a share, are of one level."""

CLASSES = (3, 5, 9, 15, 23, 32)
"""Harmonics up to which sines are balanced together: those that ask for about as many."""

SAME = 1e-3
"""Motions whose fundamentals differ by less, as a share, are one."""

SAMPLES = 128
"""Of a cycle, at which the clamps' laws are evaluated; 256 change a response by less than 0.1 %."""

REDUCTION = 1e-3
"""Error of the pipe's reduction: well below what sensors err by."""


@dataclass(frozen=True, eq=False)
class CoupledModel:
    """A pipe with its clamps, as harmonic balance needs it.

    Attributes:
        pipe: the pipe, with the measurement's probes in their order.
        clamps: which of the pipe's clamps have a law, and the law, by temperature in degC; None: the system's own.
        clamp_names: of those, in their order.
        harmonics: up to which their motion is balanced; None: as many as each motion asks for.
        stated: the pipe as it is stated, in modes; `pipe` may differ from it a little.
        instrument: what the measuring chain makes of its motion.
    """

    pipe: PipeDescription
    clamps: Mapping[float | None, tuple[tuple[int, SteadyClamp], ...]]
    clamp_names: tuple[str, ...]
    harmonics: int | None
    stated: ReducedPipe
    instrument: Instrument = field(default_factory=Instrument)

    @property
    def reduced(self) -> ReducedPipe:
        """The pipe in as many modes as the stated one."""
        return _reduced(self.pipe, self.stated)

    def system(
        self, temperature: float | None, excitation: Callable[[float], float], harmonics: int | None = None
    ) -> SteadySystem:
        """Give pipe and clamps at a temperature (degC) under a sine; the excitation's amplitude is m/s2 or N over Hz.

        Harmonics are the model's where they are None.

        Raises:
            UserError: the pipe can't be reduced.
        """
        return SteadySystem(self.reduced, self.clamps[temperature], excitation, harmonics or self.harmonics)


@dataclass(frozen=True, eq=False)
class Group:
    """Sines of one temperature that are balanced up to the same harmonic.

    Attributes:
        temperature: of the clamps, degC; None for the system's own.
        rows: which of the measurement's sines.
        harmonics: H.
        solved: their steady states.
    """

    temperature: float | None
    rows: Rows
    harmonics: int
    solved: Balanced


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a model's probes show.

    Attributes:
        response: as of `SteadyMeasurement`, nan where no steady state was found, (P, probes).
        clamps: fundamental of each clamp's displacement, mm, (P, clamps).
        groups: the steady states, sines that ask for about as many harmonics together.
        branches: how many stable states there are, (P,); 1 unless it was looked for.
    """

    response: Complex
    clamps: Complex
    groups: tuple[Group, ...]
    branches: Rows


@lru_cache(maxsize=64)
def _reduced(description: PipeDescription, neighbour: ReducedPipe) -> ReducedPipe:
    return reduce_likewise(description, neighbour)


def read_model(
    path: Path, description: MeasurementDescription, drives: Iterable[Drive], clamps_at: Iterable[float | None]
) -> tuple[SystemDescription, CoupledModel]:
    """Read a coupled system, with the probes of a measurement on its pipe.

    Args:
        path: SYSTEM.toml.
        description: of the measurement.
        drives: columns that its excitation stands in.
        clamps_at: temperatures of the clamps, degC; None for the system's own.

    Raises:
        UserError: the system can't be read or built, or the measurement doesn't belong to it.
    """
    system, pipe = _measured_pipe(path, description, drives)
    reduced = reduce(pipe)
    clamps = {
        temperature: tuple(
            (index, replace(clamp, samples=SAMPLES))
            for index, clamp in steady_clamps(system, reduced, path.parent, temperature, str(path))
        )
        for temperature in clamps_at
    }
    names = tuple(source.at for source in system.clamps)
    harmonics = system.response.harmonics if system.response else None
    return system, CoupledModel(pipe, clamps, names, harmonics, reduced)


def _measured_pipe(
    path: Path, description: MeasurementDescription, drives: Iterable[Drive]
) -> tuple[SystemDescription, PipeDescription]:
    """Read a coupled system; give it, and its pipe with a measurement's probes.

    Raises:
        UserError: they can't be read, or the measurement doesn't belong to them.
    """
    system = read_system(path)
    if system.pipe.file is None:
        raise UserError(
            f"{path}: pipe: a comparison needs the pipe's equations; expected file = 'PIPE.toml', not an FMU"
        )
    pipe_path = path.parent / system.pipe.file
    pipe = with_probes(read_pipe(pipe_path), description, str(pipe_path))
    for drive in sorted(drives):
        kind = DRIVES[drive].shakes
        if kind != pipe.excitation.kind:
            raise UserError(
                f"{pipe_path}: excitation: the pipe is excited by {pipe.excitation.kind}, the measurement by {kind} "
                f"({drive}); expected the same; set excitation.kind = {kind!r}"
            )
    modes = pipe.modes.model_copy(update={"error": min(pipe.modes.error, REDUCTION)})
    return system, pipe.model_copy(update={"modes": modes})


def with_probes(pipe: PipeDescription, measurement: MeasurementDescription, where: str) -> PipeDescription:
    """Give a pipe with the probes of a measurement in place of its own; `where` is named in errors.

    Raises:
        UserError: a probe's position isn't known, or is beyond the pipe's end.
    """
    known = {place.name: place.position_m for place in (*pipe.probes, *pipe.clamps)}
    places = []
    for probe in measurement.probes:
        position = known.get(probe.name) if probe.position_m is None else probe.position_m
        if position is None:
            raise UserError(
                f"measurement: probe {probe.name!r} has no position_m, and {where} names no such probe or clamp; "
                "expected its position along the pipe in m"
            )
        if position > pipe.pipe.length_m:
            raise UserError(
                f"measurement: probe {probe.name!r}: got position_m = {position:g}; expected at most the pipe's "
                f"length_m = {pipe.pipe.length_m:g} ({where})"
            )
        places.append(Place(name=probe.name, position_m=position))
    return pipe.model_copy(update={"probes": tuple(places)})


def temperatures(measured: SteadyMeasurement) -> Iterator[tuple[float | None, Rows]]:
    """Give each temperature of the clamps, None for the system's own, and the sines at it."""
    own = np.isnan(measured.temperature)
    if own.any():
        yield None, np.flatnonzero(own)
    for temperature in np.unique(measured.temperature[~own]).tolist():
        yield temperature, np.flatnonzero(measured.temperature == temperature)


def predict(model: CoupledModel, measurement: PipeMeasurement, near: Prediction | None = None) -> Prediction:
    """Give what a model's probes show at a measurement's sines.

    Where the response has several stable branches, a sweep up follows the one from low frequencies, a sweep down that
    from high ones, and otherwise it is the one nearest to the measured response.

    Args:
        model: pipe and clamps.
        measurement: the sines.
        near: of a neighbouring model, whose branches are kept; else they are found by following the response.

    Raises:
        UserError: the pipe can't be reduced.
    """
    measured = measurement.steady
    shape = measured.response.shape
    response, clamps = np.full(shape, np.nan + 0j), np.full((shape[0], len(model.clamp_names)), np.nan + 0j)
    begun, branches = _begun(model, measurement) if near is None else (near.groups, near.branches)
    groups = []
    for group in begun:
        rows = group.rows
        operation = true_operation(model, measurement, rows)
        system = model.system(group.temperature, lambda frequency: 1.0, group.harmonics)
        solved = balance(system, operation, group.solved.unknowns, None if near is None else group.solved.slopes)
        if near is not None and not solved.found.all():
            solved = _again_from_rest(system, operation, solved)
        moved = fundamentals(system, operation, solved)
        count = len(model.clamp_names)
        clamps[rows] = 1e3 * operation.drive[:, None] * moved[:, :count]
        response[rows] = as_recorded(moved[:, count:], operation.frequency, measurement, model)
        groups.append(replace(group, solved=solved))
    return Prediction(response, clamps, tuple(groups), branches)


def true_operation(model: CoupledModel, measurement: PipeMeasurement, rows: Rows | slice = slice(None)) -> Operation:
    """Give the sines that a model's measuring chain takes the stated ones for, some of its rows."""
    measured = measurement.steady
    drive = model.instrument.true_drive(from_displacement(measured)) * measured.drive[rows]
    return Operation(model.instrument.frequency * measured.frequency[rows], drive)


def from_displacement(measured: SteadyMeasurement) -> bool:
    """Tell whether the base's acceleration was made from its displacement by the stated frequency."""
    return measured.drive_unit == "displacement_mm"


def as_recorded(moved: Complex, frequency: Array, measurement: PipeMeasurement, model: CoupledModel) -> Complex:
    """Turn displacements relative to the base over the excitation into what is recorded of the probes, (P, probes)."""
    seen = as_measured(moved, frequency, measurement, model.pipe)
    names = [probe.name for probe in model.pipe.probes]
    return model.instrument.recorded(names, seen, frequency, from_displacement(measurement.steady))


def as_measured(moved: Complex, frequency: Array, measurement: PipeMeasurement, pipe: PipeDescription) -> Complex:
    """Turn displacements relative to the base over the excitation into what the probes measure, (P, probes)."""
    turn = 2j * np.pi * frequency
    columns = []
    for column, probe in zip(moved.T, measurement.description.probes, strict=True):
        base = 1 / turn**2 if probe.absolute and pipe.excitation.kind == "base" else 0.0
        columns.append((column + base) * turn**probe.order)
    return np.column_stack(columns).astype(np.complex128)


def _begun(model: CoupledModel, measurement: PipeMeasurement) -> tuple[tuple[Group, ...], Rows]:
    """Give sines in groups, with guesses of their steady states, and how many stable ones each sine has."""
    groups, branches = [], np.ones(measurement.steady.response.shape[0], dtype=np.intp)
    for temperature, rows in temperatures(measurement.steady):
        states, branches[rows] = _first_states(model, temperature, measurement, rows)
        asked = np.array([_harmonics(model, state) for state in states])
        # Nothing settles on an unstable motion: there is none to compare.
        unstable = np.array([state is not None and not state.stable for state in states])
        for harmonics in np.unique(asked).tolist():
            own = np.flatnonzero((asked == harmonics) & ~unstable)
            if not own.size:
                continue
            guess = np.zeros((own.size, len(model.clamp_names), harmonics + 1), dtype=np.complex128)
            for place, index in enumerate(own):
                state = states[index]
                if state is not None:
                    guess[place] = resized(state.clamps, harmonics + 1)
            unknowns = packed(guess)
            nothing = np.zeros((0, 0, 0))
            begun = Balanced(unknowns, nothing, np.zeros(own.size, np.bool_), nothing[None].astype(np.complex128))
            groups.append(Group(temperature, rows[own], harmonics, begun))
    return tuple(groups), branches


def _harmonics(model: CoupledModel, state: SteadyState | None) -> int:
    """Give up to which harmonic a sine is balanced."""
    if model.harmonics is not None:
        return model.harmonics
    return CLASSES[0] if state is None else min(H for H in CLASSES if min(state.harmonics, CLASSES[-1]) <= H)


def _first_states(
    model: CoupledModel, temperature: float | None, measurement: PipeMeasurement, rows: Rows
) -> tuple[list[SteadyState | None], Rows]:
    """Give the steady states at some sines, stable ones where there are any, and how many of those each has.

    The response is followed from both ends: where it bends, each meets branches that the other doesn't.
    """
    measured = measurement.steady
    true = true_operation(model, measurement)
    chosen: list[SteadyState | None] = [None] * rows.size
    branches = np.ones(rows.size, dtype=np.intp)
    for level in number_levels(measured.level[rows], relative=SAME_LEVEL):
        own = rows[level.rows]
        frequency, inverse = np.unique(true.frequency[own], return_inverse=True)
        drive = np.bincount(inverse, true.drive[own]) / np.bincount(inverse)
        system = model.system(temperature, lambda f, at=frequency, of=drive: float(np.interp(f, at, of)))  # type: ignore[misc]
        upwards, downwards = _paths(system, float(frequency[0]), float(frequency[-1]))
        for place, row in zip(level.rows, own, strict=True):
            f, sweep = float(true.frequency[row]), measured.sweep[row]
            paths = (upwards, downwards) if sweep >= 0 else (downwards, upwards)
            everywhere = _apart([state for path in paths for state in system.crossings(path, f)])
            found = [state for state in everywhere if state.stable]
            branches[place] = max(1, len(found))
            found = found or everywhere
            if not found:
                continue
            chosen[place] = found[0]
            if len(found) > 1 and sweep == 0:
                seen = [_seen(state.probes[:, 1], int(row), measurement, model) for state in found]
                off = [float(np.nansum(np.abs(one - measured.response[row]) ** 2)) for one in seen]
                chosen[place] = found[int(np.argmin(off))]
    return chosen, branches


def _apart(states: Sequence[SteadyState]) -> list[SteadyState]:
    """Give states that differ, each once, in their order."""
    found: list[SteadyState] = []
    for state in states:
        size = SAME * np.abs(state.clamps[:, 1]).max(initial=0.0)
        if all(np.abs(state.clamps[:, 1] - other.clamps[:, 1]).max(initial=0.0) > size for other in found):
            found.append(state)
    return found


def _again_from_rest(system: SteadySystem, operation: Operation, solved: Balanced) -> Balanced:
    """Look once more for the steady states that weren't found, from rest."""
    lost = np.flatnonzero(~solved.found)
    again = balance(system, operation.rows(lost), np.zeros((lost.size, system.size)))
    unknowns, slopes, found = solved.unknowns.copy(), solved.slopes.copy(), solved.found.copy()
    unknowns[lost], slopes[lost], found[lost] = again.unknowns, again.slopes, again.found
    return Balanced(unknowns, slopes, found, solved.responses)


def _seen(probes: Complex, row: int, measurement: PipeMeasurement, model: CoupledModel) -> Complex:
    """Give what is recorded of the probes' displacements in mm at one sine, (probes,)."""
    measured = measurement.steady
    true = true_operation(model, measurement, slice(row, row + 1))
    moved = 1e-3 * probes[None] / (-1j * true.drive[0])
    seen = as_recorded(moved, true.frequency, measurement, model)[0]
    return np.asarray(np.where(measured.phased[row], seen, np.abs(seen)), dtype=np.complex128)


def _paths(system: SteadySystem, first: float, last: float) -> tuple[list[SteadyState], list[SteadyState]]:
    """Follow the response over a range of frequencies (Hz) from its lower and from its upper end, each in its order."""
    if first == last:
        state = system.at(first)
        return ([] if state is None else [state]), []
    return system.curve(first, last), system.curve(last, first)
