"""What a coupled model's probes show at the sines of a measurement: the branch that was measured, balanced."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.on_pipe.measurement import PipeMeasurement, SteadyMeasurement
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray
from pipeclamp_models.pipe.description import PipeDescription
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.continuation import Solution
from pipeclamp_system.steady.detached import leaving_branches
from pipeclamp_system.steady.harmonics import packed, resized
from pipeclamp_system.steady.points import Balanced, Operation, balance, fundamentals
from pipeclamp_system.steady.start import grown
from pipeclamp_system.steady.states import SteadyState

SAME_LEVEL = 0.06
"""Sines whose excitation differs by less, as a share, are of one level."""

HARMONIC_CLASSES = (3, 5, 9, 15, 23, 32)
"""Harmonics up to which sines are balanced together: those that ask for about as many."""

SAME_MOTION_SHARE = 1e-3
"""Motions whose fundamentals differ by less, as a share, are one."""


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
    rows: IntArray
    harmonics: int
    solved: Balanced


class Met(NamedTuple):
    """The steady states where a response passes a sine.

    Attributes:
        passed: those of the response itself, in the order of the sweep; `beside` of branches that leave it.
    """

    passed: tuple[SteadyState, ...]
    beside: tuple[SteadyState, ...]


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a model's probes show.

    Attributes:
        response: as of `SteadyMeasurement`, nan where no steady state was found, (P, probes).
        clamps: fundamental of each clamp's displacement, mm, (P, clamps).
        groups: the steady states, sines that ask for about as many harmonics together.
        branches: how many stable states there are, (P,); 1 unless it was looked for.
        model: pipe and clamps that it is of.
        met: where the response that was followed passes each sine; None where it wasn't followed.
        work: that was done to follow it, as of `Work`.
    """

    response: ComplexArray
    clamps: ComplexArray
    groups: tuple[Group, ...]
    branches: IntArray
    model: CoupledModel
    met: Mapping[int, Met] | None = None
    work: float = 0.0


def temperatures(measured: SteadyMeasurement) -> Iterator[tuple[float | None, IntArray]]:
    """Give each temperature of the clamps, None for the system's own, and the sines at it."""
    own = np.isnan(measured.temperature)
    if own.any():
        yield None, np.flatnonzero(own)
    for temperature in np.unique(measured.temperature[~own]).tolist():
        yield temperature, np.flatnonzero(measured.temperature == temperature)


def predict(
    model: CoupledModel,
    measurement: PipeMeasurement,
    near: Prediction | None = None,
    followed: Prediction | None = None,
) -> Prediction:
    """Give what a model's probes show at a measurement's sines.

    Where the response has several stable branches, a sweep up follows the one from low frequencies, a sweep down that
    from high ones, as far as they are stable and then the branches that leave them; without a sweep it is the stable
    one nearest to the measured response.

    Args:
        model: pipe and clamps.
        measurement: the sines.
        near: of a neighbouring model, whose branches are kept; else they are found by following the response.
        followed: of a model whose response was followed: where this one moves likewise, it isn't followed again.

    Raises:
        UserError: the pipe can't be reduced.
    """
    measured = measurement.steady
    shape = measured.response.shape
    response, clamps = np.full(shape, np.nan + 0j), np.full((shape[0], len(model.clamp_names)), np.nan + 0j)
    met, work = dict[int, Met](), 0.0
    if near is not None:
        begun, branches = list(map(_from_near, near.groups)), near.branches
    else:
        if followed and followed.met and model.moves_as(followed.model):
            met = (
                dict(followed.met)
                if model.pipe == followed.model.pipe
                else _seen_elsewhere(followed, model, measurement)
            )
        else:
            met, work = _followed(model, measurement)
        begun, branches = _begun(model, measurement, met)
    groups = []
    # What is but seen otherwise is balanced already, unless something wasn't found.
    alike = near is not None and model.moves_as(near.model) and all(group.solved.found.all() for group in near.groups)
    for begin in begun:
        rows = begin.rows
        operation = true_operation(model, measurement, rows)
        system = model.system(begin.temperature, lambda frequency: 1.0, begin.harmonics)
        if alike and begin.solved is not None:
            solved = replace(begin.solved, responses=system.responses(operation.frequency))
        else:
            solved = balance(system, operation, begin.unknowns, begin.slopes)
            if near is not None and not solved.found.all():
                solved = _again_from_rest(system, operation, solved)
        moved = fundamentals(system, operation, solved)
        count = len(model.clamp_names)
        clamps[rows] = 1e3 * operation.drive[:, None] * moved[:, :count]
        response[rows] = as_recorded(moved[:, count:], operation.frequency, measurement, model)
        groups.append(Group(begin.temperature, rows, begin.harmonics, solved))
    return Prediction(response, clamps, tuple(groups), branches, model, None if near is not None else met, work)


def true_operation(
    model: CoupledModel, measurement: PipeMeasurement, rows: IntArray | slice = slice(None)
) -> Operation:
    """Give the sines that a model's measuring chain takes the stated ones for, some of its rows."""
    measured = measurement.steady
    drive = model.instrument.true_drive(from_displacement(measured)) * measured.drive[rows]
    return Operation(model.instrument.frequency * measured.frequency[rows], drive)


def from_displacement(measured: SteadyMeasurement) -> bool:
    """Tell whether the base's acceleration was made from its displacement by the stated frequency."""
    return measured.drive_unit == "displacement_mm"


def as_recorded(
    moved: ComplexArray, frequency: Array, measurement: PipeMeasurement, model: CoupledModel
) -> ComplexArray:
    """Turn displacements relative to the base over the excitation into what is recorded of the probes, (P, probes)."""
    seen = as_measured(moved, frequency, measurement, model.pipe)
    names = [probe.name for probe in model.pipe.probes]
    return model.instrument.recorded(names, seen, frequency, from_displacement(measurement.steady))


def as_measured(
    moved: ComplexArray, frequency: Array, measurement: PipeMeasurement, pipe: PipeDescription
) -> ComplexArray:
    """Turn displacements relative to the base over the excitation into what the probes measure, (P, probes)."""
    turn = 2j * np.pi * frequency
    columns = []
    for column, probe in zip(moved.T, measurement.description.probes, strict=True):
        base = 1 / turn**2 if probe.absolute and pipe.excitation.kind == "base" else 0.0
        columns.append((column + base) * turn**probe.order)
    return np.column_stack(columns).astype(np.complex128)


class _Begin(NamedTuple):
    """From where the steady states of a group of sines are sought.

    Attributes:
        temperature, rows, harmonics: as of `Group`.
        unknowns, slopes: as of `Balanced`; slopes are None where none are known that may still serve.
        solved: the steady states of the neighbour; None where there is none.
    """

    temperature: float | None
    rows: IntArray
    harmonics: int
    unknowns: Array
    slopes: Array | None
    solved: Balanced | None = None


def _from_near(group: Group) -> _Begin:
    solved = group.solved
    return _Begin(group.temperature, group.rows, group.harmonics, solved.unknowns, solved.slopes, solved)


def _begun(model: CoupledModel, measurement: PipeMeasurement, met: Mapping[int, Met]) -> tuple[list[_Begin], IntArray]:
    """Give from where groups of sines begin, and how many stable states each sine has."""
    groups, branches = list[_Begin](), np.ones(measurement.steady.response.shape[0], dtype=np.intp)
    for temperature, rows in temperatures(measurement.steady):
        states, branches[rows] = _first_states(model, measurement, rows, met)
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
            groups.append(_Begin(temperature, rows[own], harmonics, packed(guess), None))
    return groups, branches


def _harmonics(model: CoupledModel, state: SteadyState | None) -> int:
    """Give up to which harmonic a sine is balanced."""
    if model.harmonics is not None:
        return model.harmonics
    return (
        HARMONIC_CLASSES[0]
        if state is None
        else min(H for H in HARMONIC_CLASSES if min(state.harmonics, HARMONIC_CLASSES[-1]) <= H)
    )


def _followed(model: CoupledModel, measurement: PipeMeasurement) -> tuple[dict[int, Met], float]:
    """Give where the response passes each sine, by row, and the work that it took.

    The response is followed from both ends: where it bends, each meets branches that the other doesn't. So are the
    less symmetric branches that leave it: where these are, it is unstable itself.
    """
    measured = measurement.steady
    true = true_operation(model, measurement)
    met, work = dict[int, Met](), 0.0
    for temperature, rows in temperatures(measured):
        for level in number_levels(measured.level[rows], relative=SAME_LEVEL):
            own = rows[level.rows]
            frequency, inverse = np.unique(true.frequency[own], return_inverse=True)
            drive = np.bincount(inverse, true.drive[own]) / np.bincount(inverse)
            system = model.system(temperature, lambda f, at=frequency, of=drive: float(np.interp(f, at, of)))  # type: ignore[misc]
            first, last = float(frequency[0]), float(frequency[-1])
            upwards, downwards = _paths(system, first, last)
            leaving = _leaving(system, [upwards, *([] if downwards is None else [downwards])], first, last)
            for row in own.tolist():
                f, sweep = float(true.frequency[row]), measured.sweep[row]
                if downwards is None:
                    paths = [upwards if sweep >= 0 else upwards[::-1]]
                else:
                    paths = [upwards, downwards] if sweep >= 0 else [downwards, upwards]
                passed, beside = (
                    tuple(system.state(unknowns, f) for path in some for unknowns in system.passing(path, f))
                    for some in (paths, leaving)
                )
                met[row] = Met(passed, beside)
            work += system.work.done
    return met, work


def _seen_elsewhere(followed: Prediction, model: CoupledModel, measurement: PipeMeasurement) -> dict[int, Met]:
    """Give where a response passes each sine, as other probes see it: those of a model that moves alike."""
    met = dict[int, Met]()
    drive = true_operation(model, measurement).drive
    for temperature, rows in temperatures(measurement.steady):
        for row in rows.tolist():
            system = model.system(temperature, lambda _, of=float(drive[row]): of)  # type: ignore[misc]
            passed, beside = (
                tuple(system.state(packed(one.balanced[None])[0], one.frequency, one.side) for one in some)
                for some in (followed.met or {})[row]
            )
            met[row] = Met(passed, beside)
    return met


def _first_states(
    model: CoupledModel, measurement: PipeMeasurement, rows: IntArray, met: Mapping[int, Met]
) -> tuple[list[SteadyState | None], IntArray]:
    """Give the steady states at some sines, stable ones where there are any, and how many of those each has."""
    measured = measurement.steady
    chosen: list[SteadyState | None] = [None] * rows.size
    branches = np.ones(rows.size, dtype=np.intp)
    for place, row in enumerate(rows.tolist()):
        sweep, (passed, beside) = measured.sweep[row], met[row]
        everywhere = _apart([*passed, *beside])
        found = [state for state in everywhere if state.stable]
        branches[place] = max(1, len(found))
        if not everywhere:
            continue
        chosen[place] = met_in_sweep(passed, beside) if sweep else (found or everywhere)[0]
        if len(found) > 1 and sweep == 0:
            seen = [_seen(state.probes[:, 1], row, measurement, model) for state in found]
            off = [float(np.nansum(np.abs(one - measured.response[row]) ** 2)) for one in seen]
            chosen[place] = found[int(np.argmin(off))]
    return chosen, branches


def met_in_sweep(passed: Sequence[SteadyState], beside: Sequence[SteadyState]) -> SteadyState:
    """Give the motion that a sweep meets at a frequency.

    It is the first on its way. Where that is unstable, the sweep goes on along a branch that leaves it, not along a
    stable motion farther away, to which nothing leads but a jump that may never happen: if there is no such branch, no
    steady motion is met, and the unstable one is given.

    Args:
        passed: where the response passes the frequency, in the order of the sweep; `beside` of it branches that leave.
    """
    first = next(iter(passed), None)
    if first is None or first.stable:
        return first or next((state for state in beside if state.stable), beside[0])
    stable = [state for state in (*beside, *passed) if state.stable]
    near = min(stable, key=lambda state: float(np.abs(state.clamps[:, 1] - first.clamps[:, 1]).max()), default=first)
    return near if any(near is state for state in beside) else first


def _leaving(
    system: SteadySystem, paths: Sequence[Sequence[Solution]], first: float, last: float
) -> list[list[Solution]]:
    """Follow the branches that leave paths between two frequencies (Hz), where one changes its side."""
    changes = [path for path in paths if any(one.side * other.side < 0 for one, other in pairwise(path))]
    known = [[system.state(one.unknowns, one.parameter, one.side) for one in path] for path in changes]
    return [
        [Solution(state.frequency, packed(state.balanced[None])[0], state.side) for state in branch]
        for branch in leaving_branches(system, known, first, last)
    ]


def _apart(states: Sequence[SteadyState]) -> list[SteadyState]:
    """Give states that differ, each once, in their order."""
    found: list[SteadyState] = []
    for state in states:
        size = SAME_MOTION_SHARE * np.abs(state.clamps[:, 1]).max(initial=0.0)
        if all(np.abs(state.clamps[:, 1] - other.clamps[:, 1]).max(initial=0.0) > size for other in found):
            found.append(state)
    return found


def _again_from_rest(system: SteadySystem, operation: Operation, solved: Balanced) -> Balanced:
    """Look once more for the steady states that weren't found, from rest."""
    lost = np.flatnonzero(~solved.found)
    again = balance(system, operation.rows(lost), np.zeros((lost.size, system.size)))
    unknowns, slopes, found = solved.unknowns.copy(), solved.slopes.copy(), solved.found.copy()
    unknowns[lost], slopes[lost], found[lost] = again.unknowns, again.slopes, again.found
    forces = solved.forces.copy()
    forces[lost] = again.forces
    return Balanced(unknowns, slopes, found, solved.responses, forces)


def _seen(probes: ComplexArray, row: int, measurement: PipeMeasurement, model: CoupledModel) -> ComplexArray:
    """Give what is recorded of the probes' displacements in mm at one sine, (probes,)."""
    measured = measurement.steady
    true = true_operation(model, measurement, slice(row, row + 1))
    moved = 1e-3 * probes[None] / (-1j * true.drive[0])
    seen = as_recorded(moved, true.frequency, measurement, model)[0]
    return np.asarray(np.where(measured.phased[row], seen, np.abs(seen)), dtype=np.complex128)


def _paths(system: SteadySystem, first: float, last: float) -> tuple[list[Solution], list[Solution] | None]:
    """Follow the response over a range of frequencies (Hz) from its lower and from its upper end, each in its order.

    Where the one leads to the motion that the other begins with, the other is the same way back: None.
    """
    if first == last:
        start = grown(system, first)
        return ([] if start is None else [Solution(first, start)]), []
    upwards = system.path(first, last)
    if upwards and upwards[-1].parameter == last:
        start = grown(system, last)
        ends = [upwards[-1].unknowns, *([] if start is None else [start])]
        if len(_apart([system.state(unknowns, last) for unknowns in ends])) == 1:
            return upwards, None
    return upwards, system.path(last, first)
