"""Springs and dampers without memory, each as its source writes it; functions as in `hidden`.

Velocities of the test plans reach 30 to 50 mm/s, amplitudes 0.2 to 1 mm, temperatures 20 to 300 degC.
"""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import BaseLaw, Motion, Part

SLIDES = 0.2
"""Velocity in mm/s at which dry friction has turned round."""
SPEED = 20.0
"""mm/s at which the forces of dampers are stated."""
SNAPS, SNAPS_WITHIN = 0.35, 40.0
"""Half the share of a clearance that a bimetal takes up, and the temperatures in K within which it does."""
BUMPER = 1.2
"""mm by which a bumper can be pressed together."""
ACTIVATION = 2500.0
"""K."""
MELTS_WITHIN = 30.0
"""K."""
SHARPER = 0.1
"""By which the tops of a serration are sharper than its valleys; 0 for a sine."""
LOCKED, LOCKS_WITHIN = 3.0, 0.25
"""By how much the viscosity rises, and within which share of the speed at which it does."""
JAMMED = 6.0
"""By how much jammed grains' viscosity rises, twice over."""
TORN = 0.15
"""Force at which a film tears, over its viscous force at the middle and `SPEED`."""


def detents(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A periodic potential with several valleys within the stroke, as of a serrated seat: broad valleys, sharp tops."""
    x = 2 * np.pi * motion.y / (2.5 * shape["limit"])
    return Part(force=size * typical(base) * np.sin(x) / (1 + SHARPER**2 + 2 * SHARPER * np.cos(x)) ** 2)


def bimetal_stop(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A round stop on both sides that a bimetal moves in about a temperature."""
    gap = shape["stop"] * (1 - SNAPS * (1 + np.tanh((motion.T - shape["contact"]) / SNAPS_WITHIN)))
    return Part(force=size * base.k10 * np.sign(motion.y) * np.maximum(np.abs(motion.y) - gap, 0.0) ** 1.5)


def bumpers(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A rubber bumper on each side, at another place, which can be pressed together so far only."""
    y, side = motion.y * np.copysign(1.0, shape["sign"]), np.copysign(1.0, shape["sign"])
    near, far = np.maximum(y - 0.3 * shape["stop"], 0.0), np.maximum(-y - 0.6 * shape["stop"], 0.0)
    return Part(force=size * base.k10 * side * (near / (1 - near / BUMPER) - far / (1 - far / BUMPER)))


def thickening_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A dense suspension whose grains lock beyond a speed: its viscosity rises by a step."""
    locked = 1 / (1 + np.exp(-(np.abs(motion.v) / (8 * shape["speed"]) - 1) / LOCKS_WITHIN))
    return Part(force=size * typical(base) * motion.v / SPEED * (1 + LOCKED * locked))


def melting_wax(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A wax with a yield stress, which it loses as it melts, and the viscosity of its melt."""
    solid = (1 - np.tanh((motion.T - shape["contact"]) / MELTS_WITHIN)) / 2
    yields, flows = np.tanh(motion.v / (2 * shape["speed"])), motion.v / SPEED
    return Part(force=size * typical(base) * (solid * yields + flows))


def cavitating_film(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Oil squeezed out between two plates, the more slowly the nearer they are; pulled apart, it tears."""
    side = np.copysign(1.0, shape["sign"])
    film = side * motion.v / SPEED / (1 - side * motion.y / (2.5 * shape["stop"])) ** 3
    return Part(force=size * typical(base) * side * np.maximum(film, -TORN))


def barrel(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """An oil that thins, driven past a piston through a bore that is widest off its middle."""
    narrow = 1 + (motion.y / shape["stop"] - np.copysign(0.03, shape["sign"])) ** 4
    return Part(force=size * typical(base) * narrow * motion.v / SPEED / (1 + np.abs(motion.v) / (6 * shape["speed"])))


def jammed_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Dense grains that jam at a speed, and are torn apart again beyond it."""
    x = motion.v / (8 * shape["speed"])
    return Part(force=size * typical(base) * motion.v / SPEED * (1 + JAMMED * x**2 / (1 + x**4)))


def struck_pad(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A pad that is struck on one side: it stiffens, and its damping grows with the square of the speed."""
    side = np.copysign(1.0, shape["sign"])
    pressed = np.maximum(side * motion.y - 0.2 * shape["stop"], 0.0) ** 2.5
    speed = side * motion.v * np.abs(motion.v) / SPEED**2
    return Part(force=size * base.k10 * side * pressed * np.maximum(1 + speed, 0.0))


def shifted_flow(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A magnetorheological damper's branches: flow that levels off, turned round earlier on the way back."""
    flow = motion.v / (2 * shape["speed"]) + 0.6 * np.tanh(motion.y / (0.1 * shape["limit"]))
    return Part(force=size * typical(base) * np.tanh(flow))
