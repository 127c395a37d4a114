"""Motions that come round once in several cycles of the sine are told from those that harmonic balance gives."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from pipeclamp_system.cosim.repetition import REPEATING_SHARE, off_a_cycle_before
from pipeclamp_system.response.curves import FrequencyResponse
from pipeclamp_system.response.dots import Dot
from pipeclamp_system.response.summary import response_summary

FREQUENCY = 8.0


@pytest.mark.parametrize("step", [1 / (16 * FREQUENCY), 0.0071, 0.002])
def test_a_subharmonic_is_told_from_harmonics_in_any_step(step):
    time = np.arange(0.0, 10.0, step)
    turn = 2 * pi * FREQUENCY * time
    whole = 2.0 + np.sin(turn) + 0.1 * np.sin(2 * turn + 1)
    assert off_a_cycle_before(time, whole, FREQUENCY) < REPEATING_SHARE / 2
    third = 0.2 * np.sin(turn / 3)  # over a cycle it changes by 2 sin(60 degrees) of its size
    assert off_a_cycle_before(time, np.sin(turn) + third, FREQUENCY) == pytest.approx(
        0.2 * 3**0.5 / 1.04**0.5, rel=0.03
    )
    assert off_a_cycle_before(time, 0 * time, FREQUENCY) == 0.0
    assert off_a_cycle_before(time[time < 0.2], third[time < 0.2], FREQUENCY) == 0.0  # not two cycles


def dot(frequency, found, truncated=1e-4, repeats=True):
    return Dot(None, 1.0, frequency, (found,), (1.0,), truncated, True, 1e-3, True, repeats)


def test_only_motion_that_a_stable_branch_could_hold_is_held_against_it():
    dots = (dot(7.0, 1.003), dot(8.0, 1.2, repeats=False), dot(9.0, 1.0, truncated=None))
    said = response_summary(FrequencyResponse("x", ("clamp1",), (), "", (), dots, ({},)))
    assert "can be trusted (1) differ by at most 0.30%" in said
    assert "1 co-simulations don't repeat from cycle to cycle" in said
    assert "(level 1, 8 Hz)" in said
    assert "1 co-simulations settle where no stable branch was found" in said
    assert "(level 1, 9 Hz)" in said
