"""Least squares in lock step: each problem ends where SciPy's solution of it alone does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from pipeclamp_identification.attribution.lockstep import Evaluated, LeastSquares, fit_together

T = np.linspace(0.0, 2.0, 30)


def decay(values):
    size, rate = values
    return size * np.exp(-rate * T)


def slopes(values):
    size, rate = values
    wave = np.exp(-rate * T)
    return np.column_stack([wave, -size * T * wave])


def fitted(truths, begins, lower=(0.0, 0.0), upper=(10.0, 10.0), most=50):
    """Fit decays in lock step; count how often all of them were asked for at once."""
    measured = [decay(truth) for truth in truths]
    calls = []

    def evaluate(asked):
        calls.append(len(asked))
        return [
            None if values[1] > 9.0 else Evaluated(values, None, decay(values) - measured[index], slopes(values))
            for index, values, _ in asked
        ]

    bounds = np.array(lower), np.array(upper)
    problems = [LeastSquares(np.array(begin), *bounds, np.array([0.5, 0.5]), None, most) for begin in begins]
    return fit_together(problems, evaluate, 1e-9), calls


def test_each_problem_is_solved_and_they_are_asked_together():
    truths = [(2.0, 1.0), (0.5, 3.0), (4.0, 0.2)]
    found, calls = fitted(truths, [(1.0, 0.5)] * 3)
    for one, truth in zip(found, truths, strict=True):
        assert one.values == pytest.approx(truth, rel=1e-3)
    assert calls[0] == 3
    assert len(calls) < 30


def test_bounds_hold_as_in_scipy():
    found, _ = fitted([(2.0, 3.0)], [(1.0, 0.5)], upper=(10.0, 1.0))
    alone = least_squares(lambda values: decay(values) - decay((2.0, 3.0)), [1.0, 0.5], bounds=([0, 0], [10, 1]))
    assert found[0].values == pytest.approx(alone.x, rel=1e-3)


def test_a_problem_without_a_value_is_none_and_few_evaluations_are_enough_to_stop():
    found, _ = fitted([(2.0, 1.0), (2.0, 1.0)], [(1.0, 9.5), (1.0, 0.5)])
    assert found[0] is None
    assert found[1] is not None
    _, calls = fitted([(2.0, 1.0)], [(1.0, 0.5)], most=1)
    assert calls == [1]
