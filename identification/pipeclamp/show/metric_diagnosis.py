"""A diagnosis on loop metrics alone told: its verdict and the candidates."""

from __future__ import annotations

from pathlib import Path

from pipeclamp.show.diagnosis import verdict_lines
from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.answer import RungAnswer
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.diagnosis_answer import error, metric_diagnosis_answer
from pipeclamp_identification.metrics_only.verdict import MetricDiagnosis
from pipeclamp_identification.metrics_only.weighing import chance_words


def metric_candidate_table(diagnosis: MetricDiagnosis) -> Table:
    """Give the candidates, best first, and the law as it is."""
    rows: list[tuple[str | float | None, ...]] = [
        (
            judged.name,
            100 * error(judged, diagnosis),
            100 * diagnosis.heldout[judged.name],
            100 * diagnosis.explained(judged),
            chance_words(diagnosis.chances[judged.name]),
            "; ".join((*judged.objections, *judged.reservations)) or "–",
        )
        for judged in diagnosis.shown
    ]
    own = (100 * error(diagnosis.law, diagnosis), 100 * diagnosis.heldout[""])
    rows.append(("law as it is, refitted", *own, 0.0, None, "–"))
    header = ("with", "error / %", "on left-out conditions / %", "explained / %", "by scatter alone", "against it")
    return Table(
        header,
        rows,
        "the law alone and with every candidate, rms log ratios of dW and W; all are refitted with the scatter that "
        "these metrics show, where the file's law was fitted with the one assumed: its errors differ between the two, "
        "most on left-out conditions",
    )


def metric_diagnosis_view(
    found: MetricDiagnosed, ladder: tuple[RungAnswer, ...], next_command: str, drive: Path | None
) -> View:
    """Tell a diagnosis, the ladder before it, and the command to run next; the first line is its verdict."""
    return View(
        metric_diagnosis_answer(found, ladder, next_command),
        [metric_candidate_table(found.diagnosis)],
        verdict_lines(found, next_command, drive),
    )
