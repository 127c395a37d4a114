"""Springs and dampers without memory, each as its source writes it; functions as in `hidden`.

Velocities of the test plans reach 30 to 50 mm/s, amplitudes 0.2 to 1 mm, temperatures 20 to 300 degC.
"""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import T0, BaseLaw, Motion, Part

SLIDES = 0.2
"""Velocity in mm/s at which dry friction has turned round."""
SPEED = 20.0
"""mm/s at which the forces of dampers are stated."""
HOTTER = 300.0
"""K by which a gap that closes with temperature would close altogether."""
ACTIVATION = 2500.0
"""K."""
SHARPER = 0.1
"""By which the tops of a serration are sharper than its valleys; 0 for a sine."""
LOCKED, LOCKS_WITHIN = 3.0, 0.25
"""By how much the viscosity rises, and within which share of the speed at which it does."""
THINNEST = 0.25
"""Last viscosity over the first."""
TORN = 0.15
"""Force at which a film tears, over its viscous force at the middle and `SPEED`."""
DAMPED = 1 / 60.0
"""s/mm: damping of a contact over its elastic force, at 1 mm/s."""


def detents(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A periodic potential with several valleys within the stroke, as of a serrated seat: broad valleys, sharp tops."""
    x = 2 * np.pi * motion.y / (2.5 * shape["limit"])
    return Part(force=size * typical(base) * np.sin(x) / (1 + SHARPER**2 + 2 * SHARPER * np.cos(x)) ** 2)


def thermal_stop(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A round stop on both sides whose clearance the hot pipe takes up."""
    gap = shape["stop"] * (1 - (motion.T - T0) / HOTTER)
    return Part(force=size * base.k10 * np.sign(motion.y) * np.maximum(np.abs(motion.y) - gap, 0.0) ** 1.5)


def unequal_stops(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A stop on each side, at another place, as of a guide off its middle."""
    y = motion.y * np.copysign(1.0, shape["sign"])
    near, far = np.maximum(y - 0.3 * shape["stop"], 0.0), np.maximum(-y - 0.9 * shape["stop"], 0.0)
    return Part(force=size * base.k10 * np.copysign(1.0, shape["sign"]) * (near - far))


def thickening_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A dense suspension whose grains lock beyond a speed: its viscosity rises by a step."""
    locked = 1 / (1 + np.exp(-(np.abs(motion.v) / (8 * shape["speed"]) - 1) / LOCKS_WITHIN))
    return Part(force=size * typical(base) * motion.v / SPEED * (1 + LOCKED * locked))


def warm_flow(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Flow by jumps over barriers, which stress and heat make easier."""
    speed = motion.v / shape["speed"] * np.exp(ACTIVATION * (1 / motion.T - 1 / T0))
    return Part(force=size * typical(base) * motion.T / T0 * np.arcsinh(speed))


def cavitating_film(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Oil squeezed out between two plates, the more slowly the nearer they are; pulled apart, it tears."""
    side = np.copysign(1.0, shape["sign"])
    film = side * motion.v / SPEED / (1 - side * motion.y / (2.5 * shape["stop"])) ** 3
    return Part(force=size * typical(base) * side * np.maximum(film, -TORN))


def thinning_oil(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A melt or silicone oil that thins beyond a rate of shear, from one viscosity to another."""
    thinned = THINNEST + (1 - THINNEST) / (1 + (motion.v / (6 * shape["speed"])) ** 2)
    return Part(force=size * typical(base) * motion.v / SPEED * thinned)


def yielding_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A paste that hardly flows below a stress."""
    return Part(force=size * typical(base) * np.sign(motion.v) * -np.expm1(-np.abs(motion.v) / (6 * shape["speed"])))


def damped_contact(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A round body that is struck on one side: its damping grows with what it is pressed in. It doesn't pull."""
    side = np.copysign(1.0, shape["sign"])
    pressed = np.maximum(side * motion.y - 0.4 * shape["stop"], 0.0) ** 1.5
    return Part(force=size * base.k10 * side * pressed * np.maximum(1 + DAMPED * side * motion.v, 0.0))


def shifted_flow(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A magnetorheological damper's branches: flow that levels off, turned round earlier on the way back."""
    flow = motion.v / (2 * shape["speed"]) + 0.6 * np.tanh(motion.y / (0.1 * shape["limit"]))
    return Part(force=size * typical(base) * np.tanh(flow))
