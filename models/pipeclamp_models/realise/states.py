"""States of a law along motions, all rows at once; those of periodic motions are brought to their periodic values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray
from pipeclamp_models.law.law import Equations
from pipeclamp_models.realise.arrays import ArrayRealisation, Slopes
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.walks import AfterMotion
from pipeclamp_models.steps.ways import Ways

SETTLING_CYCLES = 20
SETTLED_SHARE = 1e-9


class StepArguments(NamedTuple):
    """Arguments of a law's step before and after its states, each (R, n), or (R, 1) where it keeps still.

    After them come numbers, which are the same in all rows.
    """

    moving: Sequence[Array]
    held: Sequence[Array]
    numbers: Sequence[float]

    def around(self, states: Sequence[Array] = ()) -> list[Array | float]:
        """Give the arguments, with states in between."""
        return [*self.moving, *states, *self.held, *self.numbers]

    def of_rows(self, rows: BoolArray) -> StepArguments:
        """Give what a step takes on some of the rows."""
        return StepArguments([each[rows] for each in self.moving], [each[rows] for each in self.held], self.numbers)


@dataclass(frozen=True)
class States:
    """States along motions.

    Attributes:
        after: each sample, J arrays of shape (R, n).
        slopes: by the moving parameters, (J, M, R, n); M is 0 where derivatives aren't wanted.
        steps, adrift, unsettled: as of `LawForce`.
        kept: what of a move of the states before a cycle they have kept after any number of cycles, (R, J, J); None
            where the motions aren't periodic.
    """

    after: Sequence[Array]
    slopes: Array
    steps: Array | None
    adrift: BoolArray
    unsettled: BoolArray
    kept: Array | None = None


@dataclass(frozen=True)
class March:
    """Steps the states of a law along motions, all rows at once."""

    compiled: ArrayRealisation
    equations: Equations
    coefficients: Sequence[Array]
    coefficient_slopes: Mapping[tuple[int, int], Array]
    values: Sequence[float]
    smoothing: tuple[float, float]
    motion: Motion

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """The parameters that the states' update depends on, M of them: no other has slopes to carry along."""
        places = self.compiled.update_slope_places
        coefficients = {coefficient for _, coefficient in places.by_coefficient}
        direct = {parameter for _, parameter in places.by_parameter}
        return tuple(sorted(direct | {place for entry, place in self.coefficient_slopes if entry in coefficients}))

    @cached_property
    def inner(self) -> Mapping[int, Sequence[tuple[int, Array]]]:
        """The slopes of each coefficient by the moving parameters, by their places."""
        slopes: dict[int, list[tuple[int, Array]]] = {entry: [] for entry in range(len(self.coefficients))}
        for (entry, parameter), slope in self.coefficient_slopes.items():
            if parameter in self.moving:
                slopes[entry].append((self.moving.index(parameter), slope))
        return slopes

    def states(self, *, derivatives: bool, memory_told: bool = True) -> States:
        """Give the states along the motions, their slopes where derivatives are wanted, and of periodic motions what
        their steps keep of a beginning where that is to be told."""
        count = len(self.equations.states)
        rows, samples = self.motion.y.shape
        parameters = len(self.moving) if derivatives else 0
        none = np.zeros(rows, dtype=np.bool_)
        if count == 0:
            return States([], np.zeros((0, parameters, rows, samples)), None, none, none)
        rest = np.array([np.full(rows, state.start) for state in self.equations.states])
        if self.motion.periodic:
            return self._periodic(rest, derivatives=derivatives, memory_told=memory_told or derivatives)
        if self.motion.memory is not None:
            rest = np.array(self.motion.memory)
        if self.motion.ways:
            found = self._between(self.motion.ways)._from(rest, derivatives=derivatives)
            last = self.motion.ways.last
            return replace(found, after=[state[:, last] for state in found.after], slopes=found.slopes[..., last])
        return self._from(rest, derivatives=derivatives)

    def _between(self, ways: Ways) -> March:
        """Give the march along the ways between a record's samples."""
        return replace(
            self,
            coefficients=list(map(ways.spread, self.coefficients)),
            coefficient_slopes={entry: ways.spread(slope) for entry, slope in self.coefficient_slopes.items()},
            motion=self.motion.between,
        )

    def _from(self, rest: Array, *, derivatives: bool) -> States:
        """Give the states along a record from those before it, (J, R)."""
        (count, rows), samples = rest.shape, self.motion.y.shape[1]
        columns = self._columns(self.motion.y_previous)
        trajectory = self._walk(rest, columns)
        slopes = np.zeros((rows, samples, count, len(self.moving) if derivatives else 0))
        if derivatives:
            by_step = self._slopes(rest, trajectory, columns)
            start = np.zeros((rows, count, len(self.moving)))
            slopes = trail(start, self._by_states(by_step, samples), self._by_parameters(by_step, samples))
        none = np.zeros(rows, dtype=np.bool_)
        return States(list(trajectory), np.moveaxis(slopes, (0, 1), (2, 3)), None, none, none)

    def _periodic(self, rest: Array, *, derivatives: bool, memory_told: bool) -> States:
        """Bring the states' map over one cycle to its fixed point by Newton's method, after a first move from rest.

        Directions in which the map is the identity (an element that never slips) stay as that move left them.
        """
        (count, rows), samples = rest.shape, self.motion.y.shape[1]
        last = self._last()
        from_rest = last._columns(np.zeros((rows, 1)))
        moved = last._walk(rest, from_rest)
        start, columns = moved[:, :, 0].copy(), self._columns(self.motion.y_previous)
        scale = 1e-300 + np.max(np.abs(start), axis=0)
        self._settle(start, scale, columns, np.ones(rows, dtype=np.bool_), most=1)
        trajectory = self._walk(start, columns)
        # Most states have forgotten their beginning after one cycle: a whole one told that, and its slopes, again.
        unsettled = _moves(trajectory[:, :, -1] - start, scale, np.abs(trajectory).max(axis=2))
        if unsettled.any():
            unsettled = self._settle(start, scale, columns, unsettled, most=SETTLING_CYCLES)
            trajectory = self._walk(start, columns)
        if not memory_told:
            none = np.zeros(rows, dtype=np.bool_)
            return States(list(trajectory), np.zeros((count, 0, rows, samples)), None, none, unsettled)
        by_step = self._slopes(start, trajectory, columns)
        by_states = self._by_states(by_step, samples)
        to_begin = _back(composed(np.moveaxis(by_states, 1, 0)))
        left, size, right = np.linalg.svd(to_begin)
        adrift = np.min(size, axis=1) < SETTLED_SHARE
        still = np.where((size < SETTLED_SHARE)[:, :, None], right, 0.0)
        kept = np.swapaxes(still, 1, 2) @ still
        slopes = np.zeros((rows, samples, count, 0))
        if derivatives:
            by_parameters = self._by_parameters(by_step, samples)
            begin = np.zeros((rows, count, len(self.moving)))
            if adrift.any():  # what loses its beginning doesn't ask for it
                begin = last._by_parameters(last._slopes(rest, moved, from_rest), 1)[:, 0]
            once = trail(begin, by_states, by_parameters)[:, -1]
            told = size > SETTLED_SHARE * np.max(size, axis=1, keepdims=True)
            inverse = np.where(told, 1 / np.where(told, size, 1.0), 0.0)
            to_period = np.swapaxes(right, 1, 2) @ (inverse[:, :, None] * (np.swapaxes(left, 1, 2) @ (once - begin)))
            slopes = trail(begin + to_period, by_states, by_parameters)
        return States(list(trajectory), np.moveaxis(slopes, (0, 1), (2, 3)), by_states, adrift, unsettled, kept)

    def _settle(self, start: Array, scale: Array, columns: StepArguments, moving: BoolArray, *, most: int) -> BoolArray:
        """Move states before the first sample, (J, R), to their periodic values; tell which rows still move.

        Args:
            start: the states; they are changed.
            scale: their sizes, (R,).
            columns: the steps' arguments.
            moving: the rows that aren't there yet.
            most: Newton steps at most.
        """
        left = np.flatnonzero(moving)
        taken = columns if moving.all() else columns.of_rows(moving)
        for _ in range(most):
            after, largest, by_start = self._turn(start[:, left], taken)
            change = after - start[:, left]
            moves = _moves(change, scale[left], largest)
            if not moves.any():
                return np.zeros_like(moving)
            left, taken = left[moves], taken if moves.all() else taken.of_rows(moves)
            inverse = np.linalg.pinv(_back(by_start[moves]), rcond=SETTLED_SHARE)
            start[:, left] += np.einsum("rjk,kr->jr", inverse, change[:, moves])
        return np.isin(np.arange(len(moving)), left)

    def _last(self) -> March:
        """Give the march to the last sample alone."""
        motion = self.motion
        y, v, a = motion.y[:, -1:], motion.v[:, -1:], motion.a[:, -1:]
        return replace(
            self,
            coefficients=[column[:, -1:] for column in self.coefficients],
            coefficient_slopes={entry: slope[:, -1:] for entry, slope in self.coefficient_slopes.items()},
            motion=replace(motion, y=y, v=v, a=a),
        )

    def _columns(self, y_previous: Array) -> StepArguments:
        """Give what the states' update takes before and after the states."""
        motion = self.motion
        moving = [motion.y, motion.v, motion.a, y_previous, motion.h]
        return StepArguments(moving, self.coefficients, [*self.values, *self.smoothing])

    def _walk(self, start: Array, columns: StepArguments) -> Array:
        """Step along all samples from the states (J, R) before the first; give those after each, (J, R, n)."""
        arguments = columns.around()
        states = np.empty((*start.shape, self.motion.y.shape[1]))
        for walk in self.compiled.walks:
            states[walk.states] = walk(start, arguments, self.motion.y.shape)
        return states

    def _turn(self, start: Array, columns: StepArguments) -> AfterMotion:
        """Step along all samples; give what that makes of the states."""
        arguments = columns.around()
        (count, rows), samples = start.shape, self.motion.y.shape[1]
        after, largest, slopes = np.empty_like(start), np.empty_like(start), np.zeros((rows, count, count))
        for turn in self.compiled.turns:
            places = turn.states
            own = turn(start, arguments, (rows, samples))
            after[places], largest[places], slopes[:, np.array(places)[:, None], places] = own
        return AfterMotion(after, largest, slopes)

    def _slopes(self, start: Array, trajectory: Array, columns: StepArguments) -> Slopes:
        """Give the slopes of each step that don't vanish.

        Args:
            start: states (J, R) before the first sample.
            trajectory: states after each, (J, R, n).
            columns: the steps' other arguments.
        """
        before = np.concatenate([start[:, :, None], trajectory[:, :, :-1]], axis=2)
        arguments = columns.around(list(before))
        found = [slope for part in self.compiled.update_slopes for slope in part(arguments, self.motion.y.shape)]
        return self.compiled.update_slope_places.filled(found)

    def _by_states(self, slopes: Slopes, samples: int) -> Array:
        """Give the slopes of each step by the states before it, (R, n, J, J)."""
        count = len(self.equations.states)
        by_states = np.zeros((len(self.motion.y), samples, count, count))
        for (state, before), slope in slopes.by_state.items():
            by_states[:, :, state, before] = slope
        return by_states

    def _by_parameters(self, slopes: Slopes, samples: int) -> Array:
        """Give the slopes of each step by the moving parameters, (R, n, J, M)."""
        by_parameters = np.zeros((len(self.motion.y), samples, len(self.equations.states), len(self.moving)))
        for (state, coefficient), slope in slopes.by_coefficient.items():
            for place, inner in self.inner[coefficient]:
                by_parameters[:, :, state, place] += slope * inner
        for (state, parameter), slope in slopes.by_parameter.items():
            by_parameters[:, :, state, self.moving.index(parameter)] += slope
        return by_parameters


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


def trail(start: Array, by_states: Array, inputs: Array) -> Array:
    """Carry slopes along all samples.

    Args:
        start: before the first sample, (R, J, M).
        by_states: of each step, (R, n, J, J).
        inputs: what each step adds, (R, n, J, M).

    Returns:
        after each sample, (R, n, J, M).
    """
    from pipeclamp_models.realise.trails import carried

    return np.asarray(carried(*map(np.ascontiguousarray, (start, by_states, inputs))))


def composed(steps: Array) -> Array:
    """Give what linear steps (n, ..., d, d) make one after the other, (..., d, d)."""
    while len(steps) > 1:
        paired = len(steps) // 2 * 2
        steps = np.concatenate([steps[1:paired:2] @ steps[:paired:2], steps[paired:]])
    return np.asarray(steps[0])
