"""The force of a law on given motions, many at once, with exact derivatives by its parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.law.law import Equations, Law
from pipeclamp_models.realise.arrays import FAST_ARGUMENTS, ArrayRealisation, InParts, Pair, realise
from pipeclamp_models.realise.motion import Motion, Turning, refuse_unknown_conditions
from pipeclamp_models.realise.states import March, States

VELOCITY = FAST_ARGUMENTS.index("v")


@dataclass(frozen=True)
class Jacobian:
    """Derivatives of the force by the parameters: sums of courses along the motions, each times a number of its row.

    The parameters of a power surface share the course of its coefficient: few courses stand for many parameters.

    Attributes:
        courses: shape (K, R, n).
        terms: for each parameter, the courses that make up its derivative, by place, and their factors, shape (R, 1) or
            numbers.
    """

    courses: Array
    terms: Sequence[Sequence[tuple[int, Array | float]]]

    def of(self, parameters: IntArray) -> Array:
        """Give the derivatives by some of the parameters, shape (P, R, n)."""
        return self.through(lambda courses: courses, parameters)

    def through(self, linear: Callable[[Array], Array], parameters: IntArray) -> Array:
        """Give what a linear map makes of the derivatives by some of the parameters.

        Args:
            linear: takes forces of shape (K, R, n) to shape (K, R, m), row by row.
            parameters: places of the parameters, P of them.

        Returns:
            shape (P, R, m).
        """
        used = sorted({course for parameter in parameters for course, _ in self.terms[parameter]})
        every = len(used) == len(self.courses)  # all of them are many megabytes, which needn't be copied
        mapped = linear(self.courses if every else self.courses[used])
        by_course = dict(zip(used, mapped, strict=True))
        found = np.zeros((len(parameters), *mapped.shape[1:]))
        for derivative, parameter in zip(found, parameters, strict=True):
            for place, (course, factor) in enumerate(self.terms[parameter]):
                if place:
                    derivative += factor * by_course[course]
                else:
                    np.multiply(factor, by_course[course], out=derivative)
        return found

    def moved(self, courses: Array, course: Array, factors: Mapping[int, float]) -> Jacobian:
        """Give the same sums of other courses, and of one more, which some parameters have with these factors."""
        terms = [list(one) for one in self.terms]
        for parameter, factor in factors.items():
            terms[parameter].append((len(courses), factor))
        return Jacobian(np.concatenate([courses, course[None]]), terms)


@dataclass(frozen=True)
class LawForce:
    """Force of a law on motions.

    Attributes:
        force: N, shape (R, n).
        jacobian: derivatives of the force by the parameters, where asked for.
        adrift: rows in which a state never loses its beginning (an element that sticks all the way round, say), so
            that the force is known up to a constant which only the history before the record would tell; shape (R,).
        held: mean force, N, that the states of such a row can hold at most: what the largest of the motions would have
            stretched them by before; zero in other rows; shape (R,).
        unsettled: rows in which a state isn't periodic after all that was tried: their force is that of one cycle among
            others; shape (R,).
        states: the states after each sample, J arrays of shape (R, n).
    """

    force: Array
    jacobian: Jacobian | None
    adrift: BoolArray
    held: Array
    unsettled: BoolArray
    states: Sequence[Array]


def known_jacobian(law_force: LawForce) -> Jacobian:
    """Give the Jacobian of a force that was computed with it."""
    if law_force.jacobian is None:
        raise ValueError("the force was computed without derivatives")
    return law_force.jacobian


def force_of_law(law: Law, motion: Motion) -> LawForce:
    """Give the force of a law on motions."""
    equations = law.equations
    return force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion)


def force_of_equations(
    equations: Equations,
    parameters: Sequence[float] | Array,
    smoothing: tuple[float, float],
    motion: Motion,
    *,
    derivatives: bool = False,
) -> LawForce:
    """Give the force on motions. States start at rest; on periodic motions they are brought to their periodic values.

    Where a periodic motion reverses, force may step between two samples. The sample whose interval holds the reversal
    then stands for the mean over its interval, so that harmonics see the step where it is.

    Args:
        equations: the composed law.
        parameters: values in the order of the equations' parameters.
        smoothing: v_r (mm/s) and y_r (mm).
        motion: the motions, R rows of n samples.
        derivatives: whether the Jacobian is wanted, of periodic motions alone.

    Raises:
        ValueError: it is wanted of others.
        UserError: a condition that the law depends on isn't stated.
    """
    if derivatives and not motion.periodic:
        raise ValueError("got a record; expected periodic motions, the only ones with derivatives")
    compiled = realise(equations)
    refuse_unknown_conditions(compiled.slow, motion)
    values = [float(value) for value in parameters]
    slow = [motion.slow[name] for name in compiled.slow]
    numbers = [*values, *smoothing]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        still = compiled.coefficients_with_slopes if derivatives else compiled.coefficients
        values_and_slopes, count = still(*slow, *numbers), len(equations.outline.coefficients)
        coefficients = values_and_slopes[:count]
        states = _march(compiled, equations, coefficients, numbers, motion).states(derivatives=derivatives)
        fast = [motion.y, motion.v, motion.a, motion.y_previous, motion.moved_in]
        arguments = [*fast, *states.after, *coefficients, *numbers]
        evaluated = compiled.force_with_slopes if derivatives else compiled.force
        force, *slopes = _with_means(evaluated, arguments, motion.turning, motion.y.shape)
        held = _held(compiled, fast, states, [*coefficients, *numbers], motion)
        jacobian = None
        if derivatives:  # to derive and to compile them takes longer than the forces of a few loops
            by_parameters = dict(zip(compiled.coefficient_slope_index, values_and_slopes[count:], strict=True))
            found = dict(zip(compiled.force_slope_index, slopes, strict=True))
            jacobian = _jacobian(equations, motion, found, states.slopes, by_parameters)
    law_force = LawForce(force, jacobian, states.adrift, held, states.unsettled, states.after)
    return _late(compiled, values, motion, law_force)


def step_slopes(
    equations: Equations, parameters: Sequence[float] | Array, smoothing: tuple[float, float], motion: Motion,
    states: Sequence[Array],
) -> Array:  # fmt: skip
    """Give the derivatives of periodic states by those a sample before, shape (R, n, J, J).

    Args:
        equations, parameters, smoothing, motion: as of `force_of_equations`.
        states: as its answer has them.
    """
    compiled = realise(equations)
    numbers = [*map(float, parameters), *smoothing]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        coefficients = compiled.coefficients(*(motion.slow[name] for name in compiled.slow), *numbers)
        return _march(compiled, equations, coefficients, numbers, motion).step_slopes(states)


def _march(
    compiled: ArrayRealisation,
    equations: Equations,
    coefficients: Sequence[npt.ArrayLike],
    numbers: Sequence[float],
    motion: Motion,
) -> March:
    columns = [_column(value, len(motion.y)) for value in coefficients]
    return March(compiled, equations, columns, numbers, motion)


def _jacobian(
    equations: Equations,
    motion: Motion,
    slopes: Mapping[int, Array],
    of_states: Mapping[Pair, Array],
    of_coefficients: Mapping[Pair, Array | float],
) -> Jacobian:
    """Put the derivatives by the parameters together: a course for each coefficient, and for each parameter itself.

    Args:
        equations: the composed law: states, coefficients and parameters.
        motion: periodic motions.
        slopes: of the force, (R, n) each, by places among states, coefficients and parameters.
        of_states: slopes of the states, (R, n) each, by places among them, and among coefficients and parameters.
        of_coefficients: slopes of coefficients by parameters, which keep still along the motions.
    """
    states, coefficients = len(equations.states), len(equations.outline.coefficients)
    courses = {place - states: slope for place, slope in slopes.items() if place >= states}
    for (state, by), slope in of_states.items():
        if state in slopes:
            moved = slopes[state] * slope
            courses[by] = courses[by] + moved if by in courses else moved
    terms: list[list[tuple[int, Array | float]]] = [[] for _ in equations.names]
    for course, by in enumerate(courses):
        if by >= coefficients:
            terms[by - coefficients].append((course, 1.0))
        for (coefficient, parameter), factor in of_coefficients.items():
            if coefficient == by:
                terms[parameter].append((course, factor))
    return Jacobian(np.array(list(courses.values())).reshape(len(courses), *motion.y.shape), terms)


def _held(
    compiled: ArrayRealisation, fast: Sequence[Array], states: States, still: Sequence[npt.ArrayLike], motion: Motion
) -> Array:
    """Give the mean force that states which are adrift can hold at most, N, shape (R,).

    Half of what they move by in a cycle, as far as the largest of the motions would have moved them. What loses its
    beginning in a cycle beside them, such as an element that slips, holds nothing.

    Args:
        compiled: the law.
        fast: signals at each sample.
        states: of all rows.
        still: coefficients, parameters and smoothing.
        motion: the motions.
    """
    held = np.zeros(len(motion.y))
    if states.kept is None or not states.adrift.any():
        return held
    reach = np.array([np.ptp(state, axis=1) / 2 for state in states.after])
    half = np.clip(np.einsum("rjk,kr->jr", states.kept, reach), -reach, reach)[:, :, None]
    ends = []
    for sign in (1, -1):
        moved = [state + sign * move for state, move in zip(states.after, half, strict=True)]
        ends.append(np.broadcast_to(compiled.force(*fast, *moved, *still)[0], motion.y.shape).mean(axis=1))
    size = np.ptp(motion.y, axis=1)
    return np.asarray(np.where(states.adrift, np.abs(ends[0] - ends[1]) / 2 * (size.max() / size), held))


def _with_means(
    function: InParts, arguments: Sequence[Array | float], turning: Turning, shape: tuple[int, int]
) -> list[Array]:
    """Evaluate force or slopes at all samples; where the motion turns, their mean over the sample's interval.

    Only the velocity is taken to change within an interval: all else stands nearly still at a reversal, and so does
    what doesn't take the velocity.

    Args:
        function: of the fast arguments.
        arguments: their values, of shape (R, n) or what broadcasts to it.
        turning: where the motion turns.
        shape: (R, n).
    """
    results = [_filled(value, shape) for value in function(*arguments)]
    if len(turning.row):
        moved, there = function.taking(VELOCITY), list(arguments)
        for column in moved.columns:
            there[column] = _where_turning(arguments[column], turning)
        there[VELOCITY] = turning.v
        for result, values in zip(results, moved(*there), strict=True):
            if np.shape(values) == turning.v.shape:
                change = np.add.reduce(turning.weight * values[:, 1:], 1) - values[:, 0]
                result[turning.row, turning.sample] += turning.share * change
    return results


def _filled(value: npt.ArrayLike, shape: tuple[int, int]) -> Array:
    """Give an own array of this shape; NumPy's own way by a broadcast view takes twice as long for few loops."""
    array = np.empty(shape)
    array[...] = value
    return array


def _where_turning(value: Array | float, turning: Turning) -> Array | float:
    """Give a quantity where the motion turns, one row each, of what broadcasts to (R, n) without broadcasting it."""
    if isinstance(value, float):
        return value
    array = np.asarray(value, dtype=np.float64)
    if array.ndim < 2:
        array = np.atleast_2d(array)
    row = turning.row if array.shape[0] > 1 else 0
    sample = turning.sample if array.shape[1] > 1 else 0
    return np.reshape(array[row, sample], (-1, 1))


def _column(value: npt.ArrayLike, rows: int) -> Array:
    """Give a slow quantity as a column, (R, 1), or as it is where it changes along the row, (R, n)."""
    array = np.asarray(value, dtype=np.float64)
    if array.shape == (rows, 1):
        return array
    array = np.atleast_2d(array)
    return np.broadcast_to(array, (rows, array.shape[1]))


def _late(compiled: ArrayRealisation, values: Sequence[float], motion: Motion, law_force: LawForce) -> LawForce:
    """Delay force and derivatives by the rig's lag: cycles harmonic by harmonic, records from sample to sample."""
    if compiled.in_time:
        return law_force
    lag = float(compiled.lag(*values)[0])
    if not motion.periodic:
        return _later(motion.h, lag, law_force)
    samples = motion.y.shape[1]
    omega = 2 * np.pi * np.arange(samples // 2 + 1) / (samples * motion.h)
    turn = np.exp(-1j * omega * lag)
    force = np.fft.rfft(law_force.force) * turn
    late = np.fft.irfft(force, samples)
    if law_force.jacobian is None:
        return replace(law_force, force=late)
    courses = np.fft.irfft(np.fft.rfft(law_force.jacobian.courses) * turn, samples)
    by_lag = -np.fft.irfft(1j * omega * force, samples)
    lag_slopes = dict(zip(compiled.lag_slope_index, compiled.lag_slopes(*values), strict=True))
    return replace(law_force, force=late, jacobian=law_force.jacobian.moved(courses, by_lag, lag_slopes))


def _later(h: Array, lag: float, law_force: LawForce) -> LawForce:
    """Delay the force of records, straight between samples; what is before and after them stands still."""
    last = law_force.force.shape[1] - 1
    place = np.clip(np.arange(last + 1) - lag / h, 0.0, last)
    left = np.minimum(place.astype(np.intp), max(last - 1, 0))
    right = np.minimum(left + 1, last)
    share = place - left
    rows = np.arange(len(h))[:, None]

    def delayed(samples: Array) -> Array:
        return np.asarray((1 - share) * samples[..., rows, left] + share * samples[..., rows, right])

    return replace(law_force, force=delayed(law_force.force))
