"""Equations on a narrow page: broken at operators, long parts named below, and what they say unchanged."""

from __future__ import annotations

import random

import pytest
import sympy as sp

from pipeclamp_models.equations import symbols
from pipeclamp_models.law.catalogue import find_effect, listed
from pipeclamp_models.realise.reading.text import effect_statements
from pipeclamp_models.realise.reading.typeset import BREAK, ROOM, equation, latex, rows, width

a, b, n, u, z = sp.symbols("a b n u z", real=True)
STATEMENTS = [(effect.id, one) for effect in listed() for one in effect_statements(effect)]
NARROW = ROOM / 2


def whole(expression, room):
    """Put the parts that were named back where they came from."""
    first, *parts = rows(expression, room)
    back, stated = first.expression, {part.name: part.expression for part in parts}
    for _ in parts:
        back = back.xreplace(stated)
    assert not back.free_symbols & stated.keys(), "no part is stated by itself"
    numbers = {one: sp.Integer(10) ** int(str(one)[4:-1]) for one in back.free_symbols if str(one).startswith("10^")}
    return back.xreplace(numbers)


@pytest.mark.parametrize(("effect", "statement"), STATEMENTS, ids=lambda one: getattr(one, "words", one))
def test_parts_put_back_give_the_equation(effect, statement):
    """Also in half a page, where far more of them are named."""
    draw = random.Random(effect)
    for room in (ROOM, NARROW):
        back = whole(statement.expression, room)
        names = sorted(back.free_symbols | statement.expression.free_symbols, key=str)
        for _ in range(2):
            values = {name: draw.choice((-1, 1)) * sp.Rational(10 * draw.randint(1, 20) + 3, 100) for name in names}
            values |= {name: abs(value) for name, value in values.items() if name.is_nonnegative}
            given, got = (
                complex(sp.sympify(one.replace(symbols.F_moved, sp.Max).xreplace(values)).evalf(30))
                for one in (statement.expression, back)
            )
            assert got == pytest.approx(given, rel=1e-9, abs=1e-12, nan_ok=True)


@pytest.mark.parametrize(("effect", "statement"), STATEMENTS, ids=lambda one: getattr(one, "words", one))
def test_no_line_is_wider_than_a_page(effect, statement):
    left = width(statement.left)
    for row in rows(statement.expression, ROOM - left):
        for line in row.lines:
            assert line.count("{") == line.count("}")
            if "cases" not in line:
                assert left + width(line) <= ROOM


def test_what_fits_stays_a_line():
    (state,) = [one for one in effect_statements(find_effect("relaxation")) if one.words.startswith("energy")]
    assert state.latex == r"E = \frac{q^{2}}{2 k_{m}}"


def test_what_stands_twice_is_named_with_either_sign():
    (state,) = [one for one in effect_statements(find_effect("memory")) if one.words == "z after a step"]
    cases = (
        r"\mathrm{slip} & \text{for}\: u > \mathrm{slip}",
        r"- \mathrm{slip} & \text{for}\: u < - \mathrm{slip}",
        r"u & \text{otherwise}",
    )
    whole = rf"\begin{{cases}} {BREAK.join(cases)} \end{{cases}}"
    move = r"\mathrm{stick} \left(y - y_\mathrm{prev}\right) + z"
    assert state.latex == rf"\begin{{split}}z \leftarrow & {whole} \\ u = & {move}\end{{split}}"


def test_fractions_in_a_fraction_are_no_exponent():
    """Raised, they would be a third as large as the rest; one fraction is read there."""
    (state,) = effect_statements(find_effect("relaxation_temperature"))
    assert r"\exp{\left(\frac{u r_{T1}}" in state.latex
    assert latex(sp.exp(-a / (b + 1 / n))) == r"\exp{\left(- \frac{a}{b + \frac{1}{n}} \right)}"
    assert latex(sp.exp(-a / b)) == r"e^{- \frac{a}{b}}"


def test_a_sum_is_broken_between_its_terms():
    terms = [sp.Symbol(f"stiffness_{letter}") * sp.Symbol(f"way_{letter}") for letter in "abcdefg"]
    text = equation("F =", sp.Add(*terms))
    first, *others = text.removeprefix(r"\begin{split}F = & ").removesuffix(r"\end{split}").split(r" \\ & ")
    assert others
    assert not first.startswith("+")
    assert all(line.startswith("+ ") for line in others)


def test_a_letter_that_the_equation_uses_names_nothing():
    part = sp.sqrt(a**2 + b**2 + u**2) + n
    named = [row.name for row in rows(part * sp.Max(part, z) + sp.exp(-part), NARROW)][1:]
    assert named
    assert all(str(name).startswith("w") for name in named)


@pytest.mark.parametrize(
    ("number", "text"),
    [
        (sp.Rational(1, 10**9), "10^{-9}"),
        (1 - sp.Rational(1, 10**12), "1 - 10^{-12}"),
        (1 + sp.Rational(1, 10**6), "10^{-6} + 1"),
        (sp.Integer(10**9), "10^{9}"),
        (sp.Rational(1, 50), r"\frac{1}{50}"),
        (sp.Integer(1001), "1001"),
    ],
)
def test_limits_are_written_with_their_power_of_ten(number, text):
    assert latex(number) == text


def test_names_of_words_are_upright_and_those_of_greek_letters_are_letters():
    assert latex(sp.Symbol("rate_oil_midway")) == r"\mathrm{rate}_{\mathrm{oil},\mathrm{midway}}"
    assert latex(sp.Symbol("mu_p")) == r"\mu_{p}"
    assert latex(sp.Symbol("k1_A")) == "k_{1,A}"


def test_a_sum_begins_without_a_minus_where_it_can():
    assert latex(1 - a * z) == "1 - a z"
    assert latex(-a - z) == "- a - z"


def test_a_power_of_a_sign_stands_on_its_name():
    assert latex(sp.sign(a) ** 2) == r"\operatorname{sgn}^{2}{\left(a \right)}"
