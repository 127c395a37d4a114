"""Viscoelasticity whose complex stiffness is known in closed form: a springpot in series with a spring."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion, sinusoids

SMOOTHING = (0.01, 0.001)
K, TAU = 700.0, 0.05


def force_on(effect, values, motion):
    """Force of a clamp that has nothing but this effect."""
    equations = Structure("power", (effect,)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], SMOOTHING, motion).force


def complex_stiffness(beta, decades):
    """The complex stiffness at w tau = 10^decades, from the force on A cos w t."""
    motion = sinusoids(0.8, 10.0**decades / (2 * np.pi * TAU), 293.15, 1024)
    force = force_on("relaxation_spread", {"k_r": K, "tau_r": TAU, "beta_r": beta}, motion)
    return np.fft.rfft(force)[:, 1] / np.fft.rfft(motion.y)[:, 1]


@pytest.mark.parametrize("beta", [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
def test_the_arms_are_a_springpot_in_series_with_a_spring(beta):
    """Koeller: k (i w tau)^beta / (1 + (i w tau)^beta); with beta = 1 Maxwell's, but for the steps' straight lines."""
    decades = np.linspace(-1.5, 1.5, 31)
    turn = (1j * 10.0**decades) ** beta
    exact = K * turn / (1 + turn)
    error = np.abs(complex_stiffness(beta, decades) - exact) / np.abs(exact)
    middle = np.abs(decades) <= 1.0
    assert error[middle].max() < (2e-4 if beta == 1.0 else 0.04)
    assert error.max() < (2e-4 if beta == 1.0 else 0.075)


def test_storage_and_loss_modulus_of_maxwells_element():
    """Ferry: k (w tau)^2/(1 + (w tau)^2) and k w tau/(1 + (w tau)^2)."""
    motion = sinusoids(0.8, 10.0 ** np.linspace(-1.0, 1.0, 9) / (2 * np.pi * TAU), 293.15, 2048)
    force = force_on("relaxation", {"k_m": K, "tau": TAU}, motion)
    found = np.fft.rfft(force)[:, 1] / np.fft.rfft(motion.y)[:, 1]
    turn = 10.0 ** np.linspace(-1.0, 1.0, 9)
    np.testing.assert_allclose(found.real, K * turn**2 / (1 + turn**2), rtol=1e-5, atol=1e-4 * K * 0.01)
    np.testing.assert_allclose(found.imag, K * turn / (1 + turn**2), rtol=1e-5)


def test_the_loss_factor_of_a_springpot_hardly_changes_with_frequency():
    """Below 1/tau it falls by a fifth over a factor of four in frequency, where one relaxation time gives four."""
    found = complex_stiffness(0.4, np.array([-1.2, -0.6]))
    loss = found.imag / found.real
    turn = (1j * 10.0 ** np.array([-1.2, -0.6])) ** 0.4
    exact = (turn / (1 + turn)).imag / (turn / (1 + turn)).real
    np.testing.assert_allclose(loss, exact, rtol=0.08)
    assert 1.0 < loss[0] / loss[1] < 1.5


def test_all_arms_are_there_at_once():
    """A sudden step meets the whole stiffness, k_r; long after it nothing is left."""
    slow = {name: np.array([[value]]) for name, value in (("A", 1.0), ("f", 1.0), ("T", 293.15))}
    y = np.array([[1e-2, 1e-2, 1e-2]])
    values = {"k_r": K, "tau_r": TAU, "beta_r": 0.5}
    for h, expected in ((1e-9, K * 1e-2), (1e9, 0.0)):
        motion = Motion(y, 0 * y, 0 * y, slow, np.array([[h]]), periodic=False)
        assert force_on("relaxation_spread", values, motion)[0, -1] == pytest.approx(expected, rel=1e-3, abs=1e-6)
