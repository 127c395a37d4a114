"""Springs and dampers without memory, each as its source writes it; functions as in `hidden`.

Velocities of the test plans reach 30 to 50 mm/s, amplitudes 0.2 to 1 mm.
"""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import BaseLaw, Motion, Part

SLIDES = 0.2
"""Velocity in mm/s at which dry friction has turned round."""
SPEED = 20.0
"""mm/s at which the forces of dampers are stated."""


def arctan_spring(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring that saturates slowly: its force falls short of the last part by 1/y."""
    return Part(force=size * typical(base) * np.arctan(motion.y / shape["limit"]) * 2 / np.pi)


def lateral_springs(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Two pressed springs across the motion, which push away from the middle (smooth and discontinuous oscillator)."""
    aside = 2 * shape["limit"]
    length = 1.3 * aside
    return Part(force=size * base.k10 * motion.y * (1 - length / np.hypot(motion.y, aside)))


def sine_spring(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A periodic potential, as of teeth or grooves."""
    return Part(force=size * typical(base) * np.sin(2 * np.pi * motion.y / (6 * shape["limit"])))


def log_spring(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A spring that softens for ever."""
    return Part(force=size * typical(base) * np.sign(motion.y) * np.log1p(np.abs(motion.y) / shape["limit"]))


def pressed_contact(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Round bodies pressed together, which part where the motion pulls further than they were pressed."""
    pressed = np.maximum(1 + motion.y * np.copysign(1.0, shape["sign"]) / shape["stop"], 0.0)
    return Part(force=size * typical(base) * np.copysign(1.0, shape["sign"]) * (pressed**1.5 - 1))


def magnets(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A magnet between two that repel it, as dipoles."""
    share = motion.y / (4 * shape["stop"])
    return Part(force=size * typical(base) * ((1 - share) ** -4 - (1 + share) ** -4))


def limited_chain(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Rubber whose chains have an end."""
    stretched = motion.y / (2.2 * shape["stop"])
    return Part(force=size * base.k10 * motion.y * stretched**2 / (1 - stretched**2))


def eddy_brake(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A brake whose own currents push its field away: beyond a speed its force falls."""
    speed = motion.v / (10 * shape["speed"])
    return Part(force=size * typical(base) * 2 * speed / (1 + speed**2))


def activated_flow(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Flow by jumps over barriers, which stress makes easier."""
    return Part(force=size * typical(base) * np.arcsinh(motion.v / shape["speed"]))


def squeeze_film(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Oil squeezed out between two plates, the more slowly the nearer they are."""
    return Part(force=size * typical(base) * motion.v / SPEED / (1 - motion.y / (2.5 * shape["stop"])) ** 3)


def thinning_oil(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A melt or silicone oil that thins beyond a rate of shear."""
    thinned = (1 + (motion.v / (6 * shape["speed"])) ** 2) ** ((0.2 - 1) / 2)
    return Part(force=size * typical(base) * motion.v / SPEED * thinned)


def yielding_paste(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A paste that hardly flows below a stress."""
    return Part(force=size * typical(base) * np.sign(motion.v) * -np.expm1(-np.abs(motion.v) / (6 * shape["speed"])))


def lateral_damper(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A viscous damper across the motion: it is moved only off the middle."""
    aside = 3 * shape["limit"]
    return Part(force=size * typical(base) * motion.v / SPEED * motion.y**2 / (aside**2 + motion.y**2))


def capstan(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Friction of a rope that is wound further round as the displacement grows."""
    wound = np.exp(motion.y * np.copysign(1.0, shape["sign"]) / shape["stop"])
    return Part(force=size * typical(base) * wound * np.tanh(motion.v / SLIDES))
