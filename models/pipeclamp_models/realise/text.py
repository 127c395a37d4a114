"""Equations as mathematics to read: for reports and the FMU's documentation."""

from __future__ import annotations

import re
from dataclasses import dataclass

import sympy as sp
from sympy.codegen.cfunctions import expm1
from sympy.printing.str import StrPrinter

from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.compose import Composed


def equation_lines(equations: Composed) -> list[str]:
    """Give a law's equations, a line each: the force, its coefficients, its memory after a step, as plain text."""
    lines = [f"F = {_text(equations.force)}"]
    lines += [f"{entry.symbol} = {_text(entry.expression)}" for entry in equations.coefficients]
    lines += [f"{stage.symbol}, within a step = {_text(stage.expression)}" for stage in equations.stages]
    lines += [f"{state.symbol}, after a step = {_text(state.update)}" for state in equations.states]
    return lines


WIDEST = 120
"""Signs of an equation's plain text from which on it takes several lines."""
BREAK = r" \\ & "
SMALL = 1000
"""Whole numbers from which on their inverse is written as a power of ten, where it is one."""


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
        """The whole equation in LaTeX, a term of the sum a line where it is too wide for one."""
        if len(self.plain) > WIDEST and (lines := _terms(self.expression)):
            return rf"\begin{{split}}{self.left} & {BREAK.join(lines)}\end{{split}}"
        right = _latex(self.expression)
        is_sum = isinstance(self.expression, sp.Add) and self.left.endswith(r"\times")
        return rf"{self.left} \left({right}\right)" if is_sum else f"{self.left} {right}"


def _terms(expression: sp.Expr) -> list[str]:
    """Part a sum, or a product with one, into LaTeX of its terms; nothing without one, or where one term is wide.

    Brackets that hold a sum over several lines have a size of their own: those that grow end with the line.
    """
    parts = sp.Mul.make_args(expression)
    sums = [part for part in parts if isinstance(part, sp.Add)]
    if not sums:
        return []
    longest = max(sums, key=lambda part: len(_text(part)))
    *_, second, _ = sorted(len(_text(term)) for term in longest.args)
    if second < WIDEST / 4:
        return []
    before = sp.Mul(*(part for part in parts if part is not longest))
    terms = [_latex(term) for term in longest.as_ordered_terms()]
    terms[1:] = [term if term.startswith("-") else f"+ {term}" for term in terms[1:]]
    if before == 1:
        return terms
    terms[-1] += r" \Bigr)"
    factor = rf"\left({_latex(before)}\right)" if isinstance(before, sp.Add) else _latex(before)
    return [rf"{factor} \Bigl(", *terms]


def effect_statements(effect: Effect) -> list[Statement]:
    """Give an effect's equations, in the order in which they are read."""
    found = []
    if effect.force != 0:
        found.append(Statement("force added, N", r"\Delta F =", effect.force))
    for coefficient in effect.coefficients:
        words = str(coefficient.symbol) + (f", {coefficient.unit}" if coefficient.unit != "-" else "")
        found.append(Statement(words, f"{_latex(coefficient.symbol)} =", coefficient.expression))
    for target, factor in effect.scales.items():
        found.append(Statement(f"factor on every {target}", rf"\text{{{target}}} \times", factor))
    for signal, path in effect.replaces.items():
        found.append(Statement(f"in place of {signal}", f"{_latex(signal)} =", path))
    if symbols.y in effect.replaces:
        found.append(Statement("force that comes through, N", "F =", effect.passes))
    found += [
        Statement(f"{stage.symbol}, {stage.meaning}", f"{_latex(stage.symbol)} =", stage.expression)
        for stage in effect.stages
    ]
    found += [
        Statement(f"{state.symbol} after a step", f"{_latex(state.symbol)} \\leftarrow", state.update)
        for state in effect.states
    ]
    if effect.lag != 0:
        late = r"F_\mathrm{measured}(t) = F(t - \tau),\quad \tau ="
        found.append(Statement("force measured late by, s", late, effect.lag))
    if effect.energy != 0:
        found.append(Statement("energy stored, N mm", "E =", effect.energy.replace(_is_compliance, _stiff)))
    return found


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


def _is_small_power(expression: sp.Expr) -> bool:
    """Tell whether a number is 1/1000 or a smaller power of ten."""
    is_inverse = isinstance(expression, sp.Rational) and expression.p == 1 and expression.q >= SMALL
    return is_inverse and str(expression.q).strip("0") == "1"


def _latex(expression: sp.Expr) -> str:
    expression = expression.replace(expm1, lambda argument: sp.exp(argument) - 1)
    expression = expression.replace(_is_small_power, lambda one: sp.Symbol(f"10^{{-{len(str(one.q)) - 1}}}"))
    names = {symbols.y_previous: r"y_\mathrm{prev}"}
    for symbol in expression.free_symbols:
        word = re.fullmatch(r"([a-z]{3,})(\d*)", str(symbol))
        if word and str(sp.latex(symbol)).startswith(word[1]):  # a word, not the name of a Greek letter
            names[symbol] = rf"\mathrm{{{word[1]}}}" + (f"_{{{word[2]}}}" if word[2] else "")
    return str(sp.latex(expression, symbol_names=names)).replace(r"\operatorname{sign}", r"\operatorname{sgn}")


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
