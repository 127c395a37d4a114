"""Laws from loop metrics: fitted to dW and W of all runs at once, and held against them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeclamp.declaration import Declaration
from pipeclamp.errors import UserError
from pipeclamp.law import Structure, compose, find_base
from pipeclamp.parameter_file import FitQuality, HistoryStep, LawFile, RunQuality, law_of
from pipeclamp.realise.arrays import Array
from pipeclamp.response import law_response, refuse_unknown_conditions
from pipeclamp_identification.fit import Fit, Progress, fit
from pipeclamp_identification.identify import (
    data_source,
    file_of_fit,
    refuse_unknown,
)
from pipeclamp_identification.law_range import intervals_of, outside_range, rounded
from pipeclamp_identification.metric_campaign import SCATTER, MetricCampaign, metric_observations
from pipeclamp_identification.report import Section, Table

METHOD = "metrics"
"""What a parameter file says of how its law was fitted; its errors are then rms log ratios."""
WORST_SHOWN = 8


def identify_metrics(
    campaign: MetricCampaign,
    *,
    base: str = "power",
    effects: Sequence[str] = (),
    frozen: Mapping[str, float] | None = None,
    declared: Sequence[Declaration] = (),
    progress: Progress | None = None,
) -> Fit:
    """Identify a law from the metrics of all runs.

    Args:
        campaign: the metrics.
        base: name of the base law.
        effects: names of effects fitted with it.
        frozen: values of parameters that are not to be fitted, by name.
        declared: a user's own effects.
        progress: is told what is being done.

    Raises:
        UserError: an unknown base or effect, or metrics that can't determine the law.
    """
    if find_base(base).terms == find_base("series").terms:
        raise UserError(
            f"base {base!r}: {campaign.name} holds metrics without records, which can't choose the orders of a series; "
            "expected base power or memory"
        )
    structure = Structure(base, tuple(effects), tuple(sorted((frozen or {}).items()))).with_declared(declared)
    refuse_unknown(structure)
    return fit(structure, metric_observations(campaign), progress=progress)


def metric_law_file(
    result: Fit,
    campaign: MetricCampaign,
    *,
    name: str,
    command: str,
    date: str | None,
    history: Iterable[HistoryStep] = (),
) -> LawFile:
    """Give the parameter file of a law fitted to metrics; arguments as for `identify.law_file`."""
    logs = metric_observations(campaign).logs(result.response.force)
    quality = FitQuality(
        method=METHOD,
        nrmse=rounded(rms(logs)),
        runs=tuple(
            RunQuality(run=run.name, nrmse=rounded(rms(row))) for run, row in zip(campaign.runs, logs, strict=True)
        ),
        unsettled=int(np.count_nonzero(result.response.unsettled)) or None,
    )
    data = data_source(campaign.name, campaign.fingerprint, len(campaign.runs), campaign.left_out)
    return file_of_fit(
        result, intervals_of(_columns(campaign)), data, quality, name=name, command=command, date=date, history=history
    )


def rms(logs: Array) -> float:
    """Give the root mean square of logs of ratios."""
    return float(np.sqrt(np.mean(logs**2)))


def _columns(campaign: MetricCampaign) -> dict[str, Array]:
    """Give the conditions by the names that a law's range has."""
    motion = metric_observations(campaign).motion
    further = {name: np.array([run.conditions[name] for run in campaign.runs]) for name in campaign.condition_columns}
    known = (name for name in ("A", "f", "T", "rho") if name not in motion.assumed)
    return {**{name: motion.slow[name][:, 0] for name in known}, **further}


@dataclass(frozen=True)
class MetricComparison:
    """A law held against metrics.

    Attributes:
        campaign: the metrics.
        logs: logs of measured over computed dW and W, shape (R, 2).
        outside: runs whose conditions lie outside the range the law was identified in, with what is outside.
    """

    campaign: MetricCampaign
    logs: Array
    outside: dict[str, str]

    @property
    def nrmse(self) -> float:
        """Rms of the logs of all ratios measured/computed: the error as a share."""
        return rms(self.logs)


def compare_metrics(file: LawFile, campaign: MetricCampaign) -> MetricComparison:
    """Hold the law of a parameter file against metrics.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    law = law_of(file)
    observations = metric_observations(campaign)
    refuse_unknown_conditions(sorted(map(str, compose(law.structure).slow_signals)), observations.motion)
    logs = observations.logs(law_response(law, observations.motion).force)
    if not np.all(np.isfinite(logs)):
        run = campaign.runs[int(np.flatnonzero(~np.isfinite(logs).all(axis=1))[0])].name
        raise UserError(
            f"the law gives no finite dW and W above 0 for run {run!r}; expected conditions that are known and near "
            "the law's range"
        )
    return MetricComparison(
        campaign, logs, outside_range(file, [run.name for run in campaign.runs], _columns(campaign))
    )


def metric_comparison_json(comparison: MetricComparison) -> dict[str, Any]:
    """Give the answer of `compare --json` (CONTRACT.md); "nrmse" is the rms log ratio of dW and W."""
    runs = zip(comparison.campaign.runs, comparison.logs, strict=True)
    dissipated, elastic = (rms(column) for column in comparison.logs.T)
    return {
        "nrmse": comparison.nrmse,
        "noise_nrmse": None,
        "measure": "rms of log(measured/computed) of dW and W: the campaign has no records",
        "dissipated_energy_nrmse": dissipated,
        "max_elastic_energy_nrmse": elastic,
        "runs": [
            {
                "run": run.name,
                "nrmse": rms(logs),
                "noise_nrmse": None,
                "dissipated_energy_log_ratio": float(logs[0]),
                "max_elastic_energy_log_ratio": float(logs[1]),
                "amplitude_mm": run.amplitude_mm,
                "frequency_Hz": run.frequency_Hz,
                "temperature_C": run.temperature_C,
                "outside_range": comparison.outside.get(run.name),
            }
            for run, logs in runs
        ],
        "left_out": [{"run": entry.run, "reason": entry.reason} for entry in comparison.campaign.left_out],
    }


def metric_worst_table(comparison: MetricComparison, most: int | None = None) -> Table:
    """Give the runs as a table, worst first."""
    order = np.argsort(-np.sqrt(np.mean(comparison.logs**2, axis=1)), kind="stable")[:most]
    rows: list[tuple[str | float | None, ...]] = []
    for row in order:
        run, (dissipated, elastic) = comparison.campaign.runs[row], comparison.logs[row]
        rows.append(
            (
                run.name, run.amplitude_mm, run.frequency_Hz, run.temperature_C, 100 * float(dissipated),
                100 * float(elastic), comparison.outside.get(run.name, ""),
            )
        )  # fmt: skip
    header = ("run", "A / mm", "f / Hz", "T / °C", "dW / %", "W / %", "outside the law's range")
    return Table(header, rows, "100 log(measured/computed), worst first")


def metric_comparison_words(comparison: MetricComparison) -> list[str]:
    """Say how much a law errs."""
    dissipated, elastic = (rms(column) for column in comparison.logs.T)
    words = [
        f"The law errs by {comparison.nrmse:.2%} over {len(comparison.campaign.runs)} runs, {dissipated:.2%} in dW and "
        f"{elastic:.2%} in W (rms of log ratios). Metrics without records say nothing of the place in the loop, of "
        f"harmonics, or of scatter from cycle to cycle; about {SCATTER:.0%} is usual between runs."
    ]
    if comparison.outside:
        words.append(f"{len(comparison.outside)} runs lie outside the range in which the law was identified.")
    return [*words, *(f"Left out: {entry}." for entry in comparison.campaign.left_out)]


def metric_comparison_sections(comparison: MetricComparison) -> list[Section]:
    """Give the report of a comparison with metrics."""
    return [
        Section("How much", metric_comparison_words(comparison)),
        Section("All runs", (), [metric_worst_table(comparison)]),
    ]
