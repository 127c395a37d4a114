"""What `plan -o FOLDER` answers, and the files that it writes."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path

from pydantic import Field

from pipeclamp_identification.campaign.description import FILE_NAME as DESCRIPTION
from pipeclamp_identification.campaign.description import description_text
from pipeclamp_identification.campaign.drive import DrivePlan, drive_content
from pipeclamp_identification.campaign.runs_table import FILE_NAME as RUNS
from pipeclamp_identification.diagnosis.further_test.limits import limits_words
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, SINE
from pipeclamp_identification.planning.campaign import CampaignPlan
from pipeclamp_identification.planning.schedule import TABLE, table_text
from pipeclamp_identification.planning.telling import NAMED
from pipeclamp_models.base.answer import AnswerModel, known


class EffectPower(AnswerModel):
    """From which size on an effect is named."""

    effect: str
    newtons: float | None = Field(description="rms force from which on it is named in 90% of such campaigns; None: no")
    nearest: str | None = Field(description="the effect that is most like it in these tests; None: isn't known")


class StagePower(AnswerModel):
    """What is known after a block."""

    temperature_C: float
    hours: float
    newtons: float | None = Field(description="as of the whole plan; None: no size does")
    told: int = Field(description="effects that can be told at all")


class CampaignPlanAnswer(AnswerModel):
    """A campaign before any test."""

    law: str = Field(description="that the clamp is expected to be like")
    limits: str
    hours: float
    runs: int
    amplitudes_mm: tuple[float, ...]
    frequencies_Hz: tuple[float, ...]
    temperatures_C: tuple[float, ...]
    repeats: int
    named: float = Field(description="share of the effects that are named from `newtons` on")
    newtons: float | None = Field(description="rms force of an effect over the loops within the limits")
    force_noise_N: float
    scatter: float = Field(description="rms share by which stiffness and damping differ from run to run")
    effects: tuple[EffectPower, ...]
    not_reckoned: tuple[str, ...] = Field(
        description="effects that follow what these tests don't vary, or need another effect"
    )
    stages: tuple[StagePower, ...]


def campaign_plan_answer(plan: CampaignPlan) -> CampaignPlanAnswer:
    """Give what a campaign would tell."""
    scene = plan.power.scene
    sizes, told = plan.power.sizes, plan.power.told
    return CampaignPlanAnswer(
        law=plan.law,
        limits=limits_words(plan.limits),
        hours=plan.hours,
        runs=len(plan.runs),
        amplitudes_mm=tuple(sorted({run.amplitude_mm for run in plan.runs})),
        frequencies_Hz=tuple(sorted({run.frequency_Hz for run in plan.runs})),
        temperatures_C=tuple(sorted({run.temperature_C for run in plan.runs})),
        repeats=plan.repeats,
        named=NAMED,
        newtons=known(plan.power.from_newtons),
        force_noise_N=plan.asked.noise_N,
        scatter=plan.asked.scatter,
        effects=tuple(
            EffectPower(
                effect=name,
                newtons=float(sizes[place]) if told[place] else None,
                nearest=scene.hidden[place].nearest or None,
            )
            for place, name in enumerate(scene.effects)
        ),
        not_reckoned=scene.not_reckoned,
        stages=tuple(
            StagePower(temperature_C=one.temperature_C, hours=one.hours, newtons=one.newtons, told=one.told)
            for one in plan.stages
        ),
    )


def plan_files(plan: CampaignPlan, name: str, command: str) -> Iterator[tuple[str, bytes]]:
    """Give the files of a plan: its order, drive signals, and a campaign that waits for its records."""
    yield TABLE, table_text(plan.runs).encode()
    yield DESCRIPTION, description_text(name, f"Planned: {command}", time_measured=plan.timed).encode()
    yield RUNS, _runs_text(plan).encode()
    for file, (A, f) in {run.drive: (run.amplitude_mm, run.frequency_Hz) for run in plan.runs}.items():
        yield file, drive_content(DrivePlan(PROFILES[SINE], A, f).signal(), Path(file))


def _runs_text(plan: CampaignPlan) -> str:
    text = io.StringIO()
    columns = ("run", "file", "amplitude_mm", "frequency_Hz", "temperature_C", "first_cycle")
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for run in plan.runs:
        writer.writerow({**vars(run), "file": f"runs/{run.run}.csv"})
    return text.getvalue()
