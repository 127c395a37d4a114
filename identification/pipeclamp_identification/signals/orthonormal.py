"""An orthonormal basis of what columns span."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array

ROUNDING_SHARE = 1e-8
"""Directions with a smaller share of the largest singular value are rounding."""


def orthonormal(columns: Array, smallest: float = ROUNDING_SHARE) -> Array:
    """Give an orthonormal basis of what columns span.

    Args:
        columns: shape (R, k).
        smallest: share of the largest singular value that a direction must exceed to count.

    Returns:
        shape (R, p), p <= k.
    """
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, singular > smallest * singular.max(initial=0.0)])
