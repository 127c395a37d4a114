"""Numbers as people write them."""

from __future__ import annotations

import math


def rounded_to(value: float, digits: int) -> float:
    """Give a number with so many significant digits."""
    return float(f"{value:.{digits}g}")


def plain(value: float, digits: int) -> str:
    """Give a number with so many significant digits, without a power of ten where figures do: 1000, not 1e+03."""
    return f"{rounded_to(value, digits):g}"


def one_digit(value: float) -> str:
    """Give a standard error."""
    return plain(value, 1)


def with_error(value: float, error: float) -> str:
    """Give a value to the place that its standard error begins at, and that.

    >>> with_error(83.1234, 0.52)
    '83.1 ± 0.5'
    >>> with_error(885.7, 146.3)
    '900 ± 100'
    """
    if not error > 0 or value == 0:
        return f"{plain(value, 3)} ± {one_digit(error)}"
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 1
    return f"{plain(value, max(digits, 1))} ± {one_digit(error)}"


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


def error_goes(before: float, after: float) -> str:
    """Give two errors, shares, in percent: in hundredths, or in as small parts as show where they differ.

    >>> error_goes(0.7069, 0.0110)
    '70.69% -> 1.10%'
    >>> error_goes(0.001043, 0.000982)
    '0.104% -> 0.098%'
    """
    shown = [(f"{before:.{places}%}", f"{after:.{places}%}") for places in range(2, 6)]
    two = next((each for each in shown if each[0] != each[1]), shown[0])
    return " -> ".join(two)
