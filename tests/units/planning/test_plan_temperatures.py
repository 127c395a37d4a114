"""Temperatures of planned tests are those that a chamber is set to, not the kelvins that a law's file is rounded to."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_identification.planning.loop_tests import reach_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Interval
from pipeclamp_models.law.range import celsius_tested, intervals_of


@pytest.mark.parametrize(
    ("tested", "planned"),
    [((0.0, 80.0), (0, 80)), ((20.22, 60.23), (20, 60)), ((23.0, 23.0), (23, 23)), ((-40.0, -40.0), (-40, -40))],
)
def test_tests_are_planned_at_whole_degrees(tested, planned):
    """Of tests at 0 to 80 degC one had been planned at -0.15 degC, and another at 80.8."""
    file = open_law("emwm2")
    T = intervals_of({"T": np.array(tested) + 273.15})["T"]
    file = file.model_copy(update={"range": {**file.range, "T": T}})
    assert reach_of(file, None, 20.0).temperature == planned


def test_a_range_without_a_whole_degree_keeps_its_ends():
    assert celsius_tested(Interval(minimum=293.45, maximum=293.85, unit="K")) == pytest.approx((20.3, 20.7))
