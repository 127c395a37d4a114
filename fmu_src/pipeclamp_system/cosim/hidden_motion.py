"""How much of the clamps' motion a co-simulation's steps don't show.

Over a macro step the forces are linear, and a pipe answers to them with every mode that it has. A lightly damped mode
near a multiple of the step's rate 1/h rings with the corners of the forces. That exchanges hardly any energy, so the
energy balance is silent, but where the points of the steps lie on the ringing it looks like slow motion, the same at
every point of a cycle. What tells is that displacement and velocity don't belong together then.
"""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array


def hidden_share(time: Array, displacement: Array, velocity: Array) -> float:
    """Give the share of a clamp's motion that passes between the communication points; the largest of all clamps.

    The rms of Delta s/h - (v0 + v1)/2 over that of (v0 + v1)/2. Of a sine in steps of h it is (omega h)^2/12, as is the
    error of forces that are taken as linear over a step.

    Args:
        time: communication points, s, (n,).
        displacement: of each clamp there, m, (n, clamps).
        velocity: m/s, (n, clamps).
    """
    h = np.diff(time)[:, np.newaxis]
    mean = (velocity[1:] + velocity[:-1]) / 2
    missing = (h * (np.diff(displacement, axis=0) / h - mean) ** 2).sum(axis=0)
    shown = (h * mean**2).sum(axis=0)
    moving = shown > 0
    return float(np.sqrt(missing[moving] / shown[moving]).max(initial=0.0))
