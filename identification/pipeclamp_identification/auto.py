"""Diagnose and add, again and again, until the law is complete, ambiguous or beyond the catalogue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pipeclamp.declaration import Declaration
from pipeclamp.parameter_file import LawFile
from pipeclamp_identification.add import Addition, add_effect
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.diagnosis_report import Answer, answer_for
from pipeclamp_identification.fit import Progress
from pipeclamp_identification.metric_campaign import MetricCampaign
from pipeclamp_identification.metric_diagnosis_report import MetricAnswer, metric_answer_for
from pipeclamp_identification.next_test import Limits
from pipeclamp_identification.screen import effect_id

MOST_EFFECTS = 8


@dataclass(frozen=True)
class Settled:
    """Where the repetition ended.

    Attributes:
        file: the law.
        answer: the last answer.
        additions: what was added on the way.
        cautions: what to mind of each addition.
        in_vain: what the last answer named, where adding it didn't lower the error on left-out conditions.
    """

    file: LawFile
    answer: Answer | MetricAnswer
    additions: tuple[Addition, ...]
    cautions: tuple[tuple[str, ...], ...]
    in_vain: Addition | None = None

    def words(self) -> list[str]:
        """Say what each addition did to the error on left-out conditions, and what to mind of it."""
        words = []
        for one, cautions in zip(self.additions, self.cautions, strict=True):
            before, after = one.heldout
            words += [f"{one.effect}: error on left-out conditions {before:.2%} -> {after:.2%}"]
            words += [f"  {caution}" for caution in cautions]
        if self.in_vain:
            before, after = self.in_vain.heldout
            words.append(
                f"{self.in_vain.effect} was tried and not added: the error on left-out conditions didn't fall "
                f"({before:.2%} -> {after:.2%}); tests at further conditions would tell whether it is real"
            )
        return words


def add_until_settled(
    file: LawFile,
    campaign: Campaign | MetricCampaign,
    *,
    command: str,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
    most: int = MOST_EFFECTS,
    seen: Callable[[Answer | MetricAnswer, LawFile], None] = lambda answer, file: None,
) -> Settled:
    """Add the missing effect and diagnose again, while one is missing and the error on left-out conditions falls.

    Args:
        file: the law to begin with.
        campaign: records, or metrics alone.
        command, declared, limits, jobs, progress: as for `add_effect` and `answer_for`.
        most: effects that are added at most.
        seen: is given each answer with its law.

    Raises:
        UserError: the data can't serve the law.
    """
    additions: list[Addition] = []
    cautions: list[tuple[str, ...]] = []
    while True:
        answer = answer_to(file, campaign, declared=declared, limits=limits, jobs=jobs, progress=progress)
        seen(answer, file)
        if answer.verdict != "missing" or len(additions) == most:
            return Settled(file, answer, tuple(additions), tuple(cautions))
        addition = add_effect(
            file, named(answer), campaign, command=command, date=file.date, declared=declared, progress=progress
        )
        if addition.heldout[1] >= addition.heldout[0]:
            return Settled(file, answer, tuple(additions), tuple(cautions), in_vain=addition)
        additions.append(addition)
        cautions.append(tuple(answer.cautions()) if isinstance(answer, MetricAnswer) else ())
        file = addition.after


def answer_to(
    file: LawFile,
    campaign: Campaign | MetricCampaign,
    *,
    declared: Sequence[Declaration] = (),
    limits: Limits | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Answer | MetricAnswer:
    """Diagnose the law of a parameter file on records or on metrics.

    Raises:
        UserError: the data can't serve the law.
    """
    if isinstance(campaign, MetricCampaign):
        return metric_answer_for(file, campaign, declared=declared, limits=limits, progress=progress)
    return answer_for(file, campaign, declared=declared, limits=limits, jobs=jobs, progress=progress)


def named(answer: Answer | MetricAnswer) -> str:
    """Give the effect to add, with the number of memory elements that did best."""
    if isinstance(answer, MetricAnswer):
        return answer.to_add
    diagnosis = answer.diagnosis
    wanted = diagnosis.effects[0]
    found = [*([diagnosis.pair] if diagnosis.pair else []), *diagnosis.candidates]
    names = [name for judged in found for name in judged.effects]
    return next((name for name in names if effect_id(name) == wanted), wanted)
