"""Equations in LaTeX, as narrow as a telephone's page: broken at their operators, and long parts named below them.

An equation that fits a line is one. Else what stands in it several times is named, u, and stated below; then sums take
several lines, cases a line or two each; and of what still is too wide parts are named, until all fits.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import sympy as sp
from sympy.codegen.cfunctions import expm1
from sympy.printing.latex import LatexPrinter
from sympy.printing.printer import Printer

from pipeclamp_models.equations import symbols

ROOM = 38.0
"""Signs, each half as wide as the font is high, that a line holds on a page of 420 pixels."""
LONG_DIGITS = 4
"""Digits from which on a power of ten, or its inverse, is written as such."""
SHORTEST_NAMED = 6.0
"""Signs of what is worth a name of its own."""
LETTERS = "uwrb"
"""For parts that are named: the first that no name in the equation begins with, doubled where all do."""
BREAK = r" \\ "
PART = re.compile(r"PART\d+PART")


class TooWideError(Exception):
    """Something that no line holds; `part` is what."""

    def __init__(self, part: sp.Basic) -> None:
        super().__init__(str(part))
        self.part = part


class PlusFirst(Printer):  # type: ignore[misc]
    """Prints sums from a term without a minus on, where there is one: 1 - x."""

    def _as_ordered_terms(self, expression: sp.Expr, order: str | None = None) -> list[sp.Expr]:
        terms = super()._as_ordered_terms(expression, order=order)
        return sorted(terms, key=lambda term: bool(term.could_extract_minus_sign()))


class _Formulas(PlusFirst, LatexPrinter):  # type: ignore[misc]
    """Prints LaTeX, with names of several letters upright."""

    def _print_Symbol(self, expression: sp.Symbol, style: str = "plain") -> str:
        name = str(expression)
        if expression == symbols.y_previous:
            return r"y_\mathrm{prev}"
        if PART.fullmatch(name) or "^" in name:
            return name
        stem, *below = name.split("_")
        if digits := re.fullmatch(r"(.*[A-Za-z])(\d+)", stem):
            stem, below = digits[1], [digits[2], *below]
        marks = ",".join(self._word(one) for one in below)
        return self._word(stem) + (f"_{{{marks}}}" if below else "")

    def _word(self, text: str) -> str:
        """Give letters as they are, words upright, names of Greek letters as the letter."""
        if not text.isalpha():
            return text
        known = str(super()._print_Symbol(sp.Symbol(text)))
        return rf"\mathrm{{{text}}}" if re.fullmatch(r"[A-Za-z]{3,}", known) else known

    def _print_ExpBase(self, expression: sp.Expr, exp: str | None = None) -> str:
        """Write an exponent with fractions in a fraction beside exp: raised, they are too small to be read."""
        argument = str(self._print(expression.args[0]))
        if exp is None and argument.count(r"\frac") > 1:
            return rf"\exp{{\left({argument} \right)}}"
        return str(super()._print_ExpBase(expression, exp=exp))

    def _print_sign(self, expression: sp.Expr, exp: str | None = None) -> str:
        power = "" if exp is None else rf"^{{{exp}}}"
        return rf"\operatorname{{sgn}}{power}{{\left({self._print(expression.args[0])} \right)}}"


def latex(expression: sp.Basic) -> str:
    """Give an expression's LaTeX, in one line."""
    return str(_Formulas().doprint(_readable(expression)))


@dataclass(frozen=True)
class Row:
    """What stands at one place of an equation's left side.

    Attributes:
        name: the part that is stated here; None for the equation itself.
        expression: what it is, with names for parts that are stated further down.
        lines: its LaTeX, a line each.
    """

    name: sp.Symbol | None
    expression: sp.Expr
    lines: tuple[str, ...]


def equation(left: str, expression: sp.Expr) -> str:
    """Give an equation's LaTeX, in as many lines as a narrow page needs.

    Args:
        left: LaTeX of what stands left of the expression, with the sign between the two.
        expression: what stands right of it.
    """
    whole, *parts = rows(expression, ROOM - width(left))
    if not parts and len(whole.lines) == 1:
        return f"{left} {whole.lines[0]}"
    stated = [(left, whole), *((f"{latex(part.name)} =", part) for part in parts)]
    text = BREAK.join(f"{before} & {f'{BREAK}& '.join(row.lines)}" for before, row in stated)
    return rf"\begin{{split}}{text}\end{{split}}"


def rows(expression: sp.Expr, room: float) -> list[Row]:
    """Break an equation into lines, and name what has to be named for that, in the order in which it is read.

    Args:
        expression: the right side.
        room: width of a line, in signs (`width`).
    """
    used = tuple(map(str, expression.free_symbols))
    letters = (letter * times for times in count(1) for letter in LETTERS)
    letter = next(letter for letter in letters if not any(name.startswith(letter) for name in used))
    named: dict[str, sp.Expr] = {}
    found = [_row(None, _readable(expression), room, named)]
    order: list[str] = []
    for row in found:  # which grows by the parts that it names
        for name in PART.findall(" ".join(row.lines)):
            if name not in order:
                order.append(name)
                found.append(_row(_symbol(name), named[name], room, named))
    places = [f"{letter}_{place}" for place in range(1, len(order) + 1)] if len(order) > 1 else [letter]
    names = dict(zip(map(_symbol, order), map(_symbol, places), strict=False))

    def shown(line: str) -> str:
        return PART.sub(lambda name: latex(names[_symbol(name[0])]), line)

    return [
        Row(row.name and names[row.name], row.expression.xreplace(names), tuple(map(shown, row.lines))) for row in found
    ]


def _symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def width(formula: str) -> float:
    """Estimate how wide a line of LaTeX is, in signs that are half as wide as the font is high."""
    tokens = re.findall(r"\\[A-Za-z]+|\\.|PART\d+PART|[^\s]", formula)
    tokens.reverse()
    total = 0.0
    while tokens:
        total += _next(tokens)
    return total


FUNCTIONS = {
    r"\max": 4.0,
    r"\min": 4.0,
    r"\log": 3.0,
    r"\exp": 3.5,
    r"\operatorname": 0.5,
    r"\tanh": 4.5,
    r"\sqrt": 1.5,
}
SPACED = (r"\leftarrow", r"\times", r"\leq", r"\geq", r"\neq", "=", "+", "-", "<", ">")
NOTHING = (r"\left", r"\right", r"\mathrm", r"\text", r"\limits", r"\Bigl", r"\Bigr", "{", "}")
BELOW = 0.7
"""Size of indices and exponents over that of what bears them."""


def _next(tokens: list[str]) -> float:
    """Take the next piece off the end, and give its width."""
    token = tokens.pop()
    if token == "{":
        total = 0.0
        while tokens and tokens[-1] != "}":
            total += _next(tokens)
        tokens.pop()
        return total
    if token in ("^", "_"):
        return BELOW * _next(tokens)
    if token == r"\frac":
        return max(_next(tokens), _next(tokens)) + 0.6
    if PART.fullmatch(token):
        return 1 + BELOW
    if token in NOTHING:
        return 0.0
    if token in SPACED:
        return 2.2
    return FUNCTIONS.get(token, 1.0)


def _readable(expression: sp.Basic) -> sp.Basic:
    """Write exp(x) - 1 as such, and limits that are small powers of ten, or 1 less one, with that power."""
    expression = expression.replace(expm1, lambda argument: sp.exp(argument) - 1)
    return expression.replace(lambda one: one.is_Rational and short(one) is not None, short)


def short(number: sp.Rational) -> sp.Expr | None:
    """Give a number with a power of ten, if it is one, or 1 and a small one more or less."""
    for beside in (0, 1) if number.q > 1 else (0,):
        rest = abs(number - beside)
        digits = str(rest.p * rest.q)
        if 1 in (rest.p, rest.q) and len(digits) >= LONG_DIGITS and digits.strip("0") == "1":
            exponent = (len(digits) - 1) * (1 if rest.q == 1 else -1)
            return beside + sp.sign(number - beside) * sp.Symbol(f"10^{{{exponent}}}", positive=True)
    return None


def _row(name: sp.Symbol | None, expression: sp.Expr, room: float, named: dict[str, sp.Expr]) -> Row:
    """Break an expression into lines; what has to be named for that joins those named."""
    while not _fits(expression, room) and (part := _repeated(expression)) is not None:
        expression = _with_name(expression, part, named)
    while True:
        try:
            return Row(name, expression, tuple(_lines(expression, room)))
        except TooWideError as wide:
            part = _within(wide.part, room)
            if part is None:
                return Row(name, expression, (latex(expression),))
            expression = _with_name(expression, part, named)


def _with_name(expression: sp.Expr, part: sp.Expr, named: dict[str, sp.Expr]) -> sp.Expr:
    """Put a new name in place of a part, also where it stands with the other sign."""
    name = _symbol(f"PART{len(named)}PART")
    named[str(name)] = part
    return expression.xreplace({part: name, -part: -name})


def _fits(expression: sp.Expr, room: float) -> bool:
    """Tell whether an expression stands in one line; cases never do."""
    return not expression.has(sp.Piecewise) and width(latex(expression)) <= room


def _parts(expression: sp.Basic) -> Iterator[sp.Expr]:
    """Give each part of an expression that may bear a name, as often as it stands there."""
    for argument in expression.args:
        yield from _parts(argument)
        is_value = isinstance(argument, sp.Expr) and argument.args and not (-argument).is_Atom
        if is_value and width(latex(argument)) >= SHORTEST_NAMED:
            yield argument


def _repeated(expression: sp.Expr) -> sp.Expr | None:
    """Give the part whose name would spare most of the equation's width; None if no part stands there twice."""
    counts: Counter[sp.Expr] = Counter()
    for part in _parts(expression):
        counts[-part if -part in counts else part] += 1
    spared = {part: (count - 1) * width(latex(part)) for part, count in counts.items() if count > 1}
    return max(spared, key=lambda part: (spared[part], str(part)), default=None)


def _within(wide: sp.Basic, room: float) -> sp.Expr | None:
    """Give what to name of something too wide: cases first, else the widest part that a line holds."""
    parts = list(_parts(wide))
    cases = [part for part in parts if isinstance(part, sp.Piecewise)]
    held = [part for part in parts if _fits(part, room)]
    return max(cases or held or parts, key=lambda part: (width(latex(part)), str(part)), default=None)


def _lines(expression: sp.Expr, room: float) -> list[str]:
    """Break an expression at its operators.

    Raises:
        TooWideError: a part of it can't be broken.
    """
    if _fits(expression, room):
        return [latex(expression)]
    if isinstance(expression, sp.Piecewise):
        return [_cases(expression, room)]
    parts = sp.Mul.make_args(expression)
    sums = [part for part in parts if isinstance(part, sp.Add)]
    if not sums or any(part.has(sp.Piecewise) for part in parts):
        raise TooWideError(expression)
    longest = max(sums, key=lambda part: width(latex(part)))
    before = sp.Mul(*(part for part in parts if part is not longest))
    if before == 1:
        return _sum(longest, room)
    factor = rf"\left({latex(before)}\right)" if isinstance(before, sp.Add) else latex(before)
    if width(factor) + 1 > room:
        raise TooWideError(before)
    lines = _sum(longest, room - 2)
    # brackets that hold a sum over several lines have a size of their own: those that grow end with the line
    lines[-1] += r" \Bigr)"
    first, rest = rf"{factor} \Bigl(", lines
    if width(f"{first} {lines[0]}") <= room:
        first, rest = f"{first} {lines[0]}", lines[1:]
    return [first, *(rf"\quad {line}" for line in rest)]


def _sum(expression: sp.Add, room: float) -> list[str]:
    """Put as many terms into each line as it holds."""
    lines: list[str] = []
    for term in _Formulas()._as_ordered_terms(expression):
        text = latex(term)
        if lines and not text.startswith("-"):
            text = f"+ {text}"
        if width(text) > room:
            raise TooWideError(term)
        if lines and width(f"{lines[-1]} {text}") <= room:
            lines[-1] += f" {text}"
        else:
            lines.append(text)
    return lines


def _cases(expression: sp.Piecewise, room: float) -> str:
    """Write cases, each value beside its condition, or above it where they are wide."""
    values = [value for value, _ in expression.args]
    conditions = [when for _, when in expression.args]
    for value in values:
        if not _fits(value, room - 2):
            raise TooWideError(sp.Tuple(value))
    for when in conditions:
        if width(latex(when)) > room - 6:
            raise TooWideError(when)
    words = [r"\text{otherwise}" if when == sp.true else rf"\text{{for}}\: {latex(when)}" for when in conditions]
    wide = max(width(latex(value)) for value in values) + max(map(width, words)) > room - 3
    between = r" \\ \quad " if wide else " & "
    rows = [f"{latex(value)}{between}{word}" for value, word in zip(values, words, strict=True)]
    return rf"\begin{{cases}} {BREAK.join(rows)} \end{{cases}}"
