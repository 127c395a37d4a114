"""Factors of temperature, amplitude, frequency, cycles and a further column; functions as in `hidden`."""

from __future__ import annotations

import numpy as np
from hidden import Shape, typical
from truth import T0, BaseLaw, Motion, Part

from beyond.plain import SPEED

MIDDLE_FREQUENCY, MIDDLE_AMPLITUDE = 3.0, 0.4
"""Hz and mm about which a factor turns."""
SATURATES = 8.0
"""Level of the further column at which a field's force saturates; the column has 5, 10 and 20."""
ACTIVATION = 1500.0
"""K."""


def glass_transition(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that falls by a step about a temperature."""
    return Part(stiffness=1 - size / (1 + np.exp(-(motion.T - shape["contact"]) / 20.0)))


def payne(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A network of filler that is torn down with amplitude, and carries nothing in the end."""
    return Part(stiffness=1 + size / (1 + (motion.A / MIDDLE_AMPLITUDE) ** 3))


def loss_peak(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping with a peak over frequency, as one relaxation has it."""
    share = motion.f / MIDDLE_FREQUENCY
    return Part(damping=1 + size * 2 * share / (1 + share**2) * np.ones_like(motion.A))


def running_in(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Damping that grows with the logarithm of cycles, as contacts run in."""
    return Part(damping=1 + size * np.log1p(motion.cycles_seen / (0.3 * shape["cycles"])))


def field_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A yield force that a field raises and saturates."""
    flow = np.tanh(motion.v / (2 * shape["speed"]))
    return Part(force=size * typical(base) * np.tanh(motion.u / SATURATES) * flow)


def warm_oil(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A viscous part whose viscosity is thermally activated."""
    thin = np.exp(ACTIVATION * (1 / motion.T - 1 / T0))
    return Part(force=size * typical(base) * motion.v / SPEED * thin)
