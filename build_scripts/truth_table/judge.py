"""Put one case to the package, as a user would: identify, diagnose, add, again and again; and say how it did."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from cases import Case, Drawn, Measured, draw, further_runs, measure

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed, diagnosed
from pipeclamp_identification.diagnosis.further_test.limits import Limits
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.fitting.misfit import misfits, overall_nrmse
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.workflow.auto import MOST_RUNGS, add_until_settled
from pipeclamp_identification.workflow.climb import Settled
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.tests import Tests
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import LawFile, Provenance, law_of, structure_of

COMMAND = "truth table"
RIG_LIMITS = Limits((0.1, 1.5), (0.5, 20.0), (20.0, 300.0))
"""What the rig states that it can do."""
MOST_TESTS = 2
"""Proposed tests that are run for one case, one after the other."""


class Noted(Protocol):
    """What is counted of a diagnosis, of whatever kind: verdict, kind and effects."""

    @property
    def verdict(self) -> str:
        """The verdict."""

    @property
    def kind(self) -> str | None:
        """How what was answered with it is meant."""

    @property
    def effects(self) -> tuple[str, ...]:
        """What was answered with it."""


@dataclass(frozen=True)
class Step:
    """One diagnosis.

    Attributes:
        verdict, kind, effects: what was answered.
        heldout_over_floor: error of the law, as it was diagnosed, on held-out conditions over that of the truth itself.
        lack: lack of fit of the law over the noise.
        candidates: effects, squares on left-out groups, lack of fit, objections; best first.
        screened_out: what was not fitted, with its share of the best's promise.
        reasons: given for the verdict.
    """

    verdict: str
    kind: str | None
    effects: tuple[str, ...]
    heldout_over_floor: float
    lack: float
    candidates: tuple[tuple[str, float, float, str], ...]
    screened_out: tuple[tuple[str, float], ...]
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Tested:
    """A proposed test in words, and what the diagnosis with its runs says; as in `Step`."""

    proposal: str
    verdict: str
    effects: tuple[str, ...]
    candidates: tuple[tuple[str, float, float, str], ...]
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """How a case came out.

    Attributes:
        name, kind, form, strength, noise, design: of the case.
        truth: ids that are hidden.
        strengths: what the base law can't imitate, over the noise.
        noise_share: noise over force.
        steps: every diagnosis, in order.
        counted: the first diagnosis, in a word: see `counted`.
        added: what was added until settled.
        settled: for an ambiguous end, how the proposed tests ended it: "right", "wrong", a verdict, or
            "none proposed"; else "".
        tests: the proposed tests that were run, in order.
        seconds: what it took.
        error: the message, where the package failed.
    """

    name: str
    kind: str
    form: str
    strength: str
    noise: str
    design: str
    truth: tuple[str, ...]
    strengths: tuple[float, ...]
    noise_share: float
    steps: tuple[Noted, ...]
    counted: str
    added: tuple[str, ...]
    settled: str
    tests: tuple[Tested, ...]
    seconds: float
    error: str = ""


def judged(case: Case, seed: int) -> Outcome:
    """Run one case."""
    begin = time.perf_counter()
    drawn = draw(case, seed)
    data = measure(drawn)
    steps: list[Step] = []
    added: tuple[str, ...] = ()
    tests: list[Tested] = []
    error = settled = ""
    try:
        file = law_file(identify(data.campaign), data.campaign, name="base", provenance=Provenance(COMMAND))
        most = 0 if case.kind == "narrow" else MOST_RUNGS
        end = follow(file, RecordTests(data.campaign), steps, partial(noted, data=data), most)
        added = tuple(one.name for one in structure_of(end.file).all_effects() if one.part != "base")
        if isinstance(end.found, RecordDiagnosed) and end.found.verdict == "ambiguous" and case.truth:
            settled = after_proposed(drawn, data, end.file, end.found, tests)
    except Exception as fault:  # a case that fails is a finding, and mustn't end the others
        error = f"{type(fault).__name__}: {fault}"
    return outcome_of(case, data.strengths, data.noise_share, steps, added, begin, error, settled, tests)


def outcome_of(
    case: Case,
    strengths: Sequence[float],
    noise_share: float,
    steps: Sequence[Noted],
    added: Sequence[str],
    begin: float,
    error: str,
    settled: str = "",
    tests: Sequence[Tested] = (),
) -> Outcome:
    """Count how a case came out that was begun at this time; arguments as in `Outcome`."""
    return Outcome(
        case.name, case.kind, case.form, case.strength, case.noise, case.design, tuple(sorted(case.truth)),
        tuple(round(one, 3) for one in strengths), noise_share, tuple(steps),
        "failed" if error else counted(case, steps, added), tuple(added), settled, tuple(tests),
        round(time.perf_counter() - begin, 1), error,
    )  # fmt: skip


def follow(
    file: LawFile,
    tests: Tests,
    steps: list[Any],
    note: Callable[[Any, LawFile], Any],
    most: int,
) -> Settled:
    """Diagnose and add as `pipeclamp diagnose --auto` does.

    Args:
        file: the law as it was identified.
        tests: records, or metrics alone.
        steps: is given each diagnosis as it is noted.
        note: notes a diagnosis of a law.
        most: effects that are added at most.
    """
    return add_until_settled(
        file, tests, command=COMMAND, limits=RIG_LIMITS, most=most,
        seen=lambda found, law: steps.append(note(found, law)),
    )  # fmt: skip


def after_proposed(drawn: Drawn, data: Measured, file: LawFile, found: RecordDiagnosed, tests: list[Tested]) -> str:
    """Run the test that an ambiguous answer proposes, and one more where rivals are left; say how it ended.

    Args:
        drawn: the case.
        data: as it was measured.
        file: the law.
        found: the ambiguous diagnosis of it.
        tests: is given each test and what came of it.
    """
    campaign = data.campaign
    while found.verdict == "ambiguous" and len(tests) < MOST_TESTS:
        if found.proposal is None:
            return "none proposed"
        campaign = further_runs(drawn, data, campaign, found.proposal)
        words = found.proposal.words()
        found = diagnosed(file, campaign, limits=RIG_LIMITS)
        diagnosis = found.diagnosis
        tests.append(Tested(words, found.verdict, _ids(found), _shown(found), diagnosis.reasons))
    if found.verdict != "missing":
        return found.verdict
    return "right" if set(_ids(found)) <= drawn.case.truth else "wrong"


def _ids(found: RecordDiagnosed) -> tuple[str, ...]:
    """Give the ids of what a diagnosis names: how many slip elements there are isn't asked."""
    return tuple(map(effect_id, found.effects))


def noted(found: RecordDiagnosed, file: LawFile, data: Measured) -> Step:
    """Note a diagnosis."""
    diagnosis = found.diagnosis
    return Step(
        found.verdict, found.kind, _ids(found),
        round(heldout_over_floor(file, data.heldout, data.heldout_floor), 4), round(diagnosis.law.lack.share, 4),
        _shown(found), tuple((name, round(promise, 4)) for name, promise in diagnosis.screened_out.items()),
        (*diagnosis.reasons, f"not locked to the motion, Hz: {list(found.diagnosis.leftover.time_locked_Hz)}"),
    )  # fmt: skip


def _shown(found: RecordDiagnosed) -> tuple[tuple[str, float, float, str], ...]:
    """Give the best candidates as `Step` holds them."""
    return tuple(
        (
            "+".join(one.effects),
            round(one.squares, 1),
            round(one.lack.share, 4),
            "; ".join((*one.objections, *one.reservations)),
        )
        for one in found.diagnosis.candidates[:6]
    )


def heldout_over_floor(file: LawFile, heldout: Campaign, floor: float) -> float:
    """Give the law's error on other conditions over that of the truth itself."""
    return overall_nrmse(misfits(law_of(file), heldout, loops_of(heldout))) / floor


def counted(case: Case, steps: Sequence[Noted], added: Sequence[str]) -> str:
    """Say how a case came out, in a word.

    "right", "ambiguous3" (truth among at most three), "ambiguous" (among more), "ambiguous_wrong", "wrong" (another
    effect, with confidence), "unknown", "complete" (missed), and, where nothing is hidden, "right" or "false_alarm".
    "other_part": another effect, which was said to take a part and to prove nothing.
    Of two effects or more: "right" when all were added and nothing else; "wrong" when another cause was named;
    "other_part" when another part was added; "ambiguous3" when it ends with a further one among at most three;
    "some" when it ends otherwise.
    """
    first = steps[0]
    if case.kind == "none":
        return "right" if first.verdict == "complete" else "false_alarm"
    if case.kind == "unlisted":
        if first.kind == "part":
            return "right"
        return {"unknown": "right", "missing": "wrong", "complete": "complete"}.get(first.verdict, "ambiguous_wrong")
    if case.kind in ("two", "several"):
        return _many(case, steps, {case.known_as(effect_id(name)) for name in added})
    if first.verdict == "missing":
        return "right" if _named(case, first) <= case.truth else _other(first)
    if first.verdict == "ambiguous":
        return _ambiguous(_named(case, first), case.truth)
    return first.verdict


def _other(step: Noted) -> str:
    return "other_part" if step.kind == "part" else "wrong"


def _named(case: Case, step: Noted) -> set[str]:
    return set(map(case.known_as, step.effects))


def _ambiguous(named: set[str], truth: frozenset[str]) -> str:
    if not truth & named:
        return "ambiguous_wrong"
    return "ambiguous3" if len(named) <= 3 else "ambiguous"


def _many(case: Case, steps: Sequence[Noted], found: set[str]) -> str:
    last = steps[-1]
    if any(
        step.verdict == "missing" and step.kind == "cause" and not _named(case, step) <= case.truth for step in steps
    ):
        return "wrong"
    if found - case.truth:
        # what wasn't called the cause was added as a part, or took a part's place
        return "other_part"
    if found == case.truth:
        return "right"
    if last.verdict == "ambiguous":
        return _ambiguous(_named(case, last), case.truth - found)
    return "some" if found else last.verdict
