"""Numbers as people write them."""

from __future__ import annotations


def one_digit(value: float) -> str:
    """Give a standard error with one significant digit, without a power of ten where figures do: 200, not 2e+02."""
    return f"{float(f'{value:.1g}'):g}"
