"""Put one device to the package, as a user would: read, identify, diagnose with --auto; and say how it did."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from devices.cases import DeviceCase, write_device
from pipeclamp_identification.campaign.reading import Campaign, read_campaign
from pipeclamp_identification.comparison.compare import compare
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.workflow.auto import add_until_settled
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.file import LawFile, Provenance

COMMAND = "devices"
FALSELY_COMPLETE = 1.3
"""A law that is called complete errs by at most so many times the noise floor on held-out conditions (issue 13, 9)."""


@dataclass(frozen=True)
class Rung:
    """One diagnosis on the way.

    Attributes:
        verdict, kind, effects: what was answered; kind is "cause", "part" or "".
        held_out: error of the law that was diagnosed, on held-out conditions, as a share of the force.
        reasons: given for the verdict.
        seconds: what the diagnosis took, with adding what it named.
    """

    verdict: str
    kind: str
    effects: tuple[str, ...]
    held_out: float
    reasons: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class DeviceOutcome:
    """How a case came out.

    Attributes:
        name, rig: of the case.
        truth: ids of effects that the device really holds; none where it is outside the catalogue.
        noise: the sensor's, as a share of the campaign's rms force.
        floor: noise on held-out conditions, as a share of their force.
        before, after: error on held-out conditions of the law as identified, and where the ladder ended.
        rungs: every diagnosis, in order.
        effects: of the law where the ladder ended.
        counted: see `counted`.
        identify_seconds, seconds: what identifying took, and the ladder.
        error: the message, where the package failed.
    """

    name: str
    rig: str
    truth: tuple[str, ...]
    noise: float
    floor: float
    before: float
    after: float
    rungs: tuple[Rung, ...]
    effects: tuple[str, ...]
    counted: str
    identify_seconds: float
    seconds: float
    error: str = ""


@one_thread()  # as every command does
def judged_device(case: DeviceCase, seed: int) -> DeviceOutcome:
    """Run one case."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        noise = write_device(case, seed, folder).noise
        campaign, held_out = read_campaign(folder / "campaign"), read_campaign(folder / "held_out")
    rungs: list[Rung] = []
    floor = before = after = float("nan")
    effects: tuple[str, ...] = ()
    error = ""
    begin = identified = time.perf_counter()
    try:
        file = law_file(identify(campaign), campaign, name="base", provenance=Provenance(COMMAND))
        identified = time.perf_counter()
        other = loops_of(held_out)
        found = compare(file, held_out, other)
        floor, before = found.noise_nrmse, found.nrmse
        law = climbed(file, campaign, lambda law: compare(law, held_out, other).nrmse, rungs)
        after, effects = compare(law, held_out, other).nrmse, law.effects
    except Exception as fault:  # a case that fails is a finding, and mustn't end the others
        error = f"{type(fault).__name__}: {fault}"
    end = time.perf_counter()
    count = "failed" if error else counted(case.truth, rungs, after / floor)
    return DeviceOutcome(
        case.name, case.rig_name, tuple(sorted(case.truth)), noise, floor, before, after, tuple(rungs), effects, count,
        round(identified - begin, 3), round(end - identified, 1), error,
    )  # fmt: skip


def climbed(file: LawFile, campaign: Campaign, held_out: Callable[[LawFile], float], rungs: list[Rung]) -> LawFile:
    """Diagnose and add as `pipeclamp diagnose --auto` does; give the law where that ends.

    Args:
        file: the law as it was identified.
        campaign: the tests.
        held_out: gives a law's error on other conditions.
        rungs: is given each diagnosis.
    """
    last = time.perf_counter()

    def note(found: Any, law: LawFile) -> None:
        nonlocal last
        seconds = round(time.perf_counter() - last, 1)
        effects = tuple(map(effect_id, found.effects))
        reasons = tuple(found.diagnosis.reasons)
        rungs.append(Rung(found.verdict, kind_of(found), effects, held_out(law), reasons, seconds))
        last = time.perf_counter()

    return add_until_settled(file, RecordTests(campaign), command=COMMAND, seen=note).file


def kind_of(found: Any) -> str:
    """Say how a diagnosis means what it names: "cause", "part", or "" where it names nothing as missing.

    Without a kind of its own, "missing" means the cause.
    """
    if found.verdict != "missing":
        return ""
    kind = getattr(found, "kind", None) or getattr(getattr(found, "diagnosis", None), "kind", None)
    return str(kind or "cause")


def counted(truth: frozenset[str], rungs: list[Rung], ratio: float) -> str:
    """Say how a case came out, in a word.

    "wrong": something was named as the cause that the device doesn't hold; "falsely complete": called complete with
    an error on held-out conditions well above the noise; else the last verdict, or "cause" or "part" where the ladder
    ends with something that is missing and doesn't help.

    Args:
        truth: ids of effects that the device holds.
        rungs: every diagnosis.
        ratio: error where the ladder ended, over the noise, both on held-out conditions.
    """
    if any(rung.kind == "cause" and not set(rung.effects) <= truth for rung in rungs):
        return "wrong"
    if rungs[-1].verdict == "complete" and ratio > FALSELY_COMPLETE:
        return "falsely complete"
    return rungs[-1].kind or rungs[-1].verdict
