"""What is held likely of parameters before the tests: normal distributions, which join the data as residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Equations
from pipeclamp_models.law.outline import Sizes, number_in


@dataclass(frozen=True)
class Priors:
    """Normal priors of parameters, shape (P,) each: `root` is one over the standard deviation, zero without a prior."""

    mean: Array
    root: Array

    def of(self, chosen: npt.NDArray[np.intp]) -> Priors:
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
    means = [parameter.neutral or 0.0 for parameter in equations.parameters]
    return Priors(np.array(means), np.array(roots))
