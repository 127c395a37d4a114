"""Amplitude and frequency of a clamp's own motion, cycle by cycle, and how far the force is off if it was told others.

The clamp's slave inlines it; `native/c/own_motion.c` is its counterpart. A step adds to five sums; a reversal of the
motion may end a cycle, and only a cycle under other conditions than the last one costs a comparison of forces.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

LIMIT = 0.05
"""Share of the force by which A and f may be off before it is said: about what two clamps of one make differ by, so
that less than it isn't worth a word, and more is a mistake of the model and not of the clamp."""

OFF_BY = "the force is off by"
"""In the message that says it, and in no other."""

WHOLE = 0.75
"""Periods of its own frequency after which a reversal ends a cycle: half way from half a one."""

LONGEST = 3.0
"""Such periods in a cycle at most: in a longer one the clamp stood still, and its averages mean nothing."""

REST = 0.01
"""Share of the law's smallest amplitude below which a motion passes for rest."""

STEADY = 0.05
"""Share by which A and f of a steady motion change at most from cycle to cycle."""

LASTING = 20
"""Cycles off in a row that are said of a motion that isn't steady; of a steady one two are."""

SAMPLES = 16
"""Of the cycle on which forces are compared: harmonics up to the seventh are seen."""

Cycle = tuple[float, float, float, float]
"""What has passed of a cycle: time (s), integrals of y, y^2, v^2 over it (mm, s)."""

BEGIN: Cycle = (0.0, 0.0, 0.0, 0.0)

Seen = tuple[bool, float, float, int, tuple[Any, ...]]
"""Whether a first reversal was seen; A (mm) and f (Hz) of the last cycle; how many in a row were off; what was compared
last, see `compared_already`."""

NOTHING_SEEN: Seen = (False, 0.0, 0.0, 0, ())


def ended(cycle: Cycle, before: float) -> tuple[float, float, float] | None:
    """Give A (mm), f (Hz) and mean (mm) of a cycle that ends at this reversal, None where it goes on.

    A = sqrt(2 var y), 2 pi f = sqrt(<v^2>/var y), as the tracker has them. f is 0 where the clamp stood still in it.
    Small reversals within a larger motion end no cycle: one isn't taken for shorter than half the amplitude `before`.
    """
    time, y, square, speed = cycle
    mean = y / time
    variance = square / time - mean * mean
    if variance <= 0.0:
        return None
    amplitude = math.sqrt(2.0 * variance)
    frequency = math.sqrt(speed / (time * variance)) / (2.0 * math.pi)
    periods = time * frequency
    if periods * amplitude < WHOLE * max(amplitude, before / 2.0):
        return None
    return amplitude, (frequency if periods <= LONGEST else 0.0), mean


def near(value: float, other: float, share: float, size: float) -> bool:
    """Tell whether two values differ by no more than a share of a size."""
    return abs(value - other) <= share * size


def compared_already(compared: tuple[Any, ...], A: float, f: float, mean: float, told: tuple[float, ...]) -> bool:
    """Tell whether forces were last compared for these coefficients along this motion, to a fifth of the limit."""
    if not compared:
        return False
    share = 0.2 * LIMIT
    return (
        near(A, compared[0], share, A)
        and near(f, compared[1], share, f)
        and near(mean, compared[2], share, A)
        and bool(told == compared[3])
    )


def force_deviation(
    step: Callable[..., tuple[float, float, tuple[float, ...]]],
    told: tuple[float, ...],
    own: tuple[float, ...],
    rest: tuple[float, ...],
    A: float,
    f: float,
    mean: float,
) -> float:
    """Give the rms difference of the whole force under two sets of coefficients, as a share of the second's rms.

    Along the second cycle from rest of the sinusoid of this amplitude and mean (mm) and frequency (Hz); 0 where the
    law has no value on it.

    Args:
        step: the law's step.
        told: its coefficients for the A and f that the clamp was told.
        own: those for A and f of the motion.
        rest: the law's memory before anything has moved.
        A, f, mean: of the motion.
    """
    h, speed = 1.0 / (SAMPLES * f), 2.0 * math.pi * f * A
    memory_told = memory_own = rest
    y_before = mean
    difference = size = 0.0
    for n in range(1, 2 * SAMPLES + 1):
        theta = 2.0 * math.pi * n / SAMPLES
        y, v = mean + A * math.sin(theta), speed * math.cos(theta)
        force_told, _, memory_told = step(told, memory_told, y_before, y, v, h)
        force_own, _, memory_own = step(own, memory_own, y_before, y, v, h)
        y_before = y
        if n > SAMPLES:
            difference += (force_told - force_own) * (force_told - force_own)
            size += force_own * force_own
    return math.sqrt(difference / size) if size > 0.0 and difference < math.inf else 0.0
