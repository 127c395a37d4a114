"""A speed or an acceleration becomes a displacement: integrated, with what moves slower than the test taken off.

A constant of integration, and what a sensor's zero and noise make of it, are no motion: the mean displacement isn't
known. Of a sine the mean over the period around each sample is taken off, by which no harmonic of it changes; of any
other motion what is slower than a third of the lowest frequency that the force shows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial
from scipy.fft import rfft, rfftfreq
from scipy.interpolate import CubicSpline
from scipy.signal import butter, get_window, sosfiltfilt

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.importing.samples.split import unsteady
from pipeclamp_models.base.arrays import Array

DRIFT_DEGREE = 3
"""Of the polynomial that is taken off first: a zero's error makes a parabola."""
HARMONICS = 5
"""Of a sine, beside which that polynomial is fitted."""
LOWEST_SHARE = 0.1
"""Of the largest line of the force: the lowest one that reaches it is the motion's."""
TAKEN_OFF_SHARE = 1 / 3
"""Of that frequency, below which other motions than sines are taken off."""
FILTER_ORDER = 4


def integrated(record: Record, times: int, *, free: bool = False) -> Record:
    """Give a record whose displacement was its rate: a speed, mm/s, or an acceleration, mm/s2.

    Of a sine half a period at each end is left aside: the mean around its samples isn't known.

    Args:
        record: its samples follow each other in even steps.
        times: that the rate is integrated: 1 or 2.
        free: whether its motion is stated to be no sine.
    """
    time, rate = record.time_s - record.time_s[0], record.displacement_mm
    moved = CubicSpline(time, rate - np.mean(rate)).antiderivative(times)(time)
    frequency = None if free else _frequency_of(record)
    if frequency is None:
        moved = moved - Polynomial.fit(time, moved, DRIFT_DEGREE)(time)
        return replace(record, displacement_mm=_without_slow_motion(time, moved, record.force_N))
    moved = moved - _drift_beside(time, moved, frequency)
    half = 0.5 / frequency
    first, last = np.searchsorted(time, [half, time[-1] - half])
    whole, inner = CubicSpline(time, moved).antiderivative(), time[first:last]
    mean = (whole(inner + half) - whole(inner - half)) * frequency
    return replace(record.part(first, last), displacement_mm=moved[first:last] - mean)


def _frequency_of(record: Record) -> float | None:
    """Give the frequency of a sine, Hz; None where it changes, or the motion is none."""
    try:
        cycles = find_cycles(record)
    except UnusableRecord:
        return None
    return None if unsteady(record.time_s, record.displacement_mm, cycles.steady, cycles.count) else cycles.frequency_Hz


def _drift_beside(time: Array, moved: Array, frequency: float) -> Array:
    """Give the polynomial that is fitted to a motion beside the harmonics of a frequency, Hz."""
    scaled = 2 * time / time[-1] - 1
    slow = np.polynomial.legendre.legvander(scaled, DRIFT_DEGREE)
    turns = np.outer(2 * np.pi * frequency * time, np.arange(1, HARMONICS + 1))
    columns = np.hstack([slow, np.cos(turns), np.sin(turns)])
    found = np.linalg.lstsq(columns, moved, rcond=None)[0]
    return np.asarray(slow @ found[: slow.shape[1]])


def _without_slow_motion(time: Array, moved: Array, force: Array) -> Array:
    """Take off what is slower than the motion, by the lowest frequency of the force."""
    step = float(time[-1]) / (len(time) - 1)
    spectrum = np.abs(rfft((force - np.mean(force)) * get_window("hann", len(force))))[1:]
    lowest = float(rfftfreq(len(force), step)[1:][np.argmax(spectrum >= LOWEST_SHARE * np.max(spectrum))])
    passing = butter(FILTER_ORDER, TAKEN_OFF_SHARE * lowest, "highpass", fs=1 / step, output="sos")
    return np.asarray(sosfiltfilt(passing, moved, padlen=min(len(moved) - 1, round(1 / (lowest * step)))))
