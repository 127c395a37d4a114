"""Equations as plain scalar Python source, standard library only: what the Python FMU runs."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from pipeclamp import symbols
from pipeclamp.law import Equations, Law, compose


class ScalarPrinter(PythonCodePrinter):  # type: ignore[misc]
    """Print sign as NumPy understands it, zero at zero, and powers so that none is complex."""

    def _print_sign(self, expression: sp.Expr) -> str:
        argument = self._print(expression.args[0])
        return f"((({argument}) > 0) - (({argument}) < 0))"

    def _print_Pow(self, expression: sp.Pow, rational: bool = False) -> str:
        base, exponent = expression.as_base_exp()
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
        whole = part.xreplace(back)
        if symbol not in needed and whole.has(sp.Pow, sp.exp, sp.log):
            back[symbol] = whole
        else:
            kept.append((symbol, whole))
    return kept, [expression.xreplace(back) for expression in reduced]


def _unconditional(expression: sp.Expr) -> set[sp.Symbol]:
    """Give the symbols that an expression needs whichever way its choices fall."""
    choices = expression.atoms(sp.Piecewise)
    return set(expression.xreplace({choice: sp.Dummy() for choice in choices}).free_symbols)


def _number(value: float) -> sp.Expr:
    """Give the number as SymPy sees it without loss; whole numbers stay whole, so that factors of 1 vanish."""
    return sp.Integer(value) if value == int(value) else sp.Float(repr(value), 17)


def _tuple(names: Sequence[str]) -> str:
    return "(" + "".join(f"{name}, " for name in names).rstrip() + ")"


def clamp_equations(law: Law) -> Equations:
    """Give the equations that travel: the law without what belongs to the rig."""
    return compose(law.structure, ("base", "clamp"))


def python_source(law: Law) -> str:
    """Give the law as the text of a module of the standard library alone.

    It defines `STATES` (name and start of each), `CONDITIONS` (names of further slow signals), `coefficients(A, f, T,
    *conditions)` with A in mm, f in Hz, T in K, which gives what depends on slow signals only, and
    `step(k, state, y_previous, y, v, h)`, which gives the force in N, the stored energy in N mm and the new state after
    a straight move from `y_previous` to `y` (mm) in `h` seconds.
    """
    equations = clamp_equations(law)
    numbers = dict(symbols.REFERENCES)
    numbers[symbols.v_r], numbers[symbols.y_r] = law.v_r, law.y_r
    for parameter in equations.parameters:
        numbers[parameter.symbol] = law.values[parameter.name]
    exact = {symbol: _number(value) for symbol, value in numbers.items()}
    conditions = tuple(sorted({str(symbol) for symbol in equations.slow_signals} - {"A", "f", "T"}))
    coefficient_names = [str(entry.symbol) for entry in equations.coefficients]
    state_names = [str(state.symbol) for state in equations.states]
    # Names of the source's own begin with an underscore, which no effect's symbol does.
    after = {state.symbol: sp.Symbol(f"_{state.symbol}", real=True) for state in equations.states}
    new_names = [str(symbol) for symbol in after.values()]
    lines = [
        f"STATES = {tuple((str(state.symbol), state.start) for state in equations.states)!r}",
        f"CONDITIONS = {conditions!r}",
        "",
        "",
        f"def coefficients({', '.join(('A', 'f', 'T', *conditions))}):",
        *(
            f"    {line}"
            for line in _statements(
                coefficient_names, [entry.expression.xreplace(exact) for entry in equations.coefficients]
            )
        ),
        f"    return {_tuple(coefficient_names)}",
        "",
        "",
        "def step(_k, _state, y_previous, y, v, h):",
        f"    {_tuple(coefficient_names)} = _k",
    ]
    if state_names:
        updates = [state.update.xreplace(exact) for state in equations.states]
        lines.append(f"    {_tuple(state_names)} = _state")
        lines += [f"    {line}" for line in _statements(new_names, updates)]
    results = [equations.force.xreplace(exact).xreplace(after), equations.energy.xreplace(exact).xreplace(after)]
    lines += [f"    {line}" for line in _statements(["_force", "_energy"], results)]
    lines += [f"    return _force, _energy, {_tuple(new_names) if new_names else '()'}", ""]
    return "\n".join(lines)
