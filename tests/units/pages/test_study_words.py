"""A study's page says what is varied in words with units, not as keys of a description."""

import pytest

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
