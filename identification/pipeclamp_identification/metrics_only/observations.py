"""What a fit compares where there are no records: loops' dissipated and elastic energy, by the logs of their ratios."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.loops.energies import energy_slopes, loop_energies, metric_slopes
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import LawForce, force_of_law
from pipeclamp_models.realise.motion import Motion

METRICS = ("dW", "W")


@dataclass(frozen=True)
class MetricObservations:
    """Dissipated and elastic energy of loops whose records aren't there, compared by the logs of their ratios.

    Attributes:
        motion: sinusoids of the conditions, R rows.
        dissipated_energy, elastic_energy: dW and W in J, shape (R,).
        relative_error: standard error of dW and of W as a share, shape (R, 2).
        rounding: the part of it that rounding to the printed digits makes, same shape.
    """

    motion: Motion
    dissipated_energy: Array
    elastic_energy: Array
    relative_error: Array
    rounding: Array

    @property
    def are_linear(self) -> bool:
        """Logs of energies aren't."""
        return False

    @property
    def deny_constant_force(self) -> bool:
        """Nothing is known of forces at rest."""
        return False

    @property
    def show_shape(self) -> bool:
        """Two energies of a loop don't."""
        return False

    @property
    def runs(self) -> IntArray | None:
        """Each row is a run of its own."""
        return None

    def rows(self, chosen: IntArray) -> Self:
        """Give the observations of some of the loops."""
        return replace(
            self,
            motion=self.motion.rows(chosen),
            dissipated_energy=self.dissipated_energy[chosen],
            elastic_energy=self.elastic_energy[chosen],
            relative_error=self.relative_error[chosen],
            rounding=self.rounding[chosen],
        )

    def with_scatter(self, share: npt.ArrayLike) -> Self:
        """Give the same with another scatter beside the rounding: a share, or one of dW and one of W, shape (2,)."""
        return replace(self, relative_error=np.hypot(np.asarray(share), self.rounding))

    def as_shares(self) -> MetricShares:
        """Give the same, compared by shares in place of logs."""
        return MetricShares(
            self.motion, self.dissipated_energy, self.elastic_energy, self.relative_error, self.rounding
        )

    @property
    def force_amplitude(self) -> Array:
        """Half the force's range, from W = F X0/2."""
        return 2e3 * self.elastic_energy / self.motion.slow["A"][:, 0]

    def logs(self, force: Array) -> Array:
        """Give the logs of measured over computed dW and W, shape (R, 2), for forces on the motion.

        Where a law makes energy instead of dissipating it, or its force is beyond all numbers, nan.
        """
        measured = np.stack([self.dissipated_energy, self.elastic_energy], axis=1)
        computed = np.stack(loop_energies(self.motion, force), axis=1)
        usable = (computed > 0) & np.isfinite(computed)
        return np.asarray(np.log(measured / np.where(usable, computed, np.nan)))

    def residual(self, law_force: LawForce) -> Array:
        """Give the logs of measured over computed dW and W, over the relative error; shape (R, 2)."""
        return np.asarray(self.logs(law_force.force) / self.relative_error)

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals; a maximum's derivative is that at its place."""
        return np.asarray(-metric_slopes(self.motion, law_force, parameters) / self.relative_error)

    def compared(self, law_force: LawForce) -> int:
        """Give how many of the residuals are evidence: all of them."""
        return self.relative_error.size


def as_seen_at_few(few: MetricObservations, many: MetricObservations, law: Law) -> MetricObservations:
    """Give what was measured, with what few points of the cycle show otherwise than many, as a law has it.

    Fits near that law then come to the same at few points, which take less time.

    Args:
        few, many: the same R metrics, with the points of the cycle at which laws are evaluated.
        law: the law.
    """
    energies = (np.stack(loop_energies(each.motion, force_of_law(law, each.motion).force)) for each in (few, many))
    at_few, at_many = (np.where(np.isfinite(each) & (each > 0), each, np.nan) for each in energies)
    dissipated, elastic = np.nan_to_num(at_few / at_many, nan=1.0)
    return replace(
        few, dissipated_energy=many.dissipated_energy * dissipated, elastic_energy=many.elastic_energy * elastic
    )


@dataclass(frozen=True)
class MetricShares(MetricObservations):
    """The same compared by what is missing of them, as shares of 2 pi W and of W: as good as linear in the force.

    An effect that is far too small, or too large, can be sized so by one step, as a log's slope doesn't tell. What a
    fit comes to is where another one begins, to the logs.
    """

    @property
    def are_linear(self) -> bool:
        """The largest force is in proportion to the force as long as it stays at its place."""
        return True

    def residual(self, law_force: LawForce) -> Array:
        """Give what is missing of dW and W, as shares over the relative error; shape (R, 2)."""
        computed = np.stack(loop_energies(self.motion, law_force.force), axis=1)
        measured = np.stack([self.dissipated_energy, self.elastic_energy], axis=1)
        return np.asarray((measured - computed) / self._units)

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals; a maximum's derivative is that at its place."""
        return np.asarray(-energy_slopes(self.motion, law_force, parameters) / self._units)

    @property
    def _units(self) -> Array:
        whole = np.stack([2 * np.pi * self.elastic_energy, self.elastic_energy], axis=1)
        return np.asarray(whole * self.relative_error)
