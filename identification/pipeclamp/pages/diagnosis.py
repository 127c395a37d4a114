"""The page of a diagnosis: the verdict, the evidence in a test engineer's words, what is left over, the next test."""

from __future__ import annotations

import plotly.graph_objects as go

from pipeclamp.pages.page import Card, Section
from pipeclamp.pages.pictures import LoopPanel, curves_picture, loops_picture
from pipeclamp.pages.sketch import sketch
from pipeclamp.pages.waterfall import ESTIMATED, RungBars
from pipeclamp.show.diagnosis import LEAST_HELP, against, before_physics, candidate_table, helpful
from pipeclamp_identification.campaign.drive import DrivePlan
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed
from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.further_test.next_test import Proposal
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.equations.effect import Effect

SHOWN_PROMISE = 0.001
"""Less than this share of the best effect's promise is shown as none."""
SKETCHED = 4
"""Candidates that are told of and drawn, best first."""
RECORDS_JOIN = "Once it is run, pipeclamp import makes a campaign of its records, and pipeclamp join one of both."


def diagnosis_answer(answer: RecordDiagnosed) -> Section:
    """Give the first section of a diagnosis: its verdict, and why."""
    words = [answer.headline(), *before_physics(answer)]
    reasons = (
        *answer.reasons(), *answer.other_values(), *answer.untested(), *answer.cautions(), *answer.farthest_off(),
        *answer.few_levels(),
    )  # fmt: skip
    words += [sentence(word) for word in reasons]
    if answer.proposal:
        words.append(f"Next test: {answer.proposal.words()}.")
    if answer.no_test:
        words.append(f"No next test: {answer.no_test}.")
    return Section("Answer", words)


def promised(diagnosis: Diagnosis) -> list[RungBars]:
    """Give the law as it is, and what the effects that it names would make of it; nothing else is promised.

    Of two that help only together neither is promised anything alone: they are added at once. Two that do nothing are
    no step.
    """
    pair = diagnosis.pair
    named = [judged for judged in diagnosis.candidates if judged.effects[0] in diagnosis.effects]
    both = diagnosis.found.named is not None and len(diagnosis.found.named.effects) > 1
    helps = pair is not None and explained_share(pair, diagnosis.law) >= LEAST_HELP
    coming = [*([] if both else named), *([pair] if pair and helps else [])] if diagnosis.effects else []
    return [
        RungBars("law as it is", {ESTIMATED: diagnosis.law.heldout_nrmse}),
        *(
            RungBars(
                f"{'or ' if place and len(judged.effects) == 1 else ''}+ {' + '.join(judged.effects)}",
                {ESTIMATED: judged.heldout_nrmse},
                promised=True,
                explained=explained_share(judged, diagnosis.law),
            )
            for place, judged in enumerate(coming)
        ),
    ]


def evidence_sections(answer: RecordDiagnosed) -> list[Section]:
    """Give the evidence of a diagnosis: the candidates, what is left over, the next test."""
    diagnosis, leftover = answer.diagnosis, answer.diagnosis.leftover
    residual = curves_picture(
        "phase / deg after the largest displacement", "residual / N",
        [("rms over runs", leftover.phase.tolist(), leftover.shape.tolist(), "lines")],
        f"Residual force along the cycle, {_law_described(diagnosis)}, noise included",
    ).update_yaxes(rangemode="tozero")  # fmt: skip
    cards = [_card(candidate, diagnosis) for candidate in helpful(diagnosis)[:SKETCHED]]
    candidates = Section("Candidates", _screened(diagnosis), [candidate_table(diagnosis)], cards=cards)
    sections = [
        *([candidates] if diagnosis.candidates else []),
        Section("What is left over", _left_over_sentences(answer), (), [residual]),
    ]
    return [*sections, _proposal_section(answer.proposal)] if answer.proposal else sections


def _card(candidate: Judged, diagnosis: Diagnosis) -> Card:
    """Tell of a candidate what to look at and what speaks against it, beside what it does to a loop."""
    law, name, effect = diagnosis.law, candidate.effects[0], _effect(candidate)
    words = [
        f"In the picture: {effect.looks_like}.",
        f"It takes the estimated error on left-out conditions from {law.heldout_nrmse:.2%} to "
        f"{candidate.heldout_nrmse:.2%}, and {explained_share(candidate, law):.0%} of what is missing.",
        f"Imitated by {', '.join(effect.imitated_by) or 'nothing'}; what tells: {effect.told_apart_by}.",
        f"Against it: {'; '.join(against(candidate, diagnosis)) or 'nothing in this data'}.",
    ]
    return Card(name, words, sketch(name, effect, candidate.result.law.structure.declared))


def _effect(candidate: Judged) -> Effect:
    return candidate.result.law.structure.effect(candidate.effects[0])


def _law_described(diagnosis: Diagnosis) -> str:
    effects = diagnosis.described.effects
    return f"law with {' and '.join(effects)}" if effects else "law as it is"


def _left_over_sentences(answer: RecordDiagnosed) -> list[str]:
    if told := [sentence(word) for word in answer.left_over()]:
        return told
    diagnosis = answer.diagnosis
    if answer.verdict == "complete" and not diagnosis.is_adequate(diagnosis.law):
        lack = diagnosis.law.lack
        times = f"{lack.share:.2g} times {answer.noise_name}"
        return [f"{newtons(lack.rms)} that follow the conditions, {times}: see the answer above."]
    return ["Nothing that follows the conditions." if answer.verdict == "complete" else "See the answer above."]


def _screened(diagnosis: Diagnosis) -> list[str]:
    """Say which effects weren't refitted, since one step towards them gained too little beside the best one's."""
    shares = diagnosis.screened_out
    if not shares:
        return []
    some = ", ".join(f"{name} ({share:.1%})" for name, share in shares.items() if share >= SHOWN_PROMISE)
    none = ", ".join(name for name, share in shares.items() if share < SHOWN_PROMISE)
    told = "; ".join(filter(None, (some, none)))
    return [
        "One linear step towards each effect shows which ones are worth a fit. These gain less by it, beside what the "
        f"best one gains, and weren't fitted: {told}."
    ]


def _proposal_section(proposal: Proposal) -> Section:
    panels = [
        LoopPanel(f"if it is {name}", proposal.motion.y[0], None, force)
        for name, force in zip(proposal.rivals, proposal.forces, strict=True)
    ]
    difference = LoopPanel("difference", proposal.motion.y[0], None, proposal.forces[0] - proposal.forces[1])
    words, drawn = drive_shown(proposal.plan, proposal.drive_words())
    return Section(
        "Next test", [sentence(proposal.words()), words, RECORDS_JOIN], (),
        [loops_picture([*panels, difference], "What each rival predicts"), drawn],
    )  # fmt: skip


def drive_shown(plan: DrivePlan, words: str) -> tuple[str, go.Figure]:
    """Give the drive signal of a proposed test in words and as a picture."""
    drive = plan.signal()
    curve = ("displacement", drive.time_s.tolist(), drive.displacement_mm.tolist(), "lines")
    picture = curves_picture("t / s", "y / mm", [curve], "Drive signal of the next test")
    return f"Drive signal, which --drive DRIVE.csv writes: {words}.", picture
