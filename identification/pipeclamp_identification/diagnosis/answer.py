"""What `diagnose` answers of records: the verdict, the candidates with their evidence, the test to run next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field

from pipeclamp_identification.campaign.faults import SensorFault
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.further_test.next_test import Proposal
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_identification.fitting.groups_answer import GroupsAnswer, groups_answer
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs
from pipeclamp_models.law.file import NamedKind, Verdict


class LawErrors(AnswerModel):
    """Errors as shares of the rms force."""

    law: float = Field(description="of the law as it is")
    best: float = Field(
        description="of the best law that was found; it is fitted in units of noise and scatter, so may err more in N"
    )
    noise: float = Field(
        description="cycle-to-cycle scatter, which no law can explain; of single cycles, the noise between samples"
    )


class HeldoutErrors(AnswerModel):
    """Errors on groups of conditions that were left out: of records estimated from the fits to all.

    The `refitted_nrmse` of a law's history is another number: that of fits without these conditions.
    """

    law: float
    best: float


class RungAnswer(AnswerModel):
    """One step that --auto took before it diagnosed last."""

    effect: str = Field(description="what was added; with - before it what went again, with `base` what took its place")
    kind: NamedKind | Literal["revision"] = Field(description="how it was named; `revision`: asked again, and changed")
    heldout_before: float = Field(
        description="error on left-out groups of A and f before, of fits without them, as a law's history has it"
    )
    heldout_after: float = Field(description="the same after")
    rivals: tuple[str, ...] = Field(
        (), description="what might as well have been added in its place, best first: of these it was ambiguous"
    )
    next_test: str | None = Field(None, description="the test that would tell them apart, or why there is none")


class RemainsAnswer(AnswerModel):
    """What is left once what is named first is in the law."""

    force_N: float | None = Field(description="rms of what follows the conditions; null where there are no forces")
    noise_share: float = Field(description="the same over the noise")
    where: tuple[str, ...] = Field(description="where it is, in words")


class CandidateAnswer(AnswerModel):
    """An effect, or two, refitted jointly with the law."""

    effect: str = Field(description="as `add` takes it; two are joined by +")
    heldout_nrmse: float = Field(description="error on left-out groups of A and f, estimated from the fit to all")
    heldout_by: Mapping[str, float] = Field(description="the same on other groups that were left out")
    lack_of_fit: float = Field(description="what follows the conditions and isn't explained, over the force noise")
    explained: float = Field(description="share of the mean-square lack of fit that it takes, on left-out conditions")
    objections: tuple[str, ...] = Field(description="what speaks physically against it")
    parameters: Mapping[str, float]


class LackAnswer(AnswerModel):
    """What follows the conditions and isn't explained, rms over that of the force noise."""

    law: float
    best: float
    p_value: float = Field(description="chance that noise alone makes the law's")
    limit: float = Field(description="below this a law counts as complete")


class ScatterAnswer(AnswerModel):
    """Scatter from run to run: shares of stiffness and damping, the mean force, and the displacement's zero."""

    stiffness: float
    damping: float
    mean_N: float
    zero_mm: float


class NextTestAnswer(AnswerModel):
    """A test that would tell rivals apart."""

    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None = Field(description="None: the temperature of the tests so far")
    further_conditions: Mapping[str, float]
    profile: str
    peak_displacement_mm: float = Field(description="of the whole motion")
    highest_frequency_Hz: float = Field(description="in the motion")
    peak_velocity_mm_s: float
    separation: float = Field(description="expected difference between the rivals in standard deviations")
    between: tuple[str, ...]
    words: str


class DiagnosisAnswer(AnswerModel):
    """The answer of `pipeclamp diagnose --json` for records."""

    verdict: Verdict
    effects: tuple[str, ...] = Field(description="as `add` takes them, best first")
    kind: NamedKind | None = Field(description="cause: it explains what is missing; part: it takes so much of it")
    explained: float | None = Field(
        description="share of the mean-square lack of fit, on left-out conditions, that what is named first takes"
    )
    together: tuple[str, ...] = Field(
        description="what is named first, and the effect without which it clearly takes nothing; empty where it does"
    )
    remains: RemainsAnswer | None = Field(description="what is left with what is named first")
    candidates: tuple[CandidateAnswer, ...]
    pair: CandidateAnswer | None
    screened_out: Mapping[str, float] = Field(description="effects that one step showed can't help, and their promise")
    nrmse: LawErrors
    noise_of: Literal["cycles", "samples"] = Field(
        description="what tells the noise that shares are of: how cycles differ or, where each run holds one, only the "
        "samples beside each other in it, which say nothing of scatter"
    )
    heldout_nrmse: HeldoutErrors
    lack_of_fit: LackAnswer
    scatter: ScatterAnswer
    next_test: NextTestAnswer | None
    no_next_test: str | None = Field(description="why no test is proposed, where rivals are left")
    left_over: tuple[str, ...]
    reasons: tuple[str, ...]
    left_out: tuple[LeftOutRun, ...]
    sensors: tuple[SensorFault, ...] = Field(
        description="gross faults of sensors, found before physics was asked, and what was done about them"
    )
    groups: tuple[GroupsAnswer, ...] = Field(
        description="specimens and other groups of runs that differ, told before physics; it is judged on what is left"
    )
    ladder: tuple[RungAnswer, ...] = Field(description="what --auto did before this verdict")
    next_command: str = Field(description="the shell line to run next")


def diagnosis_answer(found: RecordDiagnosed, ladder: tuple[RungAnswer, ...], next_command: str) -> DiagnosisAnswer:
    """Give what a diagnosis found, the ladder before it, and the command to run next."""
    diagnosis = found.diagnosis
    scatter = diagnosis.problem.noise.scatter
    return DiagnosisAnswer(
        verdict=found.verdict,
        effects=found.effects,
        kind=found.kind,
        explained=diagnosis.explained,
        together=found.together,
        remains=_remains(diagnosis),
        candidates=tuple(_candidate(candidate, diagnosis) for candidate in diagnosis.candidates),
        pair=_candidate(diagnosis.pair, diagnosis) if diagnosis.pair else None,
        screened_out=diagnosis.screened_out,
        nrmse=LawErrors(
            law=found.comparison.nrmse,
            best=found.best_nrmse,
            noise=found.comparison.noise_nrmse,
        ),
        noise_of="cycles" if found.knows_scatter else "samples",
        heldout_nrmse=HeldoutErrors(law=diagnosis.law.heldout_nrmse, best=diagnosis.best.heldout_nrmse),
        lack_of_fit=LackAnswer(
            law=diagnosis.law.lack.share,
            best=diagnosis.best.lack.share,
            p_value=diagnosis.law.lack.p_value,
            limit=diagnosis.tolerance.complete,
        ),
        scatter=ScatterAnswer(
            stiffness=scatter.stiffness,
            damping=scatter.damping,
            mean_N=scatter.mean_N,
            zero_mm=scatter.zero_mm,
        ),
        next_test=_next_test(found.proposal) if found.proposal else None,
        no_next_test=found.no_test or None,
        left_over=found.left_over(),
        reasons=found.reasons(),
        left_out=left_out_runs(found.comparison.campaign.left_out),
        sensors=found.comparison.campaign.faults,
        groups=groups_answer(found.groups),
        ladder=ladder,
        next_command=next_command,
    )


def _remains(diagnosis: Diagnosis) -> RemainsAnswer | None:
    """Give what is left with what is named first; None where nothing is named."""
    named = diagnosis.found.named
    if named is None:
        return None
    leftover = diagnosis.leftover
    of_lines = leftover.words_of_lines
    where = of_lines if diagnosis.is_adequate(named) else (*leftover.words, *of_lines)
    return RemainsAnswer(force_N=named.lack.rms, noise_share=named.lack.share, where=where)


def _candidate(candidate: Judged, diagnosis: Diagnosis) -> CandidateAnswer:
    return CandidateAnswer(
        effect=" + ".join(candidate.effects),
        heldout_nrmse=candidate.heldout_nrmse,
        heldout_by=candidate.heldout_by,
        lack_of_fit=candidate.lack.share,
        explained=explained_share(candidate, diagnosis.law),
        objections=(*candidate.objections, *candidate.reservations),
        parameters=candidate.result.values_of(candidate.effects),
    )


def _next_test(proposal: Proposal) -> NextTestAnswer:
    return NextTestAnswer(
        amplitude_mm=proposal.amplitude_mm,
        frequency_Hz=proposal.frequency_Hz,
        temperature_C=proposal.temperature_C,
        further_conditions=proposal.further,
        profile=proposal.profile,
        peak_displacement_mm=proposal.plan.peak_displacement,
        highest_frequency_Hz=proposal.plan.highest_frequency,
        peak_velocity_mm_s=proposal.plan.peak_velocity,
        separation=proposal.separation,
        between=proposal.rivals,
        words=proposal.words(),
    )
