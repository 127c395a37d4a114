"""Which tests to run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp.api.shown import PathOrName, Shown, path_of
from pipeclamp.show.campaign_plan import campaign_plan_view
from pipeclamp.show.narrowing import band_plan_view
from pipeclamp.show.view import View
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.planning import campaign
from pipeclamp_identification.planning.band_plan import BandPlan
from pipeclamp_identification.planning.campaign import CampaignPlan
from pipeclamp_identification.planning.campaign_answer import plan_files
from pipeclamp_identification.planning.loop_tests import RIG
from pipeclamp_identification.planning.narrowing import plan_tests
from pipeclamp_identification.planning.rig_times import HOURS, SCATTER_BEFOREHAND
from pipeclamp_models.base.files import write_folder
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.law.bundled import open_law

if TYPE_CHECKING:
    from pipeclamp.pages.page import Report


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

    def save(self, folder: PathOrName) -> Path:
        """Write the order of the runs, drive signals, and a campaign that waits for its records, as a new folder.

        Raises:
            UserError: the folder exists, or its parent can't be written.
        """
        target = Path(folder)
        write_folder(target, plan_files(self.found, target.name, "pipeclamp.plan_campaign"))
        return target

    def __repr__(self) -> str:
        """Give how many runs there are, and how long they take."""
        return f"<campaign of {len(self.found.runs)} runs in {self.found.hours:.3g} h>"


@one_thread()
def plan_campaign(
    *, limits: str | None = None, hours: float = HOURS, law: PathOrName = "emwm2",
    force_noise: float = RIG.force_noise, scatter: float = SCATTER_BEFOREHAND,
) -> PlannedCampaign:  # fmt: skip
    """Plan the campaign that names the most and the smallest effects within its hours.

    Args:
        limits: what the rig can do, such as "A=0.1..2,f=0.5..20,T=20..300,v=..300"; around the law's data unless told.
        hours: rig hours that it may take, heating included.
        law: file or name of a law like that which the clamp may have.
        force_noise: rms noise of the force, N.
        scatter: rms share by which stiffness and damping differ from run to run.

    Raises:
        UserError: there is no such law, nothing can be driven within the limits, or nothing fits into the hours.

    >>> plan_campaign(hours=0.15, limits="A=0.2..1,f=1..6,T=20..20")
    <campaign of 11 runs in 0.107 h>
    """
    reach = parse_limits(limits) if limits else None
    asked = campaign.PlanRequest(hours, force_noise, scatter)
    return PlannedCampaign(campaign.plan_campaign(open_law(path_of(law, "a law")), reach, asked))


@one_thread()
def plan(
    system: PathOrName, *, limits: str | None = None, bands: float = 95.0, at: str | None = None,
    force_noise: float | None = None,
) -> LoopTests:  # fmt: skip
    """Find the loop tests that narrow the band of a pipe's peak most, one after another.

    Args:
        system: description of the coupled system, SYSTEM.toml.
        limits: what the rig can do, such as "A=0.1..2,f=0.5..20,T=20..300,v=..300".
        bands: per cent that the band holds.
        at: clamp or probe; that of the widest band beside its peak unless told.
        force_noise: rms noise of the force, N; that of the law's own tests unless told.

    Raises:
        UserError: the system can't be read or solved, or no law tells how sure it is.

    >>> plan("system.toml", limits="A=0.1..1,f=1..10,T=20..200")  # doctest: +SKIP
    <loop tests for cantilever: 2>
    """
    reach = parse_limits(limits) if limits else None
    path = Path(path_of(system, "the description of a system"))
    return LoopTests(plan_tests(path, reach, per_cent=bands, at=at, noise_N=force_noise))
