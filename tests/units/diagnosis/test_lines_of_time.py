"""A line that is locked to time is a harmonic of some runs' motions, where it passes for a part of their loops."""

from types import SimpleNamespace

import numpy as np

from pipeclamp_identification.diagnosis.leftover import harmonics_at


def test_the_runs_are_told_of_which_a_line_is_a_harmonic():
    """Mains hum in a clamp's runs at 5 Hz had been told as harmonic 10 and as a line at 50 Hz, and not as the same."""
    f = np.array([1.0, 3.0, 3.01, 5.0, 5.0])
    loops = SimpleNamespace(frequency_Hz=f, cycles=[range(5)] * len(f), force=np.zeros((len(f), 21)))
    assert harmonics_at((49.92,), loops) == [
        "of the runs at 5 Hz it is harmonic 10, and passes for a part of their loops"
    ]
    assert harmonics_at((7.4,), loops) == []
