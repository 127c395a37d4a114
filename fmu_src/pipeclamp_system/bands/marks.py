"""What a person reads off a curve: its peak, and the frequencies at which it turns back, where a sweep jumps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeclamp_models.base.arrays import Array

REACHING_SHARE = 0.5
"""Share of the draws in which a stretch of a curve reaches a frequency, below which it has no band there."""
MOVED_DEVIATIONS = 0.1
"""Of a standard deviation, by which a curve is moved to see what its marks do."""


@dataclass(frozen=True, eq=False)
class Moving:
    """A piece of a curve at one point, and how each of its states moves per quantity.

    Attributes:
        frequency: Hz, and amplitude: mm, shape (S,).
        by_frequency, by_amplitude: their changes, shape (Q, S).
        by_turning: changes of the frequency at which the curve turns back, next to each state, shape (Q, S).
    """

    frequency: Array
    amplitude: Array
    by_frequency: Array
    by_amplitude: Array
    by_turning: Array

    def peak(self) -> tuple[float, float, bool]:
        """Give the frequency and the amplitude of the highest state, and whether that is inside the piece."""
        at = int(np.argmax(self.amplitude))
        found = _turning(self.amplitude, at)
        inside = 0 < at < len(self.amplitude) - 1
        return float(_at(self.frequency, at, found)), float(_at(self.amplitude, at, found)), inside

    def peak_errors(self) -> tuple[float, float]:
        """Give by how much frequency and amplitude of the peak may be off, for the curve is known in states alone.

        A parabola's error falls with the square of its width: a third of what one of twice the width says otherwise.
        """
        at = int(np.argmax(self.amplitude))
        narrow, wide = _turning(self.amplitude, at), _turning(self.amplitude, at, 2)
        off = [
            float(_at(values, at, wide, 2) - _at(values, at, narrow)) / 3 for values in (self.frequency, self.amplitude)
        ]
        return abs(off[0]), abs(off[1])

    def peak_moves(self, sizes: Array) -> tuple[Array, Array]:
        """Give the derivatives of the peak's frequency and amplitude, (Q,) each, told by changes of these sizes."""
        at = int(np.argmax(self.amplitude))
        sides = []
        for frequency, amplitude in self._moved(sizes):
            found = np.array([_turning(one, at) for one in amplitude])
            sides.append([_at(frequency, at, found), _at(amplitude, at, found)])
        by_frequency, by_amplitude = _differences(sides, sizes)
        return by_frequency, by_amplitude

    def turns(self) -> list[int]:
        """Give the states at which the curve turns back."""
        steps = np.sign(np.diff(self.frequency))
        return [place + 1 for place in np.flatnonzero(steps[1:] * steps[:-1] < 0).tolist()]

    def turn(self, at: int) -> float:
        """Give the frequency at which the curve turns next to a state."""
        return float(_at(self.frequency, at, _turning(self.frequency, at)))

    def turn_moves(self, at: int) -> Array:
        """Give the derivatives of that frequency, (Q,)."""
        return np.asarray(self.by_turning[:, at])

    def _moved(self, sizes: Array) -> Iterator[tuple[Array, Array]]:
        """Give frequencies and amplitudes, (Q, S) each, with each quantity a little larger, and a little smaller."""
        for step in (MOVED_DEVIATIONS * sizes[:, None], -MOVED_DEVIATIONS * sizes[:, None]):
            yield self.frequency + step * self.by_frequency, self.amplitude + step * self.by_amplitude

    def band(self, draws: Array, per_cent: float) -> tuple[Array, Array]:
        """Give the ends of the curve's band over its own frequencies, mm, (S,) each.

        Each draw moves the states of the curve. A stretch that turns back nowhere is held against itself; nan where in
        most draws it doesn't reach that frequency.

        Args:
            draws: of the quantities, (N, Q).
            per_cent: that the band holds.
        """
        frequency = self.frequency + draws @ self.by_frequency
        amplitude = self.amplitude * np.exp(draws @ (self.by_amplitude / self.amplitude))
        low, high = np.full((2, len(self.frequency)), np.nan)
        turns = self.turns()
        for first, last in pairwise([0, *turns, len(self.frequency) - 1]):
            own, turning = slice(first, last + 1), [end for end in (first, last) if end in turns]
            here = self.frequency[own]
            moved = zip(frequency[:, own], amplitude[:, own], strict=True)
            found = np.stack([np.interp(here, *_rising(*one)) for one in moved])
            # beyond where it turns back there is no such state; beyond the range of frequencies there is
            for end in turning:
                upwards = self.frequency[end] == here.max()
                past = here > frequency[:, [end]] if upwards else here < frequency[:, [end]]
                found[past] = np.nan
            there = np.mean(np.isfinite(found), axis=0) >= REACHING_SHARE
            if there.any():
                ends = np.nanpercentile(found[:, there], [50 - per_cent / 2, 50 + per_cent / 2], axis=0)
                low[own][there], high[own][there] = ends
        return low, high


def _rising(frequency: Array, amplitude: Array) -> tuple[Array, Array]:
    """Give a stretch of a curve with its frequencies rising."""
    order = np.argsort(frequency)
    return frequency[order], amplitude[order]


def _differences(sides: list[list[Array]], sizes: Array) -> tuple[Array, ...]:
    above, below = sides
    steps = 2 * MOVED_DEVIATIONS * np.where(sizes > 0, sizes, 1.0)
    return tuple((one - other) / steps for one, other in zip(above, below, strict=True))


def _turning(values: Array, at: int, apart: int = 1) -> float:
    """Give where a parabola through a value and those so many places beside it turns, in such steps; 0 at an end."""
    if not apart <= at < len(values) - apart:
        return 0.0
    before, here, after = values[at - apart], values[at], values[at + apart]
    bend = before - 2 * here + after
    return float(np.clip((before - after) / (2 * bend), -1.0, 1.0)) if bend != 0 else 0.0


def _at(values: Array, place: int, found: Array | float, apart: int = 1) -> Array:
    """Give values (..., S) at so many such steps beside a place, (...): on the parabola through it and those."""
    here = values[..., place]
    if not apart <= place < values.shape[-1] - apart:
        return np.asarray(here)
    before, after = values[..., place - apart], values[..., place + apart]
    return np.asarray(here + (after - before) / 2 * found + (before - 2 * here + after) / 2 * np.square(found))
