"""The spring that an oil damper or an inner mass is driven through softens with the temperature."""

import numpy as np
import pytest
from effects_alone import force_of_effects

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.motion import sinusoids

SOFTER = -0.6
DRIVEN = {
    "oil_damper": {"k_oil": 500.0, "F_oil": 200.0, "v_oil": 20.0, "a_oil": 0.4, "p_oil": 0.3},
    "inner_mass": {"k_i": 400.0, "f_i": 8.0, "zeta_i": 0.2, "b_i": 0.5},
}
SPRING = {"oil_damper": "k_oil", "inner_mass": "k_i"}


def force_at(temperature, effects, values):
    """Force of a clamp that has nothing but effects."""
    return force_of_effects(effects, values, sinusoids(np.array([0.2, 1.0]), np.array([3.0, 9.0]), temperature, 512))


@pytest.mark.parametrize("driven", DRIVEN)
@pytest.mark.parametrize("temperature", [253.15, 293.15, 393.15])
def test_it_is_the_same_one_with_another_spring(driven, temperature):
    share = np.exp(SOFTER * (temperature - 293.15) / 100)
    other = DRIVEN[driven] | {SPRING[driven]: DRIVEN[driven][SPRING[driven]] * share}
    if driven == "inner_mass":  # its mass and its dashpot stay: k/f^2 and zeta k/f
        other |= {"f_i": other["f_i"] * np.sqrt(share), "zeta_i": other["zeta_i"] / np.sqrt(share)}
    followed = force_at(temperature, (driven, "damping_temperature"), DRIVEN[driven] | {"k_cT": SOFTER})
    np.testing.assert_allclose(followed, force_at(293.15, (driven,), other), rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize(("term", "driven"), [("oil_damper", True), ("inner_mass", True), ("viscous", False)])
def test_only_what_is_driven_through_a_spring_has_one_that_softens(term, driven):
    assert ("k_cT" in Structure("power", (term, "damping_temperature")).equations.names) == driven
