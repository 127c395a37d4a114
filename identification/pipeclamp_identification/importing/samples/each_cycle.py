"""A program whose cycles differ is numbered cycle by cycle, so that each is a run of its own."""

from __future__ import annotations

import itertools

import numpy as np

from pipeclamp_identification.importing.samples.untimed import turns_of_curve
from pipeclamp_models.base.arrays import Array

INNER = 0.25
"""Share of a way at either end of which the motion's beginning is too close to a turn to part two cycles."""


def cycle_numbers(y: Array) -> Array:
    """Give the number of the cycle that each sample is of, from 1 on, shape (n,).

    A cycle begins where the motion comes by its own beginning, in the direction in which that went on, as programs go
    from rest to either side and back; or halfway from turn to turn, where the motion has drifted off that. What is left
    behind the last whole cycle belongs to it.

    Args:
        y: displacement, shape (n,), without blanks.
    """
    numbers = np.ones(len(y))
    turns = turns_of_curve(y)
    if len(turns) < 3:
        return numbers
    onward = np.sign(y[turns[1]] - y[0]) * (y - y[0])
    ways = list(itertools.pairwise(turns.tolist()))
    for first, last in ways[2:-1:2]:
        low, high = onward[first], onward[last]
        edge = INNER * (high - low)
        level = 0.0 if low + edge <= 0.0 <= high - edge else (low + high) / 2
        begins = first + int(np.argmax(onward[first : last + 1] >= level))
        numbers[begins:] += 1
    return numbers
