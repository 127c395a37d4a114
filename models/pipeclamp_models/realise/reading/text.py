"""Equations as mathematics to read: for reports and the FMU's documentation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp
from sympy.printing.str import StrPrinter

from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Coefficient, Effect, Stage, State
from pipeclamp_models.law.compose import Composed
from pipeclamp_models.realise.reading.typeset import PlusFirst, equation, latex, short

WITHOUT_BRACES = str.maketrans("", "", "{}")
"""What LaTeX holds an exponent together by."""


def equation_lines(equations: Composed) -> list[str]:
    """Give a law's equations, a line each: the force, its coefficients, its memory after a step, as plain text."""
    lines = [f"F = {_text(equations.force)}"]
    lines += [f"{entry.symbol} = {_text(entry.expression)}" for entry in equations.coefficients]
    lines += [f"{stage.symbol}, within a step = {_text(stage.expression)}" for stage in equations.stages]
    lines += [f"{state.symbol}, after a step = {_text(state.update)}" for state in equations.states]
    return lines


@dataclass(frozen=True)
class Statement:
    """One thing that an effect does.

    Attributes:
        words: what the expression is, in words.
        left: LaTeX of what stands left of the expression.
        expression: the mathematics.
    """

    words: str
    left: str
    expression: sp.Expr

    @property
    def plain(self) -> str:
        """The expression as plain text."""
        return _text(self.expression)

    @property
    def latex(self) -> str:
        """The whole equation in LaTeX, in lines that a narrow page holds."""
        if isinstance(self.expression, sp.Add) and self.left.endswith(r"\times"):
            return rf"{self.left} \left({latex(self.expression)}\right)"
        return equation(self.left, self.expression)

    @property
    def mathml(self) -> str:
        """The same as MathML, for pages."""
        from pipeclamp_models.realise.reading.mathml import mathml

        return mathml(self.latex, "block")


def law_statements(equations: Composed) -> list[Statement]:
    """Give a law's equations, in the order in which they are read: the force, its coefficients, its memory."""
    force = Statement("force, N", "F =", equations.force)
    return [force, *_coefficients(equations.coefficients), *_within_steps(equations.stages, equations.states)]


def effect_statements(effect: Effect) -> list[Statement]:
    """Give an effect's equations, in the order in which they are read."""
    found = []
    if effect.force != 0:
        found.append(Statement("force added, N", r"\Delta F =", effect.force))
    found += _coefficients(effect.coefficients)
    for target, factor in effect.scales.items():
        found.append(Statement(f"factor on every {target}", rf"\text{{{target}}} \times", factor))
    for signal, path in effect.replaces.items():
        found.append(Statement(f"in place of {signal}", f"{latex(signal)} \\leftarrow", path))
    if symbols.y in effect.replaces:
        found.append(Statement("force that comes through, N", "F =", effect.passes))
    found += _within_steps(effect.stages, effect.states)
    if effect.lag != 0:
        late = r"F_\mathrm{measured}(t) = F(t - \tau),\quad \tau ="
        found.append(Statement("force measured late by, s", late, effect.lag))
    if effect.energy != 0:
        found.append(Statement("energy stored, N mm", "E =", effect.energy.replace(_is_compliance, _stiff)))
    return found


def _coefficients(coefficients: Sequence[Coefficient]) -> list[Statement]:
    return [Statement(_with_unit(one), f"{latex(one.symbol)} =", one.expression) for one in coefficients]


def _with_unit(coefficient: Coefficient) -> str:
    unit = "" if coefficient.unit == "-" else f", {unit_shown(coefficient.unit)}"
    return f"{coefficient.symbol}{unit}"


def _within_steps(stages: Sequence[Stage], states: Sequence[State]) -> list[Statement]:
    return [
        *(Statement(f"{one.symbol}, {one.meaning}", f"{latex(one.symbol)} =", one.expression) for one in stages),
        *(Statement(f"{one.symbol} after a step", f"{latex(one.symbol)} \\leftarrow", one.update) for one in states),
    ]


def symbols_of(effect: Effect) -> list[symbols.Signal]:
    """Give what an effect's equations use besides its own parameters, coefficients and states."""
    used: set[sp.Symbol] = set().union(*(one.expression.free_symbols for one in effect_statements(effect)))
    used |= {
        sp.Symbol(str(symbols.F_moved), real=True)
        for one in effect_statements(effect)
        if one.expression.has(symbols.F_moved)
    }
    known = (*symbols.FAST, *symbols.SLOW, *symbols.SERIES, *symbols.FIXED)
    found = [signal for signal in known if signal.symbol in used]
    columns = sorted(str(symbol) for symbol in used if str(symbol).startswith(CONDITION))
    return found + [
        symbols.Signal(sp.Symbol(name, real=True), "its own", "further column of runs.csv") for name in columns
    ]


def _is_compliance(expression: sp.Expr) -> bool:
    """Tell whether an expression is 1/k where there is a stiffness, and else 0 (`symbols.compliance`)."""
    if not isinstance(expression, sp.Piecewise):
        return False
    stiffness = 1 / expression.args[0][0]
    return bool(expression == symbols.compliance(stiffness))


def _stiff(compliance: sp.Expr) -> sp.Expr:
    """Give 1/k, as it is read: without a spring there is no energy."""
    return compliance.args[0][0]


def _text(expression: sp.Expr) -> str:
    text = str(_Words().doprint(expression)).replace("**", "^").replace("*", " ")
    # brackets around the words hold them together within a product; alone they hold nothing
    whole = isinstance(expression, sp.Piecewise)
    return text[1:-1] if whole else text


class _Words(PlusFirst, StrPrinter):  # type: ignore[misc]
    """Prints cases in words, "(this if that; else the other)", and functions by their usual signs."""

    def _print_Piecewise(self, expression: sp.Piecewise) -> str:
        cases = [
            f"else {self._print(value)}" if when == sp.true else f"{self._print(value)} if {self._print(when)}"
            for value, when in expression.args
        ]
        return f"({'; '.join(cases)})"

    def _print_Rational(self, expression: sp.Rational) -> str:
        power = short(expression)
        return str(super()._print_Rational(expression) if power is None else power).translate(WITHOUT_BRACES)

    _print_Integer = _print_Rational

    def _print_Abs(self, expression: sp.Abs) -> str:
        return f"|{self._print(expression.args[0])}|"

    def _print_expm1(self, expression: sp.Expr) -> str:
        return f"(exp({self._print(expression.args[0])}) - 1)"

    def _print_Equality(self, expression: sp.Eq) -> str:
        return f"{self._print(expression.lhs)} is {self._print(expression.rhs)}"

    def _print_Max(self, expression: sp.Max) -> str:
        return f"max({self.stringify(expression.args, ', ')})"

    def _print_Min(self, expression: sp.Min) -> str:
        return f"min({self.stringify(expression.args, ', ')})"

    def _print_sign(self, expression: sp.sign) -> str:
        return f"sgn({self._print(expression.args[0])})"
