"""What is known of each cycle as a whole, carried over to every sample: straight lines from middle to middle."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray

Values = TypeVar("Values", Array, ComplexArray)


def between_cycles(values: Values, elapsed: Array) -> Values:
    """Give values of cycles at samples; before the first middle and after the last the line goes on.

    Args:
        values: of two cycles or more, shape (cycles, ...); a cycle's is that at its middle.
        elapsed: cycles since the first sample, (N,).

    Returns:
        shape (N, ...).
    """
    place = elapsed - 0.5
    left = np.clip(np.floor(place).astype(np.intp), 0, len(values) - 2)
    share = (place - left).reshape(-1, *[1] * (values.ndim - 1))
    return (1 - share) * values[left] + share * values[left + 1]
