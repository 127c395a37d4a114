"""A measuring chain records sines and motions over time alike, and what it does undoes a wrong record."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from pipeclamp_identification.on_pipe.instrument import Instrument, SensorChannel

STEP = 1e-3
TIME = np.arange(8000) * STEP
MIDDLE = slice(2000, 6000)


@pytest.mark.parametrize(
    "instrument",
    [
        Instrument((("tip", SensorChannel(gain=1.3, phase=0.4, delay=4e-3)),)),
        Instrument((("tip", SensorChannel(phase=pi)),), SensorChannel(phase=-0.7, delay=2e-3)),
    ],
)
def test_a_sine_and_its_record_are_changed_alike(instrument):
    f = 5.0
    factor = instrument.recorded(("tip",), np.ones((1, 1), dtype=complex), np.array([f]), False)[0, 0]
    seen = instrument.recorded_motion(("tip",), np.sin(2 * pi * f * TIME)[:, None], STEP)[:, 0]
    expected = np.imag(factor * np.exp(2j * pi * f * TIME))
    assert seen[MIDDLE] == pytest.approx(expected[MIDDLE], abs=5e-3)


def test_a_wrong_excitation_changes_what_is_divided_by_it():
    twice = Instrument(excitation=SensorChannel(gain=2.0, phase=0.3), frequency=1.1)
    recorded = twice.recorded(("tip",), np.ones((1, 1), dtype=complex), np.array([5.0]), True)[0, 0]
    # Half of what is stated shook it, at 1.1 times the stated frequency, of which the acceleration was made.
    assert recorded == pytest.approx(1.1**2 / 2 * np.exp(-0.3j))
    assert twice.true_drive(True) == pytest.approx(1.1**2 / 2)
