"""Hysteresis whose loops are known in closed form: Jenkins with two limits, Iwan's spread, Bouc and Wen's model."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)


def force_on(effect, values, motion):
    """Force of a clamp that has nothing but this effect."""
    equations = Structure("power", (effect,)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force


def along(effect, values, y):
    """Force along a way from rest."""
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    motion = Motion(y[None], np.ones_like(y)[None], 0 * y[None], slow, np.array([[1e-3]]), periodic=False)
    return force_on(effect, values, motion)[0]


def lost(motion, force):
    """Energy lost in each cycle, N mm."""
    moves = np.roll(motion.y, -1, axis=1) - motion.y
    return np.sum((np.roll(force, -1, axis=1) + force) / 2 * moves, axis=1)


def test_an_element_with_two_limits():
    """It slips over 2 A less the elastic way between its limits: (z_p + z_n) (2 A - (z_p + z_n)/k) a cycle."""
    k, up, down = 900.0, 120.0, 45.0
    motion = sinusoids([0.5, 1.0], 2.0, 293.15, 4096)
    force = force_on("directional_slip", {"k_d": k, "z_p": up, "z_n": down}, motion)
    expected = (up + down) * (2 * np.array([0.5, 1.0]) - (up + down) / k)
    np.testing.assert_allclose(lost(motion, force), expected, rtol=1e-5)
    assert (force.max(), force.min()) == pytest.approx((up, -down))


IWAN = {"F_S": 100.0, "K_T": 1000.0, "chi": -0.5, "beta_S": 0.4}


def iwan_with(chi, beta):
    return IWAN | {"chi": chi, "beta_S": beta}


def largest_slip(F_S, K_T, chi, beta_S):
    """Segalman, Eq. for phi_max: the displacement at which all slip."""
    return F_S * (1 + beta_S) / (K_T * (beta_S + (chi + 1) / (chi + 2)))


def test_the_spread_sticks_and_slips_as_a_whole():
    first, last = 1e-3 * largest_slip(**IWAN), 1.01 * largest_slip(**IWAN)
    stuck, slipped = along("slip_spread", IWAN, np.array([first, last]))
    assert stuck == pytest.approx(IWAN["K_T"] * first, rel=1e-12)
    assert slipped == pytest.approx(IWAN["F_S"], rel=1e-12)


def test_the_spread_follows_masings_rule():
    """Masing: after a reversal at (y, F) the force is F - 2 F1((y - y')/2), with the first loading's curve F1."""
    top = 0.6 * largest_slip(**IWAN)
    back = np.linspace(top, -top, 41)
    first = along("slip_spread", IWAN, np.linspace(0.0, top, 41))
    again = along("slip_spread", IWAN, np.concatenate([np.linspace(0.0, top, 41), back[1:]]))[41:]
    np.testing.assert_allclose(again, first[-1] - 2 * first[1:], rtol=1e-9)


@pytest.mark.parametrize(("chi", "beta"), [(-0.8, 0.0), (-0.5, 0.4), (-0.2, 1.0), (0.0, 0.0)])
def test_the_spread_loses_a_power_of_the_amplitude(chi, beta):
    """Segalman, microslip: 4 R A^(chi + 3) / ((chi + 2) (chi + 3)) a cycle.

    The cells meet it within an eighth over a decade, within 3 % near the largest slip displacement, and its exponent
    over the decade within 0.05.
    """
    values = iwan_with(chi, beta)
    phi = largest_slip(**values)
    share = (chi + 1) / (chi + 2)
    R = values["F_S"] * (chi + 1) / (phi ** (chi + 2) * (beta + share))
    amplitudes = phi * np.geomspace(0.09, 0.9, 24)
    motion = sinusoids(amplitudes, 1.0, 293.15, 1024)
    found = lost(motion, force_on("slip_spread", values, motion))
    expected = 4 * R * amplitudes ** (chi + 3) / ((chi + 2) * (chi + 3))
    np.testing.assert_allclose(found, expected, rtol=0.125)
    near = amplitudes > 0.3 * phi
    np.testing.assert_allclose(found[near], expected[near], rtol=0.03)
    slope = np.polyfit(np.log(amplitudes), np.log(found), 1)[0]
    assert slope == pytest.approx(chi + 3, abs=0.05)


@pytest.mark.parametrize(("chi", "beta"), [(-0.7, 0.05), (-0.4, 0.3), (-0.1, 0.5)])
def test_the_cells_err_by_less_than_the_noise_of_a_good_rig(chi, beta):
    """Against ten times as many elements, over a decade of amplitudes: 0.3 % of the force (rms).

    Seven cells erred by 0.7 %: a joint of Iwan's, measured with 0.4 % noise, had no law of its own form.
    """
    values = iwan_with(chi, beta)
    phi = largest_slip(**values)
    edges = np.linspace(0.0, 1.0, 141) ** 2
    stiffness = np.append(np.diff(edges ** (chi + 1)), beta) * values["K_T"] / (1 + beta)
    limits = np.append((chi + 1) / (chi + 2) * np.diff(edges ** (chi + 2)) / np.diff(edges ** (chi + 1)), 1.0) * phi
    for amplitude in phi * np.array([0.2, 0.5, 0.9]):
        y = amplitude * np.sin(np.linspace(0.0, 2.5 * 2 * np.pi, 1001))
        stretch, expected = np.zeros_like(limits), []
        for move in np.diff(y, prepend=0.0):
            stretch = np.clip(stretch + move, -limits, limits)
            expected.append(stiffness @ stretch)
        error = (along("slip_spread", values, y) - expected)[200:]
        assert np.sqrt(np.mean(error**2)) < 0.003 * np.sqrt(np.mean(np.square(expected[200:])))


WEN = {"k_b": 1000.0, "z_b": 100.0, "n_b": 1.0, "s_b": 0.0, "p_b": 0.0, "w_b": 0.3}


@pytest.mark.parametrize("points", [2, 5, 200])
def test_wens_first_loading_is_an_exponential_whatever_the_steps(points):
    """Wen with n = 1: z = z_u (1 - exp(-k y/z_u)), exactly, and its ultimate force is z_u."""
    y = np.linspace(0.0, 0.5, points)
    np.testing.assert_allclose(along("bouc_wen", WEN, y), 100.0 * -np.expm1(-10.0 * y), rtol=1e-6, atol=1e-6)
    assert along("bouc_wen", WEN, np.array([5.0]))[0] == pytest.approx(100.0)


@pytest.mark.parametrize(("way", "tolerance"), [(0.125, 2e-6), (0.25, 2e-5), (0.5, 3e-4)])
def test_wens_first_loading_for_n_2_is_a_hyperbolic_tangent(way, tolerance):
    """Wen with n = 2: z = z_u tanh(k y/z_u); steps are shares of z_u/k."""
    y = 0.1 * np.arange(0.0, 4.0, way)
    np.testing.assert_allclose(
        along("bouc_wen", WEN | {"n_b": 2.0}, y), 100.0 * np.tanh(10.0 * y), atol=100 * tolerance
    )


@pytest.mark.parametrize(("way", "tolerance"), [(0.1, 2e-4), (0.02, 2e-6)])
def test_dahls_friction_unloads_by_the_exponential_that_it_loads_by(way, tolerance):
    """Dahl (1968), exponent 1: dz/dy = k (1 - z/z_u sgn v), so z -> -z_u as exp(-k y/z_u) from wherever it turns."""
    y = 0.1 * np.arange(0.0, 3.0, way)
    there = along("bouc_wen", WEN | {"s_b": 1.0}, np.concatenate([y, y[-2::-1]]))
    turn = 100.0 * -np.expm1(-10.0 * y[-1])
    expected = -100.0 + (turn + 100.0) * np.exp(-10.0 * (y[-1] - y[-2::-1]))
    np.testing.assert_allclose(there[len(y) :], expected, atol=100 * tolerance)


def by_small_steps(n, y, u=0.0, k=1000.0, most=100.0, steps=400):
    """Wen's equation by Runge-Kutta's rule in small steps."""
    z, found, before = 0.0, [], 0.0
    for place in y:
        move = (place - before) / steps

        def slope(force, move=move):
            return k * (1 + (u if force * move < 0 else -1.0) * abs(force / most) ** n)

        for _ in range(steps):
            one = slope(z)
            two = slope(z + move * one / 2)
            three = slope(z + move * two / 2)
            four = slope(z + move * three)
            z += move * (one + 2 * two + 2 * three + four) / 6
        found.append(z)
        before = place
    return np.array(found)


@pytest.mark.parametrize(
    ("n", "u"), [(1.0, 0.0), (1.3, 0.0), (3.0, 0.0), (6.0, 0.0), (1.0, 0.4), (2.0, 1.0), (4.0, 2.0)]
)
def test_wens_loops_within_the_stated_tolerance(n, u):
    """A quarter of z_u/k to a step at most: within 1e-4 of z_u, and 2e-5 more for the small steps' own error."""
    y = 0.6 * np.sin(2 * np.pi * np.arange(1, 308) / 153.5)
    assert 2 * np.pi / 153.5 * 0.6 * 10.0 == pytest.approx(0.25, rel=0.02)
    expected = by_small_steps(n, y, u)
    np.testing.assert_allclose(along("bouc_wen", WEN | {"n_b": n, "s_b": u}, y), expected, atol=0.012)


def test_pinching_takes_stiffness_at_zero_force_and_leaves_the_ultimate_force():
    """Baber and Noori: the loop is slack where the force passes zero."""
    pinched, plain = (WEN | {"p_b": share} for share in (0.8, 0.0))
    near = np.array([1e-6, 2e-6])
    ratio = np.diff(along("bouc_wen", pinched, near)) / np.diff(along("bouc_wen", plain, near))
    assert ratio == pytest.approx(1 - 0.8, rel=1e-4)
    assert along("bouc_wen", pinched, np.array([2.0]))[0] == pytest.approx(100.0, rel=1e-4)
    motion = sinusoids(1.0, 1.0, 293.15, 1024)
    losses = [lost(motion, force_on("bouc_wen", values, motion))[0] for values in (pinched, plain)]
    assert 0.8 * losses[1] < losses[0] < losses[1]
