"""Views of metrics and of comparisons, whatever the kind of tests; a diagnosis, which loads more, stands apart."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch

from pipeclamp.show import comparison, metric_comparison, metrics
from pipeclamp.show.law import laws_table, least_words
from pipeclamp.show.view import View
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.laws import least_error
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.workflow.laws_answer import LawComparison, LawsComparisonAnswer
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Held
from pipeclamp_models.law.file import LawFile


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


def laws_view(laws: Sequence[tuple[LawFile, Held]]) -> View:
    """Tell how several laws stand against the same tests, and where the one fails that errs least."""
    views = [comparison_view(held) for _, held in laws]
    answers = [
        LawComparison.model_validate(
            {"law": file.name, "base": file.base, "effects": file.effects, "comparison": view.answer}
        )
        for (file, _), view in zip(laws, views, strict=True)
    ]
    table = laws_table([(file, held.nrmse, known_scatter_of(held)) for file, held in laws])
    best = least_error([held for _, held in laws])
    least = [least_words([file for file, _ in laws], best)] if len(laws) > 1 else []
    return View(LawsComparisonAnswer(laws=tuple(answers)), [table], [*least, *views[best].lines])


def known_scatter_of(held: Held) -> float | None:
    """Give the scatter of tests as a share of their force; None where it isn't known."""
    return held.known_noise if isinstance(held, Comparison) else None
