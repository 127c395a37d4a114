"""Where a response is unstable is said stretch by stretch: what lies between two of them is stable."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeclamp.pages.system.study import _unstable_words
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.bands.response import banded_system
from pipeclamp_system.response.curves import Curve, FrequencyResponse, stretches
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady.states import FollowedResponse, SteadyState


def states(*frequencies_and_growths):
    still = np.zeros((1, 4), dtype=complex)
    return tuple(
        SteadyState(frequency, still, still, still, np.ones((1, 2)), growth, 0.0, ({},))
        for frequency, growth in frequencies_and_growths
    )


BENT = states((5.0, -1), (7.0, 1), (6.5, 1), (6.0, 1), (8.0, -1), (9.0, -1), (10.0, 1), (11.0, 1), (12.0, -1))


def test_a_stable_stretch_between_two_unstable_ones_is_no_part_of_either():
    def unstable(*pieces):
        return stretches(pieces, lambda state: not state.stable)

    assert unstable(BENT) == [(6.0, 7.0), (10.0, 11.0)]
    assert unstable(BENT, states((6.8, 1), (7.4, 1))) == [(6.0, 7.4), (10.0, 11.0)]
    curve = Curve(None, 1.0, FollowedResponse((BENT,), whole=True))
    said = response_summary(FrequencyResponse("x", ("a",), ("p",), "", (curve,), (), ({},)))
    assert "; unstable from 6 to 7 Hz, from 10 to 11 Hz" in said


def test_where_a_response_was_given_up_the_way_out_is_said():
    pieces = (BENT[:2], BENT[-2:])
    for followed, missing in (
        (FollowedResponse(pieces, whole=False), "between them"),
        (FollowedResponse(pieces[:1], whole=False), "beyond"),
    ):
        curve = Curve(None, 1.0, followed)
        said = response_summary(FrequencyResponse("x", ("a",), ("p",), "", (curve,), (), ({},)))
        assert f"only: what lies {missing} is missing; run sines there in time by `pipeclamp cosim`" in said


def test_where_harmonics_are_left_out_is_told_stretch_by_stretch():
    left_out = [replace(one, truncated=0.02 if one.frequency in (5.0, 12.0) else 0.001) for one in BENT]
    curve = Curve(None, 1.0, FollowedResponse((tuple(left_out),), whole=True))
    said = response_summary(FrequencyResponse("x", ("a",), ("p",), "", (curve,), (), ({},)))
    assert "more than 1% at 5 Hz, at 12 Hz: " in said


def test_no_band_is_given_of_a_motion_that_nothing_damps():
    """A clamp without damping on a pipe without had a band up to 7e28 mm."""
    curve = Curve(None, 1.0, FollowedResponse((states((5.0, -1), (6.0, 1e-9), (7.0, -1e-9)),), whole=True))
    with pytest.raises(UserError, match=r"nothing damps its motion from 6 to 7 Hz.*\[damping\]"):
        banded_system(Path("system.toml"), FrequencyResponse("x", ("a",), ("p",), "", (curve,), (), ({},)))


def test_cases_that_nothing_damps_are_not_called_unstable():
    assert _unstable_words(pl.DataFrame({"stable": [None, 0.0, None, 1.0]})) == [
        "not stable: 1 case",
        "neither stable nor unstable, as nothing damps it: 2 cases",
    ]
    assert _unstable_words(pl.DataFrame({"stable": [1.0]})) == []
