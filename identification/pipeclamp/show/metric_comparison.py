"""A law against metrics told: sentences and a table."""

from __future__ import annotations

import numpy as np

from pipeclamp.show.comparison import RUNS_PRINTED, in_order
from pipeclamp.show.table import Table, outside_cell, outside_head
from pipeclamp.show.view import View
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.metrics_only.campaign import SCATTER_BEFOREHAND
from pipeclamp_identification.metrics_only.comparison_answer import metric_comparison_answer
from pipeclamp_identification.metrics_only.law import MetricComparison, rms
from pipeclamp_models.base.said import counted


def metric_worst_table(comparison: MetricComparison, most: int | None = None) -> Table:
    """Give the runs as a table, worst first."""
    order = np.argsort(-np.sqrt(np.mean(comparison.logs**2, axis=1)), kind="stable")[:most]
    rows: list[tuple[str | float | None, ...]] = []
    for row in order:
        run, (dissipated, elastic) = comparison.campaign.runs[row], comparison.logs[row]
        rows.append(
            (
                run.name, run.amplitude_mm, run.frequency_Hz, run.setup.temperature_C, 100 * float(dissipated),
                100 * float(elastic), *outside_cell(comparison.outside, run.name),
            )
        )  # fmt: skip
    header = ("run", "A / mm", "f / Hz", "T / °C", "dW / %", "W / %", *outside_head(comparison.outside))
    return Table(header, rows, f"100 log(measured/computed), {in_order(len(rows), len(comparison.campaign.runs))}")


def metric_comparison_words(comparison: MetricComparison) -> list[str]:
    """Say how much a law errs."""
    dissipated, elastic = (rms(column) for column in comparison.logs.T)
    runs = counted(len(comparison.campaign.runs), "run")
    words = [
        f"The law errs by {comparison.nrmse:.2%} over {runs}, {dissipated:.2%} in dW and {elastic:.2%} in W (rms of "
        "log ratios). Metrics without records say nothing of the place in the loop, of harmonics, or of scatter from "
        f"cycle to cycle; about {SCATTER_BEFOREHAND:.0%} is usual between runs."
    ]
    if comparison.outside:
        lie = f"{counted(len(comparison.outside), 'run')} {'lies' if len(comparison.outside) == 1 else 'lie'}"
        words.append(f"{lie} outside the range in which the law was identified.")
    return [*words, *(sentence(str(entry)) for entry in comparison.campaign.left_out)]


def metric_comparison_view(comparison: MetricComparison) -> View:
    """Tell how a law stands against metrics."""
    return View(
        metric_comparison_answer(comparison),
        [metric_worst_table(comparison, most=RUNS_PRINTED)],
        metric_comparison_words(comparison),
    )
