"""Factors of temperature, amplitude, frequency, cycles and a further column; functions as in `hidden`."""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import BaseLaw, Motion, Part

from beyond.plain import ACTIVATION

MIDDLE_FREQUENCY, MIDDLE_AMPLITUDE, MIDDLE_TEMPERATURE = 3.0, 0.4, 400.0
"""Hz, mm and K about which a factor turns."""
GLASSY = 12000.0
"""K, of the activation."""
SATURATES = 8.0
"""Level of the further column at which a field's force saturates; the column has 5, 10 and 20."""


def glass_transition(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that a polymer loses as heat lets its chains follow the motion: later, where that is faster."""
    slower = motion.f / MIDDLE_FREQUENCY * np.exp(GLASSY * (1 / motion.T - 1 / shape["contact"]))
    return Part(stiffness=1 - size / (1 + slower**2))


def payne(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A network of filler that is torn down with amplitude, and carries nothing in the end."""
    return Part(stiffness=1 + size / (1 + (motion.A / MIDDLE_AMPLITUDE) ** 3))


def moving_peak(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping with a peak over frequency, as one relaxation has it, which heat moves to higher frequencies."""
    slower = np.exp(ACTIVATION * (1 / motion.T - 1 / MIDDLE_TEMPERATURE))
    share = motion.f / MIDDLE_FREQUENCY * slower
    return Part(damping=1 + size * 2 * share / (1 + share**2))


def running_in(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping that grows as contacts run in: fast at first, and slowly for long."""
    return Part(damping=1 - size * np.expm1(-np.sqrt(motion.cycles_seen / shape["cycles"])))


def field_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A yield force that a field raises and saturates."""
    flow = np.tanh(motion.v / (2 * shape["speed"]))
    return Part(force=size * typical(base) * np.tanh(motion.u / SATURATES) * flow)
