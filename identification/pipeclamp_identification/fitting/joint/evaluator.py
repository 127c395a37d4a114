"""A law's weighted residuals, and their derivatives, as functions of its free parameters."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipeclamp_identification.fitting.observations import Observations
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.law import Equations, smoothing
from pipeclamp_models.realise.force import LawForce, force_of_equations


def smoothing_of(observations: Observations) -> tuple[float, float]:
    """Give the velocity and displacement within which a law fitted to observations rounds its steps, mm/s and mm."""
    A, f = observations.motion.slow["A"], observations.motion.slow["f"]
    return smoothing(float(np.min(A)), float(np.min(f)))


@dataclass
class Remembered:
    """The law's force and Jacobian at values of its parameters; remembers the last two evaluations.

    Two, for a step that is tried and refused leaves the fit at the point before.
    """

    observations: Observations
    equations: Equations
    smoothing: tuple[float, float]
    _known: dict[bytes, LawForce] = field(default_factory=dict)

    def at(self, values: Array) -> LawForce:
        """Give force and Jacobian at values in the order of the equations' parameters."""
        key = values.tobytes()
        if key not in self._known:
            while len(self._known) > 1:
                del self._known[next(iter(self._known))]
            self._known[key] = force_of_equations(
                self.equations, values, self.smoothing, self.observations.motion, derivatives=True
            )
        return self._known[key]


@dataclass(frozen=True)
class Evaluator:
    """The law's weighted residuals as a function of the free parameters, the others at their values."""

    law: Remembered
    values: Array
    free: IntArray

    @property
    def observations(self) -> Observations:
        """What the law is held against."""
        return self.law.observations

    def law_force(self, free_values: Array) -> LawForce:
        """Give force and Jacobian for values of the free parameters."""
        values = self.values.copy()
        values[self.free] = free_values
        return self.law.at(values)

    def residual(self, free_values: Array) -> Array:
        """Give the weighted residuals, flat; values beyond all reason count as huge, not as NaN."""
        residual = self.observations.residual(self.law_force(free_values)).ravel()
        return residual if np.isfinite(residual).all() else np.nan_to_num(residual, nan=1e6, posinf=1e6, neginf=-1e6)

    def jacobian(self, free_values: Array) -> Array:
        """Give the residuals' derivatives by the free parameters, shape (residuals, free)."""
        slopes = self.observations.residual_slopes(self.law_force(free_values), self.free)
        slopes = slopes.reshape(len(self.free), slopes.shape[1] * slopes.shape[2]).T
        return slopes if np.isfinite(slopes).all() else np.nan_to_num(slopes)
