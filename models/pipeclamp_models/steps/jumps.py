"""Which laws' memory jumps in a step, however short: it can't be continuous states, and needs short ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from pipeclamp_models.steps.within_step import Step

PLACES_PER_CYCLE = 200
"""Places on a cycle at which short steps are tried."""

SHORT_PERIODS = 1e-7
"""A step so short that it moves what moves at all by far less than a jump, in periods."""

JUMP = 1e-3
"""Of a state's largest value: what it moves by in a short step is no jump below it."""

PARTS_OF_A_STEP = 16
"""In which a step is walked of a law whose memory jumps: at a part's end instead of the step's. Play's force errs by
4 % of its rms in 12 steps a cycle without, and by 0.4 % with them."""


def parts_of_step(step: Step, k: Any, rest: Sequence[float], A: float, f: float) -> int:
    """Give in how many parts a law's step is walked; what is taken is as of `jumping`."""
    return PARTS_OF_A_STEP if jumping(step, k, rest, A, f) else 1


def jumping(step: Step, k: Any, rest: Sequence[float], A: float, f: float) -> list[int]:
    """Give the places of the states that a short step moves by a jump, somewhere on one of two cycles.

    Args:
        step: the law's step.
        k: its coefficients.
        rest: its states before anything has moved.
        A: largest amplitude in its range, mm.
        f: frequency, Hz.
    """
    found: set[int] = set()
    if not rest:
        return []
    for share, mean in ((1.0, 0.0), (0.3, 0.6)):
        motion = [_place(A * share, A * mean, f, n) for n in range(2 * PLACES_PER_CYCLE + 1)]
        states = tuple(rest)
        sizes, moves = [0.0] * len(states), [0.0] * len(states)
        before = motion[0][0]
        for y, v in motion[1:]:
            _, _, states = step(k, states, before, y, v, 1 / (f * PLACES_PER_CYCLE))
            for turned in (v, -v):
                h = SHORT_PERIODS / f
                here = step(k, states, y, y, turned, 0.0)[2]
                ahead = step(k, here, y, y + h * turned, turned, h)[2]
                moves = [max(most, abs(b - a)) for most, a, b in zip(moves, here, ahead, strict=True)]
            sizes = [max(most, abs(value)) for most, value in zip(sizes, states, strict=True)]
            before = y
        found |= {n for n, (move, size) in enumerate(zip(moves, sizes, strict=True)) if move > JUMP * size}
    return sorted(found)


def _place(amplitude: float, mean: float, f: float, n: int) -> tuple[float, float]:
    """Give displacement and velocity at a sample of a cycle."""
    theta = 2 * math.pi * (n + 0.5) / PLACES_PER_CYCLE
    return mean + amplitude * math.sin(theta), 2 * math.pi * f * amplitude * math.cos(theta)
