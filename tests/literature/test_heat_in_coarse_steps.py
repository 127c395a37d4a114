"""A clamp's step that turns round within: heat and force in coarse steps against what is known in closed form."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeclamp_models.steps.within_step import turning, walk
from pipeclamp_system.cosim.energy import received_work

A, F = 0.6, 3.0
OMEGA = 2 * math.pi * F
K, S = 2000.0, 150.0


def jenkins(k, memory, y_before, y, v, h):
    z = min(max(memory[0] + K * (y - y_before), -S), S)
    return z, z * z / (2 * K), (z,)


def dashpot(k, memory, y_before, y, v, h):
    return k * v, 0.0, memory


def hard_spring(k, memory, y_before, y, v, h):
    return k * y + k * y**3, k * y * y / 2 + k * y**4 / 4, memory


def walked(law, k, per_cycle, cycles=40, memory=(0.0,)):
    """Phase, force and heat (N mm) at each point along a sinusoid that begins in its middle."""
    h = 1 / (F * per_cycle)
    theta = OMEGA * h * np.arange(1, round(cycles * per_cycle) + 1)
    y_before, v_before = 0.0, A * OMEGA
    force, energy, memory = law(k, memory, 0.0, 0.0, v_before, 0.0)
    rows, heat = [], 0.0
    for y, v in zip((A * np.sin(theta)).tolist(), (A * OMEGA * np.cos(theta)).tolist(), strict=True):
        force, energy, memory, lost, _ = walk(law, k, memory, (y_before, v_before, y, v), h, (force, energy), 1)
        heat += lost
        rows.append((force, heat))
        y_before, v_before = y, v
    force, heat = np.array(rows).T
    return theta, force, heat


@pytest.mark.parametrize(("per_cycle", "force_error", "heat_error"), [(12.37, 2e-3, 2e-3), (25.37, 2e-4, 2e-4)])
def test_an_elastic_slip_element_unloads_from_where_the_motion_turned(per_cycle, force_error, heat_error):
    """Masing's loop: from A it unloads by K until -S; 4 S (A - S/K) a cycle. Straight steps err by 5 and 10 %."""
    theta, force, heat = walked(jenkins, None, per_cycle)
    y, rising = A * np.sin(theta), np.cos(theta) > 0
    loop = np.where(rising, np.minimum(-S + K * (y + A), S), np.maximum(S - K * (A - y), -S))
    steady = theta > 2 * np.pi
    assert np.abs(force - loop)[steady].max() < force_error * S
    whole = [np.searchsorted(theta, 2 * np.pi * cycles) for cycles in (2, 37)]
    cycles = (theta[whole[1]] - theta[whole[0]]) / (2 * np.pi)
    slipping = heat[whole[1]] - heat[whole[0]]
    assert slipping / cycles == pytest.approx(4 * S * (A - S / K), rel=heat_error + 1e-3)


@pytest.mark.parametrize(("per_cycle", "error"), [(12, 3e-4), (25, 2e-5)])
def test_the_heat_of_a_dashpot(per_cycle, error):
    """pi c omega A^2 a cycle; the trapezoid over straight ways errs by 4.5 and 1.0 %."""
    _, _, heat = walked(dashpot, 4.0, per_cycle)
    assert (heat[-1] - heat[per_cycle - 1]) / 39 == pytest.approx(math.pi * 4.0 * OMEGA * A**2, rel=error)


def test_a_linear_spring_gives_no_heat_and_a_hard_one_hardly_any():
    def linear(k, memory, y_before, y, v, h):
        return k * y, k * y * y / 2, memory

    _, _, heat = walked(linear, 900.0, 12.37)
    assert np.abs(heat).max() < 1e-12 * 900.0 * A**2
    _, _, heat = walked(hard_spring, 900.0, 12.37)
    assert np.abs(heat).max() < 2e-3 * 900.0 * A**2


@given(
    st.floats(-1.0, 1.0), st.floats(1e-3, 10.0), st.floats(-1.0, 1.0), st.floats(1e-3, 10.0), st.floats(1e-3, 1.0),
    st.sampled_from([1.0, -1.0]),
)  # fmt: skip
def test_the_turn_is_the_cubic_s(y_before, speed_before, y, speed, h, sign):
    """Against the roots of its derivative: there is one in the step, and the displacement is the cubic's there."""
    v_before, v = sign * speed_before, -sign * speed
    cubic = np.polynomial.Polynomial([
        y_before,
        h * v_before,
        3 * (y - y_before) - h * (2 * v_before + v),
        2 * (y_before - y) + h * (v_before + v),
    ])  # fmt: skip
    at, place = turning((y_before, v_before, y, v), h)
    assert 0.0 <= at <= 1.0
    assert cubic.deriv()(at) == pytest.approx(0.0, abs=1e-9 * (abs(h * v_before) + abs(h * v) + abs(y - y_before)))
    assert place == pytest.approx(cubic(at), abs=1e-12)


def test_a_motion_whose_velocity_isn_t_told_is_straight():
    """Nothing says where it turned."""
    force, _, _, _, way = walk(jenkins, None, (0.0,), (0.1, 0.0, 0.2, 0.0), 1e-3, (0.0, 0.0), 1)
    assert (force, way) == pytest.approx((150.0, 0.1))


def test_the_work_that_a_run_s_points_tell_of():
    """That of a dashpot over whole cycles; the trapezoidal rule alone errs by 4.5 % in 12 steps a cycle."""
    time = np.arange(0, 30 * 12 + 1) / (12 * F)
    displacement, velocity = (A * np.sin(OMEGA * time))[:, None], (A * OMEGA * np.cos(OMEGA * time))[:, None]
    work = received_work(4.0 * velocity, displacement, velocity, time)
    assert work[-1, 0] / 30 == pytest.approx(math.pi * 4.0 * OMEGA * A**2, rel=3e-3)
