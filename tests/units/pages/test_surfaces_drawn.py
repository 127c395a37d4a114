"""Surfaces of a law's page: over each condition that a coefficient follows, and over no other."""

import pytest

from pipeclamp.pages.law import surface_pictures
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of

FILE = open_law("emwm2")


def titles(**values):
    entries = {
        name: entry.model_copy(update={"value": values.get(name, entry.value)})
        for name, entry in FILE.coefficients.items()
    }
    file = FILE.model_copy(update={"coefficients": entries})
    return {figure.layout.title.text for figure in surface_pictures(law_of(file), file)}


@pytest.mark.parametrize(
    ("values", "drawn", "not_drawn"),
    [
        ({"k1_A": -0.2, "k1_T": 0.5}, "k1(A, T)", "k1(f)"),
        ({"k_f": 0.0}, "k1(A, T)", "k1(T, f)"),
        ({"k1_A": -3e-7, "k1_T": 0.5}, "k1(T, f)", "k1(A, f)"),
    ],
)
def test_what_a_coefficient_hardly_follows_is_not_drawn(values, drawn, not_drawn):
    """A stiffness of 3e-13 N/mm had been drawn with an axis from 316.56744f to 316.56754f."""
    found = titles(**values)
    assert drawn in found and not_drawn not in found


def test_temperatures_are_drawn_as_tests_state_them():
    pictures = surface_pictures(law_of(FILE), FILE)
    told = [axis.title.text for one in pictures for axis in (one.layout.xaxis, one.layout.yaxis)]
    assert {words for words in told if words.startswith("T")} == {"T / °C"}
    (over,) = [one.data[0].y for one in pictures if one.layout.title.text == "k1(A, T)"]
    assert (min(over), max(over)) == pytest.approx((20.0, 300.0), abs=1.0)
