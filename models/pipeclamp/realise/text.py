"""Equations as mathematics to read: for reports and the FMU's documentation."""

from __future__ import annotations

import sympy as sp
from sympy.printing.str import StrPrinter

from pipeclamp.law import Equations


def equation_lines(equations: Equations) -> list[str]:
    """Give a law's equations, a line each: the force, its coefficients, its memory after a step, as plain text."""
    lines = [f"F = {_text(equations.force)}"]
    lines += [f"{entry.symbol} = {_text(entry.expression)}" for entry in equations.coefficients]
    lines += [f"{state.symbol}, after a step = {_text(state.update)}" for state in equations.states]
    return lines


def _text(expression: sp.Expr) -> str:
    text = str(_Words().doprint(expression)).replace("**", "^").replace("*", " ")
    # brackets around the words hold them together within a product; alone they hold nothing
    whole = isinstance(expression, sp.Piecewise)
    return text[1:-1] if whole else text


class _Words(StrPrinter):  # type: ignore[misc]
    """Prints cases in words, "(this if that; else the other)", and functions by their usual signs."""

    def _print_Piecewise(self, expression: sp.Piecewise) -> str:
        cases = [
            f"else {self._print(value)}" if when == sp.true else f"{self._print(value)} if {self._print(when)}"
            for value, when in expression.args
        ]
        return f"({'; '.join(cases)})"

    def _print_Abs(self, expression: sp.Abs) -> str:
        return f"|{self._print(expression.args[0])}|"

    def _print_Max(self, expression: sp.Max) -> str:
        return f"max({self.stringify(expression.args, ', ')})"

    def _print_Min(self, expression: sp.Min) -> str:
        return f"min({self.stringify(expression.args, ', ')})"

    def _print_sign(self, expression: sp.sign) -> str:
        return f"sgn({self._print(expression.args[0])})"
