"""Numbers as people write them."""

from __future__ import annotations


def rounded_to(value: float, digits: int) -> float:
    """Give a number with so many significant digits."""
    return float(f"{value:.{digits}g}")


def plain(value: float, digits: int) -> str:
    """Give a number with so many significant digits, without a power of ten where figures do: 1000, not 1e+03."""
    return f"{rounded_to(value, digits):g}"


def one_digit(value: float) -> str:
    """Give a standard error."""
    return plain(value, 1)


def newtons(force: float) -> str:
    """Give a force of a sentence: three digits, and its unit.

    >>> newtons(2861.4)
    '2860 N'
    """
    return f"{plain(force, 3)} N"


def told_apart(*shares: float) -> tuple[str, ...]:
    """Give shares in percent, in tenths or hundredths only where they would look alike without.

    >>> told_apart(0.9652, 0.9746)
    ('96.5%', '97.5%')
    >>> told_apart(0.2, 0.91)
    ('20%', '91%')
    """
    shown = [tuple(f"{share:.{places}%}" for share in shares) for places in range(3)]
    return next((each for each in shown if len(set(each)) == len(shares)), shown[0])
