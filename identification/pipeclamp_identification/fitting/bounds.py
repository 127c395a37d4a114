"""Which parameters of a fit a bound holds: those that lie at it, and those that the fit has brought close to it.

A fit between bounds comes to one in ever shorter steps, and ends before it is there. Where such a parameter counted as
free, a linear step of the law could take most of what is missing, by values that the bound forbids.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array

AT_BOUND = 1e-6
"""A parameter is at a bound when no more than this share of the allowed range lies between."""
CLOSE = 1e-3
"""And when no more than this lies between, and a step of its own leads over the bound."""
ABOVE_LOWER = 0.01
"""No more than this share of a lower bound above nought may lie above it either: a range may cover decades."""
SMALLEST = 1e-3
"""Size that a parameter without two bounds counts as at least."""


def close_to_a_bound(values: Array, lower: Array, upper: Array, share: float) -> npt.NDArray[np.bool_]:
    """Tell which values lie within a share of their allowed range of a bound, shape (P,) each.

    Where a bound is infinite the value itself stands for the range.
    """
    allowed = upper - lower
    width = share * np.where(np.isfinite(allowed), allowed, np.maximum(np.abs(values), SMALLEST))
    above = np.where(lower > 0, np.minimum(width, ABOVE_LOWER * lower), width)
    return np.asarray((values - lower <= above) | (upper - values <= width))


def steps_over_a_bound(
    values: Array, lower: Array, upper: Array, residual: Array, jacobian: Array
) -> npt.NDArray[np.bool_]:
    """Tell which parameters a step of least squares of their own, the others held, would take over a bound.

    Args:
        values: at the end of a fit, shape (P,).
        lower, upper: their bounds, shape (P,).
        residual: weighted, the priors' too, shape (M,).
        jacobian: its derivatives, shape (M, P).
    """
    curvature = np.sum(jacobian**2, axis=0)
    step = -(jacobian.T @ residual) / np.where(curvature > 0, curvature, np.inf)
    return np.asarray((values + step < lower) | (values + step > upper))
