"""Equations as plain scalar Python source, standard library only: what the Python FMU runs."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from pipeclamp_models.equations.replacing import replaced
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.bounded import bounded
from pipeclamp_models.realise.stepping import CONDITIONS_FIRST, conditions_of, parameter_symbols, stepping

PRODUCTS = range(2, 5)
"""Powers that are written as products, which Python computes faster."""


class ScalarPrinter(PythonCodePrinter):  # type: ignore[misc]
    """Print sign as NumPy understands it, zero at zero, and powers so that none is complex."""

    def _print_sign(self, expression: sp.Expr) -> str:
        argument = self._print(expression.args[0])
        return f"((({argument}) > 0) - (({argument}) < 0))"

    def _print_Pow(self, expression: sp.Pow, rational: bool = False) -> str:
        base, exponent = expression.as_base_exp()
        if base.is_Symbol and exponent in PRODUCTS:
            return f"({'*'.join([self._print(base)] * int(exponent))})"
        if exponent.is_integer or abs(exponent) == sp.Rational(1, 2) or base.is_nonnegative:
            return str(super()._print_Pow(expression, rational))
        return f"math.pow({self._print(base)}, {self._print(exponent)})"


def _statements(targets: Sequence[str], expressions: Sequence[sp.Expr]) -> list[str]:
    """Give assignments of the expressions to the targets, common parts computed once."""
    printer = ScalarPrinter({"fully_qualified_modules": True})
    parts, reduced = _guarded(*sp.cse(list(expressions), symbols=sp.numbered_symbols("_")))
    lines = [f"{symbol} = {printer.doprint(expression)}" for symbol, expression in parts]
    lines += [f"{target} = {printer.doprint(part)}" for target, part in zip(targets, reduced, strict=True)]
    return lines


Parts = Sequence[tuple[sp.Symbol, sp.Expr]]


def _guarded(parts: Parts, reduced: Sequence[sp.Expr]) -> tuple[Parts, Sequence[sp.Expr]]:
    """Put back into its branches what only they need and what may have no value elsewhere.

    A choice such as "log y where y > 0, else 0" guards the logarithm, which would raise if it were computed before.
    """
    needed = set().union(*(_unconditional(expression) for expression in reduced))
    for symbol, part in reversed(parts):
        if symbol in needed:
            needed |= _unconditional(part)
    kept: list[tuple[sp.Symbol, sp.Expr]] = []
    back: dict[sp.Symbol, sp.Expr] = {}
    for symbol, part in parts:
        whole = replaced(part, back)
        if symbol not in needed and whole.has(sp.Pow, sp.exp, sp.log):
            back[symbol] = whole
        else:
            kept.append((symbol, whole))
    return kept, [replaced(expression, back) for expression in reduced]


def _unconditional(expression: sp.Expr) -> set[sp.Symbol]:
    """Give the symbols that an expression needs whichever way its choices fall."""
    choices = expression.atoms(sp.Piecewise)
    return set(expression.xreplace({choice: sp.Dummy() for choice in choices}).free_symbols)


def _tuple(names: Sequence[str]) -> str:
    return "(" + "".join(f"{name}, " for name in names).rstrip() + ")"


@bounded()
def python_source(structure: Structure) -> str:
    """Give a law's structure as the text of a module of the standard library alone; no value of a law is in it.

    It defines `STATES` (name and start of each), `CONDITIONS` (names of further slow signals), `coefficients(p, A, f,
    T, *conditions)` with the law's parameters p (`parameter_symbols`), A in mm, f in Hz, T in K, which gives what holds
    through a step, and `step(k, state, y_previous, y, v, h)`, which gives the force in N, the stored energy in N mm and
    the new state after a straight move from `y_previous` to `y` (mm) in `h` seconds.
    """
    law = stepping(structure)
    states = law.equations.states
    parameters = [str(symbol) for symbol in parameter_symbols(law.equations)]
    names = [str(symbol) for symbol, _ in law.held]
    held = [(str(symbol), expression) for symbol, expression in law.held if symbol != expression]
    state_names, new_names = [str(state.symbol) for state in states], [str(symbol) for symbol in law.after]
    slow_body = [
        *_statements([str(symbol) for symbol, _ in law.coefficients], [value for _, value in law.coefficients]),
        *_statements([name for name, _ in held], [value for _, value in held]),
    ]
    lines = [
        f"STATES = {tuple((str(state.symbol), state.start) for state in states)!r}",
        f"CONDITIONS = {conditions_of(law.equations)[len(CONDITIONS_FIRST) :]!r}",
        "",
        "",
        f"def coefficients(_p, {', '.join(conditions_of(law.equations))}):",
        f"    {_tuple(parameters)} = _p",
        *(f"    {line}" for line in slow_body),
        f"    return {_tuple(names)}",
        "",
        "",
        "def step(_k, _state, y_previous, y, v, h):",
        f"    {_tuple(names)} = _k",
    ]
    if state_names:
        lines.append(f"    {_tuple(state_names)} = _state")
        for symbol, expression in law.stages:
            lines += [f"    {line}" for line in _statements([str(symbol)], [expression])]
        lines += [f"    {line}" for line in _statements(new_names, law.updates)]
    lines += [f"    {line}" for line in _statements(["_force", "_energy"], [law.force, law.energy])]
    lines += [f"    return _force, _energy, {_tuple(new_names) if new_names else '()'}", ""]
    return "\n".join(lines)
