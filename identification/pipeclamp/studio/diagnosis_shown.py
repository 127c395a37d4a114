"""What the studio keeps of a diagnosis beside its answer: the words as `pipeclamp diagnose` prints them, the fits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from pydantic import Field

from pipeclamp.show.diagnosis import against, verdict_lines
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.law.file import LawFile, NamedKind, Verdict


class CandidateShown(AnswerModel):
    """An effect that a diagnosis fitted with the law, or two that it names together."""

    name: str = Field(description="as `add` takes it: two with a comma between them")
    does: str
    looks_like: str
    told_apart_by: str
    heldout_nrmse: float
    explained: float = Field(description="share of what is missing that it takes, on left-out conditions")
    against: tuple[str, ...] = Field(description="what speaks against it")
    effects: tuple[str, ...] = Field(description="of the law with it")
    values: Mapping[str, float] = Field(description="parameters of the law with it")


class RungShown(AnswerModel):
    """What a step that a page promises would do."""

    label: str
    heldout_nrmse: float
    explained: float | None


class DiagnosisShown(AnswerModel):
    """A diagnosis as it is shown."""

    law_command: str = Field(description="the command that made the law which was diagnosed, and its date")
    verdict: Verdict
    kind: NamedKind | None
    effects: tuple[str, ...]
    together: tuple[str, ...] = Field((), description="two effects that help only together, of which one is named")
    headline: str
    words: tuple[str, ...]
    rung: tuple[str, ...]
    lines: tuple[str, ...] = Field(description="as the command prints them, without the next command")
    heldout_nrmse: float = Field(description="of the law as it is")
    candidates: tuple[CandidateShown, ...]
    promised: tuple[RungShown, ...] = Field((), description="the steps that the page of the diagnosis promises")
    next_test: str = Field(description="which test would tell, or why none is proposed; empty where none is needed")
    drive: bool = Field(description="whether there is a drive signal for it")
    runs: int | None = Field(None, description="of the tests that it rests on; not known of diagnoses kept long ago")

    @property
    def offered(self) -> tuple[str, ...]:
        """What is named, as `add` takes it: two that help only together at once."""
        return (_at_once(self.together),) if self.together else self.effects

    def meant(self, effect: str) -> NamedKind | None:
        """Say how an effect is meant; None where it isn't named."""
        return self.kind if effect in (*self.effects, *self.offered) else None


def shown_diagnosis(found: RecordDiagnosed, file: LawFile) -> DiagnosisShown:
    """Give a diagnosis as it is shown."""
    # the server, which only shows what was told, does without
    from pipeclamp.pages.diagnosis import promised
    from pipeclamp.pages.waterfall import ESTIMATED

    diagnosis = found.diagnosis
    both = [diagnosis.found.named] if diagnosis.found.named and found.together else []
    return DiagnosisShown(
        law_command=stamp(file),
        verdict=found.verdict,
        kind=found.kind,
        effects=found.effects,
        together=found.together,
        headline=found.headline(),
        words=tuple(found.words()),
        rung=_rung(found),
        lines=tuple(verdict_lines(found, "", None)),  # what comes next are the page's buttons, with their commands
        heldout_nrmse=diagnosis.law.heldout_nrmse,
        candidates=tuple(
            _candidate(each, diagnosis) for each in (*both, *diagnosis.candidates) if _is_finite(each.result.law.values)
        ),
        promised=tuple(
            RungShown(label=rung.label, heldout_nrmse=rung.errors[ESTIMATED], explained=rung.explained)
            for rung in promised(diagnosis)
            if rung.promised
        ),
        next_test=found.proposal.words() if found.proposal else found.no_test,
        drive=found.proposal is not None,
        runs=len(found.comparison.runs),
    )


def _at_once(effects: Sequence[str]) -> str:
    """Give effects as `add` takes them."""
    return ",".join(effects)


def _rung(found: RecordDiagnosed) -> tuple[str, ...]:
    """Say what the effect that is named first takes; of two that are missing together, that there are two."""
    if found.verdict == "missing" and found.kind == "cause" and found.diagnosis.pair:
        return (*found.diagnosis.reasons[:1], *found.rung()[1:])
    return found.rung()


def stamp(file: LawFile) -> str:
    """Give what tells a law's file from another of the same name."""
    return f"{file.command} {file.date}"


def _is_finite(values: Mapping[str, float]) -> bool:
    return all(map(math.isfinite, values.values()))


def _candidate(judged: Judged, diagnosis: Diagnosis) -> CandidateShown:
    law = diagnosis.law
    known = {effect.name: effect for effect in judged.result.equations.effects}
    effects = [known[name] for name in judged.effects]
    return CandidateShown(
        name=_at_once(judged.effects),
        does="; ".join(effect.does for effect in effects),
        looks_like="; ".join(effect.looks_like for effect in effects),
        told_apart_by="; ".join(effect.told_apart_by for effect in effects),
        heldout_nrmse=judged.heldout_nrmse,
        explained=explained_share(judged, law),
        against=tuple(against(judged, diagnosis)),
        effects=judged.result.law.structure.effects,
        values=dict(judged.result.law.values),
    )
