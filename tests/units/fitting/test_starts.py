"""Where fits start: all combinations of few starts, of many the most promising ones, and as large as the data ask."""

import numpy as np
import pytest

from pipeclamp_identification.fitting.joint.starts import (
    MOST_STARTS,
    Linearised,
    SizedEffect,
    combined,
    most_promising,
    sized,
)

CHOICES = [[{name: float(value)} for value in range(count)] for name, count in (("a", 4), ("b", 1), ("c", 5), ("d", 3))]
BEST = {"a": 2.0, "b": 0.0, "c": 3.0, "d": 1.0}


def cost(start):
    return sum((start[name] - value) ** 2 for name, value in BEST.items()) + 0.3 * abs(start["a"] * start["c"] - 6.0)


def test_what_a_step_leaves_of_residuals_that_are_far_off_is_no_rounding():
    """A start off by 1e17 times the noise had promised more than there was, and hid what fits: below zero was left."""
    random = np.random.default_rng(2)
    jacobian, unexplained = random.standard_normal((600, 8)), random.standard_normal(600)
    unexplained -= jacobian @ np.linalg.lstsq(jacobian, unexplained, rcond=None)[0]
    far = Linearised(tuple("abcdefgh"), jacobian @ np.full(8, 3e7) + unexplained, jacobian)
    assert far.cost_after_one_step() == pytest.approx(unexplained @ unexplained / 2, rel=1e-6)


def test_few_starts_are_all_combined_without_a_look_at_them():
    found = most_promising(CHOICES[:2], cost=None)
    assert found == combined(CHOICES[:2]) == [{"a": float(value), "b": 0.0} for value in range(4)]


def test_of_many_the_most_promising_are_taken_by_a_few_evaluations():
    asked = []
    found = most_promising(CHOICES, lambda start: asked.append(start) or cost(start))
    assert len(asked) == 4 + 5 + 3
    assert len(found) == MOST_STARTS
    assert found[0] == min(combined(CHOICES), key=cost) == BEST
    assert len({tuple(start.values()) for start in found}) == MOST_STARTS


@pytest.mark.parametrize("seed", range(5))
def test_the_best_of_many_is_near_the_best_of_all(seed):
    """Costs that add up, and what couples them a little: what one effect starts from hardly asks for the others."""
    random = np.random.default_rng(seed)
    alone = {name: random.uniform(0, 1, len(starts)) for name, starts in zip("abcd", CHOICES, strict=True)}

    def coupled(start):
        return sum(alone[name][int(value)] for name, value in start.items()) + 0.02 * np.sin(sum(start.values()))

    every = sorted(map(coupled, combined(CHOICES)))
    assert min(map(coupled, most_promising(CHOICES, coupled))) <= every[1]


def term(start, asked):
    """Linearise a x with a term k tanh(F x / k), which is asked for so many times as large beside 3 x."""
    x = np.linspace(-1, 1, 41)
    u = start["F"] * x / start["k"]
    slope = np.cosh(u) ** -2
    jacobian = -np.column_stack([x, slope * x, np.tanh(u) - slope * u])
    return Linearised(("a", "F", "k"), (3 - start["a"]) * x + (asked - 1) * start["k"] * np.tanh(u), jacobian)


@pytest.mark.parametrize(("asked", "found"), [(0.02, 0.02), (1.0, 1.0), (50.0, 50.0), (0.0, 1.0), (-2.0, 1.0)])
def test_a_start_is_as_large_as_the_data_ask_and_keeps_its_shape(asked, found):
    start = {"a": 2.0, "F": 40.0, "k": 10.0}
    values, _ = sized(start, term(start, asked), {"a"}, [SizedEffect(["F", "k"], [])])
    assert values == pytest.approx({"a": 2.0, "F": 40.0 * found, "k": 10.0 * found})
