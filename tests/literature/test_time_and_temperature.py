"""Time-temperature superposition (Ferry 1980): a loop at another temperature is the one at T0 and another frequency."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import sinusoids

SLOPE, BEND = -4.0, 1.5
ARMS = {
    "relaxation": {"k_m": 300.0, "tau": 0.05},
    "relaxation_spread": {"k_r": 300.0, "tau_r": 0.05, "beta_r": 0.4},
}


def force_at(temperature, frequency, effects, values):
    """Force of a clamp that has nothing but effects, at phases of the cycle."""
    equations = Structure("power", effects).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    motion = sinusoids(np.array([0.5]), np.array([frequency]), temperature, 256)
    return force_of_equations(equations, [given[name] for name in equations.names], (0.01, 0.001), motion).force


@pytest.mark.parametrize("arms", ARMS)
@pytest.mark.parametrize("temperature", [263.15, 293.15, 343.15])
def test_a_temperature_is_another_frequency(arms, temperature):
    t = (temperature - 293.15) / 100
    shift = np.exp(SLOPE * t + BEND * t**2)
    warm = force_at(temperature, 2.0, (arms, "relaxation_temperature"), ARMS[arms] | {"r_T1": SLOPE, "r_T2": BEND})
    np.testing.assert_allclose(warm, force_at(293.15, 2.0 * shift, (arms,), ARMS[arms]), rtol=1e-9, atol=1e-9)
