"""States of a law along motions, all rows at once; those of periodic motions are brought to their periodic values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.law.law import Equations
from pipeclamp_models.realise.arrays import ArrayRealisation, Pair
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.walks import AfterMotion, Taken
from pipeclamp_models.steps.ways import Ways

SETTLING_CYCLES = 20
SETTLED_SHARE = 1e-9


@dataclass(frozen=True)
class States:
    """States along motions.

    Attributes:
        after: each sample, J arrays of shape (R, n).
        adrift, unsettled: as of `LawForce`.
        slopes: of the states by what their updates take, coefficients and then parameters, that don't vanish: (R, n)
            each, by the places of state and argument; where they are wanted.
        kept: what of a move of the states before a cycle they have kept after any number of cycles, (R, J, J); None
            where the motions aren't periodic.
    """

    after: Sequence[Array]
    adrift: BoolArray
    unsettled: BoolArray
    slopes: Mapping[tuple[int, int], Array] = field(default_factory=dict)
    kept: Array | None = None


@dataclass(frozen=True)
class March:
    """Steps the states of a law along motions, all rows at once.

    Attributes:
        compiled: the law.
        equations: the same.
        coefficients: (R, 1) each, or (R, n) where conditions change along a row.
        numbers: parameters and smoothing.
        motion: the motions.
    """

    compiled: ArrayRealisation
    equations: Equations
    coefficients: Sequence[Array]
    numbers: Sequence[float]
    motion: Motion

    def states(self, *, derivatives: bool) -> States:
        """Give the states along the motions, and their slopes where derivatives are wanted, of periodic ones alone.

        Raises:
            ValueError: conditions change along a periodic motion.
        """
        rows = len(self.motion.y)
        none = np.zeros(rows, dtype=np.bool_)
        if not self.equations.states:
            return States([], none, none)
        rest = np.array([np.full(rows, state.start) for state in self.equations.states])
        if self.motion.periodic:
            return self._periodic(rest, derivatives=derivatives)
        if self.motion.memory is not None:
            rest = np.array(self.motion.memory)
        if not self.motion.ways:
            return States(list(self._walk(rest, self._whole)), none, none)
        between, last = self._between(self.motion.ways), self.motion.ways.last
        return States([state[:, last] for state in between._walk(rest, between._whole)], none, none)

    def step_slopes(self, states: Sequence[Array]) -> Array:
        """Give the derivatives of periodic states by those a sample before, (R, n, J, J); the states as of `States`."""
        rows, samples = self.motion.y.shape
        taken = self._taken(self.motion.y_previous, [np.roll(state, 1, axis=1) for state in states])
        found = [slope for part in self.compiled.update_slopes for slope in part(taken)]
        slopes = np.zeros((rows, samples, len(states), len(states)))
        for (state, by), slope in zip(self.compiled.update_slope_index, found, strict=True):
            slopes[:, :, state, by] = slope
        return slopes

    def _between(self, ways: Ways) -> March:
        """Give the march along the ways between a record's samples."""
        return replace(self, coefficients=list(map(ways.spread, self.coefficients)), motion=self.motion.between)

    def _periodic(self, rest: Array, *, derivatives: bool) -> States:
        """Bring the states' map over one cycle to its fixed point by Newton's method, after a first move from rest.

        Directions in which the map is the identity (an element that never slips) stay as that move left them.
        """
        if any(column.shape[1] > 1 for column in self.coefficients):
            raise ValueError("got conditions that change along a cycle; expected them to keep still")
        last = self._last()
        from_rest = last._taken(np.zeros((rest.shape[1], 1)))
        start = last._walk(rest, from_rest)[:, :, 0].copy()
        scale = 1e-300 + np.max(np.abs(start), axis=0)
        self._settle(start, scale, np.ones(rest.shape[1], dtype=np.bool_), most=1)
        cycle = self._along(start, self._whole, derivatives=derivatives)
        # Most states have forgotten their beginning after one cycle: a whole one told that, and its slopes, again.
        unsettled = _moves(cycle.states[:, :, -1] - start, scale, np.abs(cycle.states).max(axis=2))
        if unsettled.any():
            unsettled = self._settle(start, scale, unsettled, most=SETTLING_CYCLES)
            cycle = self._along(start, self._whole, derivatives=derivatives)
        left, size, right = np.linalg.svd(_back(cycle.by_start))
        adrift = np.min(size, axis=1) < SETTLED_SHARE
        still = np.where((size < SETTLED_SHARE)[:, :, None], right, 0.0)
        kept = np.swapaxes(still, 1, 2) @ still
        slopes: Mapping[Pair, Array] = {}
        if derivatives:
            told = size > SETTLED_SHARE * np.max(size, axis=1, keepdims=True)
            inverse = np.where(told, 1 / np.where(told, size, 1.0), 0.0)[:, :, None]
            to_period = np.swapaxes(right, 1, 2) @ (inverse * np.swapaxes(left, 1, 2))
            # what loses its beginning doesn't ask for it
            first = last._along(rest, from_rest, derivatives=True).slopes if adrift.any() else {}
            slopes = _of_periodic(cycle, first, to_period)
        return States(list(cycle.states), adrift, unsettled, slopes, kept)

    def _settle(self, start: Array, scale: Array, moving: BoolArray, *, most: int) -> BoolArray:
        """Move states before the first sample, (J, R), to their periodic values; tell which rows still move.

        Args:
            start: the states; they are changed.
            scale: their sizes, (R,).
            moving: the rows that aren't there yet.
            most: Newton steps at most.
        """
        left = np.flatnonzero(moving)
        for _ in range(most):
            taken = self._whole if len(left) == len(moving) else self._of_rows(left)._whole
            after, largest, by_start = self._turn(start[:, left], taken)
            change = after - start[:, left]
            moves = _moves(change, scale[left], largest)
            if not moves.any():
                return np.zeros_like(moving)
            left = left[moves]
            inverse = np.linalg.pinv(_back(by_start[moves]), rcond=SETTLED_SHARE)
            start[:, left] += np.einsum("rjk,kr->jr", inverse, change[:, moves])
        return np.isin(np.arange(len(moving)), left)

    def _last(self) -> March:
        """Give the march to the last sample alone."""
        motion = self.motion
        y, v, a = motion.y[:, -1:], motion.v[:, -1:], motion.a[:, -1:]
        return replace(self, motion=replace(motion, y=y, v=v, a=a))

    def _of_rows(self, rows: IntArray) -> March:
        """Give the march along some of the rows."""
        coefficients = [column[rows] for column in self.coefficients]
        return replace(self, coefficients=coefficients, motion=self.motion.rows(rows))

    @cached_property
    def _whole(self) -> Taken:
        """What the states' update takes, without the states."""
        return self._taken(self.motion.y_previous)

    def _taken(self, y_previous: Array, states: Sequence[Array] = ()) -> Taken:
        """Give what the states' update takes, from a place before each sample, with states where it takes these."""
        motion = self.motion
        fast = [motion.y, motion.v, motion.a, y_previous, motion.h]
        return Taken([*fast, *states, *self.coefficients, *self.numbers], motion.y.shape)

    def _walk(self, start: Array, taken: Taken) -> Array:
        """Step along all samples from the states (J, R) before the first; give those after each, (J, R, n)."""
        states = np.empty((*start.shape, taken.shape[1]))
        for walk in self.compiled.walks:
            states[walk.states] = walk(start, taken)
        return states

    def _turn(self, start: Array, taken: Taken) -> AfterMotion:
        """Step along all samples; give what that makes of the states."""
        count, rows = start.shape
        after, largest, slopes = np.empty_like(start), np.empty_like(start), np.zeros((rows, count, count))
        for turn in self.compiled.turns:
            places = turn.states
            own = turn(start, taken)
            after[places], largest[places], slopes[:, np.array(places)[:, None], places] = own
        return AfterMotion(after, largest, slopes)

    def _along(self, start: Array, taken: Taken, *, derivatives: bool) -> Cycle:
        """Step along all samples; give the states, and their slopes at the end, or all along."""
        if not derivatives:
            return Cycle(self._walk(start, taken), self._turn(start, taken).by_start, {})
        count, rows = start.shape
        states, by_start = np.empty((*start.shape, taken.shape[1])), np.zeros((rows, count, count))
        slopes: dict[Pair, Array] = {}
        for course in self.compiled.courses:
            own = course(start, taken)
            states[course.states] = own.states
            slopes |= own.slopes
        for (state, by), slope in slopes.items():
            if by < count:
                by_start[:, state, by] = slope[:, -1]
        return Cycle(states, by_start, slopes)


class Cycle(NamedTuple):
    """States along motions, (J, R, n), their slopes at the end by those before it, (R, J, J), and those all along."""

    states: Array
    by_start: Array
    slopes: Mapping[Pair, Array]


def _of_periodic(cycle: Cycle, first: Mapping[Pair, Array], to_period: Array) -> dict[Pair, Array]:
    """Give the slopes of periodic states by what their updates take beside the states.

    Args:
        cycle: the states' cycle, with its slopes by the states before it, and by all else for those kept still.
        first: slopes of the states before it, after a first move from rest, that don't vanish, one sample each.
        to_period: makes of what a cycle changes by itself the change of periodic states, (R, J, J).
    """
    rows, count, _ = to_period.shape
    inputs = sorted({by for _, by in cycle.slopes if by >= count})
    begin, once = np.zeros((2, rows, count, len(inputs)))
    for slopes, into in ((first, begin), (cycle.slopes, once)):
        for (state, by), slope in slopes.items():
            if by >= count:
                into[:, state, inputs.index(by)] = slope[:, -1]
    begin += to_period @ (once + (cycle.by_start - np.eye(count)) @ begin)
    found = {}
    for place, by in enumerate(inputs):
        for state in range(count):
            if (state, by) in cycle.slopes:
                ways = [
                    (cycle.slopes[state, one], begin[:, one, place, None])
                    for one in range(count)
                    if (state, one) in cycle.slopes
                ]
                found[state, by - count] = sum((slope * moved for slope, moved in ways), cycle.slopes[state, by])
    return found


def _moves(change: Array, scale: Array, largest: Array) -> BoolArray:
    """Tell which rows' states a cycle changes, (J, R), against their sizes before, (R,), and within it, (J, R)."""
    return np.asarray(np.any(~(np.abs(change) <= SETTLED_SHARE * (scale + np.max(largest, axis=0))), axis=0))


def _back(by_start: Array) -> Array:
    """Give the identity less the slopes of a cycle by its beginning, (R, J, J); that alone where there are no numbers.

    A row without numbers stays one; no other may suffer for it.
    """
    identity = np.eye(by_start.shape[1])
    back = identity - by_start
    back[~np.isfinite(back).all(axis=(1, 2))] = identity
    return np.asarray(back)
