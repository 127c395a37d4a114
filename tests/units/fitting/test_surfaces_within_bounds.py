"""Where the fit of the base law begins: surfaces through the coefficients of the loops, within their bounds."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.fitting.surfaces import _surface


def parameter(name, *follows, most=2.0):
    return SimpleNamespace(name=name, follows=follows, lower=-most, upper=most)


def at(frequencies):
    return {"f": np.array(frequencies, dtype=float)[:, None]}


def test_a_power_of_the_frequency_is_found():
    f = np.array([0.5, 1.0, 4.0])
    found = _surface(300.0 * f**0.7, parameter("c0"), [parameter("c_f", "f")], at(f))
    assert found == pytest.approx({"c0": 300.0, "c_f": 0.7})


@pytest.mark.parametrize("c", [(2.0, 1.0), (1.0, 2.0)])
def test_frequencies_close_together_far_from_the_reference_give_what_was_measured_there(c):
    """Two tests 3 % apart in f and twofold in c have a slope of 23: at 1 Hz a c of 1e40 had been begun with."""
    f = np.array([0.0200, 0.0206])
    found = _surface(np.array(c), parameter("c0"), [parameter("c_f", "f")], at(f))
    assert abs(found["c_f"]) == 2.0
    assert np.exp(np.mean(np.log(found["c0"] * f ** found["c_f"]))) == pytest.approx(np.sqrt(2.0))
