"""A law against metrics told: sentences and a table."""

from __future__ import annotations

import numpy as np

from pipeclamp.show.comparison import RUNS_PRINTED
from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.metrics_only.campaign import SCATTER
from pipeclamp_identification.metrics_only.comparison_answer import metric_comparison_answer
from pipeclamp_identification.metrics_only.law import MetricComparison, rms


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


def metric_comparison_view(comparison: MetricComparison) -> View:
    """Tell how a law stands against metrics."""
    return View(
        metric_comparison_answer(comparison),
        [metric_worst_table(comparison, most=RUNS_PRINTED)],
        metric_comparison_words(comparison),
    )
