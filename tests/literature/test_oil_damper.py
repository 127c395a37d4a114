"""An oil damper: Maxwell's element where it is linear, its dashpot where the oil is stiff, any other by small steps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import gamma

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)
LINEAR = {"k_oil": 700.0, "F_oil": 300.0, "v_oil": 9.0, "a_oil": 1.0, "p_oil": 1.0}
RELIEVED = LINEAR | {"k_oil": 3000.0, "a_oil": 0.6, "p_oil": 0.15}


def force_on(values, motion):
    """Force of a clamp that has nothing but this effect."""
    equations = Structure("power", ("oil_damper",)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force


def lost(motion, force):
    """Energy lost in each cycle, N mm."""
    moves = np.roll(motion.y, -1, axis=1) - motion.y
    return np.sum((np.roll(force, -1, axis=1) + force) / 2 * moves, axis=1)


def test_it_is_maxwells_element_where_it_is_linear():
    """Ferry: storage k (w tau)^2/(1 + (w tau)^2) and loss k w tau/(1 + (w tau)^2), tau = F/(v k)."""
    tau = 300.0 / 9.0 / 700.0
    turn = 10.0 ** np.linspace(-1.0, 1.0, 9)
    motion = sinusoids(0.8, turn / (2 * np.pi * tau), 293.15, 2048)
    found = np.fft.rfft(force_on(LINEAR, motion))[:, 1] / np.fft.rfft(motion.y)[:, 1]
    np.testing.assert_allclose(found, 700.0 * 1j * turn / (1 + 1j * turn), rtol=3e-4)


@pytest.mark.parametrize("exponent", [0.3, 0.6, 1.0, 1.8])
def test_of_stiff_oil_the_dashpot_is_left(exponent):
    """Fluid dampers: c |v|^a loses 4 2^a Gamma(1 + a/2)^2/Gamma(2 + a) c A (w A)^a a cycle."""
    motion = sinusoids(1.0, 1.0, 293.15, 4096)
    values = LINEAR | {"k_oil": 1e6, "F_oil": 100.0, "v_oil": 20.0, "a_oil": exponent}
    expected = 4 * 2**exponent * gamma(1 + exponent / 2) ** 2 / gamma(2 + exponent) * 100 * (2 * np.pi / 20) ** exponent
    assert lost(motion, force_on(values, motion))[0] == pytest.approx(expected, rel=3e-3)


def test_of_stiff_oil_the_valve_is_left():
    """Kasai and Nishimura: c1 v up to F_r, beyond it F_r + p c1 (v - v_r)."""
    motion = sinusoids(1.0, 5.0, 293.15, 4096)
    force = force_on(LINEAR | {"k_oil": 1e6, "p_oil": 0.1}, motion)[0]
    mean = np.roll(motion.v[0], 1) / 2 + motion.v[0] / 2
    c1 = 300.0 / 9.0
    slow = np.clip(mean, -9.0, 9.0)
    np.testing.assert_allclose(force, c1 * (slow + 0.1 * (mean - slow)), atol=3.0)


def by_small_steps(values, A, f, times):
    """Force by an implicit integrator of high order, in the third cycle."""
    k, F, v, a, p = (values[f"{name}_oil"] for name in "kFvap")

    def speed(force):
        load = abs(force) / F
        return np.sign(force) * v * (min(load, 1.0) ** (1 / a) + max(load - 1, 0.0) / (p * a))

    def rate(t, q):
        return [k * (-2 * np.pi * f * A * np.sin(2 * np.pi * f * t) - speed(q[0]))]

    solution = solve_ivp(rate, (0, 3 / f), [0.0], "Radau", 2 / f + times, rtol=1e-8, atol=1e-5 * F, max_step=5e-3 / f)
    return solution.y[0]


@pytest.mark.parametrize(
    ("changed", "tolerance"),
    [({}, 1e-3), ({"k_oil": 600.0}, 3e-4), ({"a_oil": 1.8}, 1e-3), ({"a_oil": 0.3, "p_oil": 0.05}, 1.5e-3)],
)
def test_any_other_within_the_stated_tolerance(changed, tolerance):
    """512 steps a cycle: 0.1 % of the force (rms) while the spring gives by more than 2 % of the stroke."""
    values = RELIEVED | changed
    motion = sinusoids(0.8, 2.0, 293.15, 512)
    expected = by_small_steps(values, 0.8, 2.0, np.arange(512) / 1024)
    error = force_on(values, motion)[0] - expected
    assert np.sqrt(np.mean(error**2)) < tolerance * np.sqrt(np.mean(expected**2))


def test_it_never_overshoots_however_stiff():
    """A step at one speed ends between where it began and the force that the dashpot holds at that speed."""
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    y = np.array([[0.5, 1.0, 1.5, 1.0, 0.5, 0.5]])
    for stiffness in (1.0, 1e3, 1e6, 1e12):
        for exponent in (0.2, 1.0, 2.0):
            values = LINEAR | {"k_oil": stiffness, "a_oil": exponent, "p_oil": 0.3}
            motion = Motion(y, 0 * y, 0 * y, slow, np.array([[0.1]]), periodic=False)
            force = force_on(values, motion)[0]
            assert np.abs(force).max() <= 300.0 * (5 / 9) ** exponent * (1 + 1e-12)
            assert force[0] > 0
            assert abs(force[-1]) <= abs(force[-2])
