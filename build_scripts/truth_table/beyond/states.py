"""Elements with memory; functions as in `hidden`. None depends on a size in its course, but for the force it holds."""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import T0, Array, BaseLaw, Motion, Part, relieved

from beyond.plain import SLIDES, SPEED

GLIDES = 60.0
"""Speed that no force exceeds, over that at which the flow of other laws is stated."""
STEEPEST = 40.0
"""Force of activation over a force below which flow is as slow as there."""
ACTIVATION = 1000.0
"""K."""
PARTS_OF_STEP = 4
"""In which bristles are followed that slide bit by bit."""
DIRECTLY, WITH_AGE = 0.06, 0.2
"""Shares by which friction grows with the logarithm of the speed and of the age of its contacts."""


def gliding_arm(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring in series with what flows as dislocations glide: hardly under a small force, never beyond a speed."""
    force, speed = size * typical(base), GLIDES * shape["speed"]

    def flow(q: Array) -> Array:
        return speed * np.sign(q) * np.exp(-force / np.maximum(np.abs(q), force / STEEPEST))

    return Part(force=relieved(motion, 3 * force / shape["limit"], flow, force))


def viscoplastic(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring in series with a slider that flows the faster the more its stress is beyond yield."""
    force, speed = size * typical(base), 5 * shape["speed"]

    def flow(q: Array) -> Array:
        return speed * np.sign(q) * np.maximum(np.abs(q) / force - 1, 0.0)

    return Part(force=relieved(motion, force / shape["limit"], flow, force))


def elastic_bristles(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Bristles that bend elastically, slide bit by bit and then fully, at a force that falls with the speed."""
    bend, weaker = 0.4 * shape["limit"], 8 * shape["speed"]
    breaks_away = 0.6 * bend

    def bent() -> Array:
        result = np.zeros_like(motion.v.T)
        z = np.zeros(len(motion.v))
        v = motion.v.T
        for step in range(len(v) - 1):
            speed = (v[step] + v[step + 1]) / 2
            held = bend * (1 + 0.8 * np.exp(-((speed / weaker) ** 2)))
            for _ in range(PARTS_OF_STEP):
                moved = speed * motion.step / PARTS_OF_STEP
                half = z + moved / 2 * _bending(z, speed, breaks_away, held)
                z = z + moved * _bending(half, speed, breaks_away, held)
            result[step + 1] = z
        return result.T

    return Part(force=size * typical(base) * motion.remember("elastic_bristles", bent) / bend)


def _bending(z: Array, speed: Array, breaks_away: float, held: Array) -> Array:
    """By how much of a way bristles bend: all of it before they break away, and on the way back."""
    share = np.clip((np.abs(z) - breaks_away) / (held - breaks_away), 0.0, 1.0)
    sliding = np.where(z * speed > 0, (1 - np.cos(np.pi * share)) / 2, 0.0)
    return 1 - sliding * np.abs(z) / held


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


def wire_rope(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A rope's strands rub, pressed together the more the further it is bent to one side; exact for each step."""
    side = np.copysign(1.0, shape["sign"])

    def strained() -> Array:
        result = np.empty_like(motion.y.T)
        z = np.zeros(len(motion.y))
        for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
            kept = np.exp(-np.abs(move) / shape["limit"])
            z = z * kept + np.sign(move) * (1 - kept)
            result[step] = z
        return result.T

    pressed = np.exp(side * motion.y / shape["stop"])
    return Part(force=size * typical(base) * pressed * motion.remember("wire_rope", strained))


def setting_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A paste that sets without end at rest and that shear breaks down; exact for a speed held over a step."""
    sets, broken = 3 * shape["tau"], 3 * shape["limit"]

    def structure() -> Array:
        result = np.empty_like(motion.v.T)
        speed = np.hypot(motion.v, SLIDES)
        there = broken / (sets * speed.mean(axis=1))
        for step, now in enumerate(speed.T):
            kept = np.exp(-now * motion.step / broken)
            there = there * kept + broken / (sets * now) * (1 - kept)
            result[step] = there
        return result.T

    thicker = 1 + motion.remember("setting_paste", structure) ** 1.5
    return Part(force=size * typical(base) * motion.v / SPEED * thicker)


def ageing_contacts(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction of contacts that strengthen with their age and are renewed along a way; exact as `setting_paste`."""
    way = 0.3 * shape["limit"]

    def age() -> Array:
        result = np.empty_like(motion.v.T)
        speed = np.hypot(motion.v, SLIDES)
        there = way / speed.mean(axis=1)
        for step, now in enumerate(speed.T):
            kept = np.exp(-now * motion.step / way)
            there = there * kept + way / now * (1 - kept)
            result[step] = there
        return result.T

    speed = np.hypot(motion.v, SLIDES) / SPEED
    strength = 1 + DIRECTLY * np.log(speed) + WITH_AGE * np.log(SPEED / way * motion.remember("age", age))
    return Part(force=size * typical(base) * np.maximum(strength, 0.0) * np.tanh(motion.v / SLIDES))


def warm_arm(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring in series with a dashpot that heat makes thinner; exact, tone by tone."""
    tau = 5 * shape["tau"] * np.exp(ACTIVATION * (1 / motion.T - 1 / T0))
    held = np.zeros_like(motion.y)
    for order, tone in motion.tones:
        turn = 2j * np.pi * order * motion.f
        held += np.real(tone[:, None] * turn * tau / (1 + turn * tau) * np.exp(turn * motion.time))
    return Part(force=size * base.k10 * held)


def rubber_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction of filled rubber: from each reversal on it nears its most along a hyperbola."""
    half = 0.5 * shape["limit"]

    def shares() -> Array:
        result = np.empty_like(motion.y.T)
        share, turned = np.zeros(len(motion.y)), np.zeros(len(motion.y))
        place, side = motion.y[:, 0].copy(), np.ones(len(motion.y))
        last = motion.y[:, 0]
        for step, y in enumerate(motion.y.T):
            way = np.where(y != last, np.sign(y - last), side)
            new = way != side
            turned, place = np.where(new, share, turned), np.where(new, last, place)
            side, last = way, y
            left, gone = 1 - side * turned, np.abs(y - place)
            share = turned + side * left * gone / (half * left + gone)
            result[step] = share
        return result.T

    return Part(force=size * typical(base) * motion.remember("rubber_friction", shares))


def overshooting_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction with a peak after each reversal: of two that near their most along a way, less the slower one."""
    quick, slow = 0.15 * shape["limit"], 0.6 * shape["limit"]

    def peaked() -> Array:
        result = np.empty_like(motion.y.T)
        parts = np.zeros((2, len(motion.y)))
        ways = np.array([[quick], [slow]])
        for step, move in enumerate(np.diff(motion.y, axis=1, prepend=motion.y[:, :1]).T):
            kept = np.exp(-np.abs(move) / ways)
            parts = parts * kept + np.sign(move) * (1 - kept)
            result[step] = 2 * parts[0] - parts[1]
        return result.T

    return Part(force=size * typical(base) * motion.remember("overshooting", peaked))
