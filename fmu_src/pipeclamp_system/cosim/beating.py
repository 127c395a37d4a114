"""Beats: under a sine an amplitude may swing to and fro for ever, because a clamp's law follows it with a delay.

A law whose stiffness hangs on A steeply makes a loop of pipe, tracker and law, which needn't be stable where the clamp
itself is. What the clamp would do tells a run in which its A and f stand still.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeclamp_models.base.arrays import Array

SWINGS = 0.02
"""Share of its mean by which an amplitude must go to and fro in the last fifth (or two fifths) of a run to count."""
LASTS = 0.8
"""Of the swing in as long a part before, that must be left in the last one: less is a transient that dies out."""
FEWEST_CYCLES_THAT_SWING = 5
"""Of the excitation in a fifth of the run, that show a swing."""


@dataclass(frozen=True)
class Swing:
    """How an amplitude goes to and fro.

    Attributes:
        low, high: amplitude in single cycles over the last two fifths, or four fifths, of a run, in the signal's unit.
        period: s, from high to high; None where it isn't told.
    """

    low: float
    high: float
    period: float | None


@dataclass(frozen=True)
class Beats:
    """A swing of a clamp whose law is tracked, and whether it is the tracker's doing.

    Attributes:
        name: of the clamp that swings most.
        swing: its displacement's, m.
        held_at: amplitude at which its law was held in the last of further runs, m.
        settles_at: amplitude that the clamp then comes to, m; None where it swings then too, or that run fails.
        solved: whether that is the amplitude that the law was held at.
        failed: why the run with A held gave nothing; None where it gave a motion.
        held_motion: time, s, and the clamp's displacement, m, of that run, (2, n); None where it failed.
    """

    name: str
    swing: Swing
    held_at: float
    settles_at: float | None
    solved: bool = False
    failed: str | None = None
    held_motion: Array | None = None


def swing_of(time: Array, signal: Array, frequency: float) -> Swing | None:
    """Give how the amplitude of a signal goes to and fro at the end of a run; None where it settles, or dies down.

    Args:
        time: s, (n,).
        signal: (n,).
        frequency: of the excitation, Hz.
    """
    for share in (0.2, 0.4):
        found = _swing_in(time, signal, frequency, int(share * time[-1] * frequency))
        if found is not None:
            return found
    return None


def cycle_amplitudes(time: Array, signal: Array, frequency: float, cycles: int) -> tuple[Array, Array]:
    """Give the ends, s, of the last cycles of a run, and half the range of a signal in each, both (cycles,).

    Args:
        time: s, (n,).
        signal: (n,).
        frequency: Hz.
        cycles: how many; the run holds as many at least.
    """
    ends = time[-1] - np.arange(cycles, -1, -1) / frequency
    places = np.searchsorted(time, ends)
    ranges = [np.ptp(signal[one : max(other, one + 2)]) for one, other in pairwise(places.tolist())]
    return ends[1:], np.array(ranges) / 2


def is_judged(duration: float, frequency: float) -> bool:
    """Tell whether a run, s, under a sine, Hz, is long enough to show a swing."""
    return int(0.2 * duration * frequency) >= FEWEST_CYCLES_THAT_SWING


def _swing_in(time: Array, signal: Array, frequency: float, cycles: int) -> Swing | None:
    """Give a swing in the last cycles of a run and as many before them; what only rises or falls is none."""
    if cycles < FEWEST_CYCLES_THAT_SWING:
        return None
    _, amplitude = cycle_amplitudes(time, signal, frequency, 2 * cycles)
    before, last = amplitude[:cycles], amplitude[cycles:]
    share = np.ptp(last) / last.mean() if last.mean() > 0 else 0.0
    if share < SWINGS or np.ptp(last) < LASTS * np.ptp(before):
        return None
    above = amplitude > (amplitude.min() + amplitude.max()) / 2
    if np.count_nonzero(above[1:] != above[:-1]) < 2:
        return None
    rises = np.flatnonzero(~above[:-1] & above[1:])
    period = float(np.diff(rises).mean() / frequency) if len(rises) > 1 else None
    return Swing(float(amplitude.min()), float(amplitude.max()), period)
