"""A study's page says what is varied in words with units, not as keys of a description."""

import numpy as np
import pytest

from pipeclamp.pages.pictures import few
from pipeclamp.pages.system.study import axis_setting, axis_title


@pytest.mark.parametrize(
    ("axis", "title", "told"),
    [
        ("pipe.clamps.clamp1.position_m", "position of clamp1 / m", "position of clamp1 4.5 m"),
        ("system.clamps.*.temperature_C", "temperature of all clamps / °C", "temperature of all clamps 4.5 °C"),
        (
            "system.excitation.acceleration_m_s2",
            "acceleration of excitation / m/s²",
            "acceleration of excitation 4.5 m/s²",
        ),
        ("system.clamps.number", "number of clamps", "number of clamps 4.5"),
    ],
)
def test_what_is_varied_in_words(axis, title, told):
    assert axis_title(axis) == title
    assert axis_setting(axis, 4.5) == told


def test_cells_have_no_more_digits_than_tell_them_apart():
    """Eight positions from 0.5 to 9.5 m had stood as 1.78571, 3.07143, ... on an axis."""
    assert few(np.linspace(0.5, 9.5, 8))[:3] == ["0.5", "1.79", "3.07"]
    assert few(np.array([20.0, 20.004, 300.0])) == ["20", "20.004", "300"]
