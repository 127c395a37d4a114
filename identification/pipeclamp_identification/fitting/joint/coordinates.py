"""The coordinates in which a fit is sought: coefficients in the middle of the tests, not where they are stated.

A stiffness k10 (A/A0)^a is stated at A0 and shown where the tests are: far from A0 these tell k10 only along with `a`,
in a narrow valley that bends, which steps follow by small pieces. In the middle of the tests k1 hardly moves with `a`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.joint.beforehand import Priors
from pipeclamp_identification.fitting.joint.evaluator import Evaluator
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.realise.force import Terms, known_jacobian

LARGEST_LOG = 50.0
"""A size is moved by no more than the exponential of this, so that it stays a number."""


@dataclass(frozen=True)
class Coordinates:
    """Coordinates q of P parameters p: q = p but for sizes, of which q = p exp(sum of rates (p of shape - its begin)).

    What has a bound or a prior is its own coordinate, and a size stays on its side of zero: both hold as they are.

    Attributes:
        sizes: places of the S sizes, to which a coefficient is in proportion.
        shapes: places of the E parameters that the coefficients follow besides.
        rates: change of the coefficients' logarithms with these in the middle of the tests, (S, E).
        begin: where the shapes begin, (E,): there both coordinates are the same.
    """

    sizes: IntArray
    shapes: IntArray
    rates: Array
    begin: Array

    def _factors(self, values: Array) -> Array:
        logarithms = self.rates @ (values[self.shapes] - self.begin)
        return np.exp(np.clip(logarithms, -LARGEST_LOG, LARGEST_LOG))

    def of(self, parameters: Array) -> Array:
        """Give the coordinates of parameters, (P,) each."""
        found = parameters.copy()
        found[self.sizes] *= self._factors(parameters)
        return found

    def parameters(self, coordinates: Array) -> Array:
        """Give the parameters that have coordinates, (P,) each."""
        found = coordinates.copy()
        found[self.sizes] /= self._factors(coordinates)
        return found

    def slopes(self, jacobian: Array, parameters: Array) -> Array:
        """Give derivatives by the coordinates from those by the parameters, (M, P) each, at parameters (P,)."""
        found = jacobian.copy()
        found[:, self.shapes] -= (jacobian[:, self.sizes] * parameters[self.sizes]) @ self.rates
        found[:, self.sizes] /= self._factors(parameters)
        return found


def coordinates_at(evaluator: Evaluator, at: Array, bounds: tuple[Array, Array], priors: Priors) -> Coordinates:
    """Give the coordinates for a fit that begins at a point: the parameters themselves where residuals are no forces.

    The logarithms of energies have valleys of another form, between which these led into poor ones.

    Args:
        evaluator: of the free parameters, P of them.
        at: where it begins, (P,).
        bounds: lower and upper, (P,) each.
        priors: of the free parameters.
    """
    lower, upper = bounds
    open_ended = np.isposinf(upper) & (np.isneginf(lower) | (lower == 0.0)) & (priors.root == 0.0) & (at != 0.0)
    open_ended &= evaluator.observations.are_linear
    law_force = evaluator.law_force(at)
    terms = [known_jacobian(law_force).terms[place] for place in evaluator.free]
    sizes = _sizes(terms, open_ended)
    rates = np.zeros((len(sizes), len(at)))
    if len(sizes):
        with np.errstate(all="ignore"):
            shown = evaluator.observations.residual_slopes(law_force, evaluator.free[sizes])
            for row, (size, slopes) in enumerate(zip(sizes, shown, strict=True)):
                rates[row] = _rates(terms, int(size), float(at[size]), np.sum(slopes**2, axis=1))
    rates[:, sizes] = 0.0
    shapes = np.flatnonzero(np.any(rates != 0.0, axis=0))
    return Coordinates(sizes, shapes, rates[:, shapes], at[shapes])


def _sizes(terms: Sequence[Terms], may: BoolArray) -> IntArray:
    """Give the parameters that move one coefficient alone, of those that may be sizes; the first one of each."""
    found: dict[int, int] = {}
    places: list[int] = np.flatnonzero(may).tolist()
    for place in places:
        courses = [course for course, factor in terms[place] if isinstance(factor, np.ndarray)]
        if len(courses) == len(terms[place]) == 1:
            found.setdefault(courses[0], place)
    return np.array(sorted(found.values()), dtype=np.intp)


def _rates(terms: Sequence[Terms], size: int, value: float, weights: Array) -> Array:
    """Give how the logarithm of a size's coefficient changes with each parameter, in the mean over the rows, (P,).

    Args:
        terms: of all parameters.
        size: place of the size.
        value: of it.
        weights: how far each row shows it, (R,).
    """
    found = np.zeros(len(terms))
    ((course, own),) = terms[size]
    rows = weights > 0
    for place, one in enumerate(terms):
        for other, factor in one:
            if other == course and place != size and rows.any():
                change = np.broadcast_to(np.ravel(factor / (value * own)), weights.shape)[rows]
                found[place] = np.average(change, weights=weights[rows])
    return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)
