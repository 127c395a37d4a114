"""Physics that no effect of the catalogue imitates: the honest answer is `unknown`."""

from __future__ import annotations

import numpy as np
from hidden import Kind, Shape, typical
from truth import T0, BaseLaw, Motion, Part


def displacement_velocity(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Even-order coupling y v: the damping differs between the two halves of the stroke."""
    return Part(force=size * typical(base) * motion.y * motion.v / 10.0)


def velocity_squared(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """An even force v^2, as of flow that pulls one way."""
    return Part(force=size * typical(base) * (motion.v / 20.0) ** 2)


def static_friction(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Sticking: a peak of force after each reversal that dies out within a fixed path."""
    A = motion.A
    travelled = np.where(motion.v > 0, motion.y + A, A - motion.y)
    peak = np.exp(-(((travelled - 0.06) / 0.03) ** 2))
    return Part(force=size * typical(base) * np.sign(motion.v) * peak)


def mains_hum(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Hum of the mains, 50 Hz, at any phase in each run."""
    phase = 50.0 * motion.random[:, 3:4]
    return Part(force=size * typical(base) * np.sin(2 * np.pi * 50.0 * motion.time + phase))


def subharmonic(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """A motion of half the frequency that the drive excites."""
    force = size * typical(base) * np.cos(np.pi * motion.f * motion.time + shape["delay"])
    return Part(force=motion.A * force)


def impact(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Backlash with impact: one contact struck on the way up rings and dies out."""
    place = shape["place"] * 0.3
    peak = np.abs(motion.tones[0][1])[:, None]
    turn = 2 * np.pi * motion.f * motion.time + np.angle(motion.tones[0][1])[:, None]
    strike = -np.arccos(np.minimum(place / peak, 0.95))
    elapsed = (turn - strike) % (2 * np.pi) / (2 * np.pi * motion.f)
    speed = 2 * np.pi * motion.f * peak
    ring = np.exp(-elapsed / 0.012) * np.sin(2 * np.pi * 45.0 * elapsed)
    return Part(force=size * typical(base) * speed / 10.0 * ring)


def amplitude_and_temperature(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Stiffness that falls with T in large loops and rises in small ones."""
    return Part(stiffness=1 + size * np.log(motion.A / 0.6) * (motion.T - T0) / 100)


def resonance(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """The fixture resonates near one frequency of the test plan."""
    return Part(stiffness=1 + size * np.exp(-(((motion.f - 2.7) / 0.7) ** 2)) * np.ones_like(motion.A))


def amplitude_phase(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """Elastic force that lags by an angle that changes sign with A, as no delay does."""
    turn = size * np.log(motion.A / 0.6)
    return Part(force=turn * base.k1(motion) * motion.v / (2 * np.pi * motion.f))


def compressed_force(motion: Motion, base: BaseLaw, rough: bool, size: float, shape: Shape) -> Part:
    """The amplifier gives less beyond a force on its one side."""
    level = 0.45 * typical(base)
    return Part(channel=lambda _, force: force - size * np.maximum(force - level, 0.0))


UNLISTED: dict[str, Kind] = {
    "displacement_velocity": Kind(displacement_velocity),
    "velocity_squared": Kind(velocity_squared),
    "static_friction": Kind(static_friction),
    "mains_hum": Kind(mains_hum),
    "subharmonic": Kind(subharmonic),
    "impact": Kind(impact),
    "amplitude_and_temperature": Kind(amplitude_and_temperature),
    "resonance": Kind(resonance),
    "amplitude_phase": Kind(amplitude_phase),
    "compressed_force": Kind(compressed_force, most=0.9),
}
