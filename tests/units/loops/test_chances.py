"""Chances: those of SciPy's `stats`, to the bit where it computes them so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from pipeclamp_identification.signals import chances

NUMBERS = st.floats(-5.0, 500.0)
FREEDOMS = st.floats(1.0, 400.0)


@given(NUMBERS, FREEDOMS, FREEDOMS)
def test_ratios_and_sums_of_squares(value, freedoms, beside):
    assert chances.of_larger_ratio(value, freedoms, beside) == stats.f.sf(value, freedoms, beside)
    assert chances.of_larger_squares(value, freedoms) == stats.chi2.sf(value, freedoms)


@given(st.floats(1e-12, 1.0 - 1e-9), FREEDOMS)
def test_the_sum_of_squares_of_a_chance(chance, freedoms):
    assert chances.squares_of_chance(chance, freedoms) == stats.chi2.isf(chance, freedoms)


@given(arrays(float, (3, 4), elements=st.floats(1e-9, 1.0)))
def test_several_tests_together(values):
    together = stats.combine_pvalues(values, method="fisher", axis=0).pvalue
    assert chances.of_all(values) == pytest.approx(together, rel=1e-12)


@pytest.mark.parametrize("values", [[1.0, 2.0, 2.0, 5.0, 9.0], [3.0, 1.0, 4.0, 1.0, 5.0], [1.0, 2.0, 3.0, 4.0, 5.0]])
def test_rank_correlations_with_ties(values):
    other = np.array([0.1, 0.7, 0.3, 0.9, 2.0])
    ranks = stats.spearmanr(values, other)
    found = chances.rank_correlation(np.array(values), other)
    assert found == pytest.approx(ranks.statistic, abs=1e-12)
    assert chances.of_rank_correlation(found, 5) == pytest.approx(ranks.pvalue, abs=1e-7)
