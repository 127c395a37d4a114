"""What slips over temperature, of every kind, against the same elements at their other slip force and stiffness."""

import numpy as np
import pytest
from effects_alone import force_of_effects

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.motion import sinusoids

SLOPE, BEND, SOFTER = -0.3, 0.1, -0.15
ELEMENTS = {
    "memory": {"k_s": 900.0, "z_s": 120.0},
    "bouc_wen": {"k_b": 900.0, "z_b": 120.0, "n_b": 2.0, "s_b": 0.5, "p_b": 0.4, "w_b": 0.3},
    "self_centring": {"k_c": 900.0, "F_u": 120.0, "beta_c": 0.6},
    "slip_spread": {"K_T": 900.0, "F_S": 120.0, "chi": -0.5, "beta_S": 0.3},
    "directional_slip": {"k_d": 900.0, "z_p": 120.0, "z_n": 80.0},
}
SLIP_FORCES = {
    "memory": ("z_s",), "bouc_wen": ("z_b",), "self_centring": ("F_u",), "slip_spread": ("F_S",),
    "directional_slip": ("z_p", "z_n"),
}  # fmt: skip
STIFFNESS = {
    "memory": "k_s", "bouc_wen": "k_b", "self_centring": "k_c", "slip_spread": "K_T", "directional_slip": "k_d",
}  # fmt: skip


def force_at(temperature, effects, values):
    """Force of a clamp that has nothing but effects."""
    return force_of_effects(effects, values, sinusoids(np.array([0.2, 1.0]), np.array([2.0, 2.0]), temperature, 256))


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("temperature", [253.15, 293.15, 493.15])
def test_it_is_the_same_element_at_another_slip_force_and_stiffness(element, temperature):
    values, slips, stiffness = ELEMENTS[element], SLIP_FORCES[element], STIFFNESS[element]
    t = (temperature - 293.15) / 100
    other = values | {slip: values[slip] * np.exp(SLOPE * t + BEND * t**2) for slip in slips}
    other[stiffness] = values[stiffness] * np.exp(SOFTER * t)
    follows = {"z_T1": SLOPE, "z_T2": BEND, "k_zT": SOFTER}
    followed = force_at(temperature, (element, "slip_temperature"), values | follows)
    np.testing.assert_allclose(followed, force_at(293.15, (element,), other), rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize(("element", "softens"), [("memory", True), ("slip_lock", False)])
def test_only_what_sticks_with_a_stiffness_of_its_own_softens(element, softens):
    assert ("k_zT" in Structure("power", (element, "slip_temperature")).equations.names) == softens
