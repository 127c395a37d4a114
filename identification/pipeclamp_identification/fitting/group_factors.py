"""Factors of groups of runs: specimens, valves, operators that differ in stiffness, damping or mean force.

A group's factors are random, of a spread that the runs themselves tell (partial pooling): few runs pull a group little
away from the others. They sum to none, for a common factor is the law's. They belong to the tests and not to the law,
which stands for the group in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from pipeclamp_identification.fitting.observations import WeightedLoops
from pipeclamp_identification.signals.orthonormal import orthonormal
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.realise.force import LawForce

VARIANCE_RATIOS = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 161)])
"""Ratios of variances, between groups over between runs, among which the likeliest is taken."""


@dataclass(frozen=True)
class Mixed:
    """A quantity of runs: what conditions make of it, each group's share, and scatter.

    Attributes:
        values: of each group, shrunk towards none, their sum zero, shape (G,).
        errors: standard error of each, shape (G,).
        spread: standard deviation between groups.
        scatter: standard deviation between runs of a group.
        rest: what is left of each run, its group's share included, shape (R,).
    """

    values: Array
    errors: Array
    spread: float
    scatter: float
    rest: Array


def mixed(quantity: Array, fixed: Array, member: Array) -> Mixed:
    """Estimate groups' shares of a quantity by restricted maximum likelihood.

    Args:
        quantity: of each run, shape (R,).
        fixed: orthonormal functions of the conditions, shape (R, p).
        member: one where a run is of a group, shape (R, G).
    """
    rest = quantity - fixed @ (fixed.T @ quantity)
    contrasts = contrasts_of(member.shape[1])
    member = member @ contrasts
    own = member - fixed @ (fixed.T @ member)
    left, singular, _ = np.linalg.svd(own, full_matrices=False)
    known = singular > 1e-8 * max(float(singular[0]), 1e-300)
    left, sizes = left[:, known], singular[known] ** 2
    along = (left.T @ rest) ** 2
    beyond = float(rest @ rest - along.sum())
    free = len(quantity) - fixed.shape[1]
    weight = 1 + VARIANCE_RATIOS[:, None] * sizes
    squares = np.sum(along / weight, axis=1) + beyond
    ratio = float(
        VARIANCE_RATIOS[np.argmin(free * np.log(np.maximum(squares, 1e-300)) + np.sum(np.log(weight), axis=1))]
    )
    scatter = float(np.sqrt(max(np.sum(along / (1 + ratio * sizes)) + beyond, 0.0) / free))
    normal = own.T @ own + np.eye(member.shape[1]) / max(ratio, 1e-12)
    inverse = np.linalg.inv(normal)
    return Mixed(
        values=contrasts @ (inverse @ (own.T @ rest)),
        errors=scatter * np.sqrt(np.diag(contrasts @ inverse @ contrasts.T)),
        spread=scatter * float(np.sqrt(ratio)),
        scatter=scatter,
        rest=rest,
    )


def contrasts_of(groups: int, beside: Array | None = None) -> Array:
    """Give orthonormal differences between groups, one a column, shape (G, G - 1 - p).

    Args:
        groups: how many, G.
        beside: numbers of each group that differences are to be sought beside, shape (G, p); none but a common one
            where it is None.
    """
    common = np.ones((groups, 1))
    taken = orthonormal(common if beside is None else np.concatenate([common, beside - beside.mean(axis=0)], axis=1))
    return np.asarray(np.linalg.svd(np.eye(groups) - taken @ taken.T)[0][:, : groups - taken.shape[1]])


@dataclass(frozen=True)
class GroupFactors:
    """What differences between groups do to measured harmonics.

    Attributes:
        directions: harmonics in N per unit of each difference, shape (K, R, m).
        members: how much of each difference each row has, shape (K, R).
        kinds: what each difference is of, a number for each column and quantity, shape (K,).
        spreads: standard deviation of each, shape (K,).
        values: of each, as a first estimate, shape (K,).
        own: signals of the conditions that are constant inside each group, beside which the groups differ.
    """

    directions: Array
    members: Array
    kinds: IntArray
    spreads: Array
    values: Array
    own: frozenset[str] = frozenset()

    def rows(self, chosen: IntArray) -> GroupFactors:
        """Give them for some of the rows."""
        return replace(self, directions=self.directions[:, chosen], members=self.members[:, chosen])

    def beside(self, law_force: LawForce) -> GroupFactors:
        """Give what of them shows beside a law: no mean force where the law leaves it open."""
        if not law_force.adrift.any():
            return self
        directions = self.directions.copy()
        directions[:, law_force.adrift, 0] = 0.0
        return replace(self, directions=directions)

    def of_groups_in(self, own: BoolArray) -> Array:
        """Give the factors of groups that stand in these rows, (R,), alone, as sums of the differences, (C, K)."""
        sums = []
        for kind in np.unique(self.kinds):
            members = np.where((self.kinds == kind)[:, None], self.members, 0.0).T
            here, elsewhere = np.unique(members[own], axis=0), members[~own]
            sums += [one for one in here if one.any() and not np.isclose(elsewhere, one).all(axis=1).any()]
        return np.array(sums).reshape(-1, len(self.kinds))

    def force(self, values: Array | None = None) -> Array:
        """Give what factors, of these values or of the first estimate, add to the harmonics, N, shape (R, m)."""
        return np.asarray(np.tensordot(self.values if values is None else values, self.directions, axes=1))

    @property
    def precision(self) -> Array:
        """One over the variance of each factor, shape (K,)."""
        return np.asarray(self.spreads**-2.0)


class Weighted(Protocol):
    """Observations that say in which units they compare harmonics."""

    def in_units(self, plain: Array) -> Array:
        """Give harmonics in N, shape (..., R, m), in units of their uncertainty."""


@dataclass(frozen=True)
class Pooling:
    """Random factors of groups in the units of observations.

    Attributes:
        basis: what each factor does, shape (R m, K).
        precision: one over its variance, shape (K,).
    """

    basis: Array
    precision: Array

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        left, singular, _ = np.linalg.svd(self.basis / np.sqrt(self.precision), full_matrices=False)
        return left, 1 - 1 / np.sqrt(1 + singular**2)

    def without(self, residual: Array) -> Array:
        """Give residuals, shape (..., R, m), in units in which noise and random factors together are independent."""
        left, taken = self._directions
        flat = residual.reshape(*residual.shape[:-2], -1)
        return np.asarray((flat - ((flat @ left) * taken) @ left.T).reshape(residual.shape))

    def estimate(self, residual: Array) -> Array:
        """Give the likeliest factors behind residuals in the observations' units, shape (R, m)."""
        normal = self.basis.T @ self.basis + np.diag(self.precision)
        return np.asarray(np.linalg.solve(normal, self.basis.T @ residual.ravel()))


class Poolings:
    """Random factors of groups in the units of observations; as they show beside one law after the other."""

    def __init__(self, observations: Weighted, factors: GroupFactors) -> None:
        self.observations, self.factors = observations, factors
        self._known: dict[bytes, Pooling] = {}

    def beside(self, law_force: LawForce) -> Pooling:
        """Give them as they show beside a law: the last one is remembered."""
        key = law_force.adrift.tobytes()
        if key not in self._known:
            basis = self.observations.in_units(self.factors.beside(law_force).directions)
            self._known = {key: Pooling(basis.reshape(len(basis), -1).T, self.factors.precision)}
        return self._known[key]


@dataclass(frozen=True)
class PooledObservations(WeightedLoops):
    """Harmonics of loops of which groups have factors of their own: what a law of the middle one is fitted to."""

    factors: GroupFactors

    @cached_property
    def _poolings(self) -> Poolings:
        return Poolings(self.loops, self.factors)

    def residual(self, law_force: LawForce) -> Array:
        """Give measured less law, in units in which noise and factors together are independent."""
        return self._poolings.beside(law_force).without(self.loops.residual(law_force))

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals."""
        slopes = self.loops.residual_slopes(law_force, parameters)
        return self._poolings.beside(law_force).without(slopes)

    def compared(self, law_force: LawForce) -> int:
        """Give how many of the residuals are evidence."""
        return self.loops.compared(law_force)

    def estimate(self, law_force: LawForce) -> Array:
        """Give the likeliest factors of a law's force, shape (K,)."""
        return self._poolings.beside(law_force).estimate(self.loops.residual(law_force))
