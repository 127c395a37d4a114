"""Views of metrics and of comparisons, whatever the kind of tests; a diagnosis, which loads more, stands apart."""

from __future__ import annotations

from functools import singledispatch

from pipeclamp.show import comparison, metric_comparison, metrics
from pipeclamp.show.view import View
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests


@singledispatch
def metrics_view(tests: object) -> View:
    """Tell the metrics of tests' loops."""
    raise TypeError(f"no view of the metrics of {type(tests).__name__}")


@metrics_view.register
def _(tests: RecordTests) -> View:
    return metrics.metrics_view(tests.sines, tests.loops)


@metrics_view.register
def _(tests: MetricTests) -> View:
    return metrics.metric_rows_view(tests.campaign)


@singledispatch
def comparison_view(held: object) -> View:
    """Tell how a law stands against tests."""
    raise TypeError(f"no view of {type(held).__name__}")


@comparison_view.register
def _(held: Comparison) -> View:
    return comparison.comparison_view(held)


@comparison_view.register
def _(held: MetricComparison) -> View:
    return metric_comparison.metric_comparison_view(held)
