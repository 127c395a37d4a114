"""Where a law's form is off, and how: shares at tested conditions, and between them what these foretell (kriging).

A share follows the conditions as a Gaussian process does, whose lengths say how far one test tells of another. Near
tests it is known to what scatters there; far from all of them nothing but its whole deviation is.
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, Eqs. 2.25 and 2.26.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.file import KrigedShare, LocalForm

LOGARITHMIC = frozenset({"A", "f"})
"""Conditions whose logarithm counts."""


def coordinate(name: str, values: Array) -> Array:
    """Give what counts of a condition: the logarithm of A and f, else the condition itself."""
    return np.log(values) if name in LOGARITHMIC else np.asarray(values, dtype=np.float64)


def squares(one: Array, other: Array) -> Array:
    """Give the squared distances of conditions, (n, c) and (m, c), along each; shape (n, m, c)."""
    return np.asarray((one[:, None] - other[None]) ** 2)


def likeness(apart: Array, lengths: Array) -> Array:
    """Give the correlation of shares at conditions by their squared distances, (n, m, c), and lengths, (c,)."""
    return np.asarray(np.exp(-0.5 * (apart @ lengths**-2.0)))


@dataclass(frozen=True, eq=False)
class Kriged:
    """A share that is known at n tests of c conditions, ready to be foretold elsewhere.

    Attributes:
        names: of the conditions.
        tested: their coordinates in the tests, shape (n, c).
        lengths: over which the share stays alike, shape (c,).
        variance: of it, far from all tests.
        inverse: of the tests' covariance, shape (n, n).
        known: that times the shares, shape (n,).
    """

    names: tuple[str, ...]
    tested: Array
    lengths: Array
    variance: float
    inverse: Array
    known: Array

    @classmethod
    def of(cls, local: LocalForm, share: KrigedShare) -> Kriged:
        """Prepare a law's share: that of its stiffness, or of its damping."""
        names, variance = tuple(local.at), share.deviation**2
        tested = np.column_stack([coordinate(name, np.array(local.at[name])) for name in names])
        lengths = np.array([share.lengths[name] for name in names])
        inverse: Array = np.zeros((len(tested),) * 2)
        if variance > 0:  # else the law isn't off in it
            among = variance * likeness(squares(tested, tested), lengths) + np.diag(share.variances)
            inverse = np.asarray(np.linalg.inv(among), dtype=np.float64)
        return cls(names, tested, lengths, variance, inverse, inverse @ np.array(share.shares))

    def at(self, conditions: Mapping[str, float]) -> tuple[float, float]:
        """Give the share by which a law's force is off at conditions, and its standard deviation.

        Args:
            conditions: A (mm), f (Hz), T (K) and so on; one that isn't named is taken as in the middle of the tests.
        """
        place = self._coordinates([conditions])
        shown = self._shared(place, self.tested)[0] @ self.known
        return float(shown), float(np.sqrt(self.left([conditions])[0, 0]))

    def left(self, conditions: Sequence[Mapping[str, float]]) -> Array:
        """Give the covariance of the shares at several conditions that the tests leave, shape (m, m)."""
        places = self._coordinates(conditions)
        with_tests = self._shared(places, self.tested)
        left = self._shared(places, places) - with_tests @ self.inverse @ with_tests.T
        own = np.sqrt(np.maximum(np.diag(left), 0.0))
        return np.asarray(np.clip(left, -np.outer(own, own), np.outer(own, own)))

    def _shared(self, one: Array, other: Array) -> Array:
        """Give the covariance of the shares at conditions, (n, c) and (m, c), before any test; shape (n, m)."""
        return self.variance * likeness(squares(one, other), self.lengths)

    def _coordinates(self, conditions: Sequence[Mapping[str, float]]) -> Array:
        middle = np.median(self.tested, axis=0)
        return np.array(
            [
                [
                    coordinate(name, np.array(one[name])) if name in one else middle[place]
                    for place, name in enumerate(self.names)
                ]
                for one in conditions
            ]
        )
