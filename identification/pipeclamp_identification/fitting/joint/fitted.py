"""What a fit comes to: a law with its uncertainty."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.groups import Groups
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.law import Equations, Law
from pipeclamp_models.law.outline import ParameterOutline
from pipeclamp_models.realise.force import LawForce

STRONG_CORRELATION = 0.95


@dataclass(frozen=True)
class Fit:
    """A fitted law with its uncertainty.

    Attributes:
        law: structure and values.
        equations: the composed law.
        fitted: names of the fitted parameters, in the order of `covariance`.
        covariance: shape (fitted, fitted).
        frozen: why a parameter was held, by name.
        at_bound: parameters that ended at a bound, each with that bound.
        law_force: force (R, n) and Jacobian at the solution.
        cost: half the sum of squared weighted residuals, without the priors'.
        spreads: standard deviations of the priors, by parameter; those that have none are not in it.
        room: from each fitted parameter down and up to its bounds, shape (2, fitted).
        groups: columns of texts by which the runs differ beside the law, or may; what they do is no part of it.
    """

    law: Law
    equations: Equations
    fitted: tuple[str, ...]
    covariance: Array
    frozen: Mapping[str, str]
    at_bound: Mapping[str, float]
    law_force: LawForce
    cost: float
    spreads: Mapping[str, float]
    room: Array
    groups: tuple[Groups, ...] = ()

    @property
    def places(self) -> IntArray:
        """Places of the fitted parameters among all of the law's."""
        place = {name: index for index, name in enumerate(self.equations.names)}
        return np.array([place[name] for name in self.fitted], dtype=np.intp)

    @property
    def fitted_parameters(self) -> list[ParameterOutline]:
        """The parameters that were fitted, in the order of their names."""
        return [self.equations.parameters[place] for place in self.places]

    @property
    def precision(self) -> Array:
        """One over the variance of the fitted parameters' priors, zero where there is none, shape (fitted,)."""
        return np.array([self.spreads.get(name, math.inf) ** -2.0 for name in self.fitted])

    @property
    def from_priors(self) -> Array:
        """How far the fitted parameters lie from the means of their priors, shape (fitted,)."""
        means = self.equations.neutral_values
        return np.array([self.law.values[name] - means.get(name, 0.0) for name in self.fitted])

    def values_of(self, effects: Collection[str]) -> dict[str, float]:
        """Give the values of the parameters that effects bring, by name; in units of the law."""
        return {
            parameter.name: self.law.values[parameter.name]
            for effect in self.equations.effects
            if effect.name in effects
            for parameter in effect.parameters
        }

    def standard_errors(self) -> dict[str, float]:
        """Give the standard error of each fitted parameter by name."""
        return dict(zip(self.fitted, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def strong_correlations(self) -> list[tuple[str, str, float]]:
        """Give the pairs of parameters whose correlation exceeds `STRONG_CORRELATION`, strongest first."""
        scale = np.sqrt(np.diag(self.covariance))
        correlation = self.covariance / np.outer(scale, scale)
        pairs = [
            (self.fitted[i], self.fitted[j], float(np.clip(correlation[i, j], -1, 1)))
            for i, j in itertools.combinations(range(len(self.fitted)), 2)
            if abs(correlation[i, j]) > STRONG_CORRELATION
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))
