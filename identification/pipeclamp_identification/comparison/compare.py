"""Compare a law with a campaign: how much it errs, and where (docs/reference/answers.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pipeclamp_identification.campaign.free_motion import FreeRun
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.concentration import (
    cycles_sentence,
    drift_sentence,
    farthest_off,
    harmonic_sentence,
    hidden_sentence,
    region,
)
from pipeclamp_identification.comparison.conditions import Condition, conditions_of
from pipeclamp_identification.comparison.densest_region import region_sentence
from pipeclamp_identification.comparison.free_breakdown import FreeSamples, free_conditions
from pipeclamp_identification.comparison.free_concentration import OFTEN, free_words, outside_share
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.comparison.sums import RunSums, error_sums
from pipeclamp_identification.fitting.free_misfit import FreeMisfit, free_misfits
from pipeclamp_identification.fitting.misfit import RunMisfit, known_noise, misfits, overall_noise, overall_nrmse
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_models.base.units import celsius_of
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Law
from pipeclamp_models.law.range import outside_range


@dataclass(frozen=True)
class Comparison:
    """A law held against a campaign.

    Attributes:
        law: the law.
        campaign, loops: the tests.
        runs: the error on each run, in the campaign's order.
        free: the error on each run of free motion, likewise.
        outside: runs whose conditions lie outside the range the law was identified in, with what is outside.
    """

    law: Law
    campaign: Campaign
    loops: Loops
    runs: tuple[RunMisfit, ...]
    outside: dict[str, str]
    free: tuple[FreeMisfit, ...] = ()

    @property
    def nrmse(self) -> float:
        """Error over all samples as a share of the force."""
        return overall_nrmse((*self.runs, *self.free))

    @property
    def noise_nrmse(self) -> float:
        """The scatter of the sines, as a share of their force; of single cycles, only the noise between samples."""
        return overall_noise(self.runs)

    @property
    def known_noise(self) -> float | None:
        """The part of the error that is scatter; None where no run shows any, or a free motion, which never does."""
        return None if self.free else known_noise(self.runs, self.loops)

    @cached_property
    def free_samples(self) -> tuple[FreeSamples, ...]:
        """The error of each run of free motion, sample by sample."""
        return tuple(map(FreeSamples, self.free))

    @cached_property
    def free_varied(self) -> tuple[Condition, ...]:
        """What varies from run to run of free motion."""
        return free_conditions(self.campaign.free, self.free) if self.free else ()

    @cached_property
    def sums(self) -> tuple[RunSums, ...]:
        """The squared error of each run, split up."""
        return error_sums(self.campaign, self.loops, self.runs)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """The tests' conditions."""
        return conditions_of(self.campaign, self.loops)

    @property
    def varied(self) -> tuple[Condition, ...]:
        """The conditions that vary from run to run."""
        return tuple(condition for condition in self.conditions if condition.varies)

    @cached_property
    def farthest_off(self) -> str:
        """At which conditions the law is farthest off for the force there, in words; empty where it is alike."""
        return farthest_off(self.sums, self.varied, overall_nrmse(self.runs))

    @property
    def single_cycles(self) -> int:
        """Number of runs with a single cycle, which can't show scatter from cycle to cycle."""
        return sum(not run.scatter_known for run in self.sums)

    def worst_first(self) -> list[int]:
        """Give the rows of the runs by falling error."""
        return sorted(range(len(self.runs)), key=lambda row: -self.runs[row].nrmse)

    def worst_free_first(self) -> list[FreeMisfit]:
        """Give the runs of free motion by falling error."""
        return sorted(self.free, key=lambda run: -run.nrmse)


def compare(file: LawFile, campaign: Campaign, loops: Loops | None = None) -> Comparison:
    """Hold the law of a parameter file against a campaign, whose loops may be known already.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    law, loops = law_of(file), loops or loops_of(campaign)
    runs = misfits(law, campaign, loops) if campaign.runs else ()
    free: tuple[FreeMisfit, ...] = ()
    timed = campaign.time_measured and file.data.is_timed
    if campaign.free:
        others = zip(loops.run, loops.temperature_K.tolist(), strict=True) if runs else ()
        free = free_misfits(file, campaign.free, dict(others), timed=timed)
    outside = _outside(file, loops, timed) if runs else {}
    outside |= _free_outside(file, campaign.free, free) if free else {}
    return Comparison(law, campaign, loops, runs, outside, free)


def _free_outside(file: LawFile, runs: Sequence[FreeRun], misfits: Sequence[FreeMisfit]) -> dict[str, str]:
    columns = {
        "T": np.array([misfit.temperature_K for misfit in misfits]),
        "rho": np.array([run.setup.density for run in runs]),
        **{name: np.array([run.setup.conditions[name] for run in runs]) for name in runs[0].setup.conditions},
    }
    found = outside_range(file, [run.name for run in runs], columns)
    for misfit in misfits:
        sample = (FreeSamples(misfit),)
        texts = [
            f"{symbol} for {share:.0%} of the time"
            for index, symbol in enumerate(("A", "f"))
            if (share := outside_share(sample, index)) > OFTEN
        ]
        if texts:
            found[misfit.run] = "; ".join((*texts, *filter(None, [found.get(misfit.run)])))
    return found


def _outside(file: LawFile, loops: Loops, timed: bool) -> dict[str, str]:
    columns = {
        "A": loops.amplitude_mm, **({"f": loops.frequency_Hz} if timed else {}), "T": loops.temperature_K,
        "rho": loops.density_g_cm3, **loops.conditions,
    }  # fmt: skip
    return outside_range(file, loops.run, columns)


def where_words(comparison: Comparison) -> list[str]:
    """Say in sentences where the error sits: place and conditions, harmonics, cycles, drift; then free motions."""
    free = free_words(comparison.free_samples, comparison.free_varied) if comparison.free else []
    if not comparison.runs:
        return free
    sums = comparison.sums
    whole = breakdown.along_loop(sums)
    sentences = [
        region_sentence(region(sums, comparison.varied), whole),
        sentence(comparison.farthest_off) if comparison.farthest_off else "",
        hidden_sentence(whole),
        harmonic_sentence(breakdown.by_harmonic(sums)),
        cycles_sentence(sums),
        drift_sentence(breakdown.drift(sums), comparison.nrmse),
    ]
    return [*filter(None, sentences), *free]


def celsius(loops: Loops, row: int) -> float | None:
    """Give a run's temperature in degC, None where it isn't known."""
    T = float(loops.temperature_K[row])
    return celsius_of(T) if math.isfinite(T) else None
