"""Interval arithmetic on SymPy's expressions: bounds of a value over a box, rounded outwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import reduce

import sympy as sp

from pipeclamp_fmu.contents.passivity import Interval

EVERYTHING = (-math.inf, math.inf)

RISING: dict[type[sp.Basic], Callable[[float], float]] = {sp.exp: math.exp, sp.tanh: math.tanh, sp.atan: math.atan}
"""Functions that grow with their argument everywhere."""


def bounds(expression: sp.Basic, box: Mapping[sp.Basic, Interval]) -> Interval:
    """Give bounds of an expression where each symbol lies in its interval; everything, where none are known.

    Args:
        expression: of sums, products, powers, choices, abs, sign, min, max, exp, log, tanh, atan, sin and cos.
        box: interval of each symbol.
    """
    if expression.is_Symbol:
        return box.get(expression, EVERYTHING)
    if expression.is_number:
        value = float(expression)
        return value, value
    if expression.func is sp.Piecewise:  # whichever way its choices fall
        choices = [bounds(value, box) for value, _ in expression.args]
        return min(low for low, _ in choices), max(high for _, high in choices)
    parts = [bounds(part, box) for part in expression.args]
    try:
        found = _of(expression, parts)
    except (ArithmeticError, ValueError):
        return EVERYTHING
    if any(math.isnan(end) for end in found):
        return EVERYTHING
    return math.nextafter(found[0], -math.inf), math.nextafter(found[1], math.inf)


def _of(expression: sp.Basic, parts: list[Interval]) -> Interval:
    """Give bounds of a function by those of its arguments."""
    kind = expression.func
    if kind is sp.Add:
        return math.fsum(low for low, _ in parts), math.fsum(high for _, high in parts)
    if kind is sp.Mul:
        return reduce(_product, parts)
    if kind is sp.Pow:
        return _power(*parts, whole=expression.args[1].is_Integer)
    low, high = parts[0]
    if kind is sp.Abs:
        return (0.0 if low <= 0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
    if kind is sp.sign:
        return float((low > 0) - (low < 0)), float((high > 0) - (high < 0))
    if kind is sp.Max:
        return max(low for low, _ in parts), max(high for _, high in parts)
    if kind is sp.Min:
        return min(low for low, _ in parts), min(high for _, high in parts)
    if kind is sp.log:
        return (math.log(low) if low > 0 else -math.inf), math.log(high)
    if kind in RISING:
        return RISING[kind](low), RISING[kind](high)
    if kind in (sp.sin, sp.cos):
        return -1.0, 1.0
    return EVERYTHING


def _product(one: Interval, other: Interval) -> Interval:
    ends = [0.0 if a == 0 or b == 0 else a * b for a in one for b in other]
    return min(ends), max(ends)


def _power(base: Interval, exponent: Interval, *, whole: bool) -> Interval:
    """Give bounds of a power: of an integer exponent over any base, else over one that isn't below 0."""
    low, high = base
    if whole:
        n = round(exponent[0])
        if n < 0:
            if low <= 0 <= high:
                return (0.0, math.inf) if n % 2 == 0 else EVERYTHING
            ends = [low**n, high**n]
            return min(ends), max(ends)
        if n % 2 == 0 and low <= 0 <= high:
            return 0.0, max(low**n, high**n)
        ends = [low**n, high**n]
        return min(ends), max(ends)
    if low < 0:
        return EVERYTHING
    ends = [_positive_power(b, e) for b in base for e in exponent]
    return min(ends), max(ends)


def _positive_power(base: float, exponent: float) -> float:
    if base == 0:
        return 0.0 if exponent > 0 else 1.0 if exponent == 0 else math.inf
    return float(base**exponent)
