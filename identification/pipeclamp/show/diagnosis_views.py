"""Views of a diagnosis, whatever the kind of tests."""

from __future__ import annotations

from collections.abc import Sequence
from functools import singledispatch
from pathlib import Path

from pipeclamp.show import diagnosis, metric_diagnosis
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.answer import AddedEffect, BeforeAfter
from pipeclamp_identification.diagnosis.diagnosed import Diagnosed
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.workflow.change import Addition


@singledispatch
def diagnosis_view(found: object, additions: Sequence[Addition], next_command: str, drive: Path | None = None) -> View:
    """Tell a diagnosis; the first line is its verdict.

    Args:
        found: the diagnosis.
        additions: what was added before it.
        next_command: the shell line to run next.
        drive: the file that the next test's drive signal goes to.
    """
    raise TypeError(f"no view of {type(found).__name__}")


@diagnosis_view.register
def _(found: Diagnosed, additions: Sequence[Addition], next_command: str, drive: Path | None = None) -> View:
    return diagnosis.diagnosis_view(found, _added(additions), next_command, drive)


@diagnosis_view.register
def _(found: MetricDiagnosed, additions: Sequence[Addition], next_command: str, drive: Path | None = None) -> View:
    return metric_diagnosis.metric_diagnosis_view(found, _added(additions), next_command, drive)


def _added(additions: Sequence[Addition]) -> tuple[AddedEffect, ...]:
    return tuple(
        AddedEffect(effect=one.effect, heldout_nrmse=BeforeAfter(before=one.heldout[0], after=one.heldout[1]))
        for one in additions
    )
