"""Time-temperature superposition (Ferry 1980): a loop at another temperature is the one at T0 and another frequency."""

import numpy as np
import pytest
from effects_alone import force_of_effects

from pipeclamp_models.realise.motion import sinusoids

C1, C2 = 8.86, 101.6
"""Of Williams, Landel and Ferry (1955), C2 in K, where T0 lies 50 K above the glass transition."""
ARMS = {
    "relaxation": {"k_m": 300.0, "tau": 0.05},
    "relaxation_spread": {"k_r": 300.0, "tau_r": 0.05, "beta_r": 0.4},
}


def force_at(temperature, frequency, effects, values):
    """Force of a clamp that has nothing but effects, at phases of the cycle."""
    return force_of_effects(effects, values, sinusoids(np.array([0.5]), np.array([frequency]), temperature, 256))


@pytest.mark.parametrize("arms", ARMS)
@pytest.mark.parametrize("temperature", [263.15, 293.15, 343.15])
def test_a_temperature_is_another_frequency(arms, temperature):
    above = temperature - 293.15
    shift = 10 ** (-C1 * above / (C2 + above))
    followed = {"r_T1": -100 * np.log(10) * C1 / C2, "w_T": C2, "T_r": 293.15}
    warm = force_at(temperature, 2.0, (arms, "relaxation_temperature"), ARMS[arms] | followed)
    np.testing.assert_allclose(warm, force_at(293.15, 2.0 * shift, (arms,), ARMS[arms]), rtol=1e-9, atol=1e-9)
