"""Play: a spring behind a clearance, and friction behind a clearance, have loops that are known in closed form."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)
A, G, K, SLIP, STIFF = 1.0, 0.13, 700.0, 90.0, 1500.0


def force_on(effects, values, motion):
    """Force of a clamp that has nothing but these effects."""
    equations = Structure("power", effects).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force


def area(motion, force):
    """Energy lost in a cycle, N mm."""
    y, F = motion.y[0], force[0]
    return float(np.sum((np.roll(F, -1) + F) / 2 * (np.roll(y, -1) - y)))


def test_a_spring_behind_a_clearance_is_a_gap_about_zero():
    """Worden and Tomlinson, on backlash: k (|y| - g)+ sgn y. Nothing is lost."""
    motion = sinusoids(A, 2.0, 293.15, 512)
    force = force_on(("play",), {"k10": K, "g_p": G}, motion)
    expected = K * np.sign(motion.y) * np.maximum(np.abs(motion.y) - G, 0.0)
    np.testing.assert_allclose(force, expected, atol=1e-9 * K)
    assert abs(area(motion, force)) < 1e-9 * K


def test_friction_behind_a_clearance_is_lost_motion():
    """Nordin, Galic and Gutman, a stiff clearance: friction F_c loses 4 F_c (A - g) a cycle, and is zero within it."""
    motion = sinusoids(A, 2.0, 293.15, 4096)
    force = force_on(("coulomb", "play"), {"F_c": SLIP, "g_p": G}, motion)
    assert area(motion, force) == pytest.approx(4 * SLIP * (A - G), rel=2e-3)
    within = (motion.y[0] < A - 0.01 * G) & (motion.y[0] > A - 1.99 * G) & (motion.v[0] < 0)
    np.testing.assert_array_equal(force[0, within], 0.0)


def test_an_elastic_slip_element_behind_a_clearance():
    """The element unloads to zero, is carried back by nothing over 2 g, and loads again: 4 F (A - g - F/k) a cycle."""
    motion = sinusoids(A, 2.0, 293.15, 4096)
    force = force_on(("memory", "play"), {"k_s": STIFF, "z_s": SLIP, "g_p": G}, motion)
    assert area(motion, force) == pytest.approx(4 * SLIP * (A - G - SLIP / STIFF), rel=2e-3)
    downwards = motion.v[0] < 0
    let_go, engaged = A - SLIP / STIFF, A - SLIP / STIFF - 2 * G
    np.testing.assert_allclose(np.interp([let_go - 0.05 * G, engaged + 0.05 * G], motion.y[0, downwards][::-1],
                                         force[0, downwards][::-1]), 0.0, atol=0.02 * SLIP)  # fmt: skip
    assert np.interp(
        engaged - SLIP / STIFF / 2, motion.y[0, downwards][::-1], force[0, downwards][::-1]
    ) == pytest.approx(-SLIP / 2, rel=0.02)


def test_a_clamp_that_is_let_go_stays_where_its_force_fell_to_zero():
    """A spring and a dashpot push on until k (A sin wt - g) + c A w cos wt = 0, between two samples mostly."""
    n, w, c = 64, 4 * np.pi, 20.0
    theta = 2 * np.pi * (np.arange(n) + np.arange(8)[:, None] / 8) / n
    slow = {name: np.full((8, 1), value) for name, value in {"A": A, "f": 2.0, "T": 293.15}.items()}
    y, v = A * np.sin(theta), A * w * np.cos(theta)
    motion = Motion(y, v, -(w**2) * y, slow, np.full((8, 1), 2 * np.pi / (w * n)))
    equations = Structure("power", ("play",)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0, "k10": K, "c0": c, "g_p": G}
    law_force = force_of_equations(equations, [given[name] for name in equations.names], (1e-6, 1e-6), motion)
    place = law_force.states[0]
    free = (np.abs(place) < G - 1e-6) & (v < 0)
    let_go = brentq(lambda at: K * (A * np.sin(at) - G) + c * A * w * np.cos(at), np.pi / 2, np.pi)
    assert np.all(free.any(axis=1))
    np.testing.assert_allclose((y - place)[free], A * np.sin(let_go) - G, atol=1e-3 * A)


def test_a_small_cycle_on_a_large_one_opens_the_clearance_again():
    """What tells play from a gap about zero: at the end of a ramp a small cycle meets no force, within 2 g."""
    y = np.concatenate([np.linspace(0.0, 0.8, 200), 0.8 - 0.9 * G * (1 - np.cos(np.linspace(0, 2 * np.pi, 100)))])
    v = np.gradient(y, 1e-3)
    slow = {"A": np.array([[A]]), "f": np.array([[1.0]]), "T": np.array([[293.15]])}
    motion = Motion(y[None], v[None], 0 * y[None], slow, np.array([[1e-3]]), periodic=False)
    force = force_on(("memory", "play"), {"k_s": 1e4 * STIFF, "z_s": SLIP, "g_p": G}, motion)[0]
    assert force[199] == pytest.approx(SLIP, rel=1e-6)
    np.testing.assert_allclose(force[203:297], 0.0, atol=1e-6 * SLIP)


def test_friction_holds_a_clamp_while_the_pipe_turns_within_the_clearance():
    """Coulomb: a spring's force below F_c moves nothing, however slow the pipe is; the clamp is met where it was."""
    turns, n = (0.0, 1.0, 0.85, 1.1), 400
    theta = np.linspace(0, np.pi, n, endpoint=False)
    moves = [(low, high - low) for low, high in pairwise(turns)]
    y = np.concatenate([low + move * (1 - np.cos(theta)) / 2 for low, move in moves])
    v = np.concatenate([move * np.sin(theta) / 2 * np.pi for _, move in moves])
    slow = {"A": np.array([[A]]), "f": np.array([[1.0]]), "T": np.array([[293.15]])}
    motion = Motion(y[None], v[None], 0 * y[None], slow, np.array([[1 / n]]), periodic=False)
    force = force_on(("coulomb", "play"), {"k10": 100.0, "F_c": SLIP, "g_p": G}, motion)[0]
    held = (np.arange(y.size) > n + 40) & ((np.arange(y.size) < 2 * n) | (y < 0.99))
    np.testing.assert_array_equal(force[held], 0.0)
    again = (np.arange(y.size) > 2 * n) & (y > 1.01) & (y < 1.09)
    np.testing.assert_allclose(force[again], (100.0 * (y - G) + SLIP)[again], rtol=5e-3)


def test_what_the_rig_adds_is_not_behind_the_clearance():
    motion = sinusoids(A, 2.0, 293.15, 256)
    force = force_on(("inertia", "play"), {"g_p": 1.0, "m": 0.01}, motion)
    np.testing.assert_allclose(force, force_on(("inertia",), {"m": 0.01}, motion), rtol=1e-12, atol=1e-9)
