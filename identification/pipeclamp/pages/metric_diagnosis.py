"""The page of a diagnosis on loop metrics alone."""

from __future__ import annotations

from pipeclamp.pages.diagnosis import drive_shown
from pipeclamp.pages.page import Section
from pipeclamp.pages.waterfall import LEFT_OUT, RungBars
from pipeclamp.show.metric_diagnosis import metric_candidate_table
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.verdict import MetricDiagnosis


def metric_diagnosis_answer(answer: MetricDiagnosed) -> Section:
    """Give the first section of a diagnosis on metrics: its verdict, why, and the next test."""
    words = [answer.headline(), *map(sentence, answer.words())]
    pictures = []
    if answer.proposal:
        drive, drawn = drive_shown(answer.proposal.plan, answer.proposal.drive_words())
        words += [f"Next test: {answer.proposal.words()}.", drive]
        pictures.append(drawn)
    if answer.no_test:
        words.append(f"No next test: {answer.no_test}.")
    return Section("Answer", words, [metric_candidate_table(answer.diagnosis)], pictures)


def metric_promised(diagnosis: MetricDiagnosis) -> list[RungBars]:
    """Give the law as it is, and what the effect that is named first would make of it."""
    rungs = [RungBars("law as it is", {LEFT_OUT: diagnosis.heldout[""]})]
    if diagnosis.named is not None:
        name = diagnosis.named.name
        explained = diagnosis.explained(diagnosis.named)
        rungs.append(RungBars(f"+ {name}", {LEFT_OUT: diagnosis.heldout[name]}, promised=True, explained=explained))
    return rungs
