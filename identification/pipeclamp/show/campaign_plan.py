"""A campaign before any test, in sentences and tables."""

from __future__ import annotations

import math
from pathlib import Path

from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.further_test.limits import limits_words
from pipeclamp_identification.planning.campaign import CampaignPlan
from pipeclamp_identification.planning.campaign_answer import campaign_plan_answer
from pipeclamp_identification.planning.telling import NAMED
from pipeclamp_models.base.digits import newtons, plain
from pipeclamp_models.base.shell import shell_line

FOR_EXAMPLE = "hardening"
"""An effect that a virtual rig may hide."""


def campaign_plan_view(plan: CampaignPlan, folder: Path | None, law: str | None = None) -> View:
    """Give how a campaign is told; `folder` is where it was written, `law` as in `campaign_plan_words`."""
    return View(campaign_plan_answer(plan), [stages_table(plan)], campaign_plan_words(plan, folder, law))


def stages_table(plan: CampaignPlan) -> Table:
    """Give what is known after each block of one temperature."""
    rows: list[tuple[str | float | None, ...]] = []
    for number, stage in enumerate(plan.stages, 1):
        own = [run for run in plan.runs if run.block == number]
        rows.append((str(number), stage.temperature_C, str(len(own)), stage.hours, stage.newtons, f"{stage.told}"))
    header = ("block", "T / °C", "runs", "hours so far", f"names {NAMED:.0%} above / N", "effects that can be told")
    return Table(header, rows)


def effects_table(plan: CampaignPlan) -> Table:
    """Give from which size on each effect is named, the largest of these first."""
    scene, sizes, told = plan.power.scene, plan.power.sizes, plan.power.told
    order = sorted(range(len(sizes)), key=lambda place: -sizes[place])
    rows = [
        (
            scene.effects[place], float(sizes[place]) if told[place] else None,
            float(sizes[place] / scene.force) * 100 if told[place] else None,
            scene.hidden[place].nearest,
        )
        for place in order
    ]  # fmt: skip
    header = ("effect", "named above / N", "% of the force", "most like it here")
    return Table(header, rows, f"rms force from which on an effect is named in {NAMED:.0%} of such campaigns")


def campaign_plan_words(plan: CampaignPlan, folder: Path | None = None, law: str | None = None) -> list[str]:
    """Say what a campaign names in how many hours, when to stop, and what was assumed.

    Args:
        plan: the campaign.
        folder: that it was written into, if any.
        law: file or bundled name by which its law is known to commands; its name by default.
    """
    scene, told = plan.power.scene, plan.power.told
    lines = [_what_it_names(plan), *_runs_words(plan), *stopping_words(plan)]
    untold = [name for name, one in zip(scene.effects, told, strict=True) if not one]
    if untold:
        lines.append(f"Not told by this plan in any size below the clamp's own force: {', '.join(untold)}.")
    if scene.not_reckoned:
        lines.append(
            "Not assessed, as they follow what these tests don't vary, or change what the base law hasn't got: "
            f"{', '.join(scene.not_reckoned)}."
        )
    asked, times = plan.asked, plan.asked.times
    limits = plan.limits if plan.timed else plan.limits.untimed
    lines.append(
        f"Assessed with the base of law {plan.law}, {asked.noise_N:g} N rms noise of the force at {asked.rate:g} "
        f"samples a second, {asked.scatter:.2%} scatter from run to run, {times.heating:g} K a minute, "
        f"{times.soak_min:g} min at each new temperature, {times.pause_s:g} s between runs; within "
        f"{limits_words(limits)}. An effect of another form than the catalogue's needs more."
    )
    if folder:
        tried = shell_line("rig", law or plan.law, "-o", "virtual", "--plan", str(folder), "--effects", FOR_EXAMPLE)
        lines += [
            f"{folder} holds plan.csv, the drive signals, and a campaign that waits for its records in runs/.",
            f"To try it before the rig does, with an effect hidden in it: {tried}",
        ]
    return lines


def _what_it_names(plan: CampaignPlan) -> str:
    """Say which effects a campaign names in how many hours."""
    scene, named_from = plan.power.scene, plan.power.from_newtons
    if not math.isfinite(named_from):
        return f"This plan names no effect in {plan.hours:.3g} rig hours."
    count, among = int(plan.power.told.sum()), len(scene.effects)
    told_of = f"all {among}" if count == among else f"{count} of {among}"
    return (
        f"In {plan.hours:.3g} rig hours this plan can tell {told_of} effects that were assessed, and names "
        f"{NAMED:.0%} of them where their rms force is above {newtons(named_from)}, {named_from / scene.force:.2%} "
        f"of the clamp's own over the loops within the limits, {plain(scene.force, 4)} N."
    )


def _runs_words(plan: CampaignPlan) -> list[str]:
    """Say which runs a campaign has, about where they move, and in which order they come."""
    levels = [
        f"{', '.join(f'{value:g}' for value in sorted({getattr(run, name) for run in plan.runs}))} {unit}"
        for name, unit in (("amplitude_mm", "mm"), ("frequency_Hz", "Hz"), ("temperature_C", "°C"))
    ]
    if not plan.timed:
        levels[1] = "a cycle at any slow rate, which is called a second in its files"
    often = "once" if plan.repeats == 1 else f"{plan.repeats} times"
    lines = [f"{len(plan.runs)} runs at {'; '.join(levels)}; each {often}."]
    if about := plan.about_mm:
        lines.append(
            f"The tests of {plan.law} moved about {about:.3g} mm, and so do these runs; their drive signals count from "
            "there."
        )
    several = len({run.temperature_C for run in plan.runs}) > 1
    lines.append(
        "Order: temperatures rise, a block each; within it every condition once in random order, then in the reverse "
        "of it, so that even drift is the same for all; a reference run begins and ends each block"
        + (", and the first temperature comes again at the end." if several else ".")
    )
    return lines


def stopping_words(plan: CampaignPlan) -> list[str]:
    """Say when to stop, or to go on otherwise."""
    lines = [
        "Stopping rule: after each block identify and diagnose. Stop when the verdict is complete, or names the same "
        "effect after two blocks; where it is ambiguous run its next test instead of the next block. Where the "
        "reference run of a block's end differs from that of its beginning by more than three times the scatter, the "
        "clamp or the rig drifts: repeat the block before heating on."
    ]
    longer = [one for one in plan.tried if one.hours > plan.hours and one.told >= int(plan.power.told.sum())]
    now = plan.power.from_newtons
    best = min(longer, key=lambda one: one.newtons, default=None)
    if best is not None and best.newtons < now:
        lines.append(f"The best plan that takes longer: {newtons(best.newtons)} in {best.hours:.3g} h.")
    return lines
