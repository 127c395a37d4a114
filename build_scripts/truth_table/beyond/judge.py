"""Put one case to the package, as a user would: identify, diagnose with --auto, discover with --auto."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from cases import Case, Drawn, Measured, draw, measure
from judge import RIG_LIMITS, heldout_over_floor

from beyond.form import RIGHT_FORM, difference
from beyond.registry import LAWS
from pipeclamp_identification.discovery.proposal import TermProposal
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.discover import discover
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import LawFile, Provenance, law_of, structure_of

COMMAND = "truth table of discovery"
NEAR_FLOOR = {"clean": 1.05, "rough": 1.10}
"""A law errs on held-out conditions by at most so many times the floor, where what is hidden is found (issue 16, 5)."""


@dataclass(frozen=True)
class Answered:
    """What a discovery answered.

    Attributes:
        proposed: whether anything.
        family, formula: of the proposed term, or of the one that came nearest; "" where there is none.
        reason: why nothing is proposed.
        guards: those that weren't passed, with figures.
        tried: terms that were evaluated.
        seconds: what it took.
        instead: an effect of the catalogue that joined the law in the place of a term; "" where none did.
    """

    proposed: bool
    family: str
    formula: str
    reason: str
    guards: tuple[str, ...]
    tried: int
    seconds: float
    instead: str = ""


@dataclass(frozen=True)
class BeyondOutcome:
    """How a case came out.

    Attributes:
        name, kind, form, strength, noise, design: of the case.
        law: the name of the law that is hidden, or of the effect where no law is; "" where nothing is.
        strengths: what the base law can't imitate of it, over the noise.
        noise_share: noise over force.
        ladder: what `--auto` added.
        verdict: where it ended.
        first: of an effect of the catalogue: what a discovery answers of the base law, before the ladder.
        found: what it answers after the ladder.
        identified, diagnosed, discovered: error on held-out conditions over the floor, of the laws on the way.
        difference: of the proposed term from what is hidden, see `form`, also of one in an effect's place: after the
            ladder, or before it where none is proposed after; nan where there is none to compare.
        counted: in a word, see `counted`.
        ladder_seconds, seconds: what the ladder took, and all.
        error: the message, where the package failed.
    """

    name: str
    kind: str
    form: str
    strength: str
    noise: str
    design: str
    law: str
    strengths: tuple[float, ...]
    noise_share: float
    ladder: tuple[str, ...] = ()
    verdict: str = ""
    first: Answered | None = None
    found: Answered | None = None
    identified: float = float("nan")
    diagnosed: float = float("nan")
    discovered: float = float("nan")
    difference: float = float("nan")
    counted: str = "failed"
    ladder_seconds: float = 0.0
    seconds: float = 0.0
    error: str = ""


def judged_beyond(case: Case, seed: int) -> BeyondOutcome:
    """Run one case."""
    begin = time.perf_counter()
    drawn = draw(case, seed)
    data = measure(drawn)
    strengths = tuple(round(one, 3) for one in data.strengths)
    blank = BeyondOutcome(
        case.name, case.kind, case.form, case.strength, case.noise, case.design, "".join(case.hidden[:1]), strengths,
        data.noise_share,
    )  # fmt: skip
    try:
        outcome = _followed(blank, drawn, data)
        outcome = replace(outcome, counted=counted(outcome, case.truth))
    except Exception as fault:  # a case that fails is a finding, and mustn't end the others
        outcome = replace(blank, error=f"{type(fault).__name__}: {fault}")
    return replace(outcome, seconds=round(time.perf_counter() - begin, 1))


def _followed(blank: BeyondOutcome, drawn: Drawn, data: Measured) -> BeyondOutcome:
    """Go the way of a user; give how it came out, but for the count and the time."""
    tests = RecordTests(data.campaign)
    file = law_file(identify(data.campaign), data.campaign, name="base", provenance=Provenance(COMMAND))
    asked_first = _asked(file, tests) if blank.kind == "effect" else None
    begin = time.perf_counter()
    settled = add_until_settled(file, tests, command=COMMAND, limits=RIG_LIMITS)
    ladder_seconds = round(time.perf_counter() - begin, 1)
    proposal, answer = _asked(settled.with_diagnosis(tests.name), tests)
    last = proposal.after or settled.file
    identified, diagnosed, discovered = (
        round(heldout_over_floor(law, data.heldout, data.heldout_floor), 4) for law in (file, settled.file, last)
    )
    proposals = [proposal, *([asked_first[0]] if asked_first else [])]
    return replace(
        blank, ladder=tuple(one.name for one in structure_of(settled.file).all_effects() if one.part != "base"),
        verdict=settled.found.verdict, first=asked_first[1] if asked_first else None, found=answer,
        identified=identified, diagnosed=diagnosed, discovered=discovered,
        difference=how_far_off(blank.law, drawn, data.sizes, proposals), ladder_seconds=ladder_seconds,
    )  # fmt: skip


def how_far_off(hidden: str, drawn: Drawn, sizes: tuple[float, ...], proposals: Sequence[TermProposal]) -> float:
    """Give how far what was put into a law lies from what is hidden, see `form`; nan where the law with it has that.

    Args:
        hidden: name of the law or effect; "" where nothing is.
        drawn: the case.
        sizes: of what is hidden.
        proposals: of which the first counts that has something.
    """
    laws = ((law_of(one.before), law_of(one.after)) for one in proposals if one.after is not None)
    lacking = [pair for pair in laws if hidden not in map(effect_id, pair[1].structure.effects)]
    return round(difference(drawn, sizes, *lacking[0]), 4) if hidden and lacking else float("nan")


def _asked(file: LawFile, tests: RecordTests) -> tuple[TermProposal, Answered]:
    """Ask for a term that a law lacks, as `pipeclamp discover --auto` does."""
    begin = time.perf_counter()
    proposal = discover(file, tests, command=COMMAND)
    told = proposal.answer()
    failed = tuple(f"{guard.asked}: {guard.words}" for guard in told.guards if not guard.passed)
    seconds = round(time.perf_counter() - begin, 1)
    return proposal, Answered(
        told.proposed, told.family or "", told.formula or "", told.reason, failed, told.tried, seconds,
        told.instead or "",
    )  # fmt: skip


def counted(outcome: BeyondOutcome, truth: frozenset[str]) -> str:
    """Say how a case came out, in a word.

    Of nothing: "right", or "false alarm" where a term is proposed or an effect joins. Of an effect of the catalogue:
    "right"; "displaced" where a term is proposed in its place, before the ladder or after one that didn't find it;
    "false alarm" where one is proposed beside it, or another effect joins. Of a law beyond the catalogue: "right form",
    "wrong form" or "wrong kind" of what is proposed; where nothing is, "nothing left" where the ladder came near the
    floor by itself, else "nothing proposed".

    Args:
        outcome: what was answered.
        truth: ids of the catalogue's effects that are hidden.
    """
    proposed = outcome.found is not None and outcome.found.proposed
    if outcome.kind == "none":
        return "false alarm" if proposed or _joined(outcome) else "right"
    if outcome.kind == "effect":
        return _beside_the_catalogue(outcome, proposed, truth)
    if not proposed:
        return "nothing left" if outcome.diagnosed <= NEAR_FLOOR[outcome.form] else "nothing proposed"
    if outcome.found is None or outcome.found.family not in LAWS[outcome.law].families:
        return "wrong kind"
    return "right form" if outcome.difference <= RIGHT_FORM else "wrong form"


def _beside_the_catalogue(outcome: BeyondOutcome, proposed: bool, truth: frozenset[str]) -> str:
    if outcome.first is not None and outcome.first.proposed:
        return "displaced"
    if not proposed:
        return "right" if _joined(outcome) <= truth else "false alarm"
    found = {effect_id(name) for name in outcome.ladder}
    return "false alarm" if truth <= found else "displaced"


def _joined(outcome: BeyondOutcome) -> set[str]:
    """Give the ids of the effects that joined in the place of a term, before the ladder or after it."""
    return {effect_id(one.instead) for one in (outcome.first, outcome.found) if one is not None and one.instead}
