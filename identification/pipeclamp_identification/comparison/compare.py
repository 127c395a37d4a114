"""Compare a law with a campaign: how much it errs, and where (docs/reference/answers.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.breakdown import Condition
from pipeclamp_identification.comparison.concentration import (
    cycles_sentence,
    drift_sentence,
    harmonic_sentence,
    region,
    region_sentence,
)
from pipeclamp_identification.comparison.sums import RunSums, error_sums
from pipeclamp_identification.fitting.misfit import RunMisfit, misfits, overall_noise, overall_nrmse
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_models.base.units import CELSIUS
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
        outside: runs whose conditions lie outside the range the law was identified in, with what is outside.
    """

    law: Law
    campaign: Campaign
    loops: Loops
    runs: tuple[RunMisfit, ...]
    outside: dict[str, str]

    @property
    def nrmse(self) -> float:
        """Error over all samples as a share of the force."""
        return overall_nrmse(self.runs)

    @property
    def noise_nrmse(self) -> float:
        """The part of it that is scatter; of single cycles, only the noise between their samples."""
        return overall_noise(self.runs)

    @cached_property
    def sums(self) -> tuple[RunSums, ...]:
        """The squared error of each run, split up."""
        return error_sums(self.campaign, self.loops, self.runs)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """The tests' conditions."""
        return breakdown.conditions_of(self.campaign, self.loops)

    @property
    def varied(self) -> tuple[Condition, ...]:
        """The conditions that vary from run to run."""
        return tuple(condition for condition in self.conditions if condition.varies)

    @property
    def single_cycles(self) -> int:
        """Number of runs with a single cycle, which can't show scatter from cycle to cycle."""
        return sum(not run.scatter_known for run in self.sums)

    def worst_first(self) -> list[int]:
        """Give the rows of the runs by falling error."""
        return sorted(range(len(self.runs)), key=lambda row: -self.runs[row].nrmse)


def compare(file: LawFile, campaign: Campaign, loops: Loops | None = None) -> Comparison:
    """Hold the law of a parameter file against a campaign, whose loops may be known already.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    law, loops = law_of(file), loops or loops_of(campaign)
    return Comparison(law, campaign, loops, misfits(law, campaign, loops), _outside(file, loops))


def _outside(file: LawFile, loops: Loops) -> dict[str, str]:
    columns = {
        "A": loops.amplitude_mm, "f": loops.frequency_Hz, "T": loops.temperature_K, "rho": loops.density_g_cm3,
        **loops.conditions,
    }  # fmt: skip
    return outside_range(file, loops.run, columns)


def where_words(comparison: Comparison) -> list[str]:
    """Say in sentences where the error sits: place and conditions, harmonics, cycles, drift."""
    sums = comparison.sums
    sentences = [
        region_sentence(region(sums, comparison.varied), breakdown.along_loop(sums)),
        harmonic_sentence(breakdown.by_harmonic(sums)),
        cycles_sentence(sums),
        drift_sentence(breakdown.drift(sums), comparison.nrmse),
    ]
    return [sentence for sentence in sentences if sentence]


def celsius(loops: Loops, row: int) -> float | None:
    """Give a run's temperature in degC, None where it isn't known."""
    T = float(loops.temperature_K[row])
    return T - CELSIUS if math.isfinite(T) else None
