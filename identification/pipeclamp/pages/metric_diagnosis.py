"""The page of a diagnosis on loop metrics alone."""

from __future__ import annotations

import numpy as np

from pipeclamp.pages.diagnosis import drive_shown
from pipeclamp.pages.metric_comparison import metric_comparison_sections
from pipeclamp.pages.page import Section
from pipeclamp.pages.pictures import waterfall_picture
from pipeclamp.show.metric_diagnosis import metric_candidate_table
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed


def metric_diagnosis_sections(answer: MetricDiagnosed) -> list[Section]:
    """Give the report of a diagnosis on metrics."""
    diagnosis = answer.diagnosis
    words = [answer.headline(), *(f"{word[0].upper()}{word[1:]}." for word in answer.words())]
    pictures = []
    if answer.proposal:
        drive, drawn = drive_shown(answer.proposal.plan, answer.proposal.drive_words())
        words += [f"Next test: {answer.proposal.words()}.", drive]
        pictures.append(drawn)
    if answer.no_test:
        words.append(f"No next test: {answer.no_test}.")
    steps = [("law as it is", diagnosis.heldout[""])]
    if diagnosis.best.effects:
        name = diagnosis.best.effects[0]
        steps.append((f"+ {name}", diagnosis.heldout[name]))
    noise = float(np.sqrt(np.mean(diagnosis.scatter.share**2)))
    falling = waterfall_picture(steps, noise, "error on left-out conditions", "What the best effect would do")
    return [
        Section("Verdict", words, [metric_candidate_table(diagnosis)], [falling, *pictures]),
        *metric_comparison_sections(answer.comparison),
    ]
