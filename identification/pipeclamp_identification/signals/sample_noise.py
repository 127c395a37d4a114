"""The noise of single samples, told without knowing the motion that they follow."""

from __future__ import annotations

import math

import numpy as np

from pipeclamp_models.base.arrays import Array

OF_NORMAL = 0.6745
"""Median of the absolute value of a normal deviate."""
OF_DIFFERENCES = 70.0
"""Sum of the squared weights of a fourth difference: 1, -4, 6, -4, 1."""


def sample_noise(values: Array) -> float:
    """Give the rms of white noise by fourth differences, in which a smooth motion leaves next to nothing.

    Args:
        values: evenly sampled, shape (n,), n at least 5.
    """
    return float(np.median(np.abs(np.diff(values, 4)))) / OF_NORMAL / math.sqrt(OF_DIFFERENCES)
