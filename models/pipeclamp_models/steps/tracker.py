"""Amplitude and frequency of any motion, followed sample by sample from what has passed of it, in mm, s and Hz.

The one place of these equations in Python: records are followed by them, and the clamp's Python FMU inlines them, so
standard library only (`native/c/clamp.c` is its counterpart in C).
"""

from __future__ import annotations

import math

AVERAGING = 1.5
"""Time constant of each of the tracker's two averages, in periods of the frequency in use."""

SLACK = 1e-9
"""Share by which a value may pass the end of its range: rounding of units, not more."""

RIPPLE = 0.01
"""And by which A and f may where they are followed: of a sine they go to and fro by half of it, by the averages' own
ripple, so that a law from tests at one frequency would hardly ever be in its range."""

Interval = tuple[float, float]


def held(value: float, interval: Interval) -> float:
    """Give the nearest value in the range."""
    return min(max(value, interval[0]), interval[1])


def start_tracking(A: float, f: float) -> tuple[float, ...]:
    """Give the averages of y, y^2 and v^2 (two stages each) of a sinusoid of this amplitude (mm) and frequency (Hz)."""
    square = A * A / 2
    speed = (2 * math.pi * f) ** 2 * square
    return (0.0, 0.0, square, square, speed, speed)


def track_motion(averages: tuple[float, ...], share: float, y: float, v: float) -> tuple[float, ...]:
    """Move the averages towards the present motion: two one-pole filters in a row, of the same share per step."""
    mean1, mean, square1, square, speed1, speed = averages
    mean1 += share * (y - mean1)
    square1 += share * (y * y - square1)
    speed1 += share * (v * v - speed1)
    return (
        mean1,
        mean + share * (mean1 - mean),
        square1,
        square + share * (square1 - square),
        speed1,
        speed + share * (speed1 - speed),
    )


def amplitude_and_frequency(averages: tuple[float, ...], frequency: float, smallest: float) -> tuple[float, float]:
    """Give A (mm) and f (Hz) of the sinusoid that has these averages; without motion the frequency stays.

    Motion is what is not many times smaller than the law's smallest amplitude (mm).

    A = sqrt(2 var), 2 pi f = sqrt(<v^2>/var), var = <y^2> - <y>^2. All three averages are filtered alike, so that the
    ripple of the mean under an offset cancels in var.
    """
    _, mean, _, square, _, speed = averages
    variance = square - mean * mean
    if variance <= (SLACK * smallest) ** 2:
        return 0.0, frequency
    return math.sqrt(2 * variance), math.sqrt(speed / variance) / (2 * math.pi)


def tracked(
    averages: tuple[float, ...], step: float, frequency: float, ranges: tuple[Interval, ...], y: float, v: float
) -> tuple[float, float, tuple[float, ...]]:
    """Give A (mm) and f (Hz) after a step, before they are held inside the law's range, and the averages.

    Args:
        averages: before the step.
        step: its duration, s.
        frequency: f before the step, Hz.
        ranges: the law's range of A (mm) and f (Hz), and of what follows.
        y, v: displacement (mm) and velocity (mm/s) at its end.
    """
    periods = step * held(frequency, ranges[1])
    averages = track_motion(averages, -math.expm1(-periods / AVERAGING), y, v)
    return (*amplitude_and_frequency(averages, frequency, ranges[0][0]), averages)
