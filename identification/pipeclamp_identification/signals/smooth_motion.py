"""Displacement, velocity and acceleration of any recorded motion, without the noise of its sensor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray

EVEN_SHARE = 0.01
"""Share of a step by which times may miss an even grid: clocks are written with a few digits."""
TIMES_SAMPLES = 4
"""An uneven record is put on a grid of its usual step, of at most so many times its own samples."""
TRIED = 60
"""Cut-offs that are tried, so many over all orders: neighbours differ little in what they leave."""
MOTION_STANDARD_ERRORS = 3.0
"""Standard errors below which a velocity is no motion."""


@dataclass(frozen=True)
class SmoothMotion:
    """A motion on an even grid of n points, from a record's first sample to its last.

    Attributes:
        time: s, shape (n,).
        y, v, a: displacement mm, velocity mm/s, acceleration mm/s2; shape (n,) each.
        noise_mm: rms of what was taken for noise of the displacement.
    """

    time: Array
    y: Array
    v: Array
    a: Array
    noise_mm: float

    @property
    def step(self) -> float:
        """Seconds between points."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))

    @property
    def amplitude(self) -> float:
        """Amplitude of the sine of equal variance, mm."""
        return float(np.sqrt(2) * np.std(self.y))

    @property
    def frequency(self) -> float:
        """Frequency of the sine of equal variance of displacement and velocity, Hz."""
        return float(np.sqrt(np.mean(self.v**2)) / np.std(self.y) / (2 * np.pi))


def smooth_motion(time: Array, displacement: Array) -> SmoothMotion:
    """Smooth a record's displacement and differentiate it.

    The straight line between its ends aside, the motion is a series of sines (no jump and no corner at the ends, also
    where it begins or ends in motion), each left by 1/(1 + (k/K)^4), as a cubic smoothing spline leaves it. K has the
    least generalised cross-validation: the error that each sample would be predicted with from the others (Craven and
    Wahba, Numerische Mathematik 31, 1979). Velocities within `MOTION_STANDARD_ERRORS` of 0 fade to 0: in a
    record's quiet parts noise has no direction.

    Args:
        time: s, not falling, shape (N,), N >= 4.
        displacement: mm, shape (N,).
    """
    grid, y = _on_grid(time, displacement)
    points = len(grid)
    h = (grid[-1] - grid[0]) / (points - 1)
    order = np.arange(1, points - 1, dtype=np.float64)
    gain, noise = _smoothing(order, np.abs(_sines(y, y[0], y[-1])) ** 2)
    first, last = _ends(y, gain)
    series = _sines(y, first, last)
    slope = (last - first) / (grid[-1] - grid[0])
    line = first + slope * (grid - grid[0])
    omega = np.pi * order / ((points - 1) * h)

    def back(factor: Array) -> Array:
        whole = np.concatenate([[0.0], factor * gain * series, [0.0]])
        return np.asarray(np.fft.irfft(whole, 2 * (points - 1))[:points])

    length = 2.0 * (points - 1)
    v = back(1j * omega) + slope
    v_error = float(np.sqrt(2 * noise * np.sum((omega * gain) ** 2))) / length
    v = v * np.maximum(1 - (MOTION_STANDARD_ERRORS * v_error / np.maximum(np.abs(v), 1e-300)) ** 2, 0.0)
    noise_mm = float(np.sqrt(2 * noise * len(order))) / length
    return SmoothMotion(grid, line + back(np.ones_like(omega)), v, back(-(omega**2)), noise_mm)


def _on_grid(time: Array, displacement: Array) -> tuple[Array, Array]:
    """Give an even grid and the displacement on it."""
    count = len(time)
    even = np.linspace(time[0], time[-1], count)
    if np.max(np.abs(time - even)) <= EVEN_SHARE * (even[1] - even[0]):
        return even, displacement
    usual = float(np.median(np.diff(time)))
    shortest = float(even[1] - even[0]) / TIMES_SAMPLES
    points = round(float(time[-1] - time[0]) / max(usual, shortest)) + 1
    grid = np.linspace(time[0], time[-1], max(points, count))
    return grid, np.interp(grid, time, displacement)


def _sines(y: Array, first: float, last: float) -> ComplexArray:
    """Give the series of sines of what the line from the first to the last value leaves of samples, (n - 2,)."""
    left = y - np.linspace(first, last, len(y))
    left[[0, -1]] = 0.0
    return np.asarray(np.fft.rfft(np.concatenate([left, -left[-2:0:-1]]))[1:-1])


def _ends(y: Array, gain: Array) -> tuple[float, float]:
    """Give the values at both ends by straight lines over half a wave of the cut-off: single samples hold noise."""
    span = min(len(y) // max(int(np.count_nonzero(gain > 0.5)), 1), len(y) // 4)
    if span < 3:
        return float(y[0]), float(y[-1])
    at = np.arange(span)
    return float(np.polyfit(at, y[:span], 1)[1]), float(np.polyfit(at, y[::-1][:span], 1)[1])


def _smoothing(order: Array, power: Array) -> tuple[Array, float]:
    """Give the gain of each order, and the power of the noise in one order."""
    count = len(order)
    fourth = (order / count) ** 4
    best = (np.inf, np.ones(count), 0.0)
    for cut in np.geomspace(1.0 / count, TIMES_SAMPLES, TRIED):
        gain = 1 / (1 + fourth / cut**4)
        lost = 1 - gain
        left, free = float(np.sum(lost**2 * power)), float(np.sum(lost))
        if free > 0.0 and left / free**2 < best[0]:
            best = (left / free**2, gain, left / free)
    return best[1], best[2]
