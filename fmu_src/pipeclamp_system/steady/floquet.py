"""Stability of a periodic motion: a small disturbance, followed step by step through a cycle (Floquet).

Each clamp's mean stiffness and damping move with the modes, exactly; what is left of its force F is straight between
samples. Were all of it, a clamp far stiffer than the pipe would be unstable in the steps alone. With x = (q, q'), in a
step from 0 to 1,

    x_1 = E x_0 + B_0 F_0 + B_1 F_1,    F_1 = F_y y_1 + F_v v_1 + F_before y_0 + F_z z_0 + F_A A,

and the laws' states z_1 likewise. Where A is the motion's own, it comes as late as by the clamp FMU's tracker, through
two averages in a row: a motion can beat for that alone. The law's f is taken to stay.

Where a force steps with the velocity v, at a reversal, a disturbance of v shifts the instant: of it a+/a- is left, the
clamp's acceleration after over that before. Where the clamp sticks, nothing is left of it.

Source of that: Leine and Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer (2004).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import expm1, log

import numpy as np
from scipy.linalg import block_diag

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.steps.tracker import AVERAGING
from pipeclamp_system.steady.tangents import AMPLITUDE, BEFORE, Passage, Tangents, V, Y
from pipeclamp_system.transient.modal_step import modal_step

NEUTRAL = 1e-6
"""How near to 1 a multiplier is for what keeps a constant: a state that never slips, a place that nothing holds."""


def growth(
    stiffness: Array, damping: Array, shapes: Array, clamps: Sequence[Tangents], period: float, *, adrift: bool
) -> float:
    """Give the rate at which the disturbance grows that grows fastest, 1/s; below 0 where the motion is stable.

    What keeps a constant for ever is neither stable nor unstable, and doesn't count.

    Args:
        stiffness, damping: of the modes, q'' + damping q' + stiffness q = -shapes^T F, (m, m).
        shapes: displacement of each clamp (m) per unit of each mode, (clamps, m).
        clamps: their laws' steps, linearised about the motion, at n samples of the cycle.
        period: of the cycle, s.
        adrift: whether the pipe itself can move as a rigid body.
    """
    multipliers = np.linalg.eigvals(_cycle(stiffness, damping, shapes, clamps, period))
    if adrift or any(clamp.adrift for clamp in clamps):
        multipliers = multipliers[np.abs(multipliers - 1) > NEUTRAL]
    return log(np.abs(multipliers).max(initial=np.finfo(float).tiny)) / period


def _cycle(stiffness: Array, damping: Array, shapes: Array, clamps: Sequence[Tangents], period: float) -> Array:
    """Give what a cycle makes of a disturbance, (d, d); arguments as of `growth`."""
    count = len(clamps)
    if not count:
        return modal_step(np.hstack([-stiffness, -damping]), -shapes.T, period, 0)[0]
    samples = clamps[0].follows.size
    return _composed(_steps(stiffness, damping, shapes, clamps, period / samples))


def _steps(stiffness: Array, damping: Array, shapes: Array, clamps: Sequence[Tangents], h: float) -> Array:
    """Give what each step makes of (q, q', F, z, A, the first of A's averages), (n, d, d).

    A is there of clamps whose force hangs on that of the motion: nothing else that is averaged acts on it.
    """
    count, size = len(clamps), 2 * len(stiffness)
    memory = [clamp.memory for clamp in clamps]
    mean = np.array([clamp.by_argument[0].mean(axis=-1) for clamp in clamps])
    stiffness = stiffness + shapes.T @ (MM * mean[:, Y, None] * shapes)
    damping = damping + shapes.T @ (MM * mean[:, V, None] * shapes)
    start, (held, sloped) = modal_step(np.hstack([-stiffness, -damping]), -shapes.T, h, 2)
    places = np.cumsum([0, *memory])
    states, amplitudes = size + count, size + count + places[-1]
    tracking = [index for index, clamp in enumerate(clamps) if clamp.tracks]
    firsts, samples = amplitudes + len(tracking), clamps[0].follows.size
    width = firsts + len(tracking)

    free = np.zeros((size, width))
    free[:, :size], free[:, size:states] = start, held - sloped
    motion = MM * block_diag(shapes, shapes)
    y_of, v_of = motion[:count], motion[count:]

    # Forces and states at a step's end, by (q, q') there, and by all at its start.
    by_end = np.zeros((samples, count + places[-1], size))
    by_start = np.zeros((samples, count + places[-1], width))
    for index, clamp in enumerate(clamps):
        rows = [index, *range(count + places[index], count + places[index + 1])]
        slopes = np.moveaxis(clamp.by_argument, 2, 0)[..., None].copy()
        slopes[:, 0, [Y, V]] -= mean[index, [Y, V], None]
        by_end[:, rows] = slopes[:, :, Y] * y_of[index] + slopes[:, :, V] * v_of[index]
        by_start[:, rows, :size] = slopes[:, :, BEFORE] * y_of[index]
        own = slice(states + places[index], states + places[index + 1])
        by_start[:, rows, own] = np.moveaxis(clamp.by_state, 2, 0)
        if clamp.tracks:
            by_start[:, rows, amplitudes + tracking.index(index)] = slopes[:, :, AMPLITUDE, 0]

    known = by_end @ free + by_start
    implied = by_end @ sloped
    force = np.linalg.solve(np.eye(count) - implied[:, :count], known[:, :count])
    end = free + sloped @ force
    steps = np.zeros((samples, width, width))
    steps[:, :size], steps[:, size:states] = end, force
    steps[:, states:amplitudes] = known[:, count:] + implied[:, count:] @ force
    follows = np.array([clamps[index].follows for index in tracking]).reshape(-1, samples).T[:, :, None]
    share, kept = -expm1(-1 / (AVERAGING * samples)), np.eye(width)
    steps[:, firsts:] = (1 - share) * kept[firsts:] + share * follows * (y_of[tracking] @ end)
    steps[:, amplitudes:firsts] = (1 - share) * kept[amplitudes:firsts] + share * steps[:, firsts:]
    for shape, clamp in zip(shapes, clamps, strict=True):
        if clamp.passage is not None:
            taken = _taken(shape, clamp.passage, h)
            velocity = steps[:, len(shape) : size]
            velocity -= taken[:, None, None] * np.outer(shape, shape) / (shape @ shape) @ velocity
    return steps


def _taken(shape: Array, passage: Passage, h: float) -> Array:
    """Give the share of a disturbance of a clamp's velocity that its force takes in each step, (n,)."""
    return np.asarray(1 - passage.left * np.exp(-MM * (shape @ shape) * passage.damping * h))


def _composed(steps: Array) -> Array:
    """Give what linear steps (n, ..., d, d) make one after the other, (..., d, d)."""
    while len(steps) > 1:
        paired = len(steps) // 2 * 2
        steps = np.concatenate([steps[1:paired:2] @ steps[:paired:2], steps[paired:]])
    return np.asarray(steps[0])
