"""Numbers as people write them."""

from __future__ import annotations


def plain(value: float, digits: int) -> str:
    """Give a number with so many significant digits, without a power of ten where figures do: 1000, not 1e+03."""
    return f"{float(f'{value:.{digits}g}'):g}"


def one_digit(value: float) -> str:
    """Give a standard error."""
    return plain(value, 1)
