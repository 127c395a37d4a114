"""A clamp's way between two communication points or samples: where it turns round, and the work on it.

The clamp's slave inlines it, `native/c/within_step.c` is its counterpart, and records are walked by it. The motion is
the cubic that has displacement and velocity of both ends (Hermite). Where the velocity changes sign it turns round
once, and is walked in two ways, so that memory unloads from where the motion did. The heat of a way takes the law's
force in its middle too, beside that of both ends; it is exact where the force is linear in the displacement. Memory
that jumps, as play's where it lets the clamp go, does so at the end of a way: a step of such a law is walked in several
parts along the cubic.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

EDGE = 1e-6
"""Share of a step next to its ends in which it doesn't turn: the peak cut off is some 1e-12 of what the motion turns
back in a step, and the velocity of a shorter way would be rounding."""

Step = Callable[..., tuple[float, float, tuple[float, ...]]]
Along = Any
"""A number, or an array of them, one for each of many steps."""
Ends = tuple[Along, Along, Along, Along]
"""Displacement (mm) and velocity (mm/s) at the beginning, then at the end."""
Begun = tuple[float, float]
"""Force (N) and stored energy (N mm) at the beginning."""
Walked = tuple[float, float, tuple[float, ...], float, float]
"""Force (N), stored energy (N mm) and memory at the end, heat (N mm), length of the way (mm)."""


def bends(motion: Ends, h: Along) -> tuple[Along, Along]:
    """Give b and a of a motion's velocity over the share x of its step: that at the beginning and b x + a x^2."""
    y_before, v_before, y, v = motion
    mean = (y - y_before) / h
    return 2.0 * (3.0 * mean - 2.0 * v_before - v), 3.0 * (v_before + v - 2.0 * mean)


def part_of(motion: Ends, h: Along, share: Along) -> tuple[Along, Along]:
    """Give displacement (mm) and velocity (mm/s) of a step's motion after a share of it."""
    y_before, v_before, _, _ = motion
    b, a = bends(motion, h)
    return (
        y_before + h * share * (v_before + share * (b / 2.0 + share * (a / 3.0))),
        v_before + share * (b + share * a),
    )


def turning(motion: Ends, h: float) -> tuple[float, float]:
    """Give where a motion turns round whose velocity changes sign: the share of the step, and the displacement (mm)."""
    sign = 1.0 if motion[1] > 0.0 else -1.0  # so that it begins above 0
    c = sign * motion[1]
    b, a = (sign * bend for bend in bends(motion, h))
    inside = b * b - 4.0 * a * c
    root = math.sqrt(inside) if inside > 0.0 else 0.0
    share = (b + root) / (-2.0 * a) if b > 0.0 else 2.0 * c / (root - b)
    return share, part_of(motion, h, share)[0]


def turn_within(motion: Ends, h: float) -> tuple[float, float] | None:
    """Give where a motion turns round, as `turning` does; None where that is at an end of the step."""
    at, turn = turning(motion, h)
    return (at, turn) if EDGE < at < 1.0 - EDGE else None


def way(
    step: Step,
    k: Any,
    memory: tuple[float, ...],
    motion: Ends,
    h: float,
    begun: Begun,
) -> Walked:
    """Walk a way on which the motion doesn't turn round.

    Args:
        step: the law's step.
        k: its coefficients.
        memory: at the beginning.
        motion: displacement (mm) and velocity (mm/s) at the beginning, then at the end.
        h: s.
        begun: force (N) and stored energy (N mm) at the beginning.
    """
    y_before, v_before, y, v = motion
    force_before, energy_before = begun
    force, energy, after = step(k, memory, y_before, y, v, h)
    move = y - y_before
    lost = 0.5 * (force_before + force) * move - (energy - energy_before)
    bent = h * (v_before - v)
    if abs(bent) < 4.0 * abs(move):  # the middle lies between the ends
        middle = 0.5 * (y_before + y) + 0.125 * bent
        speed = 1.5 * move / h - 0.25 * (v_before + v)
        force_middle, _, _ = step(k, memory, y_before, middle, speed, 0.5 * h)
        beyond = force_middle - (force_before + (force - force_before) * ((middle - y_before) / move))
        lost += beyond * (0.8 * move - h * (v_before + v) / 15.0)
    return force, energy, after, lost, abs(move)


def round_turn(
    step: Step,
    k: Any,
    memory: tuple[float, ...],
    motion: Ends,
    h: float,
    begun: Begun,
) -> Walked:
    """Walk a way on which the motion may turn round once; see `way`."""
    y_before, v_before, y, v = motion
    turned = turn_within(motion, h) if v_before * v < 0.0 else None
    if turned:
        at, turn = turned
        there, back = (y_before, v_before, turn, 0.0), (turn, 0.0, y, v)
        force, energy, memory, lost, out = way(step, k, memory, there, at * h, begun)
        force, energy, memory, more, home = way(step, k, memory, back, (1.0 - at) * h, (force, energy))
        return force, energy, memory, lost + more, out + home
    return way(step, k, memory, motion, h, begun)


def walk(
    step: Step,
    k: Any,
    memory: tuple[float, ...],
    motion: Ends,
    h: float,
    begun: Begun,
    parts: int,
) -> Walked:
    """Walk a step in so many parts; see `way`."""
    if parts == 1 or motion[1] == motion[3] == 0.0:
        return round_turn(step, k, memory, motion, h, begun)
    force, energy = begun
    lost = length = 0.0
    at = motion[:2]
    for part in range(1, parts + 1):
        to = motion[2:] if part == parts else part_of(motion, h, part / parts)
        walked = round_turn(step, k, memory, (*at, *to), h / parts, (force, energy))
        force, energy, memory = walked[:3]
        lost += walked[3]
        length += walked[4]
        at = to
    return force, energy, memory, lost, length
