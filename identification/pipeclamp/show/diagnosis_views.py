"""Views of a diagnosis, whatever the kind of tests."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from pathlib import Path

from pipeclamp.show import diagnosis, metric_diagnosis
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.answer import RungAnswer
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.workflow.climb import Rung


@singledispatch
def diagnosis_view(found: object, ladder: Sequence[Rung], next_command: str, drive: Path | None = None) -> View:
    """Tell a diagnosis: sensors that fail, where any does, then its verdict.

    Args:
        found: the diagnosis.
        ladder: what --auto did before it.
        next_command: the shell line to run next.
        drive: the file that the next test's drive signal goes to.
    """
    raise TypeError(f"no view of {type(found).__name__}")


@diagnosis_view.register
def _(found: RecordDiagnosed, ladder: Sequence[Rung], next_command: str, drive: Path | None = None) -> View:
    return diagnosis.diagnosis_view(found, rungs_told(ladder), next_command, drive)


@diagnosis_view.register
def _(found: MetricDiagnosed, ladder: Sequence[Rung], next_command: str, drive: Path | None = None) -> View:
    return metric_diagnosis.metric_diagnosis_view(found, rungs_told(ladder), next_command, drive)


def rungs_told(ladder: Sequence[Rung]) -> tuple[RungAnswer, ...]:
    """Give what a ladder did, as JSON tells it."""
    return tuple(
        RungAnswer(
            effect=rung.change.step.effect if rung.change.step.adds else str(rung.change.step),
            kind=rung.kind,
            heldout_before=rung.change.heldout.before,
            heldout_after=rung.change.heldout.after,
            rivals=rung.rivals,
            next_test=rung.next_test or None,
        )
        for rung in ladder
    )
