"""What `compare` answers of several laws: the answer of each, in the order in which they were named."""

from __future__ import annotations

from pydantic import Field

from pipeclamp_identification.comparison.answer import ComparisonAnswer
from pipeclamp_identification.metrics_only.comparison_answer import MetricComparisonAnswer
from pipeclamp_models.base.answer import AnswerModel


class LawComparison(AnswerModel):
    """One of several laws, and how it stands."""

    law: str = Field(description="the law's name")
    base: str
    effects: tuple[str, ...]
    comparison: ComparisonAnswer | MetricComparisonAnswer


class LawsComparisonAnswer(AnswerModel):
    """The answer of `pipeclamp compare --json` for more than one law."""

    laws: tuple[LawComparison, ...]
