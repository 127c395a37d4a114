"""What tests scatter about their law beside its parameters' covariance: from run to run, and by the law's form.

A run's share is by how much of its elastic, or of its damping force it is off. What a share is where the run's
conditions are left out follows from the fit's own derivatives, without another fit. The product of the two, with and
without, is on average the variance of what the law can't know: neither too small by what the run did to the fit, nor
too large by what it is worth to it. So between the levels of A and f. At their ends a law that has to do without the
tests there goes on by itself: inside the range what it is off with them counts, beyond it what it is off without.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.fitting.heldout import amplitude_and_frequency_groups
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.local_form import local_form
from pipeclamp_identification.fitting.observations import LoopObservations, loop_observations
from pipeclamp_identification.fitting.smooth_trends import smooth_basis
from pipeclamp_identification.loops.loops import Loops, by_stretch, one_row_a_run
from pipeclamp_identification.signals.levels import SAME_KELVIN, SAME_SHARE, number_levels
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.file import Foretold, Shares, Spread
from pipeclamp_models.law.range import rounded

FEWEST_LEVELS_FORETOLD = 3
"""Of a condition, that its law can be foretold from at its ends."""
DETERMINED_SHARE = 1e-10
"""Directions of the parameters of which the other runs know less than this share are left to the run itself."""


@dataclass(frozen=True)
class _Pair:
    """Stiffness and damping, in this order: shares of runs, shape (2, R), or their variances."""

    shares: Array
    noise: Array


def spread_of(fit: Fit, loops: Loops, observations: LoopObservations) -> Spread | None:
    """Give what the tests of a fit scatter about its law; None where there are too few runs to tell.

    Args:
        fit: the law with its force and derivatives on the tests.
        loops: the tests, one row a run.
        observations: the same, as observations.
    """
    if len(fit.law_force.force) != len(loops.run):  # what ages was fitted in stretches of cycles
        loops = by_stretch(loops)
        observations = loop_observations(loops)
    groups = amplitude_and_frequency_groups(loops)
    if groups.max() == 0 or not fit.fitted:
        return None
    left = _LeftOut(fit, observations.with_discrepancy(fit.law_force))
    with_all = _shares(left.residual, observations)
    ends = _ends(loops)
    at_end = np.any([number >= 0 for name, (number, _) in ends.items() if name in ("A", "f")], axis=0)
    numbers = 2 * len(np.unique(loops.run))
    free = numbers - len(fit.fitted)
    fitted_away = numbers / free if free > 0 else 1.0
    products = with_all.shares * np.where(at_end, fitted_away * with_all.shares, left.shares(groups))
    variance = np.mean(products, axis=1) - np.mean(with_all.noise, axis=1)
    of_runs = _of_runs(with_all, observations.runs)
    one_each = loops if observations.runs is None else one_row_a_run(loops)
    runs = _between_runs(of_runs, one_each)
    form = np.maximum(variance - runs, 0.0)
    beyond = {}
    for name, (number, step) in ends.items():
        outside = left.shares(number)
        known = number >= 0
        at_ends = np.mean((outside**2 - with_all.noise)[:, known], axis=1) - runs
        beyond[name] = Foretold(step=rounded(step), error=_deviations(np.maximum(at_ends, form)))
    local = local_form(one_each, np.sqrt(fitted_away) * of_runs.shares, of_runs.noise + runs[:, None], np.sqrt(form))
    return Spread(runs=_deviations(runs), form=_deviations(form), beyond=beyond, local=local)


class _LeftOut:
    """What a fit's law would leave over of tests that are left out of it, to first order."""

    def __init__(self, fit: Fit, observations: LoopObservations) -> None:
        self._observations = observations
        self._weight = np.where(observations.seen, 1 / observations.standard_error, 0.0)
        self.residual = np.where(observations.seen, observations.plain_residual(fit.law_force), 0.0)
        slopes = observations.plain_slopes(fit.law_force, fit.places) * self._weight
        norms = np.sqrt(np.sum(slopes**2, axis=(1, 2)))
        self._slopes = slopes / norms[:, None, None]
        flat = self._slopes.reshape(len(norms), -1)
        self._information = flat @ flat.T + np.diag(fit.precision / norms**2)

    def shares(self, groups: IntArray) -> Array:
        """Give the shares of runs of which each group (number from 0) is left out at a time, (2, R)."""
        residual = self.residual.copy()
        for group in range(int(groups.max()) + 1):
            own = np.flatnonzero(groups == group)
            slopes = self._slopes[:, own].reshape(len(self._slopes), -1)
            of_others = self._information - slopes @ slopes.T
            pulled = slopes @ (self.residual * self._weight)[own].ravel()
            moved = np.linalg.pinv(of_others, rcond=DETERMINED_SHARE, hermitian=True) @ pulled
            change = (moved @ slopes).reshape(len(own), -1)
            weight = self._weight[own]
            residual[own] += np.divide(change, weight, out=np.zeros_like(change), where=weight > 0)
        return _shares(residual, self._observations).shares


def _shares(residual: Array, observations: LoopObservations) -> _Pair:
    """Give the share by which each run's elastic and damping force is off, and what noise makes of it."""
    force = np.where(observations.seen, observations.harmonics, 0.0)
    noise = np.where(observations.seen, observations.standard_error, 0.0) ** 2
    shares, variances = [], []
    # With the motion a cosine, what loading and unloading share is in phase, the rest in quadrature.
    for first in (1, 2):
        direction = force[:, first::2]
        size = np.maximum(np.sum(direction**2, axis=1), 1e-300)
        shares.append(np.sum(residual[:, first::2] * direction, axis=1) / size)
        variances.append(np.sum(noise[:, first::2] * direction**2, axis=1) / size**2)
    return _Pair(np.stack(shares), np.stack(variances))


def _of_runs(found: _Pair, runs: IntArray | None) -> _Pair:
    """Give the mean over the stretches of each run, which share what the run is off by."""
    if runs is None:
        return found
    counts = np.bincount(runs)
    shares, noise = (
        np.stack([np.bincount(runs, row) / power for row in each])
        for each, power in ((found.shares, counts), (found.noise, counts**2))
    )
    return _Pair(shares, noise)


def _between_runs(found: _Pair, loops: Loops) -> Array:
    """Give the variance of shares between runs, (2,): of what doesn't follow conditions smoothly, less the noise."""
    basis = np.linalg.qr(smooth_basis(loops))[0]
    free = found.shares.shape[1] - basis.shape[1]
    if free < 1:
        return np.zeros(2)
    rest = found.shares - (found.shares @ basis) @ basis.T
    by_noise = np.sum(found.noise * (1 - np.sum(basis**2, axis=1)), axis=1)
    return np.asarray(np.maximum(np.sum(rest**2, axis=1) - by_noise, 0.0) / free)


def _ends(loops: Loops) -> Mapping[str, tuple[IntArray, float]]:
    """Give, by condition, which runs are at its lowest level (0) and highest (1; else -1), and how far these are off.

    That is how far they lie from their neighbours, rms over these runs.
    """
    return dict(_ends_of(loops))


def _ends_of(loops: Loops) -> Iterator[tuple[str, tuple[IntArray, float]]]:
    main = {"A": np.log(loops.amplitude_mm), "f": np.log(loops.frequency_Hz)}
    others = {"T": loops.temperature_K, "rho": loops.density_g_cm3, **loops.conditions}
    for name, values in {**main, **others}.items():
        if not np.all(np.isfinite(values)):
            continue
        near = np.exp(values) if name in main else values
        absolute = {"absolute": SAME_KELVIN} if name == "T" else {"relative": SAME_SHARE}
        levels: list[IntArray] = [level.rows for level in number_levels(near, **absolute)]
        if len(levels) < FEWEST_LEVELS_FORETOLD:
            continue
        middles = [float(np.mean(values[rows])) for rows in levels]
        number = np.full(len(values), -1, dtype=np.intp)
        number[levels[0]], number[levels[-1]] = 0, 1
        # errors grow with the way: their mean square belongs to that of the ways of the runs
        ways = np.where(number == 0, middles[1] - middles[0], middles[-1] - middles[-2])[number >= 0]
        yield name, (number, float(np.sqrt(np.mean(ways**2))))


def _deviations(variances: Array) -> Shares:
    stiffness, damping = np.sqrt(variances).tolist()
    return Shares(stiffness=rounded(stiffness), damping=rounded(damping))
