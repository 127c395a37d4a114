"""Equations to read: usual signs, cases in words, nothing of a programming language."""

from __future__ import annotations

import pytest

from pipeclamp.law import Structure, compose
from pipeclamp.realise.text import equation_lines


def lines(*effects):
    return equation_lines(compose(Structure("power", effects)))


def test_a_state_that_slips_is_told_in_words():
    (state,) = [line for line in lines("memory") if line.startswith("z, after a step")]
    assert state == (
        "z, after a step = slip if slip < k_s (y - y_previous) + z; -slip if slip < -k_s (y - y_previous) - z; "
        "else k_s (y - y_previous) + z"
    )


def test_cases_within_a_product_stand_in_brackets():
    (state,) = [line for line in lines("relaxation") if line.startswith("q, after a step")]
    assert "(tau (1 - exp(-h/tau))/h if h > 0; else 1)" in state


@pytest.mark.parametrize("effect", ["gap", "end_stop", "quadratic_damping", "memory:2", "relaxation", "contact_growth"])
def test_nothing_is_written_as_a_program_writes_it(effect):
    text = "\n".join(lines(effect))
    for word in ("**", "*", "Piecewise", "cases", "Abs", "Max", "Min", "sign(", "True"):
        assert word not in text
    assert "k1 = k10 (A/A_0)^k1_A" in text
