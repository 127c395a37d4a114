"""The page of a law against metrics."""

from __future__ import annotations

from pipeclamp.pages.page import Section
from pipeclamp.show.metric_comparison import metric_comparison_words, metric_worst_table
from pipeclamp_identification.metrics_only.law import MetricComparison


def metric_comparison_sections(comparison: MetricComparison) -> list[Section]:
    """Give the report of a comparison with metrics."""
    return [
        Section("How much", metric_comparison_words(comparison)),
        Section("All runs", (), [metric_worst_table(comparison)]),
    ]
