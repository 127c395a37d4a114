"""Stability of a periodic motion: a small disturbance, followed step by step through a cycle (Floquet).

Between samples the clamps' forces are straight and the modes move exactly. With x = (q, q') and E, B of such a step,

    x' = E x + B_0 F + B_1 F',    F' = F_y y' + F_v v' + F_a a' + F_before y + F_z z + F_A A,    z' likewise,

A being that of the cycle before, where a law follows its motion's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm

from pipeclamp_identification.tangents import ACCELERATION, AMPLITUDE, BEFORE, STATES, Tangents, V, Y

Array = NDArray[np.float64]

MM = 1e3
"""mm in a metre: the clamps are in mm, the pipe in m."""

NEUTRAL = 1e-6
"""How near to 1 a multiplier is for a state that keeps a constant."""


def growth(stiffness: Array, damping: Array, shapes: Array, clamps: Sequence[Tangents], period: float) -> float:
    """Give the rate at which the disturbance grows that grows fastest, 1/s; below 0 where the motion is stable.

    Args:
        stiffness, damping: of the modes, q'' + damping q' + stiffness q = -shapes^T F, (m, m).
        shapes: displacement of each clamp (m) per unit of each mode, (clamps, m).
        clamps: their laws' steps, linearised about the motion, at n samples of the cycle.
        period: of the cycle, s.
    """
    modes, count = len(stiffness), len(clamps)
    if not count:
        companion = np.block([[np.zeros_like(stiffness), np.eye(modes)], [-stiffness, -damping]])
        return float(np.linalg.eigvals(companion).real.max())
    samples = clamps[0].follows.size
    steps = _steps(stiffness, damping, shapes, clamps, period / samples)
    while len(steps) > 1:
        odd = steps[len(steps) // 2 * 2 :]
        steps = np.concatenate([steps[1::2] @ steps[: len(steps) // 2 * 2 : 2], odd])
    whole = steps[0]
    # The next cycle's A is what this one's motion adds up to.
    whole[-2 * count : -count], whole[-count:] = whole[-count:], 0.0
    multipliers = np.linalg.eigvals(whole)
    if any(clamp.adrift for clamp in clamps):
        multipliers = multipliers[np.abs(multipliers - 1) > NEUTRAL]
    return log(max(float(np.abs(multipliers).max()), np.finfo(float).tiny)) / period


def _steps(stiffness: Array, damping: Array, shapes: Array, clamps: Sequence[Tangents], h: float) -> Array:
    """Give what each step makes of (q, q', F, z, A, what the next A adds up to), (n, d, d)."""
    count, size = len(clamps), 2 * len(stiffness)
    memory = [len(clamp.slopes) - 1 for clamp in clamps]
    rates = np.hstack([-stiffness, -damping])
    start, held, sloped = _held_and_sloped(rates, -shapes.T, h)
    places = np.cumsum([0, *memory])
    states, amplitudes = size + count, size + count + places[-1]
    width, samples = amplitudes + 2 * count, clamps[0].follows.size

    free = np.zeros((size, width))
    free[:, :size], free[:, size:states] = start, held - sloped
    motion = MM * block_diag(shapes, shapes)
    y_of, v_of, a_of = motion[:count], motion[count:], MM * shapes @ rates

    # Forces and states at a step's end, by (q, q') and by F there, and by all at its start.
    by_end = np.zeros((samples, count + places[-1], size))
    by_force = np.zeros((samples, count + places[-1], count))
    by_start = np.zeros((samples, count + places[-1], width))
    for index, clamp in enumerate(clamps):
        rows = [index, *range(count + places[index], count + places[index + 1])]
        slopes = np.moveaxis(clamp.slopes, 2, 0)[..., None]
        by_end[:, rows] = slopes[:, :, Y] * y_of[index] + slopes[:, :, V] * v_of[index]
        by_end[:, rows] += slopes[:, :, ACCELERATION] * a_of[index]
        by_force[:, rows] = slopes[:, :, ACCELERATION] * (-MM * shapes[index] @ shapes.T)
        by_start[:, rows, :size] = slopes[:, :, BEFORE] * y_of[index]
        own = slice(states + places[index], states + places[index + 1])
        by_start[:, rows, own] = slopes[:, :, STATES:, 0]
        by_start[:, rows, amplitudes + index] = slopes[:, :, AMPLITUDE, 0]

    known = by_end @ free + by_start
    implied = by_end @ sloped + by_force
    force = np.linalg.solve(np.eye(count) - implied[:, :count], known[:, :count])
    end = free + sloped @ force
    steps = np.zeros((samples, width, width))
    steps[:, :size], steps[:, size:states] = end, force
    steps[:, states:amplitudes] = known[:, count:] + implied[:, count:] @ force
    steps[:, amplitudes:] = np.eye(width)[amplitudes:]
    follows = np.stack([clamp.follows for clamp in clamps], axis=1)[:, :, None]
    steps[:, -count:] += follows * (y_of @ end)
    return steps


def _held_and_sloped(rates: Array, loads: Array, h: float) -> tuple[Array, Array, Array]:
    """Give what a step makes of the state, of a load that is held, and of one that grows from 0 to 1.

    Args:
        rates: q'' from (q, q'), (m, 2 m).
        loads: modal loads per unit of each, (m, loads).
        h: s.
    """
    modes, size = rates.shape
    inputs = loads.shape[1]
    whole = np.zeros((size + 2 * inputs, size + 2 * inputs))
    whole[:modes, modes:size] = h * np.eye(modes)
    whole[modes:size, :size], whole[modes:size, size : size + inputs] = h * rates, h * loads
    whole[size : size + inputs, size + inputs :] = np.eye(inputs)
    found = expm(whole)[:size]
    return found[:, :size], found[:, size : size + inputs], found[:, size + inputs :]
