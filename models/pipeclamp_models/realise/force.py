"""The force of a law on given motions, many at once, with exact derivatives by its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Equations, Law
from pipeclamp_models.realise.arrays import FAST_ARGUMENTS, ArrayRealisation, Compiled, realise
from pipeclamp_models.realise.motion import Motion, Turning, refuse_unknown_conditions
from pipeclamp_models.realise.states import March

VELOCITY = FAST_ARGUMENTS.index("v")


@dataclass(frozen=True)
class LawForce:
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
        coefficient_slopes = {}
        if derivatives:  # to derive and to compile them takes longer than the forces of a few loops
            slopes = compiled.coefficient_slopes(*slow, *values, *smoothing)
            coefficient_slopes = dict(zip(compiled.coefficient_slope_index, slopes, strict=True))
        columns = [np.broadcast_to(np.atleast_2d(value), _column_shape(value, rows)) for value in coefficients]
        slope_columns = {
            index: np.broadcast_to(np.atleast_2d(value), _column_shape(value, rows))
            for index, value in coefficient_slopes.items()
        }
        march = March(compiled, equations, columns, slope_columns, values, smoothing, motion)
        states = march.states(derivatives=derivatives)
        fast = [motion.y, motion.v, motion.a, motion.y_previous, motion.h]
        arguments = [*fast, *states.after, *coefficients, *values, *smoothing]
        shape = (rows, samples)
        force = _with_means(compiled.force, arguments, motion.turning, shape)[0]
        law_force = LawForce(force, None, states.adrift, states.unsettled, states.after, states.steps)
        if not derivatives:
            return _late(compiled, values, motion, law_force)
        jacobian = np.zeros((len(values), rows, samples))
        force_slopes = compiled.force_slope_places.filled(
            _with_means(compiled.force_slopes, arguments, motion.turning, shape)
        )
        for (_, state), slope in force_slopes.by_state.items():
            jacobian[list(march.moving)] += slope * states.slopes[state]
        for (_, coefficient), slope in force_slopes.by_coefficient.items():
            for (entry, parameter), inner in coefficient_slopes.items():
                if entry == coefficient:
                    jacobian[parameter] += slope * inner
        for (_, parameter), slope in force_slopes.by_parameter.items():
            jacobian[parameter] += slope
    return _late(compiled, values, motion, replace(law_force, jacobian=jacobian))


def _with_means(
    function: Compiled, arguments: Sequence[Array], turning: Turning, shape: tuple[int, int]
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


def _late(compiled: ArrayRealisation, values: Sequence[float], motion: Motion, law_force: LawForce) -> LawForce:
    """Delay force and derivatives by the rig's lag: cycles harmonic by harmonic, records from sample to sample."""
    if compiled.in_time:
        return law_force
    lag = float(compiled.lag(*values)[0])
    if not motion.periodic:
        return _later(compiled, values, motion.h, lag, law_force)
    samples = motion.y.shape[1]
    omega = 2 * np.pi * np.arange(samples // 2 + 1) / (samples * motion.h)
    turn = np.exp(-1j * omega * lag)
    force = np.fft.rfft(law_force.force) * turn
    late = np.fft.irfft(force, samples)
    if law_force.jacobian is None:
        return replace(law_force, force=late)
    jacobian = np.fft.irfft(np.fft.rfft(law_force.jacobian) * turn, samples)
    for parameter, slope in zip(compiled.lag_slope_index, compiled.lag_slopes(*values), strict=True):
        jacobian[parameter] -= slope * np.fft.irfft(1j * omega * force, samples)
    return replace(law_force, force=late, jacobian=jacobian)


def _later(compiled: ArrayRealisation, values: Sequence[float], h: Array, lag: float, law_force: LawForce) -> LawForce:
    """Delay the force of records, straight between samples; what is before and after them stands still."""
    last = law_force.force.shape[1] - 1
    place = np.clip(np.arange(last + 1) - lag / h, 0.0, last)
    left = np.minimum(place.astype(np.intp), max(last - 1, 0))
    right = np.minimum(left + 1, last)
    share = place - left
    rows = np.arange(len(h))[:, None]

    def delayed(samples: Array) -> Array:
        return np.asarray((1 - share) * samples[..., rows, left] + share * samples[..., rows, right])

    force = law_force.force
    late = delayed(force)
    if law_force.jacobian is None:
        return replace(law_force, force=late)
    jacobian = delayed(law_force.jacobian)
    moving = (place > 0.0) & (place < last)
    slope = np.where(moving, (force[rows, right] - force[rows, left]) / h, 0.0)
    for parameter, by_parameter in zip(compiled.lag_slope_index, compiled.lag_slopes(*values), strict=True):
        jacobian[parameter] -= by_parameter * slope
    return replace(law_force, force=late, jacobian=jacobian)
