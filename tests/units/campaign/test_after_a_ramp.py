"""After a short ramp the steady cycles hold none of it, and no force that still remembers it, where they can."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.records import Record

RAMP = 0.7
"""Cycles until the amplitude is reached."""
A, F = 5.0, 1.2


def damper(cycles, rate=500.0, relaxes_in=0.2):
    """Give the record of a dashpot behind a spring, begun at rest, its relaxation time in cycles."""
    time = np.arange(round(cycles / F * rate)) / rate
    grown = np.clip(F * time / RAMP, 0, 1)
    y = A * grown**2 * (3 - 2 * grown) * np.sin(2 * np.pi * F * time)
    force = np.zeros_like(y)
    stays = np.exp(-F / rate / relaxes_in)
    for place in range(1, len(y)):
        force[place] = stays * force[place - 1] + 9000 * (y[place] - y[place - 1])
    return Record(time, y, force)


@pytest.mark.parametrize("cycles", [3.0, 3.37, 3.6, 4.45])
def test_steady_cycles_hold_no_ramp(cycles):
    """Of 3.4 cycles two had begun within the ramp, off by 4 % in displacement and by half in force.

    The ramp draws the frequency that is found at first away, by 0.8 %, and what agreed so roughly passed for steady.
    """
    record = damper(cycles)
    found = find_cycles(record)
    y, phase = record.displacement_mm[found.steady], 2 * np.pi * F * record.time_s[found.steady]
    assert found.frequency_Hz == pytest.approx(F, rel=2e-4)
    assert np.max(np.abs(y - A * np.sin(phase))) < 0.025 * A
    assert found.count == int(cycles - RAMP + 0.02)


@pytest.mark.parametrize("cycles", [3.37, 3.6, 4.45])
def test_what_is_over_of_whole_cycles_goes_at_the_beginning(cycles):
    """The force of the first sample had been a third of what it is a cycle later."""
    record = damper(cycles)
    steady = find_cycles(record).steady
    assert len(record.time_s) - steady.stop <= 1
    later = np.interp(record.time_s[steady.start] + 1 / F, record.time_s, record.force_N)
    assert record.force_N[steady.start] == pytest.approx(later, abs=0.02 * np.ptp(record.force_N))
