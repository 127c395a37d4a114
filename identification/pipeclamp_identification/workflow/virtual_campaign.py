"""A virtual campaign: what is asked of the rig, run on a law's clamp and written."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeclamp_identification.campaign.drive import FULL_CYCLES, RAMP_CYCLES, read_drive
from pipeclamp_identification.campaign.rig.plan import TestPlan, driven, planned
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.rig.truth import Truth, beyond_range, truth_of
from pipeclamp_identification.campaign.writing import Format, write_campaign
from pipeclamp_identification.planning.schedule import read_plan
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile

OF_NO_DRIVE = ("amplitudes", "frequencies", "cycles", "ramp_cycles", "distortion", "riding", "riding_order")
"""What makes a motion, where no drive signal states it."""
OF_NO_PLAN = ("amplitudes", "frequencies", "temperatures", "repeats", "cycles", "ramp_cycles", "drive")
"""What says which runs there are, where no plan does."""


@dataclass(frozen=True)
class VirtualCampaign:
    """A virtual campaign that was written.

    Attributes:
        folder: of the campaign.
        count: of its runs.
        truth: what its clamp obeys.
        beyond: which of its conditions lie beyond the data of the law that stands for the clamp, in words.
    """

    folder: Path
    count: int
    truth: Truth
    beyond: tuple[str, ...]


def refuse_stated_twice(
    stated: Collection[str], drive: Path | None, plan: Path | None, called: Callable[[str], str] = str
) -> None:
    """Refuse what states what a file, which is given, states already.

    Args:
        stated: names of what was stated, as of `TestPlan`.
        drive, plan: the files that are given.
        called: gives what a name is called where it was stated.

    Raises:
        UsageError: something is stated twice.
    """
    for name, file, others, what in (("plan", plan, OF_NO_PLAN, "runs"), ("drive", drive, OF_NO_DRIVE, "motion")):
        if file and (twice := [called(other) for other in others if other in stated]):
            raise UsageError(f"{called(name)}: got {', '.join(twice)} as well; expected the {what} from {file} alone")


def make_virtual_campaign(
    file: LawFile,
    folder: Path,
    asked: TestPlan,
    *,
    notes: str,
    effects: Sequence[str] = (),
    declared: Iterable[Declaration] = (),
    values: Mapping[str, float] | None = None,
    drive: Path | None = None,
    plan: Path | None = None,
    format: Format = "csv",
    progress: Progress = silent,
) -> VirtualCampaign:
    """Run a campaign on the virtual rig and write it, whole or not at all.

    Args:
        file: the law that the clamp obeys.
        folder: the campaign's; it must not exist.
        asked: which runs, and how well they are measured.
        notes: of the campaign.
        effects, declared, values: further effects of the clamp, and sizes, as of `truth_of`.
        drive: a drive signal that every run follows.
        plan: a campaign that was planned, whose runs these are, in its order.
        format: of the records.
        progress: is told each run.

    Raises:
        UserError: law, effects, values and plan don't go together, or the folder can't be written.
    """
    if asked.about is None:
        asked = replace(asked, about=file.about)
    runs_of = read_plan(plan) if plan else ()
    if drive:
        asked = driven(asked, read_drive(drive))
    if runs_of:
        asked = planned(replace(asked, cycles=FULL_CYCLES, ramp_cycles=RAMP_CYCLES), runs_of)
    truth = truth_of(file, effects, values or {}, asked, declared)
    runs = virtual_runs(truth.law, asked, truth.conditions)
    count = write_campaign(folder, runs, name=folder.name, notes=notes, format=format, progress=progress)
    return VirtualCampaign(folder, count, truth, tuple(beyond_range(file, asked)))
