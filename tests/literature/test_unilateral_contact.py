"""Contact that only pushes: what a mass comes back with, and a contact that never pulls."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion

SMOOTHING = (0.01, 1e-4)
ALPHA = 2e-4
"""Of Hunt and Crossley, s/mm: their force is k d^n (1 + 3/2 alpha d')."""
STOP = {"F_h": 2000.0, "y_h": 0.5, "n_h": 1.5, "chi_h": 1.5 * ALPHA, "m_h": 1.5, "h_T": 0.0}
MASS = 0.002
"""In N s2/mm."""


def force(values, y, v, T=293.15):
    """Force of a clamp that is this stop and nothing else."""
    equations = Structure("power", ("unilateral_contact",)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    y, v = (np.atleast_2d(np.asarray(each, dtype=float)) for each in np.broadcast_arrays(y, v))
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", T))}
    motion = Motion(y, v, 0 * y, slow, np.array([[1e-3]]), periodic=False)
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force[0]


def speed_of_return(values, speed):
    """Speed in mm/s with which a mass that comes in at a speed leaves the stop."""

    def motion(_, state):
        return [state[1], -force(values, *state)[0] / MASS]

    def parted(_, state):
        return state[0] - values["y_h"]

    parted.terminal, parted.direction = True, -1.0
    begin = [values["y_h"] + 1e-9, speed]
    end = solve_ivp(motion, (0.0, 1.0), begin, events=parted, method="LSODA", rtol=1e-8, atol=1e-10, max_step=1e-3)
    assert end.status == 1
    return -float(end.y[1, -1])


def test_a_mass_comes_back_as_hunt_and_crossley_give_it():
    """Restitution is 1 - alpha v for small speeds; exactly, v/chi - ln(1 + chi v)/chi^2 is the same in and out."""
    chi = STOP["chi_h"]
    for speed in (20.0, 200.0, 2000.0):
        back = speed_of_return(STOP, speed)
        came, left = (v / chi - np.log1p(chi * v) / chi**2 for v in (speed, -back))
        assert left == pytest.approx(came, rel=2e-3)
        assert back / speed == pytest.approx(1 - ALPHA * speed, abs=0.7 * (ALPHA * speed) ** 2 + 1e-3)


def test_contact_of_round_bodies_is_hertzs():
    deep = np.array([0.55, 0.7, 1.5])
    assert force(STOP, deep, 0.0) == pytest.approx(2000 * (deep - 0.5) ** 1.5, rel=1e-5)
    assert not force(STOP, [-3.0, 0.0, 0.5], 100.0).any()


def test_the_sign_of_the_force_is_the_side():
    other = STOP | {"F_h": -2000.0}
    assert force(other, -0.8, -30.0) == pytest.approx(-force(STOP, 0.8, 30.0))
    assert not force(other, 0.8, 30.0).any()


def test_damping_has_an_exponent_of_its_own():
    """Tsuji and others: a damping of d^(1/4) d' beside d^(3/2)."""
    tsuji = STOP | {"m_h": 0.25}
    share = (force(tsuji, [0.6, 0.9], 40.0) - force(tsuji, [0.6, 0.9], 0.0)) / 40.0
    assert share == pytest.approx(2000 * STOP["chi_h"] * np.array([0.1, 0.4]) ** 0.25, rel=1e-4)


def test_a_stop_only_pushes():
    fast = STOP | {"chi_h": 1.0}
    assert not force(fast, 0.7, -50.0).any()


def test_it_softens_as_a_power_of_the_temperature():
    soft = STOP | {"h_T": -2.0}
    assert force(soft, 0.9, 10.0, T=586.3) == pytest.approx(force(STOP, 0.9, 10.0) / 4)


def test_what_is_pressed_together_at_rest_has_no_force_there():
    """A rope that is taut at rest: force counts from there, and is what it bore then, once it is slack."""
    taut = STOP | {"F_h": 150.0, "y_h": -0.8, "n_h": 1.0, "chi_h": 0.0}
    assert force(taut, 0.0, 0.0) == pytest.approx(0.0, abs=1e-12)
    assert force(taut, [0.5, -0.5, -0.8, -2.0], 0.0) == pytest.approx([75.0, -75.0, -120.0, -120.0], rel=1e-6)
