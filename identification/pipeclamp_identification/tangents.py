"""How a clamp's law answers a small change of its steady motion, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeclamp.realise.arrays import realise
from pipeclamp.realise.stepping import clamp_equations
from pipeclamp.response import respond
from pipeclamp_identification.steady_clamp import Complex, SteadyClamp

Array = NDArray[np.float64]

NUDGE = 1e-5
"""By which share of its size an argument is moved for a derivative."""

Y, V, BEFORE, AMPLITUDE, STATES = range(5)
"""Arguments: y, v at a sample, y a sample before, A, and from there on the states a sample before.

No law that is carried to a pipe depends on acceleration: only what the rig adds does."""


@dataclass(frozen=True, eq=False)
class Tangents:
    """Derivatives of a law's step at the n samples of a cycle; mm, s, N.

    Attributes:
        slopes: of the force and the states, (1 + J, n), by the arguments, (1 + J, STATES + J, n).
        follows: n times the change of A by that of y at each sample, (n,); 0 where the law's A is given or held.
        adrift: whether states keep a constant for ever, which is neither stable nor unstable.
    """

    slopes: Array
    follows: Array
    adrift: bool


def tangents(clamp: SteadyClamp, motion: Complex, frequency: float) -> Tangents:
    """Linearise a clamp's law about a periodic motion.

    Where the velocity turns, a derivative by it is that over the velocity's change in a step, as force itself is
    averaged there.

    Args:
        clamp: the law with its conditions.
        motion: harmonics of y, mm, (h,).
        frequency: Hz.
    """
    cycle = clamp.cycle(motion[None], np.array([frequency]))
    equations = clamp_equations(clamp.law.structure)
    values, smoothing = clamp.law.vector(equations), (clamp.law.v_r, clamp.law.y_r)
    compiled = realise(equations)
    response = respond(equations, values, smoothing, cycle)
    states = [state[0] for state in response.states]
    y, v, a, h, A = cycle.y[0], cycle.v[0], cycle.a[0], cycle.h[0, 0], cycle.slow["A"][0, 0]

    at = np.stack([y, v, np.roll(y, 1), np.full_like(y, A), *(np.roll(state, 1) for state in states)])
    nudges = NUDGE * np.maximum(np.abs(at).max(axis=1, keepdims=True), np.finfo(float).tiny) * np.ones_like(at)
    nudges[V] = np.maximum(nudges[V], np.abs(a) * h / 2)
    each = np.eye(len(at))[:, :, None] * nudges
    moved = np.concatenate([at + each, at - each]).swapaxes(0, 1)  # (arguments, rows, n)
    slow = {name: np.broadcast_to(value, moved[Y].shape) for name, value in cycle.slow.items()}
    slow["A"] = moved[AMPLITUDE]
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        coefficients = compiled.coefficients(*(slow[name] for name in compiled.slow), *values, *smoothing)
        held = [*coefficients, *values, *smoothing]
        fast = [moved[Y], moved[V], a, moved[BEFORE], h]
        after = compiled.update(*fast, *moved[STATES:], *held) if states else []
        results = [*compiled.force(*fast, *after, *held), *after]
    found = np.stack([np.broadcast_to(result, moved[Y].shape) for result in results])
    above, below = np.split(found, 2, axis=1)

    follows = np.zeros_like(y)
    if clamp.amplitude is None and clamp.range_A[0] < A < clamp.range_A[1]:
        follows = 2 * (y - y.mean()) / A
    return Tangents((above - below) / (2 * nudges), follows, bool(response.adrift[0]))
