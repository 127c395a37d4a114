"""Clamps whose force steps with the velocity (dry friction), in harmonic balance: the side they slide to.

A step of force has harmonics that fall with 1/h only. Those beyond the H that are balanced hardly show in the motion,
but they move the instant at which it reverses, and hold a clamp that sticks there. So they aren't left out: with the
first H harmonics of the motion given, the side s of each clamp, between -1 and 1 and so chosen that

    v = v_H + Z_H (jump/2 s),    s in Sgn(v),

is found cell by cell of the cycle; Z_H is the pipe's mobility at the harmonics beyond H. As the pipe takes up energy,
there is one such s. It is the mean of sgn v over a cell in which v is straight: a reversal counts where it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_system.steady.clamp import SteadyClamp, harmonics_of, sampled
from pipeclamp_system.steady.harmonics import resized
from pipeclamp_system.steady.tangents import Passage, Tangents, V, Y, along, answered, arguments

CELLS = 1024
"""Of a cycle, in which the side is told."""

SLOW_SHARE, FLAT = 1e-3, 10.0
"""Share of the largest velocity, and multiple of that within which a law smooths sgn v: below it a clamp's force lies
between those of both sides there."""

SMOOTH_SHARE = 0.25
"""Share of the largest velocity up to which a law's own rounding of a step may reach: one that is wider is smooth in
the few harmonics of a motion."""

ROUNDED_SHARE = 3e-4
"""Share of the largest velocity within which the sign is rounded; at least as far as the law does."""

A_DOUBLING, ALONG_ROUNDING = 2, 64
"""Velocities within a doubling at which a step is looked for, and velocities at which its rounding is told."""

JUMPS, GROWS = 0.01, 0.02
"""Share of the force's range from which on its change between both sides is a step, and by which share that change may
grow where the velocity is doubled."""

ROUNDER = 30.0
"""By which factor the sign is rounded less from one solution to the next."""

OPEN = 256
"""Cells in which the sign is rounded at first, at most: they cost by their square and more."""

MOST_CORRECTIONS = 40
SMALLEST_CORRECTION = 1e-3
"""Newton's corrections of the velocities, and the smallest share of one."""

BALANCED = 1e-9
"""Share of the largest velocity to which they are found."""

MOST_REVERSING_CELLS = 3
"""Cells in which a clamp that doesn't stick reverses, at most: what takes longer is rounded, and followed in them."""


@dataclass(frozen=True, eq=False)
class Sign:
    """The side to which a law's force steps, over the velocity: straight between what is told, and 1 beyond.

    Attributes:
        speeds: as multiples of a width, from 0, ascending, (k,).
        sides: from 0 to 1, (k,). The area between them and 1 is half of the width: as of a straight one.
    """

    speeds: Array
    sides: Array

    @cached_property
    def _slopes(self) -> Array:
        return np.asarray(np.append(np.diff(self.sides) / np.diff(self.speeds), 0.0))

    @cached_property
    def _areas(self) -> Array:
        means = (self.sides[1:] + self.sides[:-1]) / 2
        return np.asarray(np.append(0.0, np.cumsum(means * np.diff(self.speeds))))

    def at(self, speeds: Array) -> tuple[Array, Array, Array]:
        """Give the side, its slope and its area from 0 on, at multiples of the width, of either sign."""
        size = np.abs(speeds)
        place = np.searchsorted(self.speeds, size, side="right") - 1
        beyond, slope = size - self.speeds[place], self._slopes[place]
        side = self.sides[place] + slope * beyond
        return np.sign(speeds) * side, slope, self._areas[place] + (self.sides[place] + slope * beyond / 2) * beyond


STRAIGHT_SIGN = Sign(np.array([0.0, 1.0]), np.array([0.0, 1.0]))


@dataclass(frozen=True, eq=False)
class ForceStep:
    """How a clamp's force steps with the velocity.

    Attributes:
        slow: velocity from which on the force is that of one side, mm/s.
        width: velocity up to which the step is rounded, were it straight, mm/s.
        sign: how it is rounded.
    """

    slow: float
    width: float
    sign: Sign


def step_of(clamp: SteadyClamp) -> ForceStep | None:
    """Tell how a clamp's force steps with the velocity, in the middle of its law's range; None where it doesn't.

    What grows with a small power of the velocity is steep, but no step; what grows up to a small velocity is one that
    is rounded.
    """
    A = clamp.amplitude or float(np.mean(clamp.range_A))
    f = clamp.frequency or float(np.mean(clamp.range_f))
    cycle = clamp.cycle(np.array([[0.0, A]], dtype=np.complex128), np.array([f]))
    largest = float(np.abs(cycle.v).max())
    sharp = max(SLOW_SHARE * largest, FLAT * clamp.law.v_r)
    widest = max(sharp, SMOOTH_SHARE * largest)
    tried = np.geomspace(sharp, widest, 1 + int(np.ceil(A_DOUBLING * np.log2(widest / sharp))))
    once, twice = np.split(np.abs(_half_jumps(clamp, cycle, np.append(tried, 2 * tried))), 2)
    most = once.max(axis=1)
    steps = (twice.max(axis=1) < (1 + GROWS) * most) & (2 * most > JUMPS * np.ptp(_force(clamp, cycle)))
    if not steps.any():
        return None
    first = int(np.argmax(steps))
    slow = float(tried[first])
    if slow == sharp:
        return ForceStep(0.0, clamp.law.v_r, STRAIGHT_SIGN)
    speeds = np.linspace(0.0, slow, ALONG_ROUNDING)
    where = int(np.argmax(once[first]))
    sides = np.append(0.0, np.abs(_half_jumps(clamp, cycle, speeds[1:])[:, where]))
    sides /= sides[-1]
    width = 2 * float(np.sum(1 - (sides[1:] + sides[:-1]) / 2) * speeds[1])
    return ForceStep(slow, width, Sign(speeds / width, sides))


def slow_speed(clamp: SteadyClamp, cycle: Motion, step: ForceStep) -> float:
    """Give the velocity below which a force lies between those of both sides, mm/s."""
    return max(SLOW_SHARE * float(np.abs(cycle.v).max()), FLAT * clamp.law.v_r, step.slow)


def half_jumps(clamp: SteadyClamp, cycle: Motion, step: ForceStep) -> Array:
    """Give half of what the force changes by from one side to the other, at rest, (n,)."""
    return np.asarray(_half_jumps(clamp, cycle, np.array([slow_speed(clamp, cycle, step)]))[0])


def _half_jumps(clamp: SteadyClamp, cycle: Motion, speeds: Array) -> Array:
    """Give half of what the force changes by from a velocity to the opposite one, at rest, (velocities, n)."""
    many = cycle.rows(np.zeros(2 * speeds.size, dtype=np.intp))
    v = np.concatenate([speeds, -speeds])[:, None] * np.ones_like(cycle.v)
    up, down = np.split(_force(clamp, _at_velocity(many, v)), 2)
    return np.asarray((up - down) / 2)


def _force(clamp: SteadyClamp, cycle: Motion) -> Array:
    equations = clamp.law.structure.equations_without_rig
    return force_of_equations(equations, clamp.law.vector(equations), (clamp.law.v_r, clamp.law.y_r), cycle).force


def _at_velocity(cycle: Motion, v: Array) -> Motion:
    """Give a motion with another velocity at its samples; that is then the one at which the force is wanted."""
    return replace(cycle, v=v, a=np.zeros_like(v))


@dataclass(frozen=True, eq=False)
class Sides:
    """Sides of clamps.

    Attributes:
        velocity: at the edges of the cells, mm/s, (clamps, n); those of cell i are i and i + 1.
        side: mean over each cell, from -1 to 1, (clamps, n).
        by_edge: its derivatives by the velocity at both edges of the cell, (2, clamps, n).
        where: edges of the cells whose side follows the velocity, among all, (E,).
        answers: how the velocities there follow those of the given motion, (E, E).
    """

    velocity: Array
    side: Array
    by_edge: Array
    where: IntArray
    answers: Array


def means_of_sign(v: Array, rounded: float, shape: Sign = STRAIGHT_SIGN) -> tuple[Array, Array]:
    """Give the mean of sgn v over cells in which v is straight, and its derivatives by v at both edges.

    Args:
        v: at the edges, (..., n), periodic.
        rounded: velocity up to which the sign is taken for straight, or what stands for it in another shape.
        shape: of the sign.
    """
    after = np.roll(v, -1, axis=-1)
    change = after - v
    same = np.abs(change) < 1e-9 * rounded
    size = np.where(same, 1.0, change)
    side, slope, area = shape.at(v / rounded)
    ahead, beyond = (np.roll(one, -1, axis=-1) for one in (side, area))
    one_sided = np.abs(side + ahead) == 2.0  # exactly, so that no velocity counts where none does
    mean = np.where(same | one_sided, side, rounded * (beyond - area) / size)
    slopes = [np.where(same, slope / (2 * rounded), one / size) for one in (mean - side, ahead - mean)]
    return mean, np.stack(slopes)


def _followed(by_edge: Array, changes: Array) -> Array:
    """Give what sides change by when the velocities at all edges do, (..., clamps, n)."""
    return np.asarray(by_edge[0] * changes + by_edge[1] * np.roll(changes, -1, axis=-1))


class Friction:
    """The clamps of a pipe, at one frequency, with the harmonics beyond H that their steps of force make."""

    def __init__(
        self,
        clamps: Sequence[SteadyClamp],
        steps: Sequence[ForceStep],
        frequency: float,
        responses: ComplexArray,
        balanced: int,
        motion: ComplexArray,
    ) -> None:
        """Prepare what the pipe answers beyond H, with the clamps' own stiffness and damping about a motion.

        Args:
            clamps: with `CELLS` samples each.
            steps: of their forces.
            frequency: Hz.
            responses: of the clamps to forces into each, mm/N, (clamps, clamps, CELLS/2 + 1).
            balanced: H.
            motion: harmonics of the clamps' motion, mm, (clamps, h); those beyond H are added to the steps' own.
        """
        order = np.arange(responses.shape[2])
        self.clamps, self.steps, self.frequency = clamps, steps, frequency
        self._turn = 2j * pi * frequency * order
        self._to_edge = np.exp(-1j * pi * order / CELLS)
        self._given = resized(motion, order.size)
        cycles = [clamp.cycle(one[None], np.array([frequency])) for clamp, one in zip(clamps, motion, strict=True)]
        each = list(zip(clamps, cycles, steps, strict=True))
        self._jumps = np.stack([half_jumps(*one) for one in each])
        self._slopes = np.stack([self._slope(*one) for one in each])
        # Of the highest harmonic a cycle's samples don't tell the phase.
        kept = responses * ((order > balanced) & (order < CELLS // 2))
        held = np.eye(len(clamps)) - np.einsum("ijh,jh->hij", kept, self._slopes)
        free = np.moveaxis(kept * np.sinc(order / CELLS), 2, 0)
        self._beyond = np.moveaxis(np.linalg.solve(held, free), 0, 2)
        self._mobility = np.fft.irfft(self._beyond * self._turn * self._to_edge, CELLS)

    def found(self, near: Array | None = None) -> Rubbed:
        """Find the sides and the forces.

        Args:
            near: velocities of a motion near it at the cells' edges, mm/s, (clamps, n): they are found from there.
        """
        sides = self._sides(self.at_edges(self._given), self._jumps, near)
        forces = harmonics_of(self._jumps * sides.side, self._turn.size)
        moved = self.moved(forces)
        return Rubbed(self, self._given + moved, forces + self._slopes * moved, self._jumps, sides)

    def _slope(self, clamp: SteadyClamp, cycle: Motion, step: ForceStep) -> ComplexArray:
        """Give what a clamp's force, but for its step, answers to fast small motions, N/mm, (h,)."""
        slow = slow_speed(clamp, cycle, step)
        v = np.where(cycle.v < 0, np.minimum(cycle.v, -slow), np.maximum(cycle.v, slow))
        law = along(clamp, _at_velocity(cycle, v))
        return np.asarray(law.by_argument[0, Y].mean() + law.by_argument[0, V].mean() * self._turn)

    def at_edges(self, motion: ComplexArray) -> Array:
        """Give the velocity at the cells' edges, mm/s, (..., n), of harmonics (..., h)."""
        turned = motion * (self._turn * self._to_edge)[: motion.shape[-1]]
        return sampled(turned.reshape(-1, motion.shape[-1]), CELLS).reshape(*motion.shape[:-1], CELLS)

    def moved(self, forces: ComplexArray) -> ComplexArray:
        """Give what harmonics of forces, (..., clamps, h), move beyond H, mm."""
        return np.asarray(np.einsum("ijh,...jh->...ih", self._beyond, forces))

    def _pushed(self, forces: Array) -> Array:
        """Give the velocities at the edges that forces in cells, (clamps, n), make beyond H."""
        spectrum = np.einsum("ijh,jh->ih", self._beyond, np.fft.rfft(forces)) * self._turn * self._to_edge
        return np.fft.irfft(spectrum, CELLS)

    def _sides(self, edges: Array, jumps: Array, near: Array | None) -> Sides:
        """Find the sides; arguments (clamps, n), the velocities of the given motion and half the jumps.

        The sign is rounded as little as it is to be at once, or else less and less.
        """
        largest = float(np.abs(edges).max(initial=0.0)) or 1.0
        least = np.maximum(ROUNDED_SHARE * largest, [step.width for step in self.steps])
        begin = edges + self._pushed(jumps * np.sign(edges))
        v, done = self._solved(edges, jumps, begin if near is None else near, least, BALANCED * largest)
        if not done:
            spread = float(np.abs(begin - edges).max())
            widest = float(np.sort(np.abs(begin), axis=None)[min(OPEN, begin.size - 1)])
            v, rounded = begin, np.maximum(min(spread, widest), least)
            while True:
                v, _ = self._solved(edges, jumps, v, rounded, BALANCED * largest)
                if np.array_equal(rounded, least):
                    break
                rounded = np.maximum(rounded / ROUNDER, least)
        side, by_edge = self._signs(v, least)
        where, slope = self._open(jumps, by_edge)
        return Sides(v, side, by_edge, where, np.asarray(np.linalg.inv(slope), dtype=np.float64))

    def _signs(self, v: Array, rounded: Array) -> tuple[Array, Array]:
        """Give what `means_of_sign` does of each clamp, (clamps, n) and (2, clamps, n), rounded each by its width."""
        each = zip(v, rounded.tolist(), self.steps, strict=True)
        sides, by_edge = zip(*(means_of_sign(one, width, step.sign) for one, width, step in each), strict=True)
        return np.stack(sides), np.stack(by_edge, axis=1)

    def _solved(self, edges: Array, jumps: Array, v: Array, rounded: Array, enough: float) -> tuple[Array, bool]:
        """Solve for the velocities at all edges, by Newton's method from a guess; tell whether they are found."""

        def missed(v: Array) -> tuple[Array, Array]:
            side, by_edge = self._signs(v, rounded)
            return v - edges - self._pushed(jumps * side), by_edge

        error, by_edge = missed(v)
        for _ in range(MOST_CORRECTIONS):
            if np.abs(error).max() <= enough:
                return v, True
            # Only where a side follows the velocity there is something to solve for.
            where, slope = self._open(jumps, by_edge)
            there = np.zeros(v.size)
            there[where] = np.linalg.solve(slope, -error.ravel()[where])
            sides = _followed(by_edge, there.reshape(v.shape))
            change, share = self._pushed(jumps * sides) - error, 1.0
            size = float(np.linalg.norm(error))
            while True:
                tried = v + share * change
                error, by_edge = missed(tried)
                if np.linalg.norm(error) < size:
                    break
                share /= 2
                if share < SMALLEST_CORRECTION:
                    return v, False
            v = tried
        return v, False

    def _open(self, jumps: Array, by_edge: Array) -> tuple[IntArray, Array]:
        """Give the edges of the cells whose side follows the velocity, and how the given motion's velocities there
        would change for a change of what comes out, (E, E)."""
        n = jumps.shape[1]
        cells = np.flatnonzero(by_edge.any(axis=0))
        clamp, cell = np.divmod(cells, n)
        where = np.union1d(cells, clamp * n + (cell + 1) % n)
        left, right = np.searchsorted(where, cells), np.searchsorted(where, clamp * n + (cell + 1) % n)
        of, edge = np.divmod(where, n)
        answer = self._mobility[of[:, None], clamp, (edge[:, None] - cell) % n] * jumps.ravel()[cells]
        slope = np.eye(where.size)
        slope[:, left] -= answer * by_edge[0].ravel()[cells]
        slope[:, right] -= answer * by_edge[1].ravel()[cells]
        return where, slope


@dataclass(frozen=True, eq=False)
class Rubbed:
    """A motion with the sides to which its clamps slide.

    Attributes:
        friction: the clamps.
        whole: harmonics of the motion with those that the steps make beyond H, mm, (clamps, h).
        stepping: harmonics of that part of the forces which steps, N, (clamps, h).
        jumps: half of it, (clamps, n).
        sides: to which they slide.
    """

    friction: Friction
    whole: ComplexArray
    stepping: ComplexArray
    jumps: Array
    sides: Sides

    @cached_property
    def _laws(self) -> list[Tangents]:
        """Each clamp's law along the motion, the mean of both sides by their shares."""
        at, found = np.array([self.friction.frequency]), []
        for index, clamp in enumerate(self.friction.clamps):
            cycle = clamp.cycle(self.whole[index][None], at)
            slow = slow_speed(clamp, cycle, self.friction.steps[index])
            side = self.sides.side[index]
            laws = []
            for sign, limited in ((1, np.maximum(cycle.v, slow)), (-1, np.minimum(cycle.v, -slow))):
                v = np.where(side == -sign, cycle.v, limited)  # which has no share there
                law = along(clamp, _at_velocity(cycle, v))
                law.by_argument[:, V] *= v[0] == cycle.v[0]
                laws.append(law)
            up, down = laws
            share = np.ones((1 + up.memory, 1)) / 2 * np.ones(CELLS)
            share[0] = (1 + self.sides.side[index]) / 2
            found.append(
                Tangents(
                    share[0] * up.force + (1 - share[0]) * down.force,
                    share[:, None] * up.by_argument + (1 - share)[:, None] * down.by_argument,
                    share[:, None] * up.by_state + (1 - share)[:, None] * down.by_state,
                    up.follows,
                    up.adrift,
                )
            )
        return found

    def disturbed(self) -> list[Tangents]:
        """Give each clamp's law as a small disturbance of the motion meets it."""
        return [replace(law, passage=self._passage(index)) for index, law in enumerate(self._laws)]

    def _passage(self, index: int) -> Passage:
        """Tell what the step of a clamp's force does to a disturbance: at once where it reverses within few cells."""
        v, side = self.sides.velocity[index], self.sides.side[index]
        change = np.roll(v, -1) - v
        damping, left = self.jumps[index] * self.sides.by_edge[:, index].sum(axis=0), np.ones(CELLS)
        whole = np.abs(side) == 1.0
        for first in np.flatnonzero(~whole & np.roll(whole, 1)).tolist():
            length = int(np.argmax(np.roll(whole, -first)))
            cells = np.arange(first, first + length) % CELLS
            before, after = first - 1, (first + length) % CELLS
            if length <= MOST_REVERSING_CELLS and side[before] * side[after] < 0:
                damping[cells] = 0.0
                left[cells[length // 2]] = np.clip(change[after] / change[before], 0.0, 1.0)
        return Passage(damping, left)

    @property
    def forces(self) -> ComplexArray:
        """All harmonics of the clamps' forces, N, (clamps, h)."""
        return harmonics_of(np.stack([law.force for law in self._laws]), self.stepping.shape[1])

    def smooth_beyond(self, H: int) -> ComplexArray:
        """Give all harmonics of the forces, beyond H without the part that steps, N, (clamps, h)."""
        found = self.forces.copy()
        found[:, H + 1 :] -= self.stepping[:, H + 1 :]
        return found

    def changes(self, changes: ComplexArray) -> ComplexArray:
        """Give what the forces change by, to first order, N, for changes of the given harmonics, (rows, clamps, h)."""
        friction, (rows, count, h) = self.friction, changes.shape
        own, all_ = resized(changes, self.whole.shape[1]), self.whole.shape[1]
        moved = np.zeros((rows, count * CELLS))
        where = self.sides.where
        moved[:, where] = friction.at_edges(own).reshape(rows, -1)[:, where] @ self.sides.answers.T
        moved = moved.reshape(rows, count, CELLS)
        stepping = self.jumps * _followed(self.sides.by_edge, moved)
        own = own + friction.moved(harmonics_of(stepping.reshape(-1, CELLS), all_).reshape(rows, count, all_))
        found = np.zeros((rows, count, CELLS))
        at = np.full(1 + rows, friction.frequency)
        for index, (clamp, law) in enumerate(zip(friction.clamps, self._laws, strict=True)):
            motion = self.whole[index][None]
            each = arguments(clamp.cycle(np.concatenate([motion, motion + own[:, index]]), at))
            found[:, index] = answered(law, each[:, 1:] - each[:, :1]) + stepping[:, index]
        return harmonics_of(found.reshape(-1, CELLS), h).reshape(rows, count, h)
