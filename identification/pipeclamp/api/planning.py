"""Which tests to run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.law import Law, opened
from pipeclamp.api.shown import (
    PathOrName,
    Shown,
    called_from_python,
    count_of,
    file_of,
    frame_of,
    limits_of,
    number_of,
    number_or_none,
    path_of,
    text_of,
)
from pipeclamp.show.campaign_plan import campaign_plan_view
from pipeclamp.show.narrowing import band_plan_view
from pipeclamp.show.view import View
from pipeclamp_identification.campaign.drive import write_drive
from pipeclamp_identification.planning import campaign
from pipeclamp_identification.planning.band_plan import BandPlan
from pipeclamp_identification.planning.campaign import CampaignPlan
from pipeclamp_identification.planning.campaign_answer import plan_files
from pipeclamp_identification.planning.loop_tests import RIG
from pipeclamp_identification.planning.narrowing import plan_tests
from pipeclamp_identification.planning.rig_times import HOURS, RIG_TIMES, SCATTER_BEFOREHAND, RigTimes
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_folder
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report
    from pipeclamp_models.base.tables import pl


class LoopTests(Shown):
    """The loop tests that narrow the band of a pipe's peak.

    Attributes:
        found: the bands and the tests.
    """

    def __init__(self, found: BandPlan) -> None:
        self.found = found

    def view(self) -> View:
        """Give its answer, tables and lines."""
        return band_plan_view(self.found, None)

    def page(self) -> Report:
        """Give its page: title, subtitle, sections."""
        from pipeclamp.pages.narrowing import band_plan_page

        return band_plan_page(self.found)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a test, one after another: law, mm, Hz, °C, repeats, and the ends of the peak's band after it."""
        from pipeclamp_models.base.tables import pl

        ends = {"peak_low_mm": ("peak_mm", "low"), "peak_high_mm": ("peak_mm", "high")}
        plain = ("law", "amplitude_mm", "frequency_Hz", "temperature_C", "repeats")
        rows = [
            {name: row[name] for name in plain} | {name: row[of][end] for name, (of, end) in ends.items()}
            for row in self.to_dict()["tests"]
        ]
        return pl.DataFrame(rows, schema_overrides={"temperature_C": pl.Float64} if rows else None)

    def save_drive(self, path: PathOrName) -> Path:
        """Write the first test's drive signal, .csv or .parquet, whole or not at all, and give its path.

        Raises:
            UserError: no test is worth its time, or it can't be written there.
        """
        if not self.found.tests:
            raise UserError("save_drive: no test is proposed: none makes the peak surer by what it is worth")
        with called_from_python(drive="save_drive"):
            target = file_of(path)
            write_drive(self.found.tests[0].plan.signal(), target)
        return target

    def __repr__(self) -> str:
        """Give the system and how many tests are worth their time."""
        return f"<loop tests for {self.found.system}: {len(self.found.tests)}>"


class PlannedCampaign(Shown):
    """A campaign before any test.

    Attributes:
        found: its runs, and which effects they would name.
    """

    def __init__(self, found: CampaignPlan) -> None:
        self.found = found

    def view(self) -> View:
        """Give its answer, tables and lines."""
        return campaign_plan_view(self.found, None)

    def page(self) -> Report:
        """Give its page: title, subtitle, sections."""
        from pipeclamp.pages.campaign_plan import campaign_plan_page

        return campaign_plan_page(self.found)

    def to_frame(self) -> pl.DataFrame:
        """Give a row a run, in their order: run, mm, Hz, °C, load cycles before it, its drive signal."""
        return frame_of([vars(run) for run in self.found.runs])

    def save(self, folder: PathOrName) -> Path:
        """Write the order of the runs, drive signals, and a campaign that waits for its records, as a new folder.

        Raises:
            UserError: the folder exists, or its parent can't be written.
        """
        target = file_of(folder)
        write_folder(target, plan_files(self.found, target.name, "pipeclamp.plan_campaign"))
        return target

    def __repr__(self) -> str:
        """Give how many runs there are, and how long they take."""
        return f"<campaign of {len(self.found.runs)} runs in {self.found.hours:.3g} h>"


@called_from_python()
@one_thread()
def plan_campaign(
    *, limits: str | None = None, hours: float = HOURS, law: Law | PathOrName = "emwm2",
    force_noise: float = RIG.force_noise, scatter: float = SCATTER_BEFOREHAND, heating: float = RIG_TIMES.heating,
    soak: float = RIG_TIMES.soak_min, pause: float = RIG_TIMES.pause_s, seed: int = 0, progress: Progress = silent,
) -> PlannedCampaign:  # fmt: skip
    """Plan the campaign that names the most and the smallest effects within its hours.

    Args:
        limits: what the rig can do, such as "A=0.1..2,f=0.5..20,T=20..300,v=..300"; around the law's data unless told.
        hours: rig hours that it may take, heating included.
        law: a law like that which the clamp may have, or its file or bundled name.
        force_noise: rms noise of the force, N.
        scatter: rms share by which stiffness and damping differ from run to run.
        heating: heating and cooling, K per minute.
        soak: minutes at a new temperature before a run.
        pause: seconds between two runs.
        seed: of the random order.
        progress: is told what is being done.

    Raises:
        UserError: there is no such law, nothing can be driven within the limits, or nothing fits into the hours.

    >>> plan_campaign(hours=0.15, limits="A=0.2..1,f=1..6,T=20..20")
    <campaign of 11 runs in 0.107 h>
    """
    reach = limits_of(limits)
    times = RigTimes(number_of(heating, "heating"), number_of(soak, "soak"), number_of(pause, "pause"))
    asked = campaign.PlanRequest(
        number_of(hours, "hours"), number_of(force_noise, "force_noise"), number_of(scatter, "scatter"), times=times,
        seed=count_of(seed, "seed"),
    )  # fmt: skip
    return PlannedCampaign(campaign.plan_campaign(opened(law).file, reach, asked, progress))


@called_from_python()
@one_thread()
def plan(
    system: PathOrName, *, limits: str | None = None, bands: float = 95.0, at: str | None = None,
    force_noise: float | None = None, progress: Progress = silent,
) -> LoopTests:  # fmt: skip
    """Find the loop tests that narrow the band of a pipe's peak most, one after another.

    Args:
        system: description of the coupled system, SYSTEM.toml.
        limits: what the rig can do, such as "A=0.1..2,f=0.5..20,T=20..300,v=..300".
        bands: per cent that the band holds.
        at: clamp or probe; that of the widest band beside its peak unless told.
        force_noise: rms noise of the force, N; that of the law's own tests unless told.
        progress: is told what is being done.

    Raises:
        UserError: the system can't be read or solved, or no law tells how sure it is.

    >>> plan("system.toml", limits="A=0.1..1,f=1..10,T=20..200")  # doctest: +SKIP
    <loop tests for cantilever: 2>
    """
    reach = limits_of(limits)
    path = Path(path_of(system, "the description of a system"))
    noise = number_or_none(force_noise, "force_noise")
    point = None if at is None else text_of(at, "at", "clamp1")
    return LoopTests(
        plan_tests(path, reach, per_cent=number_of(bands, "bands"), at=point, noise_N=noise, progress=progress)
    )
