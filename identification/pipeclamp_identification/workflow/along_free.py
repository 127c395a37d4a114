"""What a law's error along free motions alone calls for: nothing more, or sines, which a diagnosis can read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE, MATERIAL_FORCE_SHARE
from pipeclamp_identification.fitting.free_misfit import FreeMisfit
from pipeclamp_identification.fitting.misfit import overall_nrmse
from pipeclamp_identification.loops.scatter import off_neighbours
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import CELSIUS

DENSE_PER_CYCLE = 20
"""Samples of a cycle from which on neighbours show noise: fewer differ by the motion itself."""
SELDOM = 5.0
"""Per cent of the time at either end of the tracked frequency that needn't be tested: it starts in the middle of the
law's range, wherever the motion does."""


@dataclass(frozen=True)
class AlongFree:
    """What a law errs along free motions, and what of it is scatter.

    Attributes:
        nrmse: error as a share of the rms force.
        scatter: what noise and scatter make of it, likewise; None where nothing tells that.
        of_sines: whether the scatter of the law's own sines tells that, not the noise between samples.
        reach: largest displacement, frequencies and temperatures of the motions: what sines would have to cover.
    """

    nrmse: float
    scatter: float | None
    of_sines: bool
    reach: Limits

    @property
    def scatter_explains(self) -> bool:
        """Whether no more is left than what a complete law leaves, by the thresholds of a diagnosis."""
        scatter = self.scatter or 0.0
        beyond = math.sqrt(max(self.nrmse**2 - scatter**2, 0.0))
        return beyond <= max(FORM_NOISE_SHARE * scatter, MATERIAL_FORCE_SHARE)

    def scatter_words(self) -> str:
        """Say what of the error is scatter, and what tells it."""
        if self.scatter is None:
            return "scatter isn't known: these motions don't repeat, and their samples lie too far apart to show noise"
        by = "that of the law's own sines" if self.of_sines else "the noise between neighbouring samples"
        return f"scatter alone makes {self.scatter:.2%}, judged by {by}, since these motions don't repeat"

    def words(self) -> str:
        """Say what it calls for."""
        if self.scatter_explains:
            return "Free motion: beyond scatter nothing is found missing along these motions."
        return (
            "Free motion: beyond scatter the law lacks something. What it is, a diagnosis finds from "
            "sines: those that the law was identified from, or a campaign of them that reaches as far as these motions."
        )


def along_free(runs: Sequence[FreeMisfit]) -> AlongFree:
    """Judge a law's error along runs of free motion, one at least.

    No motion repeats, so that cycles can't show its scatter. What is taken for it is the larger of two: the noise
    between neighbouring samples, which a filter makes look smaller than it is, and the scatter of the law's own sines.
    Samples as far apart as corner points of a loop show no noise.
    """
    dense = [run for run in runs if _is_dense(run)]
    of_sines = runs[0].scatter_on_sines
    of_noise = (
        math.sqrt(sum(len(run.time) * _noise_variance(run) for run in dense) / sum(run.squared_force for run in dense))
        if dense
        else None
    )
    told = [scatter for scatter in (of_noise, of_sines) if scatter is not None]
    by_sines = of_noise is None or (of_sines or 0.0) > of_noise
    return AlongFree(overall_nrmse(runs), max(told, default=None), by_sines, _reach(runs))


def _is_dense(run: FreeMisfit) -> bool:
    """Tell whether steps from sample to sample are as small as those of a sine that is sampled often enough."""
    step, size = np.sqrt(np.mean(np.diff(run.y) ** 2)), np.std(run.y)
    return len(run.y) >= 3 and bool(step <= 2 * math.sin(math.pi / DENSE_PER_CYCLE) * size)


def _noise_variance(run: FreeMisfit) -> float:
    """Give the noise of the measured force in N2; what the law's own corners add to it is none."""
    return min(_between_neighbours(run, force) for force in (run.measured, run.measured - run.computed))


def _between_neighbours(run: FreeMisfit, force: Array) -> float:
    off, usual = off_neighbours(run.time, force)
    return float(np.mean(off[usual] ** 2)) if np.any(usual) else 0.0


def _reach(runs: Sequence[FreeMisfit]) -> Limits:
    frequency = np.percentile(np.concatenate([run.frequency for run in runs]), (SELDOM, 100.0 - SELDOM))
    largest = max(float(np.max(np.abs(run.y))) for run in runs)
    known = [run.temperature_K - CELSIUS for run in runs if math.isfinite(run.temperature_K)]
    reach = Limits(amplitude=(0.0, largest), frequency=(float(frequency[0]), float(frequency[1])))
    return reach.with_range("T", (min(known), max(known))) if known else reach
