"""The command line's part for planning tests."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pipeclamp.cli.terminal import (
    JsonOption,
    LimitsOption,
    ReportOption,
    command_called,
    file_option,
    folder_option,
    is_stated,
    line_called,
    opened_law,
    say,
    show,
    showing_progress,
    spare,
)
from pipeclamp_identification.planning.rig_times import HOURS, RIG_TIMES, SCATTER_BEFOREHAND, RigTimes
from pipeclamp_models.base.errors import UsageError

app = typer.Typer()


OF_CAMPAIGNS = ("hours", "law", "scatter", "heating", "soak", "pause", "seed")
"""Options of a campaign before any test."""
OF_BANDS = ("bands", "at", "drive")
"""Options of the next loop test."""


@app.command(epilog="Example: pipeclamp plan system.toml --limits A=0.1..2,f=0.5..20,T=20..300 --drive next.csv")
def plan(
    context: typer.Context,
    system: Annotated[
        Path | None,
        typer.Argument(metavar="[SYSTEM.toml]", help="A coupled system: which loop test makes its peak surer?"),
    ] = None,
    output: Annotated[
        Path | None, folder_option("FOLDER", "Without a system: the folder of a campaign that is planned.")
    ] = None,
    limits: LimitsOption = "",
    hours: Annotated[float, typer.Option(help="Rig hours that the campaign may take.")] = HOURS,
    law: Annotated[str, typer.Option(metavar="LAW", help="A law like that which the clamp may have.")] = "emwm2",
    force_noise: Annotated[
        float | None,
        typer.Option(help="Rms noise of the force, N; that of the law's tests, for a campaign 3 N by default."),
    ] = None,
    scatter: Annotated[
        float, typer.Option(help="Rms share by which k and c differ from run to run.")
    ] = SCATTER_BEFOREHAND,
    heating: Annotated[float, typer.Option(help="Heating and cooling, K per minute.")] = RIG_TIMES.heating,
    soak: Annotated[float, typer.Option(help="Minutes at a new temperature before a run.")] = RIG_TIMES.soak_min,
    pause: Annotated[float, typer.Option(help="Seconds between two runs.")] = RIG_TIMES.pause_s,
    seed: Annotated[int, typer.Option(min=0, help="Of the random order.")] = 0,
    bands: Annotated[float, typer.Option(metavar="PER_CENT", help="That the peak's band holds.")] = 95.0,
    at: Annotated[
        str | None, typer.Option(metavar="POINT", help="Clamp or probe; that of the widest band by default.")
    ] = None,
    drive: Annotated[
        Path | None, file_option("DRIVE.csv", "Write the first test's drive signal, .csv or .parquet.", "--drive")
    ] = None,
    json: JsonOption = None,
    report: ReportOption = None,
) -> None:
    """Which tests to run: the loop test that makes a pipe's peak surer, or a whole campaign before any test."""
    if (system is None) == (output is None):
        raise UsageError(
            "plan: expected either SYSTEM.toml, for the next loop test, or -o FOLDER, for a campaign before any test"
        )
    stated = [f"--{name}" for name in (OF_BANDS if system is None else OF_CAMPAIGNS) if is_stated(context, name)]
    if stated:
        raise UsageError(
            f"plan: got {', '.join(stated)}; expected that of {'a system' if system is None else 'a campaign'} alone"
        )
    if system is not None:
        _next_test(system, limits, force_noise, bands, at, drive, json, report)
        return
    assert output is not None
    from pipeclamp.show.campaign_plan import campaign_plan_view
    from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
    from pipeclamp_identification.planning.campaign import PlanRequest, plan_campaign
    from pipeclamp_identification.planning.campaign_answer import plan_files
    from pipeclamp_identification.planning.loop_tests import RIG
    from pipeclamp_identification.workflow.next_command import after_campaign_plan
    from pipeclamp_models.base.files import write_folder

    spare(law, outputs=(json, report))
    noise = RIG.force_noise if force_noise is None else force_noise
    with showing_progress("plan") as tell:
        reach = parse_limits(limits) if limits else None
        asked = PlanRequest(hours, noise, scatter, times=RigTimes(heating, soak, pause), seed=seed)
        found = plan_campaign(opened_law(law), reach, asked, tell)
    write_folder(output, plan_files(found, output.name, command_called()))
    following = after_campaign_plan(str(output))
    if report:
        from pipeclamp.pages.campaign_plan import campaign_plan_page
        from pipeclamp.pages.page import write_report

        write_report(report, *campaign_plan_page(found, following), command_called())
    show(campaign_plan_view(found, output, law), json)
    say([following.words()])


def _next_test(
    system: Path, limits: str, force_noise: float | None, bands: float, at: str | None, drive: Path | None,
    json: Path | None, report: Path | None,
) -> None:  # fmt: skip
    """Say which loop test narrows the band of a pipe's peak most."""
    from pipeclamp.show.narrowing import band_plan_view
    from pipeclamp_identification.campaign.drive import refuse_drive_name, write_drive
    from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
    from pipeclamp_identification.planning.narrowing import plan_tests
    from pipeclamp_identification.workflow.systems.next_in_system import after_band_plan

    spare(system, outputs=(drive, json, report))
    if drive:
        refuse_drive_name(drive)
    with showing_progress("plan") as tell:
        reach = parse_limits(limits) if limits else None
        found = plan_tests(system, reach, per_cent=bands, at=at, noise_N=force_noise, progress=tell)
    following = after_band_plan(system, line_called(), proposed=bool(found.tests), driven=drive is not None)
    if report:
        from pipeclamp.pages.narrowing import band_plan_page
        from pipeclamp.pages.page import write_report

        write_report(report, *band_plan_page(found, following), command_called())
    if drive and found.tests:
        write_drive(found.tests[0].plan.signal(), drive)
    show(band_plan_view(found, drive), json)
    say([following.words()])
