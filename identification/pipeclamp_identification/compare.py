"""Compare a law with a campaign: how much it errs, and where (CONTRACT.md, compare)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pipeclamp.law import Law
from pipeclamp.parameter_file import LawFile, law_of
from pipeclamp.symbols import CELSIUS
from pipeclamp_identification import breakdown
from pipeclamp_identification.breakdown import PLACES, Condition, parts_json, phase_edges, place_of
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.concentration import (
    cycles_sentence,
    drift_sentence,
    harmonic_sentence,
    region,
    region_sentence,
)
from pipeclamp_identification.error_sums import RunSums, error_sums
from pipeclamp_identification.law_range import outside_range
from pipeclamp_identification.loops import Loops, loops_of
from pipeclamp_identification.misfit import RunMisfit, known_noise, misfits, overall_noise, overall_nrmse


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


def compare(file: LawFile, campaign: Campaign) -> Comparison:
    """Hold the law of a parameter file against a campaign.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    law, loops = law_of(file), loops_of(campaign)
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


def comparison_json(comparison: Comparison) -> dict[str, Any]:
    """Give the answer of `compare --json` (CONTRACT.md); what isn't known is None."""
    loops = comparison.loops
    return {
        "nrmse": comparison.nrmse,
        "noise_nrmse": known_noise(comparison.runs, loops),
        "runs": [
            {
                "run": run.run,
                "nrmse": run.nrmse,
                "noise_nrmse": run.noise_nrmse if sums.scatter_known else None,
                "amplitude_mm": float(loops.amplitude_mm[row]),
                "frequency_Hz": float(loops.frequency_Hz[row]),
                "temperature_C": celsius(loops, row),
                "outside_range": comparison.outside.get(run.run),
            }
            for row, (run, sums) in enumerate(zip(comparison.runs, comparison.sums, strict=True))
        ],
        "where": _where_json(comparison),
        "left_out": [{"run": entry.run, "reason": entry.reason} for entry in comparison.campaign.left_out],
    }


def _where_json(comparison: Comparison) -> dict[str, Any]:
    sums = comparison.sums
    drift, densest = breakdown.drift(sums), region(sums, comparison.varied)
    phases = parts_json(breakdown.along_loop(sums))
    for index, phase in enumerate(phases):
        place, branch = place_of(index)
        phase["from_deg"], phase["to_deg"] = phase_edges(index)
        phase["place"], phase["branch"] = PLACES[place][0], breakdown.BRANCHES[branch]
    return {
        "words": where_words(comparison),
        "region": densest and {"words": list(densest.words), "share": densest.share, "even_share": densest.even},
        "phases": phases,
        "places": parts_json(breakdown.by_place(sums)),
        "branches": parts_json(breakdown.by_branch(sums)),
        "harmonics": parts_json(breakdown.by_harmonic(sums)),
        "cycles": parts_json(breakdown.along_cycles(sums)),
        "drift": drift
        and {
            "in_phase": drift.in_phase,
            "in_quadrature": drift.in_quadrature,
            "standard_error": drift.standard_error,
        },
        "conditions": {
            condition.key: parts_json(breakdown.by_condition(sums, condition)) for condition in comparison.varied
        },
    }
