"""Broyden's method: linear, steep and kinked functions of several unknowns."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeclamp_system.coupling.bracketing import enclosed
from pipeclamp_system.coupling.broyden import NotFoundError, Solver, SolverTolerance


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_linear_function_far_from_a_contraction(count: int) -> None:
    random = np.random.default_rng(count)
    compliance = random.normal(size=(count, count))
    gain = np.diag(random.uniform(1, 30, count)) @ (compliance @ compliance.T)
    start = random.normal(size=count)
    solution = np.linalg.solve(np.eye(count) + gain, start)
    calls = []

    def answer(f: list[float]) -> list[float]:
        calls.append(f)
        return list(start - gain @ f)

    solver = Solver(count, SolverTolerance(1e-9, 100))
    assert solver.solve(answer, [0.0] * count) == pytest.approx(list(solution), rel=1e-6, abs=1e-6)
    first = len(calls)
    start = 2 * start  # the Jacobian is known by now
    assert solver.solve(answer, list(solution)) == pytest.approx(list(2 * solution), rel=1e-6, abs=1e-6)
    assert len(calls) - first < max(first, 4)


@pytest.mark.parametrize("offset", [-3.0, -0.2, 0.0, 1e-3, 0.7, 5.0])
def test_a_step_like_function(offset: float) -> None:
    """Friction: the answer jumps from one side to the other within a hundredth of the range."""

    def answer(f: list[float]) -> list[float]:
        return [float(np.tanh(100 * (offset - f[0])))]

    found = Solver(1, SolverTolerance(1e-8, 100)).solve(answer, [0.3])[0]
    assert found == pytest.approx(answer([found])[0], abs=1e-6)


def test_zero_is_found_at_once() -> None:
    assert Solver(2, SolverTolerance(1e-6, 60)).solve(lambda f: [0.0, 0.0], [0.0, 0.0]) == [0.0, 0.0]


def test_no_unknowns() -> None:
    assert Solver(0, SolverTolerance(1e-6, 60)).solve(lambda f: [], []) == []


def test_too_few_trials_are_said() -> None:
    with pytest.raises(NotFoundError) as stopped:
        Solver(1, SolverTolerance(1e-12, 3)).solve(lambda f: [float(np.tanh(100 * (1 - f[0])))], [0.3])
    assert stopped.value.error > 1e-12


def test_a_function_that_is_not_finite_is_not_a_solution() -> None:
    with pytest.raises(NotFoundError):
        Solver(1, SolverTolerance(1e-6, 60)).solve(lambda f: [float("nan")], [0.0])


def _friction(force, given=(30.0, -12.0), limit=20.0, width=1e-9):
    """Two clamps with dry friction on a pipe that moves less the more they hold it: steps, smooth over `width`."""
    speed = [g - f - 0.3 * other for g, f, other in zip(given, force, reversed(force), strict=True)]
    return [limit * v / math.sqrt(v * v + width**2) for v in speed]


def test_forces_that_step_are_enclosed():
    tolerance = SolverTolerance(1e-6, 60)
    with pytest.raises(NotFoundError):
        Solver(2, tolerance).solve(_friction, [0.0, 0.0])
    found = enclosed(_friction, [0.0, 0.0], [20.0, 20.0], tolerance)
    # The first slides; the second is held by what keeps it still: -12 - f - 0.3 * 20 = 0.
    assert found == pytest.approx([20.0, -18.0], rel=1e-5)


def test_unknowns_that_run_away_are_given_up_before_an_fmu_refuses_them():
    asked = []

    def answer(force):
        asked.append(abs(force[0]))
        return [1.0 + 30.0 * force[0]]

    with pytest.raises(NotFoundError):
        enclosed(answer, [1.0], [1.0], SolverTolerance(1e-6, 60))
    assert max(asked) < 1e12
