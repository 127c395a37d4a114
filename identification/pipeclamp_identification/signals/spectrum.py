"""Spectra of records of any length, whose ends don't meet."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pipeclamp_models.base.arrays import Array

LENGTHS = 8
"""Windows that are kept: the records of a campaign have few different lengths."""


def hann_spectrum(samples: Array) -> Array:
    """Give the magnitude of each line of a signal, its mean left aside, through a Hann window.

    Args:
        samples: equally spaced, shape (n,).

    Returns:
        shape (n // 2 + 1,), in the samples' unit times n: lines of 0, 1, 2, ... cycles over n samples.
    """
    return np.abs(np.fft.rfft((samples - np.mean(samples)) * _hann(len(samples))))


@lru_cache(maxsize=LENGTHS)
def _hann(count: int) -> Array:
    window = np.hanning(count)
    window.flags.writeable = False
    return window
