"""An honest noise model: what scatters between cycles, and what scatters between runs.

Three parts. White sensor noise, each run with its own level. Slow, coloured noise: how much stronger scatter is at low
absolute frequencies, pooled over runs. Scatter from run to run: by how much a whole run's elastic, damping or mean
force, or the zero of its displacement, is off, estimated from what of the residuals doesn't follow the conditions
smoothly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.fitting.group_factors import GroupFactors, Poolings
from pipeclamp_identification.fitting.observations import WeightedLoops
from pipeclamp_identification.fitting.smooth_trends import smooth_basis, trends
from pipeclamp_identification.loops.loops import Loops, one_row_a_run
from pipeclamp_identification.signals.real_harmonics import as_real, elastic_and_damping, for_both_parts
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.realise.force import LawForce

WHITE_FROM = 5
"""Harmonics from this one on show the white level of a run."""
MOST_SCATTER = 0.02
"""Stiffness or damping that differs by more than this share from run to run is a law's error, not a rig's scatter; so
is a mean force that differs by more than this share of the force, a zero by more than this share of the amplitude."""
UNSEEN_VARIANCE = 1e15
"""Variance in N2 that stands for a harmonic which wasn't measured."""


def cycle_variance(loops: Loops) -> Array:
    """Give the variance of each harmonic's real (and imaginary) part of the mean loop, N2, shape (R, H + 1).

    A run's white level comes from its high harmonics; how far scatter at low absolute frequency lies above it is
    pooled over runs by octaves of frequency, so that five cycles of one run needn't tell.
    """
    count = loops.force.shape[1]
    single = np.full(loops.force.shape, np.nan)
    cycles = np.array([len(force) for force in loops.force_per_cycle], dtype=float)
    for row, force in enumerate(loops.force_per_cycle):
        if len(force) > 1:
            deviation = np.abs(force - force.mean(axis=0)) ** 2
            single[row] = deviation.sum(axis=0) / ((len(force) - 1) * np.where(np.arange(count) > 0, 2.0, 1.0))
    unseen = ~np.isfinite(loops.force_standard_error)
    single[unseen] = np.nan
    fallback = np.where(unseen, np.nan, loops.force_standard_error**2) * cycles[:, None]
    single = np.where(np.isnan(single), fallback, single)
    high = single[:, min(WHITE_FROM, count - 1) :]
    level = np.array([np.mean(row[np.isfinite(row)]) if np.isfinite(row).any() else np.nan for row in high])
    level = np.where(np.isfinite(level), level, np.nanmean(single, axis=1))
    ratio = single / level[:, None]
    # A run that is quieter than most doesn't count for more: what a law misses doesn't ask how quiet the sensor was.
    per_sample = level * loops.samples / cycles
    level = level * np.maximum(1.0, np.mean(per_sample) / per_sample)
    frequency = np.arange(count) * loops.frequency_Hz[:, None]
    octave = np.where(np.arange(count) > 0, np.floor(np.log2(np.maximum(frequency, 1e-9))), -np.inf)
    shape = np.ones_like(ratio)
    for band in np.unique(octave):
        members = (octave == band) & np.isfinite(ratio)
        if members.any():
            shape[octave == band] = max(1.0, float(np.mean(ratio[members])))
    floor = (1e-6 * loops.force_rms_N[:, None]) ** 2
    variance = level[:, None] * shape / cycles[:, None] + _from_displacement(loops, cycles)
    return np.where(unseen, UNSEEN_VARIANCE, np.maximum(variance, floor))


def _from_displacement(loops: Loops, cycles: Array) -> Array:
    """Give the variance that the displacement sensor's noise makes in force by the stiffness, N2, shape (R, H + 1)."""
    stiffness = np.abs(loops.force[:, 1]) / loops.amplitude_mm
    variance = np.zeros(loops.force.shape)
    for row, displacement in enumerate(loops.displacement_per_cycle):
        if len(displacement) > 1:
            upper = displacement[:, displacement.shape[1] // 2 :]
            noise = np.mean(np.abs(upper - upper.mean(axis=0)) ** 2) * len(upper) / (len(upper) - 1) / 2
            variance[row, :2] = stiffness[row] ** 2 * noise / cycles[row]
    return variance


@dataclass(frozen=True)
class NoiseModel:
    """The covariance of each run's harmonics.

    Attributes:
        variance: from cycles, N2, shape (R, 2 H + 1), ordered as `as_real` orders them.
        directions: what of the harmonics goes with what scatters from run to run.
        scatter: from run to run.
        most_mean: scatter of the mean force, N, beyond which it would be no rig's.
        stretches: into how many rows each row's run is parted, shape (R,). They are off alike, by what their run is
            off by, so that none of them tells of scatter what another doesn't.
    """

    variance: Array
    directions: Directions
    scatter: RunScatter
    most_mean: float
    stretches: Array | float = 1.0

    @property
    def is_no_rigs(self) -> bool:
        """Whether more would have to scatter from run to run than on any rig."""
        of_mean = 0.0 < self.most_mean <= self.scatter.mean_N
        return of_mean or max(self.scatter.stiffness, self.scatter.damping) >= MOST_SCATTER

    @property
    def mean_shows(self) -> bool:
        """Whether mean forces scatter by more than noise makes of them."""
        return self.scatter.mean_N**2 > float(np.median(self.variance[:, 0]))

    @property
    def zero_shows(self) -> bool:
        """Whether the displacement's zero scatters by more than noise makes of it."""
        made = np.sum((self.scatter.zero_mm * self.directions.shifted) ** 2, axis=1)
        return float(np.median(made)) > float(np.median(self.variance[:, 0]))

    def total_variance(self) -> Array:
        """Give the variance of each harmonic part, scatter between runs included, N2, shape (R, 2 H + 1)."""
        return np.asarray(self.noise_and_mean() + np.sum(self.scatter.by_harmonics(self.directions) ** 2, axis=0))

    def noise_and_mean(self) -> Array:
        """Give the variance of each harmonic part by noise and scatter of the mean force, N2, shape (R, 2 H + 1)."""
        variance = self.variance.copy()
        variance[:, 0] += self.scatter.mean_N**2
        return variance

    def over_runs(self, variance: Array) -> Array:
        """Give by what each row counts where rows are summed that are off alike, N2, shape (R, 2 H + 1).

        Args:
            variance: of noise and scatter, of that shape.
        """
        return np.asarray(self.variance + np.reshape(self.stretches, (-1, 1)) * (variance - self.variance))

    @property
    def runs(self) -> int:
        """How many runs the rows are of."""
        return round(float(np.sum(1.0 / np.broadcast_to(self.stretches, len(self.variance)))))

    def no_scatter(self, residual: Array) -> Array:
        """Give residuals, N, shape (R, 2 H + 1), without what scatter of harmonics can make of them."""
        for direction in self.directions.all():
            size = np.maximum(np.sum(direction**2, axis=1, keepdims=True), np.finfo(np.float64).tiny)
            residual = residual - np.sum(residual * direction, axis=1, keepdims=True) / size * direction
        return residual

    def whitener(self, discrepancy: float = 0.0) -> Array:
        """Give the matrices that make each row's residuals independent with variance one, shape (R, m, m).

        Rows of one run count less, so that together they tell of what their run is off by as one row does.

        Args:
            discrepancy: variance of each harmonic part that a law's form is granted besides the noise, N2.
        """
        size = self.variance.shape[1]
        covariance = self.scatter.covariance(self.directions) * np.reshape(self.stretches, (-1, 1, 1))
        covariance[:, np.arange(size), np.arange(size)] += self.variance + discrepancy
        lower = np.linalg.cholesky(covariance)
        return np.asarray(np.linalg.solve(lower, np.broadcast_to(np.eye(size), covariance.shape)))

    def share_trends(self, loops: Loops) -> Array:
        """Give stiffness and damping that follow each condition by itself, N, shape (c, 2, R, m)."""
        both = np.stack([self.directions.elastic, self.directions.damping])
        return np.asarray(trends(loops).T[:, None, :, None] * both)


def noise_model(loops: Loops, shifted: Array, residual: Array | None = None) -> NoiseModel:
    """Estimate the noise model.

    Args:
        loops: R runs.
        shifted: what a shift of the displacement does to the law's loops, N/mm, shape (R, 2 H + 1).
        residual: measured less law in N, shape (R, 2 H + 1), of the best law so far; None leaves out the scatter
            between runs.
    """
    variance = for_both_parts(cycle_variance(loops))
    off = Directions(*elastic_and_damping(as_real(loops.force)), shifted)
    most_mean = MOST_SCATTER * float(np.median(loops.force_rms_N))
    record = np.unique(loops.run, return_inverse=True)[1]
    rows = np.bincount(record)
    scatter = RunScatter()
    if residual is not None:
        smooth = smooth_basis(one_row_a_run(loops))
        mean = np.zeros_like(variance)
        mean[:, 0] = 1.0

        def between_runs(direction: Array, most: float) -> float:
            weight, along = (
                np.bincount(record, np.sum(values * direction / variance, axis=1)).astype(np.float64)
                for values in (direction, residual)
            )
            return _scatter(along, weight, smooth, most)

        scatter = RunScatter(
            stiffness=between_runs(off.elastic, MOST_SCATTER),
            damping=between_runs(off.damping, MOST_SCATTER),
            mean_N=between_runs(mean, most_mean),
            zero_mm=between_runs(off.shifted, MOST_SCATTER * float(np.median(loops.amplitude_mm))),
        )
    return NoiseModel(variance, off, scatter, most_mean, rows[record].astype(np.float64))


def _scatter(along: Array, weight: Array, smooth: Array, most: float) -> float:
    """Estimate the scatter from run to run of the share by which a direction's force is off; not above `most`.

    Each run's share is its residual's weighted projection on the direction. What follows the conditions smoothly is
    taken for missing physics; the rest is as large as cycle noise and scatter together make it (Paule and Mandel, J.
    Res. NBS 87, 1982: the mean over groups of unequal accuracy).

    Args:
        along: each run's residual times the direction over the variance, summed over harmonics and rows, shape (n,).
        weight: the direction's square over the variance, summed likewise, shape (n,).
        smooth: smooth functions of the runs' conditions, shape (n, q).
        most: the largest scatter that is told.
    """
    known = weight > 0
    share = along[known] / weight[known]
    free: int = len(share) - smooth.shape[1]
    if free < 1:
        return 0.0

    def squares_too_many(share_of_most: float) -> float:
        accuracy = 1.0 / np.sqrt((share_of_most * most) ** 2 + 1.0 / weight[known])
        basis = np.linalg.qr(accuracy[:, None] * smooth[known])[0]
        rest = accuracy * share
        rest = rest - basis @ (basis.T @ rest)
        return float(rest @ rest) - free

    if squares_too_many(0.0) <= 0.0:
        return 0.0
    if squares_too_many(1.0) >= 0.0:
        return most
    return most * float(brentq(squares_too_many, 0.0, 1.0))


@dataclass(frozen=True)
class WhitenedObservations(WeightedLoops):
    """Harmonics of loops in units in which noise is independent with variance one.

    Attributes:
        whitener: shape (R, m, m).
        factors: random factors of groups, where they have any; the units then are those of noise and factors together.
    """

    whitener: Array
    factors: GroupFactors | None = None

    def rows(self, chosen: IntArray) -> WhitenedObservations:
        """Give the observations of some of the loops, by their places, shape (n,)."""
        factors = None if self.factors is None else self.factors.rows(chosen)
        return WhitenedObservations(self.loops.rows(chosen), self.whitener[chosen], factors)

    def in_units(self, plain: Array) -> Array:
        """Give harmonics in N, shape (P, R, m), whitened by the noise alone."""
        return np.asarray(np.moveaxis(np.moveaxis(plain, 0, 1) @ np.swapaxes(self.whitener, 1, 2), 1, 0))

    def against_noise(self, law_force: LawForce) -> Array:
        """Give measured less law, whitened by the noise alone, shape (R, m)."""
        return np.asarray(np.einsum("rij,rj->ri", self.whitener, self.loops.plain_residual(law_force)))

    @cached_property
    def poolings(self) -> Poolings | None:
        """The random factors in units of the noise."""
        return None if self.factors is None else Poolings(self, self.factors)

    def factors_beside(self, law_force: LawForce) -> Array:
        """Give the likeliest factors of groups beside a law's force, shape (K,); none where there are none."""
        if self.poolings is None:
            return np.zeros(0)
        return self.poolings.beside(law_force).estimate(self.against_noise(law_force))

    def residual(self, law_force: LawForce) -> Array:
        """Give measured less law, whitened, shape (R, m)."""
        residual = self.against_noise(law_force)
        return residual if self.poolings is None else self.poolings.beside(law_force).without(residual)

    def residual_slopes(self, law_force: LawForce, parameters: IntArray) -> Array:
        """Give the derivatives of the residuals, shape (P, R, m)."""
        slopes = self.in_units(self.loops.plain_slopes(law_force, parameters))
        return slopes if self.poolings is None else self.poolings.beside(law_force).without(slopes)

    def compared(self, law_force: LawForce) -> int:
        """Give how many of the residuals are evidence."""
        return self.loops.compared(law_force)
