"""Drifts over load cycles: none that was over before the tests began."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_models.law.catalogue import find_effect
from pipeclamp_models.realise.motion import sinusoids
from pipeclamp_models.realise.sizes import data_sizes, number_of

LENGTHS = {"fade": "N_d", "loosening": "N_l"}


def shortest(effect, cycles):
    """Give the shortest drift that may be fitted to runs at load cycles, or to runs of which they aren't known."""
    motion = sinusoids(np.ones(3), 1.0, 293.15)
    if cycles is not None:
        motion = replace(motion, slow={**motion.slow, "N": np.array(cycles)[:, None]})
    parameter = next(one for one in find_effect(effect).parameters if one.name == LENGTHS[effect])
    return number_of(parameter.lower, data_sizes(motion, np.ones(3)))


@pytest.mark.parametrize("effect", LENGTHS)
def test_no_drift_is_over_before_the_tests_begin(effect):
    assert shortest(effect, (2.6, 3.6, 900.0)) == 2.6
    assert shortest(effect, (0.0, 40.0, 80.0)) == 0.5
    assert shortest(effect, None) == 0.5
