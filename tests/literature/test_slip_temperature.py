"""Slip forces over temperature, of elements of every kind, against the same elements at their other slip force."""

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import sinusoids

SLOPE, BEND = -0.3, 0.1
ELEMENTS = {
    "memory": {"k_s": 900.0, "z_s": 120.0},
    "bouc_wen": {"k_b": 900.0, "z_b": 120.0, "n_b": 2.0, "p_b": 0.4, "w_b": 0.3},
    "self_centring": {"k_c": 900.0, "F_u": 120.0, "beta_c": 0.6},
}
SLIP_FORCE = {"memory": "z_s", "bouc_wen": "z_b", "self_centring": "F_u"}


def force_at(temperature, effects, values):
    """Force of a clamp that has nothing but effects."""
    equations = Structure("power", effects).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    motion = sinusoids(np.array([0.2, 1.0]), np.array([2.0, 2.0]), temperature, 256)
    return force_of_equations(equations, [given[name] for name in equations.names], (0.01, 0.001), motion).force


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("temperature", [253.15, 293.15, 493.15])
def test_it_is_the_same_element_at_another_slip_force(element, temperature):
    values, slip = ELEMENTS[element], SLIP_FORCE[element]
    t = (temperature - 293.15) / 100
    other = values | {slip: values[slip] * np.exp(SLOPE * t + BEND * t**2)}
    followed = force_at(temperature, (element, "slip_temperature"), values | {"z_T1": SLOPE, "z_T2": BEND})
    np.testing.assert_allclose(followed, force_at(293.15, (element,), other), rtol=1e-9, atol=1e-9 * values[slip])
