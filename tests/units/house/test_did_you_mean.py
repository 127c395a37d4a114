"""Which known name is asked about where another was written."""

import pytest

from pipeclamp_models.base.errors import did_you_mean
from pipeclamp_models.law.catalogue import identifiers

COLUMNS = ("run", "file", "amplitude_mm", "frequency_Hz", "temperature_C")


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("memroy", "memory"),
        ("boucwen", "bouc_wen"),
        ("spread", "slip_spread"),
        ("cubic", "cubic_stiffness"),
    ],
)
def test_a_name_that_is_spelled_nearly_so_or_abbreviated_is_asked_about(written, meant):
    assert did_you_mean(written, identifiers()) == f"did you mean {meant!r}? "


@pytest.mark.parametrize("written", ["hysteresis", "fractional", "inelastic creep", "s", "nonlinear"])
def test_a_name_that_is_not_near_is_not_asked_about(written):
    """'hysteresis' had been answered with 'elastic_series'."""
    assert did_you_mean(written, identifiers()) == ""


@pytest.mark.parametrize(("written", "meant"), [("freq", "frequency_Hz"), ("TEMP", "temperature_C"), ("fil", "file")])
def test_abbreviated_columns_are_asked_about(written, meant):
    assert did_you_mean(written, COLUMNS) == f"did you mean {meant!r}? "


def test_several_may_be_asked_about():
    assert did_you_mean("damping_temp", ("damping_temperature", "damping_series"), most=3).count("'") >= 4
