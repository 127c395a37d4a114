"""Steady motions found in time: cycles are marched until they repeat.

Where friction holds a clamp's place within a clearance, any place of a range is a solution of the balance, and its
corrections jump between them. A march has the place to which the motion itself brings the clamp. It comes to what is
stable only, and says so where nothing repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, log, pi

import numpy as np
from scipy.linalg import expm

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_models.realise.scalar_law import scalar_law
from pipeclamp_models.steps.tracker import AVERAGING, amplitude_and_frequency
from pipeclamp_system.steady.clamp import SteadyClamp, harmonics_of
from pipeclamp_system.transient.modal_step import modal_step

FEWEST_STEPS_PER_CYCLE, MOST_STEPS_PER_CYCLE, STEPS_A_PERIOD = 1024, 16384, 10
"""Of a cycle; and of the period of the pipe's highest mode, at least."""

ERRS = 2e-3
"""Share of a motion's rms by which it may change where its steps are halved."""

FEWEST_CYCLES_MARCHED, MOST_CYCLES_MARCHED = 10, 600
"""That are marched until the motion repeats."""

REPEATING_SHARE = 2e-4
"""Share of a motion's rms that it may still be off a motion that repeats."""

LATELY = 5
"""Cycles over which the rate is told at which a motion comes to repeat."""

TELLING_SHARE = 1e-9
"""Share of a motion's rms below which the change from cycle to cycle tells no rate any more."""

HOPELESS_CYCLES, LOOKED_BACK = 150, 40
"""Cycles after which a march ends whose changes don't die out fast enough; they are held against those so many cycles
before."""

ROUND_SHARE, LONGEST_ROUND, KEPT = 2e-3, 12, 48
"""Share by which a motion that comes round in several cycles may be off itself then, most of these cycles, and cycles
that are kept to tell."""

MOST_HARMONICS = 128
"""Harmonics of a marched motion that are given, from 0."""


@dataclass(frozen=True, eq=False)
class Standing:
    """Pipe and clamps at the beginning of a cycle.

    Attributes:
        modal: (q, q'), (2 m,).
        memory: the laws' states, (clamps, most of one).
        force: N, (clamps,).
        largest: of the forces so far, N.
        averages: of y, y^2, v^2 in two stages, as the tracker has them, (clamps, 6).
        conditions: A (mm) and f (Hz) of each clamp, (clamps, 2).
    """

    modal: Array
    memory: Array
    force: Array
    largest: float
    averages: Array
    conditions: Array


@dataclass(frozen=True, eq=False)
class MarchedMotion:
    """A motion under a sine to which a march came.

    Attributes:
        frequency: Hz.
        round: cycles in which the motion comes round: 1 of a steady motion; 0 where it doesn't.
        cycles: that were marched.
        decay: by which the change from cycle to cycle grew in the end, 1/s; below 0 where it died out.
        error: share of the rms by which the motion changed when its steps were halved.
        low, high: smallest and largest amplitude of a cycle, mm, (points,): the clamps, then the probes.
        points: harmonics of the displacement of clamps and probes, mm, (points, h), of the last cycle.
        forces: harmonics of the forces into the clamps, N, (clamps, h).
        conditions: A (mm) and f (Hz) that each clamp's law was taken for, (clamps, 2).
        end: pipe and clamps at its end: the march at a neighbouring frequency goes on from there.
    """

    frequency: float
    round: int
    cycles: int
    decay: float
    error: float
    low: Array
    high: Array
    points: ComplexArray
    forces: ComplexArray
    conditions: Array
    end: Standing


class InTime:
    """A pipe with its clamps under a sine, marched cycle by cycle."""

    def __init__(self, pipe: ReducedPipe, clamps: Sequence[SteadyClamp], shapes: Array) -> None:
        """Keep what is marched; shapes are the displacement of each clamp per unit of each mode, (clamps, m)."""
        self._clamps, self._shapes = clamps, shapes
        self._stiffness, self._damping = np.array(pipe.stiffness_matrix), np.array(pipe.damping_matrix)
        self._shaken = np.array(pipe.excitation_participation)
        probes = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), self._shaken.size)
        self._points = MM * np.vstack([shapes, probes])
        self._scalar = [scalar_law(clamp.law) for clamp in clamps]
        self._from_rest: dict[tuple[float, float], MarchedMotion | None] = {}

    @cached_property
    def _machine(self) -> Callable[..., float]:
        from pipeclamp_system.steady.cycles import machine_clamps

        found: Callable[..., float] = machine_clamps(self._scalar)
        return found

    def at_rest(self, frequency: float) -> Standing:
        """Give pipe and clamps at rest."""
        memory = np.zeros((len(self._clamps), max((len(law.states) for law in self._scalar), default=0)))
        for row, law in zip(memory, self._scalar, strict=True):
            row[: len(law.states)] = [start for _, start in law.states]
        still = np.zeros((1, 1), dtype=np.complex128)
        at = np.array([frequency])
        conditions = np.array([[float(one[0]) for one in c.conditions(still, at)] for c in self._clamps])
        count = len(self._clamps)
        return Standing(
            np.zeros(2 * self._shaken.size), memory, np.zeros(count), 1e-6, np.zeros((count, 6)),
            conditions.reshape(count, 2),
        )  # fmt: skip

    def at(self, frequency: float, drive: float, begin: Standing | None = None) -> MarchedMotion | None:
        """March at a frequency (Hz) under a sine of an amplitude (m/s2 or N) until the motion repeats.

        What begins at rest is remembered: a curve's beginning is asked for by all who look for it.

        Args:
            frequency: Hz.
            drive: m/s2 or N.
            begin: where it begins; None for rest.

        Returns:
            the motion; None where it has no numbers.
        """
        if begin is not None:
            return self._in_steps_enough(frequency, drive, begin)
        key = frequency, drive
        if key not in self._from_rest:
            self._from_rest[key] = self._in_steps_enough(frequency, drive, self.at_rest(frequency))
        return self._from_rest[key]

    def _in_steps_enough(self, frequency: float, drive: float, begin: Standing) -> MarchedMotion | None:
        """March until the motion repeats, in steps that are halved until that hardly changes it."""
        highest = float(np.sqrt(np.abs(np.linalg.eigvals(self._stiffness)).max())) / (2 * pi)
        steps = max(FEWEST_STEPS_PER_CYCLE, ceil(STEPS_A_PERIOD * highest / frequency))
        found = self._repeated(frequency, drive, begin, steps)
        if found is not None and found.round != 1:  # it may be the steps that keep it from repeating
            steps *= 2
            finer = self._repeated(frequency, drive, found.end, steps)
            found = None if finer is None else replace(finer, cycles=found.cycles + finer.cycles)
        while found is not None and found.round == 1:
            steps *= 2
            finer = self._repeated(frequency, drive, found.end, steps)
            if finer is None:
                return None
            error = _rms(finer.points - found.points) / max(_rms(finer.points), 1e-300)
            cycles = found.cycles + finer.cycles
            found = replace(finer, cycles=cycles, error=error, decay=found.decay)
            if error <= ERRS or steps >= MOST_STEPS_PER_CYCLE:
                return found
        return found

    def _repeated(self, frequency: float, drive: float, begin: Standing, steps: int) -> MarchedMotion | None:
        """March in so many steps a cycle until the motion repeats."""
        march = _Cycles(self, frequency, drive, steps)
        kept: list[Array] = []
        changes: list[float] = []
        now = begin
        for cycle in range(1, MOST_CYCLES_MARCHED + 1):
            now, modal, forces = march.onward(now)
            if not np.all(np.isfinite(modal)):
                return None
            kept = [*kept[1 - KEPT :], self._points @ modal[:, : self._shaken.size].T]
            if cycle > 1:
                changes.append(_change(kept[-1], kept[-2]))
            if cycle >= FEWEST_CYCLES_MARCHED and _missing(changes) <= REPEATING_SHARE:
                return self._marched_motion(frequency, 1, cycle, changes, kept[-1:], forces, now)
            if (
                cycle % LOOKED_BACK == 0
                and cycle >= HOPELESS_CYCLES
                and _too_slow(changes, MOST_CYCLES_MARCHED - cycle)
            ):
                break
        return self._marched_motion(frequency, _round(kept), cycle, changes, kept, forces, now)

    def _marched_motion(
        self, frequency: float, round_: int, cycles: int, changes: Sequence[float], kept: Sequence[Array],
        forces: Array, end: Standing,
    ) -> MarchedMotion:  # fmt: skip
        ranges = np.array([np.ptp(one, axis=1) / 2 for one in kept])
        # What a step ends with stands at its end: the last one is the cycle's beginning.
        points, into = (
            harmonics_of(np.roll(signals, 1, axis=1), min(MOST_HARMONICS, signals.shape[1] // 2))
            for signals in (kept[-1], forces.T)
        )
        decay = frequency * log(max(_rate(changes), np.finfo(float).tiny))
        return MarchedMotion(
            frequency, round_, cycles, decay, 0.0, ranges.min(axis=0), ranges.max(axis=0), points, into,
            end.conditions, end,
        )  # fmt: skip


class _Cycles:
    """Cycles at one frequency in so many steps each."""

    def __init__(self, system: InTime, frequency: float, drive: float, steps: int) -> None:
        self._system, self._frequency, self._steps = system, frequency, steps
        shapes, size = system._shapes, system._shaken.size
        self._h = 1 / (frequency * steps)
        rates = np.hstack([-system._stiffness, -system._damping])
        onward, (held, sloped) = modal_step(rates, -shapes.T, self._h, 2)
        omega = 2 * pi * frequency
        whole = np.zeros((2 * size + 2, 2 * size + 2))
        whole[:size, size : 2 * size] = np.eye(size)
        whole[size : 2 * size, : 2 * size], whole[size : 2 * size, -2] = rates, drive * system._shaken
        whole[-2, -1], whole[-1, -2] = omega, -omega
        turn = omega * self._h * np.arange(steps)
        sine = np.stack([np.sin(turn), np.cos(turn)], axis=1) @ expm(self._h * whole)[: 2 * size, -2:].T
        seen = MM * np.block([[shapes, np.zeros_like(shapes)], [np.zeros_like(shapes), shapes]])
        self._seen = seen
        self._matrices = [np.ascontiguousarray(one) for one in (onward, sine, held, sloped, seen)]

    def onward(self, begin: Standing) -> tuple[Standing, Array, Array]:
        """March a cycle; also give (q, q') and the forces after each step, (n, 2 m) and (n, clamps)."""
        from pipeclamp_system.steady.cycles import marched

        system, count = self._system, begin.force.size
        coefficients = [
            law.coefficients(*condition, clamp.temperature, *(clamp.further[name] for name in law.further))
            for law, clamp, condition in zip(system._scalar, system._clamps, begin.conditions.tolist(), strict=True)
        ]
        held = np.zeros((count, max(map(len, coefficients), default=0)))
        for row, values in zip(held, coefficients, strict=True):
            row[: len(values)] = values
        modal, memory, force = begin.modal.copy(), begin.memory.copy(), begin.force.copy()
        largest = np.array([begin.largest])
        path, forces = np.empty((self._steps, modal.size)), np.empty((self._steps, count))
        onward, sine, held_loads, sloped, seen = self._matrices
        marched(
            system._machine, held, memory, modal, force, largest, onward, sine, held_loads, sloped, seen, self._h, path,
            forces,
        )  # fmt: skip
        averages, conditions = self._followed(begin, path)
        return Standing(modal, memory, force, float(largest[0]), averages, conditions), path, forces

    def _followed(self, begin: Standing, path: Array) -> tuple[Array, Array]:
        """Give the averages of the clamps' motion, and A (mm) and f (Hz) of it, after a cycle."""
        averages, conditions, count = begin.averages.copy(), begin.conditions.copy(), begin.force.size
        y, v = np.split((path @ self._seen.T).T, [count])
        share = 1 - np.exp(-1 / AVERAGING)
        for place, clamp in enumerate(self._system._clamps):
            if clamp.amplitude is not None:
                continue
            for column, value in enumerate((y[place].mean(), (y[place] ** 2).mean(), (v[place] ** 2).mean())):
                first, second = 2 * column, 2 * column + 1
                averages[place, first] += share * (value - averages[place, first])
                averages[place, second] += share * (averages[place, first] - averages[place, second])
            A, f = amplitude_and_frequency(tuple(averages[place].tolist()), self._frequency, clamp.range_A[0])
            conditions[place] = np.clip(A, *clamp.range_A), np.clip(f, *clamp.range_f)
        return averages, conditions


def _rms(points: ComplexArray) -> float:
    return float(np.linalg.norm(points[:, 1:]))


def _change(after: Array, before: Array) -> float:
    """Give by how much cycles differ, (points, n), as a share of the rms, of the point that differs most."""
    moved = np.sqrt(np.mean((after - before) ** 2, axis=1))
    size = np.maximum(after.std(axis=1), 1e-3 * after.std(axis=1).max())
    return float((moved / np.maximum(size, 1e-300)).max(initial=0.0))


def _rate(changes: Sequence[float]) -> float:
    """Give by which factor the change from cycle to cycle fell lately, while it told anything."""
    telling = [change for change in changes if change > TELLING_SHARE]
    if len(telling) < 2:
        return 0.0
    last = telling[-LATELY - 1 :]
    return float((last[-1] / last[0]) ** (1 / (len(last) - 1)))


def _missing(changes: Sequence[float]) -> float:
    """Give how far a motion still is from one that repeats: the rest of the geometric series of its changes."""
    last = max(changes[-3:])
    if last <= TELLING_SHARE:
        return 0.0
    rate = _rate(changes)
    return last * rate / (1 - rate) if rate < 1 else np.inf


def _too_slow(changes: Sequence[float], left: int) -> bool:
    """Tell whether changes don't die out within the cycles that are left."""
    before, lately = (max(part) for part in (changes[-2 * LOOKED_BACK : -LOOKED_BACK], changes[-LOOKED_BACK:]))
    return lately * (lately / before) ** (left / LOOKED_BACK) > REPEATING_SHARE if lately < before else True


def _round(kept: Sequence[Array]) -> int:
    """Give in how many cycles the last ones come round; 0 where they don't."""
    for length in range(1, LONGEST_ROUND + 1):
        if max(_change(after, before) for before, after in zip(kept, kept[length:], strict=False)) <= ROUND_SHARE:
            return length
    return 0
