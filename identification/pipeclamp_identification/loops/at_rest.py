"""The force before a record's motion begins: what is constant in a loop shows there, too.

In loops that always slip, a constant force and slip forces that differ between the directions are one and the same. At
rest they aren't: there friction holds any force up to its slip force, and a constant one is added to that.
"""

from __future__ import annotations

import math

import numpy as np

from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.records import Record
from pipeclamp_models.base.arrays import Array

NEAR = 0.01
"""Of the amplitude: a record that stays within that of where it begins rests."""
IN_THE_MIDDLE = 0.1
"""Of the amplitude, too: farther from the loop's middle a spring has a force of its own."""
SHORTEST = 0.05
"""Of a period: a sine that is recorded from a turning point on stays so near for less than half as long."""
FEWEST_SAMPLES = 5
"""Of a rest whose force is known."""
DENIED_BY_CHANCE = 1e-3
"""Chance by which forces at rest that hold a constant force spread so little about nought."""


def force_at_rest(record: Record, cycles: Cycles) -> float:
    """Give the mean force in N before the motion of a record begins; nan where it doesn't rest in the loop's middle.

    Args:
        record: of a run.
        cycles: the same record's.
    """
    y = record.displacement_mm
    before = y[: int(cycles.bounds[0])]
    if len(before) < FEWEST_SAMPLES:
        return math.nan
    low, high = float(np.min(y[cycles.steady])), float(np.max(y[cycles.steady]))
    middle, amplitude = (low + high) / 2, (high - low) / 2
    begins = float(np.median(before[:FEWEST_SAMPLES]))
    if abs(begins - middle) > IN_THE_MIDDLE * amplitude:
        return math.nan
    moved = np.abs(before - begins) > NEAR * amplitude
    samples = int(np.argmax(moved)) if moved.any() else len(before)
    if samples < FEWEST_SAMPLES:
        return math.nan
    periods = cycles.frequency_Hz * float(record.time_s[samples - 1] - record.time_s[0])
    return float(np.mean(record.force_N[:samples])) if periods >= SHORTEST else math.nan


def deny_constant_force(rest: Array, mean: Array, error: Array) -> bool:
    """Tell whether forces at rest deny that loops' mean forces are constant ones.

    They do where they lie about nought, much closer than they lie about the mean forces of the same runs (ratio of
    mean squares, Fisher's F): else friction would have to hold, in each test, what cancels the constant force.

    Args:
        rest: `force_at_rest` of each run, N, shape (R,); nan where it isn't known.
        mean: of its loop, N, shape (R,).
        error: standard error of that, N, shape (R,); infinite where the mean isn't known.
    """
    known = np.isfinite(rest) & np.isfinite(error)
    runs = int(np.count_nonzero(known))
    about_nought = float(np.sum(rest[known] ** 2 + error[known] ** 2))
    about_means = float(np.sum((rest[known] - mean[known]) ** 2))
    if about_means <= about_nought:  # as where no run begins at rest; commands that need none don't load SciPy
        return False
    from scipy.special import fdtrc

    ratio = about_means / about_nought if about_nought else math.inf
    return bool(fdtrc(runs, runs, ratio) < DENIED_BY_CHANCE)
