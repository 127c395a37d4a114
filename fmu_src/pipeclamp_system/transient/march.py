"""Neighbouring models of a pipe and its clamps, marched through one record together.

Over a step the loads are quadratic in time, through their values before it, at its start and at its end; the modes then
move exactly, by matrix exponentials. The clamps' forces at the end follow from their laws by Newton's method, begun
from forces that go on as they went. An array operation costs nearly the same for fifty models as for one: that makes
refits of many parameters affordable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.law.law import Law
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_models.realise.arrays import realise
from pipeclamp_system.coupling.march import SMALLEST_MOTION
from pipeclamp_system.transient.modal_step import modal_step

LAST_CORRECTION_SHARE = 1e-3
"""Share of the largest motion so far by which a correction may move the clamps and still be the last one."""
MOST_CORRECTIONS = 6
NUDGE = 1e-3
"""Of a law's v_r (mm/s) and y_r (mm): by so much motion is moved for the slopes of a force."""
BLOCK = 512
"""Steps that are kept until what the probes show is computed of them at once."""


@dataclass(frozen=True)
class HeldLaw:
    """A law with the A (mm), f (Hz) and T (K) that it is taken for."""

    law: Law
    amplitude: float
    frequency: float
    temperature: float


@dataclass(frozen=True)
class Variant:
    """A pipe in modes, and the law of each of its clamps."""

    pipe: ReducedPipe
    laws: tuple[HeldLaw, ...]


@dataclass(frozen=True, eq=False)
class MarchedModels:
    """What B models say.

    Attributes:
        probes: displacement (m), velocity or acceleration of each probe relative to the base, as asked, (B, n, probes).
        displacement: of each clamp, m, (B, n, clamps).
        velocity: m/s, likewise.
    """

    probes: Array
    displacement: Array
    velocity: Array


@one_thread()
def march(variants: Sequence[Variant], drive: Array, step: float, every: int, orders: Sequence[int]) -> MarchedModels:
    """March models from rest through an excitation.

    Args:
        variants: the models, B of them, alike in modes, clamps and structures of laws.
        drive: m/s2 of the base or N, at each step, (every (n - 1) + 1,).
        step: s.
        every: of so many steps one is asked for.
        orders: how often each probe's displacement is differentiated by time.
    """
    modal = _Modal(variants, step, orders)
    laws = _Laws([variant.laws for variant in variants], step)
    count, clamps, size = len(variants), modal.clamps, modal.size
    before, now = laws.at_rest(), laws.at_rest()
    given = np.zeros((count, size + 2 * clamps + 3))
    extended = np.concatenate([[2 * drive[0] - drive[1]], drive])
    samples, remember = (drive.size - 1) // every + 1, laws.remember
    kept = np.zeros((BLOCK, count, size + clamps + 1))
    kept[0, :, size:] = np.hstack([now, np.full((count, 1), drive[0])])
    filled, done = 1, 0
    seen = np.empty((count, samples, modal.seen.shape[1]))
    largest = np.full((count, 2 * clamps), SMALLEST_MOTION)
    with np.errstate(all="ignore"):
        for index in range(1, drive.size):
            given[:, size : size + clamps], given[:, size + clamps : size + 2 * clamps] = before, now
            given[:, -3:] = extended[index - 1 : index + 2]
            free = (modal.transition @ given[:, :, None])[:, :, 0]
            force = 2 * now - before
            for _ in range(MOST_CORRECTIONS if clamps else 0):
                moved = free[:, size:] + _pushed(modal.answers, force)
                change = laws.correction(moved, force, modal.answers)
                force = force + change
                np.maximum(largest, np.abs(moved), out=largest)
                if not np.any(np.abs(_pushed(modal.answers, change)) > LAST_CORRECTION_SHARE * largest):
                    break
            if remember:
                laws.accept(free[:, size:] + _pushed(modal.answers, force))
            before, now = now, force
            given[:, :size] = free[:, :size] + _pushed(modal.ends, force)
            if index % every == 0:
                kept[filled, :, :size], kept[filled, :, size:-1] = given[:, :size], now
                kept[filled, :, -1] = drive[index]
                filled += 1
            if filled == BLOCK or index == drive.size - 1:
                block = modal.seen @ np.moveaxis(kept[:filled], 0, 2)
                seen[:, done : done + filled] = np.swapaxes(block, 1, 2)
                done, filled = done + filled, 0
    probes = len(orders)
    return MarchedModels(seen[:, :, :probes], seen[:, :, probes : probes + clamps], seen[:, :, probes + clamps :])


def _pushed(answers: Array, force: Array) -> Array:
    """Give what forces, (B, c), make by their answers, (B, m, c): (B, m). Products of one column need no matrices."""
    if force.shape[1] == 1:
        return np.asarray(answers[:, :, 0] * force)
    return np.asarray((answers @ force[:, :, None])[:, :, 0])


class _Modal:
    """Matrices of B pipes for one step.

    Attributes:
        size: of the state (q, q').
        transition: from (state, clamp forces one step before and at its start, excitation at the three) to the state
            and the clamps' displacements and velocities at its end, without the forces there, (B, size + 2 c, ...).
        ends, answers: what those forces add to the state, and to the clamps' motion, (B, size, c), (B, 2 c, c).
        seen: from (state, clamp forces, excitation) to the probes and the clamps' motion, (B, probes + 2 c, ...).
    """

    def __init__(self, variants: Sequence[Variant], step: float, orders: Sequence[int]) -> None:
        pipes = [variant.pipe for variant in variants]
        modes, self.clamps, self.size = len(pipes[0].omega), len(variants[0].laws), 2 * len(pipes[0].omega)
        shapes = np.array([pipe.clamp_shapes for pipe in pipes]).reshape(len(pipes), self.clamps, modes)
        probes = np.array([pipe.probe_shapes for pipe in pipes]).reshape(len(pipes), len(orders), modes)
        shaken = np.array([pipe.excitation_participation for pipe in pipes])
        loads = np.concatenate([-np.swapaxes(shapes, 1, 2), shaken[:, :, None]], axis=2)
        rates = np.zeros((len(pipes), modes, self.size))
        for rate, pipe in zip(rates, pipes, strict=True):
            rate[:] = np.hstack([-pipe.stiffness_matrix, -pipe.damping_matrix])
        start, (held, sloped, curved) = modal_step(rates, loads, step, 3)
        # The quadratic through a load's values before the step, at its start and at its end.
        by_load = (curved - sloped / 2, held - 2 * curved, curved + sloped / 2)
        earlier, first, last = by_load
        clamps = slice(0, self.clamps)
        transition = np.concatenate(
            [start, earlier[:, :, clamps], first[:, :, clamps], *(part[:, :, -1:] for part in by_load)], axis=2
        )
        none = np.zeros_like(shapes)
        points = np.block([[shapes, none], [none, shapes]])
        self.transition = np.concatenate([transition, points @ transition], axis=1)
        self.ends = np.ascontiguousarray(last[:, :, clamps])
        self.answers = points @ self.ends
        self.seen = np.zeros((len(pipes), len(orders) + 2 * self.clamps, self.size + self.clamps + 1))
        for row, order in enumerate(orders):
            shape = probes[:, row : row + 1]
            if order == 2:
                self.seen[:, row : row + 1] = np.concatenate([shape @ rates, shape @ loads], axis=2)
            else:
                self.seen[:, row, order * modes : (order + 1) * modes] = shape[:, 0]
        self.seen[:, len(orders) :, : self.size] = points


class _Laws:
    """The laws of all clamps of B models, those of one structure evaluated together."""

    def __init__(self, laws: Sequence[Sequence[HeldLaw]], step: float) -> None:
        self._count, self._clamps = len(laws), len(laws[0])
        structures = [held.law.structure for held in laws[0]]
        self._groups = [
            _Group([[laws[row][index] for row in range(self._count)] for index in chosen], chosen, self._clamps, step)
            for structure in dict.fromkeys(structures)
            if (chosen := [index for index, own in enumerate(structures) if own == structure])
        ]

    @property
    def remember(self) -> bool:
        """Whether a force depends on the motion before."""
        return any(group.remembers for group in self._groups)

    def at_rest(self) -> Array:
        """Give the forces at rest, N, (B, c)."""
        forces = np.zeros((self._count, self._clamps))
        for group in self._groups:
            none = np.zeros((group.size, self._count))
            forces[:, group.displacements] = group.forces(none, none).T
        return forces

    def correction(self, moved: Array, force: Array, answers: Array) -> Array:
        """Give by what the forces (N, (B, c)) at a motion (m, m/s, (B, 2 c)) have to change, linearised, (B, c)."""
        clamps = self._clamps
        missed, slopes = np.empty_like(force), np.empty_like(moved)
        for group in self._groups:
            y, v = 1e3 * moved[:, group.displacements].T, 1e3 * moved[:, group.velocities].T
            value, by_y, by_v = group.with_slopes(y, v)
            missed[:, group.displacements] = value.T - force[:, group.displacements]
            slopes[:, group.displacements], slopes[:, group.velocities] = 1e3 * by_y.T, 1e3 * by_v.T
        follows = slopes[:, :clamps, None] * answers[:, :clamps] + slopes[:, clamps:, None] * answers[:, clamps:]
        if clamps == 1:
            return np.asarray(missed / (1.0 - follows[:, 0]))
        return np.asarray(np.linalg.solve(np.eye(clamps) - follows, missed[:, :, None])[:, :, 0])

    def accept(self, moved: Array) -> None:
        """Take a motion for the end of the step."""
        for group in self._groups:
            group.accept(1e3 * moved[:, group.displacements].T, 1e3 * moved[:, group.velocities].T)


class _Group:
    """Laws of one structure, at some clamps of B models; arrays are (clamps, B), in mm and N."""

    def __init__(self, laws: Sequence[Sequence[HeldLaw]], places: Sequence[int], clamps: int, step: float) -> None:
        equations = laws[0][0].law.structure.equations_without_rig
        compiled = realise(equations)
        self.size = len(places)
        self.displacements, self.velocities = _chosen(places), _chosen([clamps + place for place in places])

        def table(value: Any) -> Array:
            return np.array([[value(held) for held in row] for row in laws], dtype=np.float64)

        values = [table(lambda held, name=name: held.law.values[name]) for name in equations.names]
        smoothing = [table(lambda held: held.law.v_r), table(lambda held: held.law.y_r)]
        slow = {
            "A": table(lambda held: held.amplitude),
            "f": table(lambda held: held.frequency),
            "T": table(lambda held: held.temperature),
        }
        coefficients = compiled.coefficients(*(slow[name] for name in compiled.slow), *values, *smoothing)
        self._held = [*coefficients, *values, *smoothing]
        self._force, self._update = compiled.force, compiled.update
        self.remembers = bool(equations.states)
        self._y, self._step = np.zeros(values[0].shape), step
        self._states = [np.full(self._y.shape, float(state.start)) for state in equations.states]
        self._y_moved, self._v_moved = (np.empty((3, *self._y.shape)) for _ in range(2))
        self._nudges = [NUDGE * smoothing[1], NUDGE * smoothing[0]]

    def forces(self, y: Array, v: Array) -> Array:
        """Give the forces at motions, (..., clamps, B)."""
        fast = [y, v, 0.0, self._y, self._step]
        states = self._updated(y, v)
        return np.asarray(np.broadcast_to(self._force(*fast, *states, *self._held)[0], y.shape))

    def _updated(self, y: Array, v: Array) -> list[Array]:
        if not self._states:
            return []
        return list(self._update(y, v, 0.0, self._y, self._step, *self._states, *self._held))

    def with_slopes(self, y: Array, v: Array) -> tuple[Array, Array, Array]:
        """Give the forces and their derivatives by y and by v."""
        by_y, by_v = self._nudges
        self._y_moved[:], self._v_moved[:] = y, v
        self._y_moved[1] += by_y
        self._v_moved[2] += by_v
        value, at_y, at_v = self.forces(self._y_moved, self._v_moved)
        return value, (at_y - value) / by_y, (at_v - value) / by_v

    def accept(self, y: Array, v: Array) -> None:
        """Take a motion for the end of the step."""
        self._states = [np.broadcast_to(state, y.shape) for state in self._updated(y, v)]
        self._y = y


def _chosen(places: Sequence[int]) -> slice | list[int]:
    """Give places as a slice where they are neighbours, which is cheaper."""
    first, last = places[0], places[-1] + 1
    return slice(first, last) if list(places) == list(range(first, last)) else list(places)
