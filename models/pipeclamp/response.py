"""The force of a law on given motions, many at once, with exact derivatives by its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeclamp.errors import UserError
from pipeclamp.law import Equations, Law, compose
from pipeclamp.realise.arrays import FAST_ARGUMENTS, Array, ArrayRealisation, Compiled, realise
from pipeclamp.symbols import CONDITION, v

SETTLING_CYCLES = 20
SETTLED = 1e-9
VELOCITY = FAST_ARGUMENTS.index(v)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Motion:
    """Motions, one a row, sampled at n equal steps: one whole cycle each, or a record that starts at rest.

    Attributes:
        y, v, a: displacement mm, velocity mm/s, acceleration mm/s2; shape (R, n).
        slow: slow signals by name (`A` mm, `f` Hz, `T` K, `N`, `rho`, further conditions), each of shape (R, 1), or
            (R, n) where it changes along the row.
        h: time between samples in s, shape (R, 1).
        periodic: whether each row is a whole cycle that repeats.
        assumed: slow signals that nobody knows, whose values only let laws be evaluated that don't follow them.
    """

    y: Array
    v: Array
    a: Array
    slow: Mapping[str, Array]
    h: Array
    periodic: bool = True
    assumed: frozenset[str] = frozenset()

    def rows(self, chosen: npt.NDArray[np.intp]) -> Motion:
        """Give some of the motions."""
        slow = {name: values[chosen] for name, values in self.slow.items()}
        return replace(self, y=self.y[chosen], v=self.v[chosen], a=self.a[chosen], slow=slow, h=self.h[chosen])


def sinusoids(
    amplitude: npt.ArrayLike, frequency: npt.ArrayLike, temperature: npt.ArrayLike, samples: int = 512
) -> Motion:
    """Give the motions A cos(2 pi f t) of one cycle.

    Args:
        amplitude: mm, frequency: Hz, temperature: K; shapes that broadcast to (R,).
        samples: samples in the cycle.
    """
    A, f, T = (
        np.atleast_1d(column)[:, None]
        for column in np.broadcast_arrays(*(np.asarray(entry, float) for entry in (amplitude, frequency, temperature)))
    )
    phase = 2 * np.pi * np.arange(samples) / samples
    omega = 2 * np.pi * f
    y = A * np.cos(phase)
    return Motion(y, -A * omega * np.sin(phase), -(omega**2) * y, {"A": A, "f": f, "T": T}, 1.0 / (f * samples))


def refuse_unknown_conditions(slow: Iterable[str], motion: Motion) -> None:
    """Refuse motions that don't state a condition which the law depends on.

    Args:
        slow: names of the slow signals that the law depends on.
        motion: the motions.

    Raises:
        UserError: with the column that is missing.
    """
    for name in slow:
        if name not in motion.slow:
            known = ", ".join(sorted(entry.removeprefix(CONDITION) for entry in motion.slow))
            raise UserError(
                f"the law depends on {name.removeprefix(CONDITION)}, which the tests don't state; got {known}; "
                "expected a column of that name in runs.csv"
            )


@dataclass(frozen=True)
class Response:
    """Force of a law on motions.

    Attributes:
        force: N, shape (R, n).
        jacobian: derivatives of the force by the parameters, shape (parameters, R, n), where asked for.
        adrift: rows in which a state never loses its beginning (an element that sticks all the way round, say), so
            that the force is known up to a constant which only the history before the record would tell; shape (R,).
        unsettled: rows in which a state isn't periodic after all that was tried: their force is that of one cycle among
            others; shape (R,).
        states: the states after each sample, J arrays of shape (R, n).
        steps: of periodic motions, derivatives of the states by those a sample before, shape (R, n, J, J).
    """

    force: Array
    jacobian: Array | None
    adrift: npt.NDArray[np.bool_]
    unsettled: npt.NDArray[np.bool_]
    states: Sequence[Array]
    steps: Array | None = None


def law_response(law: Law, motion: Motion) -> Response:
    """Give the response of a law to motions."""
    equations = compose(law.structure)
    return respond(equations, law.vector(equations), (law.v_r, law.y_r), motion)


def respond(
    equations: Equations,
    parameters: Sequence[float] | Array,
    smoothing: tuple[float, float],
    motion: Motion,
    *,
    derivatives: bool = False,
) -> Response:
    """Give the force on motions. States start at rest; on periodic motions they are brought to their periodic values.

    Where a periodic motion reverses, force may step between two samples. The sample whose interval holds the reversal
    then stands for the mean over its interval, so that harmonics see the step where it is.

    Args:
        equations: the composed law.
        parameters: values in the order of the equations' parameters.
        smoothing: v_r (mm/s) and y_r (mm).
        motion: the motions, R rows of n samples.
        derivatives: whether the Jacobian is wanted.

    Raises:
        UserError: a condition that the law depends on isn't stated.
    """
    compiled = realise(equations)
    refuse_unknown_conditions(compiled.slow, motion)
    rows, samples = motion.y.shape
    values = [float(value) for value in parameters]
    slow = [motion.slow[name] for name in compiled.slow]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        coefficients = compiled.coefficients(*slow, *values, *smoothing)
        slopes = compiled.coefficient_slopes(*slow, *values, *smoothing) if derivatives else ()
        coefficient_slopes = dict(zip(compiled.coefficient_slope_index, slopes, strict=derivatives))
        columns = [np.broadcast_to(np.atleast_2d(value), _column_shape(value, rows)) for value in coefficients]
        slope_columns = {
            index: np.broadcast_to(np.atleast_2d(value), _column_shape(value, rows))
            for index, value in coefficient_slopes.items()
        }
        march = _March(compiled, equations, columns, slope_columns, values, smoothing, motion)
        states = march.states(derivatives=derivatives)
        y_previous = np.roll(motion.y, 1, axis=1)
        if not motion.periodic:
            y_previous[:, 0] = 0.0
        fast = [motion.y, motion.v, motion.a, y_previous, motion.h]
        arguments = [*fast, *states.after, *coefficients, *values, *smoothing]
        shape = (rows, samples)
        turning = _turning(motion)
        force = _with_means(compiled.force, arguments, turning, shape)[0]
        response = Response(force, None, states.adrift, states.unsettled, states.after, states.steps)
        if not derivatives:
            return _late(compiled, values, motion, response)
        jacobian = np.zeros((len(values), rows, samples))
        state_count, coefficient_count = len(states.after), len(coefficients)
        force_slopes = _with_means(compiled.force_slopes, arguments, turning, shape)
        for column, slope in zip(compiled.force_slope_index, force_slopes, strict=True):
            if column < state_count:
                jacobian[list(march.moving)] += slope * states.slopes[column]
            elif column < state_count + coefficient_count:
                for (entry, parameter), inner in coefficient_slopes.items():
                    if entry == column - state_count:
                        jacobian[parameter] += slope * inner
            else:
                jacobian[column - state_count - coefficient_count] += slope
    return _late(compiled, values, motion, replace(response, jacobian=jacobian))


@dataclass(frozen=True)
class _Turning:
    """Samples in whose interval, or next to it, the velocity changes its sign.

    Attributes:
        row, sample: where they are, shape (K,).
        v: velocities of the interval in mm/s, shape (K, q).
        weight: of each in the mean over the interval, shape (K, q).
        share: by which the mean stands in the place of the sample, shape (K,).
    """

    row: npt.NDArray[np.intp]
    sample: npt.NDArray[np.intp]
    v: Array
    weight: Array
    share: Array


def _turning(motion: Motion) -> _Turning:
    """Give the samples of periodic motions whose interval, half a step to each side, holds a reversal.

    Beyond the interval the mean fades out over another half step, so that force stays continuous in the motion.
    """
    reach = np.abs(motion.a) * motion.h / 2
    row, sample = np.nonzero((np.abs(motion.v) < 2 * reach) & motion.periodic)
    middle, half = motion.v[row, sample], reach[row, sample]
    # From the interval's one end to the reversal, if it is inside, and from there to the other end; v grows evenly.
    ends = np.stack([middle - half, np.clip(0.0, middle - half, middle + half), middle + half], axis=1)
    length = np.diff(ends)[:, :, None]
    v = (ends[:, :-1, None] + length * (1 + NODES) / 2).reshape(len(row), 2 * len(NODES))
    weight = (length * WEIGHTS / 2).reshape(v.shape) / (2 * half[:, None])
    return _Turning(row, sample, v, weight, np.clip(2 - np.abs(middle) / half, 0.0, 1.0))


def _with_means(
    function: Compiled, arguments: Sequence[Array], turning: _Turning, shape: tuple[int, int]
) -> list[Array]:
    """Evaluate force or slopes at all samples; where the motion turns, their mean over the sample's interval.

    Only the velocity is taken to change within an interval: all else stands nearly still at a reversal.

    Args:
        function: of the fast arguments.
        arguments: their values, of shape (R, n) or what broadcasts to it.
        turning: where the motion turns.
        shape: (R, n).
    """
    results = [np.array(np.broadcast_to(value, shape), dtype=np.float64) for value in function(*arguments)]
    if len(turning.row):
        there = [
            np.broadcast_to(value, shape)[turning.row, turning.sample][:, None] if np.ndim(value) else value
            for value in arguments
        ]
        there[VELOCITY] = turning.v
        for result, values in zip(results, function(*there), strict=True):
            own = result[turning.row, turning.sample]
            result[turning.row, turning.sample] += turning.share * (np.sum(turning.weight * values, axis=1) - own)
    return results


def _column_shape(value: npt.ArrayLike, rows: int) -> tuple[int, int]:
    """Give the shape of a slow quantity as a column (R, 1), or as it is where it changes along the row, (R, n)."""
    array = np.atleast_2d(np.asarray(value))
    return rows, array.shape[1]


def _late(compiled: ArrayRealisation, values: Sequence[float], motion: Motion, response: Response) -> Response:
    """Delay force and derivatives by the rig's lag, harmonic by harmonic; a record is taken for one long cycle."""
    if compiled.in_time:
        return response
    lag = float(compiled.lag(*values)[0])
    samples = motion.y.shape[1]
    omega = 2 * np.pi * np.arange(samples // 2 + 1) / (samples * motion.h)
    turn = np.exp(-1j * omega * lag)
    force = np.fft.rfft(response.force) * turn
    late = np.fft.irfft(force, samples)
    if response.jacobian is None:
        return replace(response, force=late)
    jacobian = np.fft.irfft(np.fft.rfft(response.jacobian) * turn, samples)
    for parameter, slope in zip(compiled.lag_slope_index, compiled.lag_slopes(*values), strict=True):
        jacobian[parameter] -= slope * np.fft.irfft(1j * omega * force, samples)
    return replace(response, force=late, jacobian=jacobian)


Columns = tuple[Sequence[Array], Sequence[Array]]
"""Arguments of a law's step before and after its states, each (R, n), or (R, 1) where it keeps still."""


@dataclass(frozen=True)
class _States:
    """States along motions.

    Attributes:
        after: each sample, J arrays of shape (R, n).
        slopes: by the moving parameters, (J, M, R, n); M is 0 where derivatives aren't wanted.
        steps, adrift, unsettled: as of `Response`.
    """

    after: Sequence[Array]
    slopes: Array
    steps: Array | None
    adrift: npt.NDArray[np.bool_]
    unsettled: npt.NDArray[np.bool_]


@dataclass(frozen=True)
class _March:
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
        states, coefficients = len(self.equations.states), len(self.coefficients)
        columns = {column - states for _, column in self.compiled.update_slope_index if column >= states}
        direct = {column - coefficients for column in columns if column >= coefficients}
        return tuple(sorted(direct | {place for entry, place in self.coefficient_slopes if entry in columns}))

    @cached_property
    def inner(self) -> Mapping[int, Sequence[tuple[int, Array]]]:
        """The slopes of each coefficient by the moving parameters, by their places."""
        slopes: dict[int, list[tuple[int, Array]]] = {entry: [] for entry in range(len(self.coefficients))}
        for (entry, parameter), slope in self.coefficient_slopes.items():
            if parameter in self.moving:
                slopes[entry].append((self.moving.index(parameter), slope))
        return slopes

    def states(self, *, derivatives: bool) -> _States:
        """Give the states along the motions, and their slopes where derivatives are wanted."""
        count = len(self.equations.states)
        rows, samples = self.motion.y.shape
        parameters = len(self.moving) if derivatives else 0
        none = np.zeros(rows, dtype=np.bool_)
        if count == 0:
            return _States([], np.zeros((0, parameters, rows, samples)), None, none, none)
        rest = np.array([np.full(rows, state.start) for state in self.equations.states])
        if self.motion.periodic:
            return self._periodic(rest, parameters)
        columns = self._columns(np.concatenate([np.zeros((rows, 1)), self.motion.y[:, :-1]], axis=1))
        trajectory = self._walk(rest, columns)
        slopes = np.zeros((rows, samples, count, parameters))
        if derivatives:
            slopes = trail(slopes[:, 0], *self._slopes(rest, trajectory, columns, parameters))
        return _States(list(trajectory), np.moveaxis(slopes, (0, 1), (2, 3)), None, none, none)

    def _periodic(self, rest: Array, parameters: int) -> _States:
        """Bring the states' map over one cycle to its fixed point by Newton's method, after a first move from rest.

        Directions in which the map is the identity (an element that never slips) stay as that move left them.
        """
        count, rows = rest.shape
        last = self._last()
        from_rest = last._columns(np.zeros((rows, 1)))
        moved = last._walk(rest, from_rest)
        start, columns = moved[:, :, 0], self._columns(np.roll(self.motion.y, 1, axis=1))
        scale = 1e-300 + np.max(np.abs(start), axis=0)
        for _ in range(SETTLING_CYCLES):
            trajectory = self._walk(start, columns)
            by_states, by_parameters = self._slopes(start, trajectory, columns, parameters)
            change = trajectory[:, :, -1] - start
            to_begin = np.eye(count) - composed(np.moveaxis(by_states, 1, 0))
            inverse = np.linalg.pinv(to_begin, rcond=SETTLED)
            size = scale + np.max(np.abs(trajectory), axis=(0, 2))
            unsettled = ~np.all(np.abs(change) <= SETTLED * size, axis=0)
            if not np.any(unsettled):
                break
            start = start + np.einsum("rjk,kr->jr", inverse, change)
        adrift = np.min(np.linalg.svd(to_begin, compute_uv=False), axis=1) < SETTLED
        slopes = by_parameters
        if parameters:
            begin = last._slopes(rest, moved, from_rest, parameters)[1][:, 0]
            once = trail(begin, by_states, by_parameters)[:, -1]
            slopes = trail(begin + inverse @ (once - begin), by_states, by_parameters)
        return _States(list(trajectory), np.moveaxis(slopes, (0, 1), (2, 3)), by_states, adrift, unsettled)

    def _last(self) -> _March:
        """Give the march to the last sample alone."""
        motion = self.motion
        y, v, a = motion.y[:, -1:], motion.v[:, -1:], motion.a[:, -1:]
        return replace(
            self,
            coefficients=[column[:, -1:] for column in self.coefficients],
            coefficient_slopes={entry: slope[:, -1:] for entry, slope in self.coefficient_slopes.items()},
            motion=replace(motion, y=y, v=v, a=a),
        )

    def _columns(self, y_previous: Array) -> Columns:
        """Give what the states' update takes before and after the states."""
        motion, ones = self.motion, np.ones((len(self.motion.y), 1))
        numbers = [value * ones for value in (*self.values, *self.smoothing)]
        return [motion.y, motion.v, motion.a, y_previous, motion.h], [*self.coefficients, *numbers]

    def _walk(self, start: Array, columns: Columns) -> Array:
        """Step along all samples from the states (J, R) before the first; give those after each, (J, R, n)."""
        if len(self.motion.y) == 1:  # one motion is stepped many times faster in plain numbers than in arrays of one
            numbers = [[column[0].tolist() for column in some] for some in columns]
            try:
                steps = list(_steps(self.compiled.update_of_numbers, start[:, 0].tolist(), *numbers))
                return np.array(steps, dtype=np.float64).T[:, None]
            except (ArithmeticError, ValueError):
                pass  # what plain numbers refuse is infinite or no number in arrays
        states = np.empty((*start.shape, self.motion.y.shape[1]))
        arrays = [[list(column.T) for column in some] for some in columns]
        for index, after in enumerate(_steps(self.compiled.update, list(start), *arrays)):
            for state, value in zip(states, after, strict=True):
                state[:, index] = value
        return states

    def _slopes(self, start: Array, trajectory: Array, columns: Columns, parameters: int) -> tuple[Array, Array]:
        """Give the slopes of each step.

        Args:
            start: states (J, R) before the first sample.
            trajectory: states after each, (J, R, n).
            columns: the steps' other arguments.
            parameters: M; 0 where slopes by parameters aren't wanted.

        Returns:
            by the states, (R, n, J, J), and by the moving parameters, (R, n, J, M).
        """
        count, rows, samples = trajectory.shape
        moving, held = columns
        before = np.concatenate([start[:, :, None], trajectory[:, :, :-1]], axis=2)
        slopes = self.compiled.update_slopes(*moving, *before, *held)
        by_states, by_parameters = (np.zeros((rows, samples, count, width)) for width in (count, parameters))
        for (row, column), slope in zip(self.compiled.update_slope_index, slopes, strict=True):
            if column < count:
                by_states[:, :, row, column] = slope
            elif not parameters:
                continue
            elif column < count + len(self.coefficients):
                for place, inner in self.inner[column - count]:
                    by_parameters[:, :, row, place] += slope * inner
            else:
                by_parameters[:, :, row, self.moving.index(column - count - len(self.coefficients))] += slope
        return by_states, by_parameters


def _steps(
    update: Compiled, start: Sequence[Any], moving: Sequence[Sequence[Any]], held: Sequence[Sequence[Any]]
) -> Iterator[Sequence[Any]]:
    """Give the states after each sample, from those before the first; an argument of one value keeps it."""
    y, *others = moving
    fast, slow = ([repeat(values[0]) if len(values) == 1 else values for values in some] for some in (others, held))
    after = start
    for place, with_it, still in zip(y, zip(*fast, strict=False), zip(*slow, strict=False), strict=False):
        after = update(place, *with_it, *after, *still)
        yield after


def trail(start: Array, by_states: Array, inputs: Array) -> Array:
    """Carry slopes along all samples.

    Args:
        start: before the first sample, (R, J, M).
        by_states: of each step, (R, n, J, J).
        inputs: what each step adds, (R, n, J, M).

    Returns:
        after each sample, (R, n, J, M).
    """
    after, current = np.empty_like(inputs), start
    for index in range(inputs.shape[1]):
        current = by_states[:, index] @ current + inputs[:, index]
        after[:, index] = current
    return after


def composed(steps: Array) -> Array:
    """Give what linear steps (n, ..., d, d) make one after the other, (..., d, d)."""
    while len(steps) > 1:
        paired = len(steps) // 2 * 2
        steps = np.concatenate([steps[1:paired:2] @ steps[:paired:2], steps[paired:]])
    return np.asarray(steps[0])
