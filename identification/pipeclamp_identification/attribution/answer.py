"""What `compare` answers of a coupled system as a whole: how much it errs, where, and which parameter is wrong."""

from __future__ import annotations

from pydantic import Field

from pipeclamp_identification.attribution.attributed import Attributed
from pipeclamp_identification.attribution.repeats import NextMeasurement
from pipeclamp_identification.attribution.verdict import Attribution, PipeVerdict
from pipeclamp_identification.on_pipe.answer import (
    BandsOnPipeAnswer,
    OnPipeAnswer,
    records_answer,
    sines_answer,
    where_told,
)
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.law.file import NamedKind


class RefitErrors(AnswerModel):
    """Errors as shares of the rms of what was measured."""

    stated: float = Field(description="of the model as it is stated")
    all_refitted: float = Field(description="with all parameters refitted at once")


class CandidateAnswer(AnswerModel):
    """Parameters that were refitted together, one alone as a rule."""

    parameters: tuple[str, ...]
    sides: tuple[str, ...]
    values: str = Field(description="the refitted values with their standard errors, in words")
    nrmse: float
    heldout: float = Field(description="mean square of what is left on what was left out, in units of the noise's")


class AttributionAnswer(AnswerModel):
    """What of pipe, clamps or measurement is wrong."""

    verdict: PipeVerdict
    kind: NamedKind | None = Field(description="cause: it explains what is wrong; part: it takes most of it")
    parameters: tuple[str, ...] = Field(description="all that the verdict names")
    alternatives: tuple[tuple[str, ...], ...] = Field(description="one of these is wrong, best first")
    sides: tuple[str, ...] = Field(description="pipe, clamp, measurement: those of what the verdict names")
    left_in_noise: float = Field(description="rms of what the best refit leaves, in units of the noise")
    nrmse: RefitErrors
    candidates: tuple[CandidateAnswer, ...] = Field(description="all that were tried, best first")
    next_test: str | None


class SystemComparisonAnswer(OnPipeAnswer):
    """The answer of `pipeclamp compare SYSTEM.toml MEASURED --json`.

    Of sines where there are any, else of records; where there are both, those of records stand in `over_time`.
    """

    over_time: OnPipeAnswer | None = where_told("the records, where sines stand above")
    bands: BandsOnPipeAnswer | None = where_told("with --bands")
    attribution: AttributionAnswer | None = Field(description="None where too little was measured to ask")


def attribution_answer(found: Attribution, proposal: NextMeasurement | None) -> AttributionAnswer:
    """Give what was found to be wrong, and the test that would tell more."""
    return AttributionAnswer(
        verdict=found.verdict,
        kind=found.kind,
        parameters=tuple(suspect.id for suspect in found.suspects),
        alternatives=tuple(tuple(suspect.id for suspect in entry.suspects) for entry in found.named),
        sides=tuple(sorted({suspect.side for suspect in found.suspects})),
        left_in_noise=found.left,
        nrmse=RefitErrors(stated=found.stated.nrmse, all_refitted=found.together.nrmse),
        candidates=tuple(
            CandidateAnswer(
                parameters=tuple(suspect.id for suspect in entry.suspects),
                sides=tuple(sorted({suspect.side for suspect in entry.suspects})),
                values=entry.value_words(),
                nrmse=entry.nrmse,
                heldout=entry.heldout / entry.refit.residual.size,
            )
            for entry in found.candidates
        ),
        next_test=proposal.words() if proposal else None,
    )


def system_comparison_answer(found: Attributed) -> SystemComparisonAnswer:
    """Give how a coupled system stands against what was measured on the pipe, and what of it may be wrong."""
    compared = found.compared
    sines = sines_answer(compared.sines) if compared.sines else None
    records = records_answer(compared.records) if compared.records else None
    first = sines or records
    assert first is not None, "a measurement holds one of them"
    return SystemComparisonAnswer(
        nrmse=first.nrmse,
        noise_nrmse=first.noise_nrmse,
        probes=first.probes,
        sines=first.sines,
        records=first.records,
        where=first.where,
        over_time=records if sines else None,
        bands=None if found.bands is None else found.bands.answer(),
        attribution=None if found.attribution is None else attribution_answer(found.attribution, found.proposal),
    )
