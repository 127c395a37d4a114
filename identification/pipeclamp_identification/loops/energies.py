"""Energies of a law's loops, and what they owe to its parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.realise.force import LawForce, known_jacobian
from pipeclamp_models.realise.motion import Motion


def metric_slopes(motion: Motion, law_force: LawForce, parameters: IntArray) -> Array:
    """Give the derivatives of log dW and log W by some of the parameters, shape (P, R, 2).

    Where a law makes energy instead of dissipating it, nan.
    """
    linear = _energies_at_extremes(motion, law_force.force)
    energies = linear(law_force.force[None])[0]
    return _slopes(linear, law_force, parameters) / np.where(energies > 0, energies, np.nan)


def energy_slopes(motion: Motion, law_force: LawForce, parameters: IntArray) -> Array:
    """Give the derivatives of dW and W in J by some of the parameters, shape (P, R, 2).

    Where a law's force is beyond all numbers they are 0: a fit has no way on from there.
    """
    return _slopes(_energies_at_extremes(motion, law_force.force), law_force, parameters)


def _slopes(linear: Callable[[Array], Array], law_force: LawForce, parameters: IntArray) -> Array:
    slopes = known_jacobian(law_force).through(linear, parameters)
    return slopes if np.isfinite(slopes).all() else np.where(np.isfinite(slopes), slopes, 0.0)


def _energies_at_extremes(motion: Motion, force: Array) -> Callable[[Array], Array]:
    """Give the linear map that makes dW and W in J, (K, R, 2), of courses (K, R, n) where this force has its extremes.

    It gives the force's own energies, and their derivatives of its derivatives.
    """
    dissipates, lever = motion.v * motion.h, motion.slow["A"][:, 0] / 2
    rows, highest, lowest = np.arange(len(force)), force.argmax(axis=1), force.argmin(axis=1)

    def energies(courses: Array) -> Array:
        found = np.empty((*courses.shape[:2], 2))
        found[:, :, 0] = np.add.reduce(courses * dissipates, 2)
        found[:, :, 1] = (courses[:, rows, highest] - courses[:, rows, lowest]) / 2 * lever
        return found / 1e3

    return energies


def stiffness_of_energy(elastic_J: float, amplitude_mm: float) -> float:
    """Give the stiffness in N/mm that belongs to W in J, k = 2 W/X0^2, Eq. 4."""
    return 2e3 * elastic_J / amplitude_mm**2


def loop_energies(motion: Motion, force: Array) -> tuple[Array, Array]:
    """Give dW and W in J of periodic loops, Eq. 2 and 4: dW = sum F v h, W = (Fmax - Fmin)/2 X0/2; shape (R,) each."""
    dissipated = np.sum(force * motion.v * motion.h, axis=1) / 1e3
    elastic = (force.max(axis=1) - force.min(axis=1)) / 2 * motion.slow["A"][:, 0] / 2e3
    return dissipated, elastic
