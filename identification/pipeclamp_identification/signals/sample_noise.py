"""Scatter told by medians, which few values far off don't move; and so the noise of single samples."""

from __future__ import annotations

import math

import numpy as np

from pipeclamp_models.base.arrays import Array

OF_NORMAL = 0.6745
"""Median of the absolute value of a normal deviate."""
OF_DIFFERENCES = 70.0
"""Sum of the squared weights of a fourth difference: 1, -4, 6, -4, 1."""


def scatter_by_median(deviations: Array) -> float:
    """Give the standard deviation of normal scatter about zero by the median of its sizes.

    Args:
        deviations: of any shape.
    """
    return float(np.median(np.abs(deviations))) / OF_NORMAL


def sample_noise(values: Array) -> float:
    """Give the rms of white noise by fourth differences, in which a smooth motion leaves next to nothing.

    Args:
        values: evenly sampled, shape (n,), n at least 5.
    """
    return scatter_by_median(np.diff(values, 4)) / math.sqrt(OF_DIFFERENCES)
