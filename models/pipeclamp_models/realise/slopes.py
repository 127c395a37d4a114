"""Derivatives of expressions that are in stages: each stage's is a definition of its own, so that none grows large."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from pipeclamp_models.realise.stepping import Definition

StageSlopes = Mapping[tuple[sp.Symbol, sp.Symbol], sp.Symbol]
"""What stands for the derivative of a stage by a symbol, where it doesn't vanish."""


class _Magnitude(sp.Function):  # type: ignore[misc]
    """|x| of an x that SymPy can't see to be real (a division in it is enough); its slope is the sign of x.

    SymPy's own is x sign(x)/|x| there: 0/0 at x = 0.
    """

    is_real = True
    is_nonnegative = True

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        return sp.sign(self.args[0])


def _of_unseen(one: sp.Expr) -> bool:
    return isinstance(one, sp.Abs) and not one.args[0].is_extended_real


def slope_of(expression: sp.Expr, by: sp.Symbol, through: StageSlopes) -> sp.Expr | None:
    """Give a derivative, that by the way of stages included; None where the expression doesn't depend on the symbol.

    A jump has no slope but on a point, where none is needed: at a step the slope is that of its sides.
    """
    used = expression.free_symbols
    expression = expression.replace(_of_unseen, lambda one: _Magnitude(one.args[0]))
    inner = [(stage, slope) for (stage, symbol), slope in through.items() if symbol == by and stage in used]
    if by not in used and not inner:
        return None
    total = sp.diff(expression, by) + sum(sp.diff(expression, stage) * slope for stage, slope in inner)
    return total.replace(sp.DiracDelta, lambda *_: sp.Integer(0)).replace(_Magnitude, sp.Abs)


def slopes_through(stages: Sequence[Definition], by: Sequence[sp.Symbol]) -> tuple[list[Definition], StageSlopes]:
    """Give stages followed each by its derivatives, and what these derivatives are called."""
    definitions: list[Definition] = []
    slopes: dict[tuple[sp.Symbol, sp.Symbol], sp.Symbol] = {}
    for symbol, expression in stages:
        definitions.append((symbol, expression))
        for one in by:
            slope = slope_of(expression, one, slopes)
            if slope is not None and slope != 0:
                slopes[symbol, one] = sp.Symbol(f"{symbol}_by_{one}_", real=True)
                definitions.append((slopes[symbol, one], slope))
    return definitions, slopes


def needed(definitions: Sequence[Definition], expressions: Sequence[sp.Expr]) -> list[Definition]:
    """Give those definitions, in their order, that expressions need, each the others that it needs itself."""
    wanted: set[sp.Symbol] = set().union(*(expression.free_symbols for expression in expressions))
    kept: list[Definition] = []
    for symbol, expression in reversed(definitions):
        if symbol in wanted:
            wanted |= expression.free_symbols
            kept.append((symbol, expression))
    return kept[::-1]


def in_order(before: Sequence[Definition], expressions: Sequence[sp.Expr]) -> tuple[list[Definition], list[sp.Expr]]:
    """Give definitions in their order, then those of parts common to some expressions, and the expressions in these.

    Common parts of the definitions are set apart too, each where it is first known.
    """
    # One search for common parts over all; a part is defined before the first that uses it, when all in it are known.
    parts, reduced = sp.cse([*(expression for _, expression in before), *expressions], list=False)
    found: list[Definition] = []
    for (symbol, _), expression in zip(before, reduced, strict=False):
        ready = needed(parts, [expression])
        found += [*ready, (symbol, expression)]
        parts = [entry for entry in parts if entry not in ready]
    return [*found, *parts], list(reduced[len(before) :])
