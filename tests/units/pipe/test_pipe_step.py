"""The exact step of a mode against the matrix exponential and against quadrature."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from pipeclamp_models.pipe import step as pipe_step


def exact(omega: float, damping: float, h: float) -> np.ndarray:
    """Map (q, p, g0, g1) to (q, p, integral of q) by the exponential of the augmented system."""
    generator = np.zeros((5, 5))  # q, p, g, slope of g, integral of q
    generator[0, 1] = 1.0
    generator[1, :3] = -(omega**2), -damping, 1.0
    generator[2, 3] = 1.0
    generator[4, 0] = 1.0
    transition = expm(generator * h)
    start = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, -1 / h, 1 / h], [0, 0, 0, 0]])
    return (transition @ start)[[0, 1, 4]]


@pytest.mark.parametrize(
    ("omega", "damping", "h"),
    [
        (0.0, 0.0, 1e-3),  # rigid body
        (0.0, 30.0, 0.5),  # rigid body with drag
        (1e-4, 0.0, 1e-3),  # nearly rigid
        (60.0, 0.6, 1e-4),  # short step
        (60.0, 0.6, 0.37),  # several periods in one step
        (500.0, 1000.0, 1e-2),  # critically damped
        (500.0, 999.999, 1e-2),
        (500.0, 2500.0, 1e-2),  # overdamped
        (3e4, 300.0, 1e-3),  # a residual mode: 5 periods in one step
        (1.0, 4000.0, 1e-2),  # heavily overdamped
    ],
)
def test_step_is_the_matrix_exponential(omega: float, damping: float, h: float) -> None:
    ours = np.array(pipe_step.coefficients(omega, damping, h)).reshape(3, 4)
    reference = exact(omega, damping, h)
    scale = np.abs(reference).max(axis=1, keepdims=True)
    assert np.abs((ours - reference) / scale).max() < 5e-13


@given(
    omega=st.floats(0.0, 2000.0),
    damping=st.floats(0.0, 4000.0),
    h=st.floats(1e-6, 0.02),
    q=st.floats(-1, 1),
    p=st.floats(-1, 1),
    g0=st.floats(-1, 1),
    g1=st.floats(-1, 1),
)
def test_two_half_steps_are_one(
    omega: float, damping: float, h: float, q: float, p: float, g0: float, g1: float
) -> None:
    whole = pipe_step.step(pipe_step.coefficients(omega, damping, h), q, p, g0, g1)
    half = pipe_step.coefficients(omega, damping, h / 2)
    middle = (g0 + g1) / 2
    q_middle, p_middle, first = pipe_step.step(half, q, p, g0, middle)
    q_end, p_end, second = pipe_step.step(half, q_middle, p_middle, middle, g1)
    rate = 1.0 + omega + damping
    assert math.isclose(whole[0], q_end, rel_tol=1e-10, abs_tol=1e-11)
    assert math.isclose(whole[1], p_end, rel_tol=1e-10, abs_tol=1e-11 * rate)
    assert math.isclose(whole[2], first + second, rel_tol=1e-10, abs_tol=1e-12)


def test_undamped_free_vibration_keeps_its_energy() -> None:
    omega = 75.0
    k = pipe_step.coefficients(omega, 0.0, 1.7e-3)
    q, p = 1e-3, 0.02
    start = p * p + omega**2 * q * q
    for _ in range(100_000):
        q, p, _ = pipe_step.step(k, q, p, 0.0, 0.0)
    assert (p * p + omega**2 * q * q) / start == pytest.approx(1.0, abs=1e-9)


def test_work_is_the_integral_of_load_times_velocity() -> None:
    omega, damping, h, q, p, g0, g1 = 40.0, 3.0, 0.05, 0.2, -1.0, 300.0, -500.0
    q_end, _, integral = pipe_step.step(pipe_step.coefficients(omega, damping, h), q, p, g0, g1)

    def rates(t: float, state: np.ndarray) -> list[float]:
        g = g0 + (g1 - g0) * t / h
        return [state[1], g - damping * state[1] - omega**2 * state[0], g * state[1]]

    reference = solve_ivp(rates, (0.0, h), [q, p, 0.0], rtol=1e-12, atol=1e-12, method="DOP853").y[2, -1]
    assert pipe_step.work(g0, g1, q, q_end, integral / h) == pytest.approx(reference, rel=1e-9)
