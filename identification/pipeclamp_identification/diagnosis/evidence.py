"""Evidence: whether what a fitted law leaves over follows the conditions.

Evidence is counted in whitened harmonics per run, never in raw samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.left_out import Whitened
from pipeclamp_identification.diagnosis.noise import UNSEEN_VARIANCE, NoiseModel
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.chances import of_larger_ratio, of_larger_squares, ratio_of_chance
from pipeclamp_models.base.arrays import Array

INDEPENDENT = 0.05
"""A change of which the law's parameters leave less than this share is one that they make themselves."""
CHANCE_STANDARD_ERRORS = 2.0
"""Standard errors by which scatter may have added to what follows the conditions, or hidden of it."""
MEAN_BY_CHANCE = float(of_larger_squares(CHANCE_STANDARD_ERRORS**2, 1)) / 2
"""Chance by which scatter may have made what is left of mean forces: that of so many standard errors, on one side."""
SCATTERED = 1e-3
"""Share of a harmonic's variance below which its being scatter from run to run leaves it as well known as noise."""
LOW_HARMONICS = 7
"""Most of what loops can miss shows up to this harmonic."""


DRIFT = 5.0
"""Standard errors by which a trend of stiffness or damping along cycles must differ from none to be taken for real."""
DRIFT_CHANCE = 0.01
"""And runs that drift each its own way make such a trend with less than this chance: a drive's frequency that creeps up
in one and down in the next moves damping, and few cycles tell their noise but roughly."""


def drifts(loops: Loops) -> bool:
    """Tell whether stiffness or damping drifts along the cycles inside records, over all runs together."""
    slopes, weights = [], []
    for row, force in enumerate(loops.force_per_cycle):
        cycles = loops.cycles[row]
        if len(cycles) < 3:
            continue
        complex_stiffness = force[:, 1] / loops.displacement_per_cycle[row][:, 1]
        parts, size = np.stack([complex_stiffness.real, complex_stiffness.imag]), abs(complex_stiffness.mean())
        centred = cycles - cycles.mean()
        spread = float(centred @ centred)
        slope = parts @ centred / spread
        rest = parts - parts.mean(axis=1, keepdims=True) - slope[:, None] * centred
        error = np.maximum(np.sum(rest**2, axis=1) / (len(cycles) - 2), 1e-12 * size**2) / spread
        slopes.append(slope / size)
        weights.append(size**2 / error)
    if len(slopes) <= 3:
        return False
    # Errors from few cycles are rough: runs count by the median of their neighbours, not by luck.
    weight = np.minimum(weights, np.median(weights, axis=0))
    total = np.sum(weight, axis=0)
    trend = np.sum(weight * slopes, axis=0) / total
    free = len(slopes) - 1
    between = np.sum((weight * (slopes - trend)) ** 2, axis=0) * len(slopes) / free
    alike = of_larger_ratio(trend**2 * total**2 / np.maximum(between, np.finfo(np.float64).tiny), 1, free)
    return bool(np.any((np.abs(trend) > DRIFT / np.sqrt(total)) & (alike < DRIFT_CHANCE)))


@dataclass(frozen=True)
class LackOfFit:
    """What of the residuals follows the conditions, against what noise alone would make of it.

    Attributes:
        p_value: chance that noise alone makes so much: over all harmonics, over the low ones, in one harmonic
            alone, or as stiffness or damping that follows one condition or a constant force, whichever is least likely,
            times four.
        share: force that follows the conditions, rms in N, as a share of the force noise per sample.
        sure_share: the same, less what scatter may have added to it by chance; at least what no run can differ by.
        most_share: the same, with what scatter may have taken from it by chance.
        by_channel: its mean square in each harmonic part, N2, shape (2 H + 1,); below zero where noise happened to be
            small. Of the mean force only what scatter can't have made, in the shares too.
    """

    p_value: float
    share: float
    sure_share: float
    most_share: float
    by_channel: Array

    @property
    def excess(self) -> float:
        """Mean square of what follows the conditions, N2."""
        return _whole(_mean_and_loop(self.by_channel))

    @property
    def rms(self) -> float:
        """What follows the conditions, N."""
        return float(np.sqrt(max(self.excess, 0.0)))


def lack_of_fit(
    fitted: Whitened, plain: Array, noise: NoiseModel, smooth: Array, directed: Sequence[Array], noise_rms: Array
) -> LackOfFit:
    """Test whether residuals follow the conditions: significance in units of the noise, size in newtons.

    Args:
        fitted: whitened residuals (R, m) and derivatives (R, m, P).
        plain: the residuals in N, shape (R, m).
        noise: the noise model.
        smooth: orthonormal functions of the conditions, shape (R, q).
        directed: whitened changes of force that are looked for one by one, in d directions each, shape (d, R, m).
        noise_rms: force noise per sample of each run, N, shape (R,).
    """
    runs, channels, count = fitted.jacobian.shape
    explained = np.sum((smooth.T @ fitted.residual) ** 2, axis=0)
    flat = np.linalg.qr(_scaled(fitted.jacobian.reshape(runs * channels, count)))[0]
    taken = np.sum(np.einsum("rq,rmp->qmp", smooth, flat.reshape(runs, channels, -1)) ** 2, axis=(0, 2))
    freedoms = smooth.shape[1] - taken
    low = 2 * LOW_HARMONICS + 1
    p_values = [
        float(of_larger_squares(explained[:end].sum(), max(freedoms[:end].sum(), 1.0))) for end in (channels, low)
    ]
    leverage = np.sum(smooth**2, axis=1)
    seen = noise.variance < UNSEEN_VARIANCE
    variance = np.where(seen, noise.over_runs(noise.total_variance()), 0.0)
    expected = (leverage @ variance) * freedoms / smooth.shape[1]
    # Scatter is told by as many runs as smooth functions leave (Welch and Satterthwaite), noise by all samples.
    free = max(noise.runs - smooth.shape[1], 1)
    of_noise = leverage @ np.where(seen, noise.variance, 0.0)
    scattered = 1 - np.divide(of_noise, leverage @ variance, out=np.ones(channels), where=of_noise > 0)
    told_by = free / np.maximum(scattered, SCATTERED) ** 2
    wanted = np.maximum(freedoms, 1.0)
    alone = of_larger_ratio(explained / wanted, wanted, told_by)
    p_values.append(min(1.0, channels * float(alone.min())))
    p_values.append(_least_likely(directed, fitted.residual, flat, free))
    plain = np.where(seen, plain, 0.0)
    by_channel, chance = _above_scatter(plain, expected, smooth, wanted)
    # What runs can't differ by is no scatter, however large that is.
    own = leverage @ np.where(seen, noise.over_runs(noise.noise_and_mean()), 0.0) * freedoms / smooth.shape[1]
    by_form, chance_of_form = _above_scatter(np.where(seen, noise.no_scatter(plain), 0.0), own, smooth, wanted)
    by_channel[0] = by_form[0] = _mean_force(plain[:, 0], variance[:, 0], smooth, float(wanted[0]), float(told_by[0]))
    excess, of_form = _mean_and_loop(by_channel), _mean_and_loop(by_form)
    least, most = np.maximum(excess - chance, of_form - chance_of_form), excess + chance
    if least[1] > excess[1]:
        # scatter that happened to be small hides what it can't have made
        by_channel, excess, most = by_form, of_form, np.maximum(most, of_form)
    share, sure_share, most_share = (
        float(np.sqrt(_whole(one) / np.mean(noise_rms**2))) for one in (excess, least, most)
    )
    return LackOfFit(min(1.0, len(p_values) * min(p_values)), share, sure_share, most_share, by_channel)


def _above_scatter(plain: Array, expected: Array, smooth: Array, freedoms: Array) -> tuple[Array, Array]:
    """Give what follows the conditions above what scatter makes of it, mean squares in N2.

    Args:
        plain: residuals, N, shape (R, m).
        expected: squares that scatter makes of each harmonic part, N2, shape (m,).
        smooth: orthonormal functions of the conditions, shape (R, q).
        freedoms: squares of which each of these is a sum, shape (m,).

    Returns:
        by harmonic part, shape (m,), and what chance may have added to all but the mean force, shape (2,).
    """
    by_channel = (np.sum((smooth.T @ plain) ** 2, axis=0) - expected) / len(plain)
    error = expected * np.sqrt(2 / freedoms) / len(plain)
    # A harmonic's mean square is half its squared amplitude.
    by_channel[1:] /= 2
    error[1:] /= 2
    return by_channel, np.array([0.0, CHANCE_STANDARD_ERRORS * np.linalg.norm(error[1:])])


def _mean_force(mean: Array, variance: Array, smooth: Array, freedoms: float, told_by: float) -> float:
    """Give the mean square of mean forces that scatter can't have made, N2; below zero where that happened to be small.

    Of what follows the conditions, or is the same in all runs, whichever shows more. They may scatter by more than a
    loop's noise, and few runs tell by how much: the ratio to what is expected has the F distribution.

    Args:
        mean: each run's mean force that is left over, N, shape (R,).
        variance: that noise and scatter make of it, N2, shape (R,).
        smooth: orthonormal functions of the conditions, shape (R, q).
        freedoms: of them, less what the law's parameters take.
        told_by: degrees of freedom by which the variance is known.
    """
    runs = len(mean)
    found = []
    for functions, free in ((smooth, freedoms), (np.full((runs, 1), runs**-0.5), 1.0)):
        squares = float(np.sum((functions.T @ mean) ** 2))
        expected = float(np.sum(functions**2, axis=1) @ variance) * free / functions.shape[1]
        by_chance = expected * ratio_of_chance(MEAN_BY_CHANCE, free, told_by)
        found.append(max(squares - by_chance, min(squares - expected, 0.0)))
    return float(max(found) / runs)


def _mean_and_loop(by_channel: Array) -> Array:
    """Give the mean square in the mean force and in all other harmonics, N2, shape (2,)."""
    return np.array([by_channel[0], by_channel[1:].sum()])


def _whole(mean_and_loop: Array) -> float:
    """Give the mean square of both, N2: a mean that happens to scatter less takes nothing from what the loop lacks."""
    return float(np.maximum(mean_and_loop, 0.0).sum())


def _least_likely(directed: Sequence[Array], residual: Array, basis: Array, free: int) -> float:
    """Give the chance that noise alone makes the largest of several changes as large as it is.

    Args:
        directed: the changes, each a plane of d directions, shape (d, R, m); what the law's parameters can make of
            them counts for nothing.
        residual: shape (R, m).
        basis: orthonormal, of what the parameters can do, shape (R m, P).
        free: runs that told the size of the scatter.
    """
    chances = []
    for each in directed:
        plane = each.reshape(len(each), -1)
        own = plane - (plane @ basis) @ basis.T
        known = np.linalg.norm(own, axis=1) > INDEPENDENT * np.linalg.norm(plane, axis=1)
        if not known.any():
            continue
        span = np.linalg.qr(own[known].T)[0]
        explained = float(np.sum((span.T @ residual.ravel()) ** 2))
        chances.append(float(of_larger_ratio(explained / span.shape[1], span.shape[1], max(free, 1))))
    return min(1.0, len(chances) * min(chances)) if chances else 1.0


def _scaled(jacobian: Array) -> Array:
    norms = np.linalg.norm(jacobian, axis=0)
    return np.asarray(jacobian / np.where(norms > 0, norms, 1.0))
