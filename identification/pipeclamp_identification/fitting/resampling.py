"""Conditions drawn again with replacement: in what share of the draws something holds."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array

DRAWS = 2000


def draws(count: int) -> Array:
    """Give how often each of so many is drawn when as many are drawn at random, (DRAWS, count)."""
    return np.random.default_rng(0).multinomial(count, np.full(count, 1 / count), size=DRAWS).astype(np.float64)


def share_of_gains(gain: Array, least: float = 0.0) -> float:
    """Give the share of draws in which the sum of gains, one of each group, shape (G,), is above the least that counts.

    Groups differ in size by orders of magnitude, so that a sum's standard error says little; its draws do.
    """
    return float(np.mean(draws(len(gain)) @ gain > least))
