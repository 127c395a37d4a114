"""What `diagnose` answers of metrics without records; errors are rms log ratios of dW and W."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from pydantic import Field

from pipeclamp_identification.diagnosis.answer import HeldoutErrors, LawErrors, RemainsAnswer, RungAnswer
from pipeclamp_identification.metrics_only.comparison_answer import MEASURE
from pipeclamp_identification.metrics_only.diagnosed import MetricDiagnosed
from pipeclamp_identification.metrics_only.evidence import MetricJudged
from pipeclamp_identification.metrics_only.law import rms
from pipeclamp_identification.metrics_only.next_test import MetricProposal
from pipeclamp_identification.metrics_only.verdict import MetricDiagnosis
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs
from pipeclamp_models.law.file import NamedKind, Verdict


class MetricCandidateAnswer(AnswerModel):
    """An effect, or two, refitted jointly with the law."""

    effect: str = Field(description="as `add` takes it; two are joined by +")
    heldout_nrmse: float = Field(description="error on left-out conditions, of fits without them")
    nrmse: float
    explained: float = Field(description="share of what is missing that it takes, as above")
    chance: float = Field(description="that scatter alone makes what it gains, once for each effect tried")
    objections: tuple[str, ...] = Field(description="what speaks physically against it")
    parameters: Mapping[str, float]


class MetricScatterAnswer(AnswerModel):
    """Scatter of dW and W as shares, and the degrees of freedom that each is known by."""

    dissipated_energy: float
    max_elastic_energy: float
    degrees_of_freedom: tuple[float, ...]


class MetricNextTestAnswer(AnswerModel):
    """A test that would tell rivals apart."""

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    profile: str
    peak_displacement_mm: float
    highest_frequency_Hz: float
    peak_velocity_mm_s: float
    separation: float
    between: tuple[str, ...]
    words: str


class MetricDiagnosisAnswer(AnswerModel):
    """The answer of `pipeclamp diagnose --json` for metrics without records."""

    verdict: Verdict
    effects: tuple[str, ...] = Field(description="as `add` takes them, best first")
    kind: NamedKind | None = Field(description="cause: it explains what is missing; part: it takes so much of it")
    explained: float | None = Field(
        description="share of what the richest law explains that what is named first takes; where that law leaves more "
        "than scatter, of the mean square on left-out conditions"
    )
    together: tuple[str, ...] = Field(
        description="what is named first, and the effect that scales what only it brings; empty where it is named alone"
    )
    remains: RemainsAnswer | None = Field(description="what is left with what is named first")
    measure: str = Field(description="what the errors measure")
    candidates: tuple[MetricCandidateAnswer, ...]
    pairs: tuple[MetricCandidateAnswer, ...] = Field(
        description="effects each with another one that scales what only it brings, best first"
    )
    screened_out: tuple[str, ...] = Field(description="effects that were fitted and gain next to nothing")
    not_visible: Mapping[str, str] = Field(description="effects that metrics can't show here, and why")
    nrmse: LawErrors
    heldout_nrmse: HeldoutErrors = Field(description="of metrics: of fits without the left-out conditions")
    scatter: MetricScatterAnswer
    richest_law: tuple[str, ...] = Field(description="the effects that the metrics support together")
    rests_on: tuple[str, ...] = Field(description="runs without any one of which the named effect gains little")
    next_test: MetricNextTestAnswer | None
    no_next_test: str | None = Field(description="why no test is proposed, where rivals are left")
    left_over: tuple[str, ...]
    reasons: tuple[str, ...]
    left_out: tuple[LeftOutRun, ...]
    ladder: tuple[RungAnswer, ...] = Field(description="what --auto did before this verdict")
    next_command: str = Field(description="the shell line to run next")


def metric_diagnosis_answer(
    found: MetricDiagnosed, ladder: tuple[RungAnswer, ...], next_command: str
) -> MetricDiagnosisAnswer:
    """Give what a diagnosis found, the ladder before it, and the command to run next."""
    diagnosis, proposal = found.diagnosis, found.proposal
    dissipated, elastic = diagnosis.scatter.share
    named = diagnosis.named
    return MetricDiagnosisAnswer(
        verdict=found.verdict,
        effects=found.effects,
        kind=found.kind,
        explained=None if named is None else diagnosis.explained(named),
        together=found.together,
        remains=None if named is None else RemainsAnswer(force_N=None, noise_share=rms(named.residual), where=()),
        measure=MEASURE,
        candidates=tuple(_candidate(judged, diagnosis) for judged in diagnosis.candidates),
        pairs=tuple(_candidate(judged, diagnosis) for judged in diagnosis.pairs),
        screened_out=diagnosis.screened_out,
        not_visible=diagnosis.hidden,
        nrmse=LawErrors(
            law=found.comparison.nrmse,
            best=error(diagnosis.best, diagnosis),
            noise=float(np.sqrt((dissipated**2 + elastic**2) / 2)),
        ),
        heldout_nrmse=HeldoutErrors(law=diagnosis.heldout[""], best=diagnosis.heldout[diagnosis.best.name]),
        scatter=MetricScatterAnswer(
            dissipated_energy=float(dissipated),
            max_elastic_energy=float(elastic),
            degrees_of_freedom=tuple(diagnosis.scatter.freedoms.tolist()),
        ),
        richest_law=diagnosis.richest.effects,
        rests_on=tuple(found.campaign.runs[row].name for row in diagnosis.rests_on),
        next_test=_next_test(proposal) if proposal else None,
        no_next_test=found.no_test or None,
        left_over=(),
        reasons=tuple(found.words()),
        left_out=left_out_runs(found.campaign.left_out),
        ladder=ladder,
        next_command=next_command,
    )


def error(judged: MetricJudged, diagnosis: MetricDiagnosis) -> float:
    """Give the rms log ratio that a law leaves."""
    return rms(judged.residual * diagnosis.observations.relative_error)


def _candidate(judged: MetricJudged, diagnosis: MetricDiagnosis) -> MetricCandidateAnswer:
    return MetricCandidateAnswer(
        effect=judged.name,
        heldout_nrmse=diagnosis.heldout[judged.name],
        nrmse=error(judged, diagnosis),
        explained=diagnosis.explained(judged),
        chance=diagnosis.chances[judged.name],
        objections=(*judged.objections, *judged.reservations),
        parameters=judged.result.values_of(judged.effects),
    )


def _next_test(proposal: MetricProposal) -> MetricNextTestAnswer:
    return MetricNextTestAnswer(
        amplitude_mm=proposal.amplitude_mm,
        frequency_Hz=proposal.frequency_Hz,
        temperature_C=proposal.temperature_C,
        profile="sine",
        peak_displacement_mm=proposal.plan.peak_displacement,
        highest_frequency_Hz=proposal.plan.highest_frequency,
        peak_velocity_mm_s=proposal.plan.peak_velocity,
        separation=proposal.separation,
        between=proposal.rivals,
        words=proposal.words(),
    )
