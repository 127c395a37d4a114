"""Compare a law with a campaign: how much it errs, and where."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeclamp.law import Law
from pipeclamp.parameter_file import LawFile, law_of
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.loops import Loops, loops_of
from pipeclamp_identification.misfit import (
    DRAWN_SAMPLES,
    RunMisfit,
    force_of_rows,
    loop_of_run,
    misfits,
    overall_noise,
    overall_nrmse,
)
from pipeclamp_identification.pictures import ConditionsMap, LoopPanel, conditions_picture, loops_picture
from pipeclamp_identification.report import Section, Table

WORST_SHOWN = 8


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
        """The part of it that is cycle-to-cycle scatter."""
        return overall_noise(self.runs)

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
    """Find the runs outside the law's range, by more than 2 % of it."""
    columns = {"A": loops.amplitude_mm, "f": loops.frequency_Hz, "T": loops.temperature_K, **loops.conditions}
    found: dict[str, str] = {}
    for name, interval in file.range.items():
        margin = 0.02 * max(interval.maximum - interval.minimum, 0.02 * abs(interval.maximum))
        for run, value in zip(loops.run, columns.get(name, ()), strict=False):
            if not interval.minimum - margin <= value <= interval.maximum + margin and math.isfinite(value):
                found[run] = (
                    f"{name} = {value:.4g} {interval.unit}, law: {interval.minimum:.4g} to {interval.maximum:.4g}"
                )
    return found


def comparison_json(comparison: Comparison) -> dict[str, Any]:
    """Give the answer of `compare --json` (CONTRACT.md)."""
    loops = comparison.loops
    return {
        "nrmse": comparison.nrmse,
        "noise_nrmse": comparison.noise_nrmse,
        "runs": [
            {
                "run": run.run,
                "nrmse": run.nrmse,
                "noise_nrmse": run.noise_nrmse,
                "amplitude_mm": float(loops.amplitude_mm[row]),
                "frequency_Hz": float(loops.frequency_Hz[row]),
                "temperature_C": _celsius(loops, row),
                "outside_range": comparison.outside.get(run.run),
            }
            for row, run in enumerate(comparison.runs)
        ],
        "left_out": [{"run": entry.run, "reason": entry.reason} for entry in comparison.campaign.left_out],
    }


def _celsius(loops: Loops, row: int) -> float | None:
    T = float(loops.temperature_K[row])
    return T - 273.15 if math.isfinite(T) else None


def worst_table(comparison: Comparison, most: int | None = None) -> Table:
    """Give the runs as a table, worst first."""
    loops = comparison.loops
    rows = [
        (
            comparison.runs[row].run,
            float(loops.amplitude_mm[row]),
            float(loops.frequency_Hz[row]),
            _celsius(loops, row),
            100 * comparison.runs[row].nrmse,
            100 * comparison.runs[row].noise_nrmse,
            comparison.outside.get(comparison.runs[row].run, ""),
        )
        for row in comparison.worst_first()[:most]
    ]
    header = ("run", "A / mm", "f / Hz", "T / °C", "error / %", "scatter / %", "outside the law's range")
    return Table(header, rows, "error and cycle-to-cycle scatter, as a share of the run's rms force; worst first")


def loop_panels(comparison: Comparison, rows: Sequence[int]) -> list[LoopPanel]:
    """Give the measured and computed loops of some runs."""
    force = force_of_rows(comparison.law, comparison.loops, DRAWN_SAMPLES)
    panels = []
    for row in rows:
        y, measured = loop_of_run(comparison.loops, row)
        run = comparison.runs[row]
        panels.append(LoopPanel(f"{run.run}: {100 * run.nrmse:.2g} %", y, measured, force[row]))
    return panels


def comparison_sections(comparison: Comparison) -> list[Section]:
    """Give the report of a comparison: the numbers, where it fails, the worst loops."""
    loops, campaign = comparison.loops, comparison.campaign
    summary = [
        f"The law errs by {comparison.nrmse:.2%} of the rms force over {len(comparison.runs)} runs; "
        f"{comparison.noise_nrmse:.2%} is cycle-to-cycle scatter, which no law can explain."
    ]
    if comparison.outside:
        summary.append(f"{len(comparison.outside)} runs lie outside the range in which the law was identified.")
    summary += [f"Left out: {entry}." for entry in campaign.left_out]
    A, f, T = (_nominal(values) for values in (loops.amplitude_mm, loops.frequency_Hz, loops.temperature_K - 273.15))
    errors = np.array([100 * run.nrmse for run in comparison.runs])
    worst = comparison.worst_first()[:WORST_SHOWN]
    where = ConditionsMap(A, f, T, errors, "error / %")
    return [
        Section("How much", summary),
        Section("Where", (), (), [conditions_picture(where, "Error by condition, share of the run's rms force")]),
        Section(
            "Worst loops",
            (),
            (),
            [loops_picture(loop_panels(comparison, worst), "Measured (grey) and law (red), worst first")],
        ),
        Section("All runs", (), [worst_table(comparison)]),
    ]


def _nominal(values: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Give measured conditions as the set points they scatter about: the mean of each cluster, two digits."""
    order = np.argsort(values)
    scale = np.maximum(np.abs(values[order]), 1e-9)
    jumps = np.diff(values[order]) > 0.06 * scale[1:]
    cluster = np.concatenate([[0], np.cumsum(jumps)])
    nominal = np.empty(len(values))
    for number in range(int(cluster[-1]) + 1):
        members = order[cluster == number]
        nominal[members] = float(f"{np.mean(values[members]):.2g}")
    return nominal
