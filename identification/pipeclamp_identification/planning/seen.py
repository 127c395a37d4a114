"""Lack of fit that tests would show where a law lacks something: the test of a diagnosis, told before the tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from pipeclamp_identification.diagnosis.evidence import LOW_HARMONICS
from pipeclamp_identification.diagnosis.thresholds import REAL_LACK_CHANCE
from pipeclamp_identification.fitting.smooth_trends import smooth_functions
from pipeclamp_identification.signals.chances import squares_of_chance
from pipeclamp_models.base.arrays import Array, IntArray

P_VALUES = 4
"""Chances of which a diagnosis takes the least. The fourth, of stiffness and damping that follow one condition, is left
aside here: it adds little to that of one harmonic alone. It sees a constant force sooner, of which a plan says less."""


@dataclass(frozen=True, eq=False)
class Lack:
    """What follows the conditions in tests of E things that a law lacks, each in its size, and what noise makes of it.

    Attributes:
        freedoms: of noise in the harmonics that are looked at together, shape (K,), K sets of them.
        shown: squares that each makes there, over noise, shape (E, K).
        critical: squares of noise alone that are real lack, shape (K,).
        excess: mean square that follows the conditions, N2, shape (E,).
        by_noise: variance of what noise makes of that by itself, N4.
        beside: variance of what noise makes of it beside each, N4, shape (E,).
    """

    freedoms: Array
    shown: Array
    critical: Array
    excess: Array
    by_noise: float
    beside: Array

    def chance(self, times: Array, least: float) -> Array:
        """Give the chance that a diagnosis calls it real and material, in so many times those sizes, shape (E,).

        Args:
            times: shape (E,).
            least: rms force that is material, N.
        """
        squares = times[:, None] ** 2 * self.shown
        # a sum of squares is about normal, with this mean and variance
        away = (self.freedoms + squares - self.critical) / np.sqrt(2 * (self.freedoms + 2 * squares))
        real = ndtr(away).max(axis=1)
        deviation = np.sqrt(self.by_noise + times**2 * self.beside)
        material = ndtr((times**2 * self.excess - least**2) / np.maximum(deviation, 1e-300))
        return np.asarray(np.minimum(real, material))


def lack_of(grid: Mapping[str, Array], runs: Array, covariance: Array, slopes: Array, does: Array) -> Lack:
    """Give the lack of fit that tests would show.

    Args:
        grid: A (mm), f (Hz), T (K), shape (R,) each.
        runs: how many there are at each condition, shape (R,).
        covariance: of the harmonics of one run, N2, shape (R, m, m).
        slopes: derivatives of the harmonics by the law's parameters, N, shape (P, R, m).
        does: harmonics that each of E things adds, N, shape (E, R, m).
    """
    tested = np.flatnonzero(runs)
    count = runs[tested].astype(np.intp)
    weight = np.sqrt(count)[:, None]
    smooth = _smooth(grid, tested, count)
    roots = np.linalg.cholesky(covariance[tested])
    fitted, lacking = (
        np.moveaxis(np.linalg.solve(roots, np.moveaxis(one[:, tested], 0, -1)), -1, 0) for one in (slopes, does)
    )
    left, singular, right = np.linalg.svd(_columns(weight * fitted), full_matrices=False)
    kept = singular > 1e-8 * singular[0]
    basis, back = left[:, kept], right[kept].T / singular[kept]
    taken = basis.T @ (weight * lacking).reshape(len(does), -1).T
    scale = norms_of(weight * fitted)
    in_N = does[:, tested] - np.einsum("prm,pe->erm", slopes[:, tested] / scale[:, None, None], back @ taken)
    white = lacking - (basis @ taken).T.reshape(lacking.shape) / weight
    counted = smooth * count[:, None]
    by_channel = np.sum(np.einsum("rq,erm->eqm", counted, white) ** 2, axis=1)
    by_law = np.einsum("rq,rmp->qmp", smooth * weight, basis.reshape(*lacking.shape[1:], -1))
    freedoms = np.maximum(smooth.shape[1] - np.sum(by_law**2, axis=(0, 2)), 1.0)
    channels = len(freedoms)
    low = min(2 * LOW_HARMONICS + 1, channels)
    chosen = np.stack([np.ones(channels), np.arange(channels) < low, *np.eye(channels)])
    together = chosen @ freedoms
    chances = REAL_LACK_CHANCE / P_VALUES / np.array([1, 1, *[channels] * channels])
    parts = np.where(np.arange(channels) > 0, 0.5, 1.0)
    squares = np.sum(np.einsum("rq,erm->eqm", counted, in_N) ** 2, axis=1)
    variance = np.diagonal(covariance[tested], axis1=1, axis2=2)
    noise = (np.sum(counted * smooth, axis=1) @ variance) / smooth.shape[1]
    total = float(count.sum())
    return Lack(
        together, by_channel @ chosen.T, squares_of_chance(chances, together), squares @ parts / total,
        float(np.sum((parts * noise) ** 2 * 2 * freedoms)) / total**2,
        squares @ (4 * parts**2 * noise) / total**2,
    )  # fmt: skip


def _smooth(grid: Mapping[str, Array], tested: IntArray, count: IntArray) -> Array:
    """Give the smooth functions of the tests' conditions, a row for each condition, shape (R, q)."""
    rows = np.repeat(tested, count)
    functions = smooth_functions(grid["A"][rows], grid["f"][rows], grid["T"][rows], (), [None] * len(rows))
    return np.asarray(functions[np.cumsum(count) - 1])


def norms_of(columns: Array) -> Array:
    """Give the length of each of several columns, shape (P, R, m); one where there is nothing."""
    norms = np.sqrt(np.sum(columns**2, axis=(1, 2)))
    return np.where(norms > 0, norms, 1.0)


def _columns(slopes: Array) -> Array:
    """Give derivatives as columns of length one, shape (R m, P)."""
    return np.asarray((slopes / norms_of(slopes)[:, None, None]).reshape(len(slopes), -1).T)
