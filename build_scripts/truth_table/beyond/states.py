"""Elements with memory; functions as in `hidden`. None depends on a size in its course, but for the force it holds."""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import Array, BaseLaw, Motion, Part, relieved

STEEPEST = 40.0
"""Force over that of activation beyond which flow is as fast as there."""


def creeping_arm(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring in series with a dashpot of activated flow, as glassy polymers have."""
    force, speed = size * typical(base), shape["speed"]

    def flow(q: Array) -> Array:
        return speed * np.sinh(np.clip(q / force, -STEEPEST, STEEPEST))

    return Part(force=relieved(motion, 3 * force / shape["limit"], flow, force))


def viscoplastic(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring in series with a slider that flows the faster the more its stress is beyond yield."""
    force, speed = size * typical(base), 5 * shape["speed"]

    def flow(q: Array) -> Array:
        return speed * np.sign(q) * np.maximum(np.abs(q) / force - 1, 0.0)

    return Part(force=relieved(motion, force / shape["limit"], flow, force))


def bristles(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Bristles that bend, then slide at a force that falls with the speed; exact for a speed held over a step."""
    bend, weaker = 0.4 * shape["limit"], 8 * shape["speed"]

    def bent() -> Array:
        result = np.zeros_like(motion.v.T)
        z = np.zeros(len(motion.v))
        v = motion.v.T
        for step in range(len(v) - 1):
            speed = (v[step] + v[step + 1]) / 2
            held = bend * (1 + 0.8 * np.exp(-((speed / weaker) ** 2)))
            kept = np.exp(-np.abs(speed) * motion.step / held)
            z = z * kept + np.sign(speed) * held * (1 - kept)
            result[step + 1] = z
        return result.T

    return Part(force=size * typical(base) * motion.remember("bristles", bent) / bend)


def flag(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A self-centring tie: it yields at a force, gives back at a lower one, and is at rest in the middle again."""
    yields, gives_back = shape["limit"], 0.35 * shape["limit"]

    def stretched() -> Array:
        result = np.empty_like(motion.y.T)
        q = np.zeros(len(motion.y))
        moves = np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T
        for step, (y, move) in enumerate(zip(motion.y.T, moves, strict=True)):
            outer = np.minimum(np.abs(y), yields)
            inner = np.minimum(np.abs(y), gives_back)
            q = np.sign(y) * np.clip(np.sign(y) * (q + move), inner, outer)
            result[step] = q
        return result.T

    return Part(force=size * base.k10 * motion.remember("flag", stretched))


def hardening_plastic(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A plastic element whose middle follows it and forgets (nonlinear kinematic hardening); stiffness one, mm."""
    yields, follows, forgets = 0.5 * shape["limit"], 0.6, 1.5 / shape["limit"]

    def strained() -> Array:
        result = np.empty_like(motion.y.T)
        q = np.zeros(len(motion.y))
        middle = np.zeros(len(motion.y))
        for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
            trial = q + move
            side = np.sign(trial - middle)
            beyond = np.maximum(np.abs(trial - middle) - yields, 0.0)
            plastic = beyond / (1 + follows - forgets * middle * side)
            middle = middle + (follows * side - forgets * middle) * plastic
            q = trial - side * plastic
            result[step] = q
        return result.T

    return Part(force=size * base.k10 * motion.remember("hardening_plastic", strained))
