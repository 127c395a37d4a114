"""Slip that displacement presses: its loop in closed form, its limits, and no motion that gains work."""

from itertools import pairwise

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)
PRESSED = {"z_0": 20.0, "mu_p": 60.0, "mu_n": 25.0, "x_n": 0.05}
LOADED = {"z_0": 20.0, "mu_p": 40.0, "mu_n": -40.0, "x_n": 0.05}
"""A spring presses by a static load of 0.5 mm."""


def force_on(effect, values, motion):
    """Force of a clamp that has nothing but an effect."""
    equations = Structure("power", (effect,)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion)


def slip_force(y, values=PRESSED):
    return np.maximum(0.0, values["z_0"] + np.where(y > 0, values["mu_p"], values["mu_n"]) * np.abs(y))


def path(places):
    """Motion through places, one sample each, that isn't periodic."""
    y = np.asarray(places)[None]
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    return Motion(y, 0 * y, 0 * y, slow, np.array([[1e-3]]), periodic=False)


def test_once_it_slips_the_force_is_that_of_friction_under_its_load():
    motion = sinusoids(np.array([1.0]), np.array([2.0]), 293.15, 4096)
    y, force = motion.y[0], force_on("pressed_slip", PRESSED, motion).force[0]
    slips = np.abs(y) < 1.0 - 2 * PRESSED["x_n"]
    np.testing.assert_allclose(force[slips], (np.sign(motion.v[0]) * slip_force(y))[slips], rtol=1e-9)


def test_each_reversal_takes_the_same_way_wherever_it_is():
    """Back by x_n the element carries nothing, back by twice as much it slips."""
    for turn in (0.3, 0.9, -0.5):
        side = np.sign(turn)
        y = np.concatenate([np.linspace(0.0, turn, 200), turn - side * PRESSED["x_n"] * np.array([1.0, 2.0])])
        force = force_on("pressed_slip", PRESSED, path(y)).force[0]
        expected = [side * slip_force(turn), 0.0, -side * slip_force(y[-1])]
        np.testing.assert_allclose(force[-3:], expected, rtol=1e-9, atol=1e-9)


def test_under_a_static_load_it_slips_at_less_to_one_side_and_at_nothing_where_nothing_presses():
    """Yang's n0 + gamma y: from y = -0.5 on there is no friction."""
    motion = sinusoids(np.array([1.0]), np.array([2.0]), 293.15, 4096)
    y, force = motion.y[0], force_on("pressed_slip", LOADED, motion).force[0]
    slips = np.abs(y) < 1.0 - 2 * LOADED["x_n"]
    np.testing.assert_allclose(force[slips], (np.sign(motion.v[0]) * slip_force(y, LOADED))[slips], atol=1e-9)
    assert np.all(force[y < -0.5] == 0.0)


def test_without_growth_it_is_an_elastic_slip_element():
    motion = sinusoids(np.array([0.04, 0.3, 1.0]), np.array([2.0] * 3), 293.15, 512)
    plain = force_on("memory", {"z_s": 20.0, "k_s": 20.0 / 0.05}, motion).force
    np.testing.assert_allclose(
        force_on("pressed_slip", PRESSED | {"mu_p": 0.0, "mu_n": 0.0}, motion).force, plain, atol=1e-9
    )


@pytest.mark.parametrize("values", [PRESSED, LOADED])
@pytest.mark.parametrize("seed", range(5))
def test_no_motion_gains_work(seed, values):
    """Along a random path in small steps: stored energy never rises by more than the work that is done."""
    random = np.random.default_rng(seed)
    turns = np.concatenate([[0.0], random.uniform(-1.0, 1.0, 12)])
    y = np.concatenate([np.linspace(*ends, 4000, endpoint=False) for ends in pairwise(turns)])
    found = force_on("pressed_slip", values, path(y))
    force, share = found.force[0], np.asarray(found.states[0])[0]
    assert np.max(np.abs(share)) <= 1.0
    work = np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(y))])
    energy = np.array([stored(*pair, values) for pair in zip(y, share, strict=True)])
    assert np.all(energy >= 0.0)
    lost = np.diff(work - energy)
    assert lost.min() > -1e-3 * np.abs(np.diff(work)).max()
    assert (work - energy)[-1] > 1.0


def stored(y, share, values):
    """Work that the stuck element gives back on its way to where it carries nothing."""
    start = y - values["x_n"] * share
    s = np.linspace(start, y, 201)
    return np.trapezoid(slip_force(s, values) * (s - start) / values["x_n"], s)
