"""Time-temperature superposition (Ferry 1980): a loop at another temperature is the one at T0 and another frequency."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import sinusoids

C1, C2 = 8.86, 101.6
"""Of Williams, Landel and Ferry (1955), C2 in K, where T0 lies 50 K above the glass transition."""
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
    above = temperature - 293.15
    shift = 10 ** (-C1 * above / (C2 + above))
    followed = {"r_T1": -100 * np.log(10) * C1 / C2, "w_T": C2, "T_r": 293.15}
    warm = force_at(temperature, 2.0, (arms, "relaxation_temperature"), ARMS[arms] | followed)
    np.testing.assert_allclose(warm, force_at(293.15, 2.0 * shift, (arms,), ARMS[arms]), rtol=1e-9, atol=1e-9)
