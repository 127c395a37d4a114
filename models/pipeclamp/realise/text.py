"""Equations as mathematics to read: for reports and the FMU's documentation."""

from __future__ import annotations

import sympy as sp

from pipeclamp.law import Structure, compose


def equation_lines(structure: Structure) -> list[str]:
    """Give the law's equations, a line each: the force, its coefficients, its memory, as plain text."""
    equations = compose(structure)
    lines = [f"F = {_text(equations.force)}"]
    lines += [f"{entry.symbol} = {_text(entry.expression)}" for entry in equations.coefficients]
    lines += [f"{state.symbol}, after a step: {_text(state.update)}" for state in equations.states]
    return lines


def _text(expression: sp.Expr) -> str:
    return str(expression).replace("**", "^").replace("*", " ").replace("Piecewise", "cases")
