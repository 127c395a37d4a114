"""Equations to read: usual signs, cases in words, nothing of a programming language."""

from __future__ import annotations

import re

import pytest

from pipeclamp_models.law.catalogue import find_effect, listed
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.reading.text import effect_statements, equation_lines, symbols_of


def lines(*effects):
    return equation_lines(Structure("power", effects).equations.composed)


def test_a_state_that_slips_is_told_in_words():
    (state,) = [line for line in lines("memory") if line.startswith("z, after a step")]
    assert state == (
        "z, after a step = slip if slip < stick (y - y_previous) + z; -slip if slip < -stick (y - y_previous) - z; "
        "else stick (y - y_previous) + z"
    )


def test_cases_within_a_product_stand_in_brackets():
    (state,) = [line for line in lines("relaxation") if line.startswith("q, after a step")]
    assert "(-tau_m (exp(-h/tau_m) - 1)/h if h > 0; else 1)" in state


@pytest.mark.parametrize("effect", ["gap", "end_stop", "quadratic_damping", "memory:2", "relaxation", "contact_growth"])
def test_nothing_is_written_as_a_program_writes_it(effect):
    text = "\n".join(lines(effect))
    for word in ("**", "*", "Piecewise", "cases", "Abs", "Max", "Min", "sign(", "True", "expm1"):
        assert word not in text
    assert "k1 = k10 (A/A_0)^k1_A" in text


@pytest.mark.parametrize("effect", listed(), ids=lambda effect: effect.id)
def test_an_effect_is_stated_whole(effect):
    """Every symbol of its equations is its own or explained beside them."""
    statements = effect_statements(effect)
    explained = {signal.symbol for signal in symbols_of(effect)}
    own = (*effect.parameters, *effect.coefficients, *effect.states, *effect.stages)
    explained |= {one.symbol for one in own}
    assert set().union(*(one.expression.free_symbols for one in statements)) <= explained
    for one in statements:
        assert not any(word in one.plain + one.latex for word in ("**", "Piecewise", "sign"))
        assert not re.search(r"\d{7}|[{}]", one.plain)


def test_statements_say_what_they_are():
    said = [(one.words, one.plain) for one in effect_statements(find_effect("memory"))]
    assert said[0] == ("force added, N", "z")
    assert said[-1] == ("energy stored, N mm", "z^2/(2 stick)")
    (growth,) = effect_statements(find_effect("contact_growth"))
    assert growth.words == "factor on every stiffness"
    assert growth.latex == r"\text{stiffness} \times \left(\beta \max\left(0, T - T_{c}\right) + 1\right)"
