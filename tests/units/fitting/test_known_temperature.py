"""Temperatures that some runs lack are told by run, not by each of a run's cycles."""

import numpy as np
import pytest

from pipeclamp_identification.fitting.observations import known_temperature
from pipeclamp_models.base.errors import UserError


def test_a_run_of_several_rows_is_named_once():
    with pytest.raises(UserError, match=r"known for 1 of 2 runs only, not for b; fill in temperature_C"):
        known_temperature(np.array([293.15, np.nan, np.nan, np.nan]), ["a", "b", "b", "b"])
