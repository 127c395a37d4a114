"""Where a law's form is off, and how: shares at tested conditions, and between them what these foretell (kriging).

A share follows the conditions as a Gaussian process does, whose lengths say how far one test tells of another. Near
tests it is known to what scatters there; far from all of them nothing but its whole deviation is.
C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, Eqs. 2.25 and 2.26.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.file import KrigedShare, LocalForm

LOGARITHMIC = frozenset({"A", "f"})
"""Conditions whose logarithm counts."""


def coordinate(name: str, values: Array) -> Array:
    """Give what counts of a condition: the logarithm of A and f, else the condition itself."""
    return np.log(values) if name in LOGARITHMIC else np.asarray(values, dtype=np.float64)


def likeness(one: Array, other: Array, lengths: Array) -> Array:
    """Give the correlation of shares at conditions, (n, c) and (m, c), by lengths, (c,); shape (n, m)."""
    apart = (one[:, None] - other[None]) / lengths
    return np.asarray(np.exp(-0.5 * np.sum(apart**2, axis=2)))


def foretold(local: LocalForm, share: KrigedShare, conditions: Mapping[str, float]) -> tuple[float, float]:
    """Give the share by which a law's force is off at conditions, and its standard deviation.

    Args:
        local: of the law's file; share: that of its stiffness, or of its damping.
        conditions: A (mm), f (Hz), T (K) and so on; one that isn't named is taken as in the middle of the tests.
    """
    if share.deviation == 0.0:
        return 0.0, 0.0
    names = list(local.at)
    tested = np.column_stack([coordinate(name, np.array(local.at[name])) for name in names])
    middle = np.median(tested, axis=0)
    here = np.array(
        [
            coordinate(name, np.array(conditions[name])) if name in conditions else middle[place]
            for place, name in enumerate(names)
        ],
        dtype=np.float64,
    )
    lengths = np.array([share.lengths[name] for name in names])
    variance = share.deviation**2
    among = variance * likeness(tested, tested, lengths) + np.diag(share.variances)
    with_tests = variance * likeness(here[None], tested, lengths)[0]
    known = np.linalg.solve(among, np.column_stack([np.array(share.shares), with_tests]))
    left = variance - float(with_tests @ known[:, 1])
    return float(with_tests @ known[:, 0]), float(np.sqrt(max(left, 0.0)))
