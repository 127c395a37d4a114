"""The exact step of coupled modes against the matrix exponential, and against the step of single modes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from pipeclamp_models.pipe import coupled_step as pipe_coupled_step
from pipeclamp_models.pipe import step as pipe_step


def rows_of(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())


def exact(stiffness: np.ndarray, damping: np.ndarray, h: float) -> np.ndarray:
    """Map (q, p, g0, g1) to (q, p, integral of q) by the exponential of the augmented system."""
    n = len(stiffness)
    none, one = np.zeros((n, n)), np.eye(n)
    generator = np.block(
        [
            [none, one, none, none, none],
            [-stiffness, -damping, one, none, none],
            [none, none, none, one, none],
            [none] * 5,
            [one, none, none, none, none],
        ]
    )
    start = np.block(
        [
            [one, none, none, none],
            [none, one, none, none],
            [none, none, one, none],
            [none, none, -one / h, one / h],
            [none] * 4,
        ]
    )
    after = expm(generator * h) @ start
    return np.vstack([after[: 2 * n], after[4 * n :]])


@pytest.mark.parametrize("h", [1e-5, 1e-3, 0.03])
@pytest.mark.parametrize("growing", [False, True])
def test_step_is_the_matrix_exponential(h: float, growing: bool) -> None:
    rng = np.random.default_rng(2)
    omega = np.array([12.0, 60.0, 300.0, 4000.0])
    stiffness = np.diag(omega**2) + (400.0 if growing else 20.0) * rng.normal(size=(4, 4))
    stiffness[0, 0] *= -1.0 if growing else 1.0
    gyroscopic = rng.normal(size=(4, 4))
    damping = np.diag(0.02 * omega) + 5 * (gyroscopic - gyroscopic.T)
    ours = np.array(pipe_coupled_step.transition(rows_of(stiffness), rows_of(damping), h))
    reference = exact(stiffness, damping, h)
    scale = np.abs(reference).max(axis=1, keepdims=True)
    assert np.abs((ours - reference) / scale).max() < 1e-11


def test_without_coupling_it_is_the_step_of_each_mode() -> None:
    omega, damping, h = (0.0, 20.0, 900.0), (0.0, 0.4, 18.0), 2e-3
    rows = pipe_coupled_step.transition(rows_of(np.diag(np.square(omega))), rows_of(np.diag(damping)), h)
    q, p, g0, g1 = (0.1, -0.2, 0.3), (2.0, 1.0, -5.0), (30.0, 10.0, -20.0), (-3.0, 2.0, 50.0)
    found = pipe_coupled_step.step_coupled(rows, q, p, g0, g1)
    modes = zip(omega, damping, q, p, g0, g1, strict=True)
    expected = [pipe_step.step(pipe_step.coefficients(w, d, h), *given) for w, d, *given in modes]
    assert np.array(found) == pytest.approx(np.array(expected).T, rel=1e-11)


def test_a_gyroscopic_system_keeps_its_energy() -> None:
    stiffness = np.diag([400.0, 3600.0])
    rows = pipe_coupled_step.transition(rows_of(stiffness), ((0.0, 9.0), (-9.0, 0.0)), 7e-3)
    q, p, none = (1e-3, -2e-3), (0.02, 0.01), (0.0, 0.0)
    start = np.dot(p, p) + q @ stiffness @ q
    for _ in range(20_000):
        q, p, _ = pipe_coupled_step.step_coupled(rows, q, p, none, none)
    assert (np.dot(p, p) + q @ stiffness @ q) / start == pytest.approx(1.0, abs=1e-9)
