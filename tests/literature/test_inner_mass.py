"""A mass inside on a spring: its closed form, small steps where the flow is turbulent, and its balance of energy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)
K, FREQUENCY, LOSSES = 400.0, 8.0, 0.2
TURN = 2 * np.pi * FREQUENCY
LINEAR = {"k_i": K, "f_i": FREQUENCY, "zeta_i": LOSSES, "b_i": 0.0}


def force_on(values, motion):
    """Force of a clamp that has nothing but this effect."""
    equations = Structure("power", ("inner_mass",)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion)


def test_it_is_an_oscillator_where_it_is_linear():
    """Singh: F/y = k (1 - w_i^2/(w_i^2 - w^2 + 2 i zeta w_i w)), below, at and above the resonance."""
    f = FREQUENCY * np.array([0.1, 0.5, 0.9, 1.0, 1.1, 2.0, 10.0])
    motion = sinusoids(0.8, f, 293.15, 2048)
    found = np.fft.rfft(force_on(LINEAR, motion).force)[:, 1] / np.fft.rfft(motion.y)[:, 1]
    w = 2 * np.pi * f
    expected = K * (1 - TURN**2 / (TURN**2 - w**2 + 2j * LOSSES * TURN * w))
    np.testing.assert_allclose(found, expected, rtol=2e-4, atol=2e-4 * K)


def test_a_thinner_fluid_loses_less_but_where_it_flows_turbulently():
    """`damping_temperature` scales the losses that go with the viscosity, as it does those of an oil damper."""
    equations = Structure("power", ("inner_mass", "damping_temperature")).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | LINEAR | {"b_i": 0.5, "c_T1": -1.2}
    motion = sinusoids(0.8, np.array([4.0, 8.0, 16.0]), 293.15 + 50, 512)
    found = force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force
    thinner = LINEAR | {"b_i": 0.5, "zeta_i": LOSSES * np.exp(-0.6)}
    np.testing.assert_allclose(found, force_on(thinner, motion).force, rtol=1e-9)


@pytest.mark.parametrize(("f", "turbulence"), [(4.0, 0.5), (8.0, 0.5), (8.0, 5.0), (16.0, 2.0)])
def test_turbulent_losses_are_those_of_small_steps(f, turbulence):
    w, A, samples = 2 * np.pi * f, 0.8, 512

    def rate(t, state):
        x, speed = state
        losses = 2 * LOSSES * TURN * speed + turbulence * abs(speed) * speed
        return [speed, TURN**2 * (A * np.cos(w * t) - x) - losses]

    last = np.arange(samples) / samples / f + 40 / f
    found = solve_ivp(rate, (0, last[-1]), [0.0, 0.0], "DOP853", last, rtol=1e-9, atol=1e-9)
    expected = K * (A * np.cos(w * last) - found.y[0])
    force = force_on(LINEAR | {"b_i": turbulence}, sinusoids(A, f, 293.15, samples)).force[0]
    assert np.sqrt(np.mean((force - expected) ** 2)) < 1e-3 * np.sqrt(np.mean(expected**2))


@pytest.mark.parametrize("h", [1e-4, 1e-2, 1.0])
def test_no_step_however_long_creates_energy(h):
    """At rest the spring's and the mass's energy falls in each step; without losses it stays, exactly."""
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    y = np.concatenate([[0.5], np.ones(40)])[None]
    motion = Motion(y, 0 * y, 0 * y, slow, np.array([[h]]), periodic=False)
    for losses, turbulence in ((0.0, 0.0), (LOSSES, 0.0), (0.0, 3.0), (LOSSES, 3.0)):
        found = force_on(LINEAR | {"zeta_i": losses, "b_i": turbulence}, motion)
        q, speed = (np.asarray(state)[0, 1:] for state in found.states)
        energy = q**2 / (2 * K) + K / TURN**2 * speed**2 / 2
        if losses or turbulence:
            assert np.all(np.diff(energy) < 0)
        else:
            np.testing.assert_allclose(energy, energy[0], rtol=1e-12)
