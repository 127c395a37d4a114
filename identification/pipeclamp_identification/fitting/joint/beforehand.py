"""What is known of parameters before the tests: bounds, and normal priors, which join the data as residuals.

A fit between bounds comes to one in ever shorter steps, and ends before it is there. Where such a parameter counted as
free, a linear step of the law could take most of what is missing, by values that the bound forbids.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.law.law import Equations
from pipeclamp_models.law.outline import Sizes, number_in

AT_BOUND = 1e-6
"""A parameter is at a bound when no more than this share of the allowed range lies between."""
CLOSE = 1e-3
"""And when no more than this lies between, and a step of its own leads over the bound."""
ABOVE_LOWER = 0.01
"""No more than this share of a lower bound above nought may lie above it either: a range may cover decades."""
SMALLEST_SIZE = 1e-3
"""Size that a parameter without two bounds counts as at least."""


def parameter_bounds(equations: Equations, scales: Sizes) -> tuple[Array, Array]:
    """Give the lower and the upper bound of each parameter of a law, for data of these scales."""
    lower = np.array([number_in(parameter.lower, scales) for parameter in equations.parameters])
    upper = np.array([number_in(parameter.upper, scales) for parameter in equations.parameters])
    return lower, upper


def close_to_a_bound(values: Array, lower: Array, upper: Array, share: float) -> BoolArray:
    """Tell which values lie within a share of their allowed range of a bound, shape (P,) each.

    Where a bound is infinite the value itself stands for the range.
    """
    allowed = upper - lower
    width = share * np.where(np.isfinite(allowed), allowed, np.maximum(np.abs(values), SMALLEST_SIZE))
    above = np.where(lower > 0, np.minimum(width, ABOVE_LOWER * lower), width)
    return np.asarray((values - lower <= above) | (upper - values <= width))


def steps_over_a_bound(values: Array, lower: Array, upper: Array, residual: Array, jacobian: Array) -> BoolArray:
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


@dataclass(frozen=True)
class Priors:
    """Normal priors of parameters, shape (P,) each: `root` is one over the standard deviation, zero without a prior."""

    mean: Array
    root: Array

    def of(self, chosen: IntArray) -> Priors:
        """Give those of some parameters."""
        return Priors(self.mean[chosen], self.root[chosen])

    def residual(self, values: Array) -> Array:
        """Give the residuals by which priors join the data's."""
        return (values - self.mean) * self.root


def spreads_of(equations: Equations, scales: Sizes) -> dict[str, float]:
    """Give the standard deviations of the priors of a law's parameters, for data of these scales, by name."""
    return {
        parameter.name: number_in(parameter.spread, scales)
        for parameter in equations.parameters
        if parameter.spread is not None
    }


def priors_of(equations: Equations, scales: Sizes) -> Priors:
    """Give the priors of a law's parameters, for data of these scales."""
    spreads = spreads_of(equations, scales)
    roots = [1.0 / spreads.get(name, math.inf) for name in equations.names]
    neutral = equations.neutral_values
    means = [neutral.get(name, 0.0) for name in equations.names]
    return Priors(np.array(means), np.array(roots))
