"""Friction that falls with speed, springs that stiffen, compressed gas: curves, work and loops in closed form."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import dawsn, i1, modstruve

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)


def values_of(effect, values):
    """Equations of a clamp that has nothing but this effect, with its values."""
    equations = Structure("power", (effect,)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return equations, [given[name] for name in equations.names]


def force_on(effect, values, motion):
    """Force on a motion."""
    return force_of_equations(*values_of(effect, values), SMOOTHING, motion).force


def at(effect, values, y, v=1.0):
    """Force at displacements and velocities."""
    y, v = np.broadcast_arrays(np.atleast_1d(y).astype(float), np.atleast_1d(v).astype(float))
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    motion = Motion(y[None], v[None], 0 * y[None], slow, np.array([[1e-3]]), periodic=False)
    return force_on(effect, values, motion)[0]


@np.errstate(invalid="ignore")  # of the branch that a choice doesn't take
def stored(effect, values, y):
    """Energy at displacements, N mm."""
    equations, numbers = values_of(effect, values)
    compiled = realise(equations)
    columns = compiled.coefficients(*(1.0 for _ in compiled.slow), *numbers, *SMOOTHING)
    return compiled.energy(np.asarray(y, float), 0.0, 0.0, 0.0, 1e-3, *columns, *numbers, *SMOOTHING)[0]


def lost(motion, force):
    """Energy lost in each cycle, N mm."""
    moves = np.roll(motion.y, -1, axis=1) - motion.y
    return np.sum((np.roll(force, -1, axis=1) + force) / 2 * moves, axis=1)


STRIBECK = {"F_k": 40.0, "F_b": 60.0, "v_s": 5.0, "delta_s": 2.0}


def test_friction_follows_the_stribeck_curve():
    """Olsson and others: F_C + (F_S - F_C) exp(-|v/v_S|^2), F_S next to rest, F_C at speed."""
    assert at("stribeck", STRIBECK, 0.0, [0.3, 5.0, 50.0]) == pytest.approx(
        [40 + 60 * np.exp(-0.0036), 40 + 60 / np.e, 40.0], rel=6e-4
    )
    assert at("stribeck", STRIBECK, 0.0, 0.0)[0] == 0.0
    falling = at("stribeck", STRIBECK | {"delta_s": 0.7}, 0.0, [0.5, 5.0, 50.0])
    assert falling == pytest.approx(40 + 60 * np.exp(-(np.array([0.1, 1.0, 10.0]) ** 0.7)), rel=6e-4)
    v = np.linspace(-20.0, 20.0, 41)
    np.testing.assert_array_equal(at("stribeck", STRIBECK, 0.0, v), -at("stribeck", STRIBECK, 0.0, -v))


@pytest.mark.parametrize("frequency", [0.1, 1.0, 10.0])
def test_the_loss_of_falling_friction(frequency):
    """A cycle loses 4 A (F_C + (F_S - F_C) D(s)/s), with Dawson's D of s = w A/v_S: from 4 A F_S to 4 A F_C.

    Smoothing at v = 0 takes less than 0.1 % of it.
    """
    motion = sinusoids(1.0, frequency, 293.15, 8192)
    speed = 2 * np.pi * frequency / STRIBECK["v_s"]
    expected = 4 * (STRIBECK["F_k"] + STRIBECK["F_b"] * dawsn(speed) / speed)
    assert lost(motion, force_on("stribeck", STRIBECK, motion))[0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("frequency", [0.01, 0.3, 10.0])
def test_the_loss_of_rounded_friction(frequency):
    """A cycle loses F_t times the integral of v tanh(v/v_t) over time.

    It goes from that of a dashpot F_t/v_t in slow cycles to 4 A F_t in fast ones.
    """
    motion = sinusoids(1.0, frequency, 293.15, 8192)
    fastest = 2 * np.pi * frequency
    expected = 4 * 50.0 * quad(lambda turn: np.sin(turn) * np.tanh(fastest * np.sin(turn) / 2.0), 0, np.pi / 2)[0]
    measured = lost(motion, force_on("rounded_friction", {"F_t": 50.0, "v_t": 2.0}, motion))[0]
    assert measured == pytest.approx(expected, rel=1e-5)
    assert at("rounded_friction", {"F_t": 50.0, "v_t": 2.0}, 0.0, 2.0)[0] == pytest.approx(50 * np.tanh(1.0))


@pytest.mark.parametrize("amplitude", [1.0, 2.0])
def test_friction_that_grows_with_the_displacement(amplitude):
    """Reid: a cycle of amplitude A loses 2 k_mu A^2, at any speed; k_mu = mu k of a ring spring."""
    for frequency in (0.1, 10.0):
        motion = sinusoids(amplitude, frequency, 293.15, 8192)
        force = force_on("displacement_friction", {"k_mu": 50.0}, motion)
        assert lost(motion, force)[0] == pytest.approx(100.0 * amplitude**2, rel=2e-3)
    assert at("displacement_friction", {"k_mu": 50.0}, 0.0, 50.0)[0] == 0.0
    assert at("displacement_friction", {"k_mu": 50.0}, -2.0, [50.0, -50.0]) == pytest.approx([100.0, -100.0], rel=1e-3)


FUNG = {"k_x": 300.0, "b_x": 4.0}


def test_stiffening_is_fungs_without_the_stiffness_at_rest():
    """Fung: the tangent grows as force plus a constant. Here dF/dy = b F + k b |y|, and k1 is left alone."""
    y = np.linspace(-1.5, 1.5, 3001)
    force = at("exponential_stiffening", FUNG, y)
    tangent = np.gradient(force, y)
    expected = FUNG["b_x"] * np.abs(force) + FUNG["k_x"] * FUNG["b_x"] * np.abs(y)
    np.testing.assert_allclose(tangent[1:-1], expected[1:-1], rtol=1e-5, atol=0.7)
    near = np.log(2) / 4 + np.array([-1e-6, 1e-6])
    assert np.diff(at("exponential_stiffening", FUNG, near))[0] == pytest.approx(300.0 * 2e-6, rel=1e-6)


def test_the_first_harmonic_of_stiffening():
    """Of exp(z |cos|) sgn cos it is 2 (I1(z) + L-1(z)), with Bessel's and Struve's modified functions (DLMF 11.5.4)."""
    A, b, k = 0.9, FUNG["b_x"], FUNG["k_x"]
    motion = sinusoids(A, 1.0, 293.15, 1024)
    first = 2 * np.mean(force_on("exponential_stiffening", FUNG, motion)[0] * motion.y[0] / A)
    expected = k * (2 * (i1(b * A) + modstruve(-1, b * A)) / b - 4 / (np.pi * b) - A)
    assert first == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("y", [0.01, 0.1, -0.8, 7.0, -9.0, 1e6])
def test_stiffening_stores_its_work(y):
    """Its force is the slope of what is stored, straight on beyond 30/b, and finite for any displacement."""
    width = 1e-4 * abs(y)
    ahead, behind = stored("exponential_stiffening", FUNG, [y + width, y - width])
    assert (ahead - behind) / (2 * width) == pytest.approx(at("exponential_stiffening", FUNG, y)[0], rel=1e-5, abs=1e-7)
    assert np.isfinite(ahead)


GAS = {"F_g": 500.0, "q_g": 0.4, "n_g": 1.3}


@pytest.mark.parametrize("n", [1.0, 1.3, 1.4, 1.8])
def test_gas_is_compressed_along_a_polytrope(n):
    """Bauer: p V^n stays; the spring's force is the change of pressure times area."""
    y = np.array([-5.0, -0.5, 0.0, 0.5, 1.5, 2.2])
    area, pressure, length = 20.0, 25.0, 2.5
    volume = area * (length - y)
    expected = area * (pressure * (area * length / volume) ** n - pressure)
    np.testing.assert_allclose(at("gas_spring", GAS | {"n_g": n}, y), expected, rtol=1e-12, atol=1e-9)
    turned = at("gas_spring", GAS | {"n_g": n, "q_g": -0.4}, -y)
    np.testing.assert_allclose(turned, expected, rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize(("n", "tolerance"), [(1.0, 1e-9), (1 + 0.99e-6, 1e-9), (1 + 1.01e-6, 1e-8), (1.3, 1e-12)])
def test_the_work_of_compression(n, tolerance):
    """Isothermal p V ln(V/V1), polytropic p V/(n - 1) ((V/V1)^(n - 1) - 1), less the work on the preload."""
    y, length, preload = np.array([-0.8, 0.3, 1.5]), 2.5, 500.0
    ratio = length / (length - y)
    of_gas = np.log(ratio) if n == 1.0 else np.expm1((n - 1) * np.log(ratio)) / (n - 1)
    expected = preload * (length * of_gas - y)
    np.testing.assert_allclose(stored("gas_spring", GAS | {"n_g": n}, y), expected, rtol=tolerance)


def test_stiffness_in_the_middle_is_n_p_area_over_the_length():
    """Quaglia and Sorli: k = n p S/H."""
    slope = np.diff(at("gas_spring", GAS, [-1e-6, 1e-6]))[0] / 2e-6
    assert slope == pytest.approx(1.3 * 500.0 * 0.4, rel=1e-6)


@pytest.mark.parametrize("y", [2.4499, 2.4501, 2.5, 100.0, 1e9, -1e9])
def test_gas_goes_straight_on_at_the_end_of_its_column(y):
    """From a fiftieth of the column on, with the slope that it has there; never below -F_g on the long side."""
    force = at("gas_spring", GAS, y)[0]
    assert np.isfinite(force)
    assert force >= -500.0
    width = 1e-7 * abs(y)
    ahead, behind = stored("gas_spring", GAS, [y + width, y - width])
    assert (ahead - behind) / (2 * width) == pytest.approx(force, rel=2e-4, abs=1e-3)
