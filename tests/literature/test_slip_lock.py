"""Slip-lock: its loop in closed form, its limits, and no motion that gains work."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion

SMOOTHING = (0.01, 0.001)
LOCK = {"x_l": 0.2, "z_lp": 30.0, "z_ln": 50.0, "g_l": 0.1, "n_l": 2.0}
MEAN = 40.0


def force_on(effect, values, places):
    """Force of a clamp that has nothing but an effect, along places, one sample each."""
    equations = Structure("power", (effect,)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    y = np.asarray(places)[None]
    motion = Motion(y, 0 * y, 0 * y, slow, np.array([[1e-3]]), periodic=False)
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion)


def test_a_reversal_unloads_waits_and_loads_again_by_the_power():
    """From the slip force on the way up; the clearance has moved along with the slip."""
    farthest = 0.1 + 0.2 * (30.0 / MEAN) ** 0.5
    back = np.array([0.05, farthest - 0.1, farthest, farthest + 0.1, farthest + 0.15, 2.0])
    force = force_on("slip_lock", LOCK, np.concatenate([np.linspace(0.0, 1.0, 50), 1.0 - back])).force[0]
    assert force[49] == pytest.approx(30.0)
    expected = [MEAN * ((farthest - 0.15) / 0.2) ** 2, 0.0, 0.0, 0.0, -MEAN * 0.25**2, -50.0]
    np.testing.assert_allclose(force[50:], expected, atol=1e-6)


def test_without_a_clearance_and_straight_it_is_directional_slip():
    places = 0.5 * np.sin(np.linspace(0.0, 12.0, 400))
    plain = force_on("directional_slip", {"k_d": MEAN / 0.2, "z_p": 30.0, "z_n": 50.0}, places).force
    np.testing.assert_allclose(force_on("slip_lock", LOCK | {"g_l": 0.0, "n_l": 1.0}, places).force, plain, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_no_motion_gains_work(seed):
    """Work done on it is stored or lost, from any place to any other."""
    places = np.concatenate([[0.0], np.cumsum(np.random.default_rng(seed).uniform(-1.0, 1.0, 30))])
    fine = np.interp(np.arange(0, 30, 1e-3), np.arange(31), places)
    force = force_on("slip_lock", LOCK, fine).force[0]
    work = np.cumsum(np.concatenate([[0.0], (force[1:] + force[:-1]) / 2 * np.diff(fine)]))
    stored = MEAN * LOCK["x_l"] * (np.abs(force) / MEAN) ** 1.5 / 3
    lost = np.diff(work - stored)
    assert lost.min() > -1e-3 * MEAN * np.abs(np.diff(fine)).max()
    assert lost.sum() > MEAN
