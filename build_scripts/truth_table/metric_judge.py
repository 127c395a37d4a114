"""Put one case of dW and W alone to the package, as a user would, and say how it did."""

from __future__ import annotations

import time
from dataclasses import dataclass

from cases import Case
from judge import COMMAND, Outcome, follow, outcome_of
from metric_cases import draw_metrics, measure_metrics

from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.law import identify_metrics, metric_law_file
from pipeclamp_identification.workflow.auto import MOST_RUNGS
from pipeclamp_identification.workflow.on_metrics import MetricTests
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import LawFile, Provenance

MOST_SHOWN = 6


@dataclass(frozen=True)
class MetricStep:
    """One diagnosis.

    Attributes:
        verdict, kind, effects: what was answered.
        cautions: warnings beside what was named.
        scatter: share of dW and of W that was taken for scatter.
        candidates: effects, squares, share explained, chance, objections; best first.
        reasons: given for the verdict.
    """

    verdict: str
    kind: str | None
    effects: tuple[str, ...]
    cautions: tuple[str, ...]
    scatter: tuple[float, float]
    candidates: tuple[tuple[str, float, float, float, str], ...]
    reasons: tuple[str, ...]


def judged_metrics(case: Case, seed: int) -> Outcome:
    """Run one case."""
    begin = time.perf_counter()
    data = measure_metrics(draw_metrics(case, seed))
    campaign = data.campaign
    steps: list[MetricStep] = []
    added: tuple[str, ...] = ()
    error = ""
    try:
        file = metric_law_file(identify_metrics(campaign), campaign, name="base", provenance=Provenance(COMMAND))
        most = MOST_RUNGS if case.kind == "two" else 0
        added = follow(file, MetricTests(campaign), steps, noted_metrics, most).file.effects
    except Exception as fault:  # a case that fails is a finding, and mustn't end the others
        error = f"{type(fault).__name__}: {fault}"
    return outcome_of(case, data.strengths, data.scatter, steps, added, begin, error)


def noted_metrics(found: MetricDiagnosed, file: LawFile) -> MetricStep:
    """Note a diagnosis."""
    diagnosis = found.diagnosis
    dissipated, elastic = diagnosis.scatter.share
    return MetricStep(
        found.verdict, found.kind, tuple(map(effect_id, found.effects)), tuple(found.cautions()),
        (round(dissipated, 5), round(elastic, 5)),
        tuple(
            (
                one.effects[0], round(one.squares, 1), round(diagnosis.explained(one), 3),
                float(f"{diagnosis.chances[one.effects[0]]:.3g}"), "; ".join(one.objections),
            )
            for one in diagnosis.candidates[:MOST_SHOWN]
        ),
        diagnosis.reasons,
    )  # fmt: skip
