"""Chances of what scatter makes: as in SciPy's `stats`, which takes half a second of each command to load."""

from __future__ import annotations

import numpy as np
from scipy import special

from pipeclamp_models.base.arrays import Array


def of_larger_ratio(ratio: Array | float, freedoms: Array | float, beside: Array | float) -> Array:
    """Give the chance of a larger ratio of two mean squares (F distribution).

    Args:
        ratio: of the mean squares; below zero is as zero.
        freedoms, beside: degrees of freedom of the one above and of the one below.
    """
    return np.asarray(special.fdtrc(freedoms, beside, np.maximum(ratio, 0.0)))


def ratio_of_chance(chance: float, freedoms: float, beside: float) -> float:
    """Give the ratio of two mean squares that is exceeded with this chance; arguments as in `of_larger_ratio`."""
    return float(special.fdtri(freedoms, beside, 1.0 - chance))


def of_larger_squares(squares: Array | float, freedoms: Array | float) -> Array:
    """Give the chance of a larger sum of squares of standard normal numbers (chi-squared distribution)."""
    return np.asarray(special.chdtrc(freedoms, np.maximum(squares, 0.0)))


def squares_of_chance(chance: Array | float, freedoms: Array | float) -> Array:
    """Give the sum of squares that is exceeded with this chance."""
    return np.asarray(special.chdtri(freedoms, chance))


def of_all(chances: Array) -> Array:
    """Give the chance of several independent tests together (Fisher 1925), along the first axis."""
    return of_larger_squares(-2 * np.sum(np.log(chances), axis=0), 2 * len(chances))


def rank_correlation(one: Array, other: Array) -> float:
    """Give Spearman's rank correlation of pairs, shape (n,) each; nan where one doesn't vary."""
    from pipeclamp_models.base.tables import pl

    pairs = pl.DataFrame({"one": one, "other": other})
    return float(pairs.select(pl.corr("one", "other", method="spearman")).item())


def of_rank_correlation(correlation: float, count: int) -> float:
    """Give the chance of a larger rank correlation, of either sign, of so many pairs (Student's t, as in `stats`)."""
    freedoms = count - 2
    t = correlation * np.sqrt(freedoms / max((1.0 + correlation) * (1.0 - correlation), np.finfo(float).eps))
    return float(2 * special.stdtr(freedoms, -abs(t)))
