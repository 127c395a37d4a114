"""The command line's part for planning tests; nothing is computed here."""

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
    show,
    spare,
    told,
)

app = typer.Typer()


@app.command(epilog="Example: pipeclamp plan system.toml --limits A=0.1..2,f=0.5..20,T=20..300 --drive next.csv")
def plan(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    limits: LimitsOption = "",
    bands: Annotated[float, typer.Option(metavar="PER_CENT", help="That the band holds.")] = 95.0,
    at: Annotated[
        str | None, typer.Option(metavar="POINT", help="Clamp or probe; that of the widest band by default.")
    ] = None,
    force_noise: Annotated[
        float | None, typer.Option(min=0, help="Rms noise of the force, N; as in the law's tests by default.")
    ] = None,
    drive: Annotated[
        Path | None, file_option("DRIVE.csv", "Write the first test's drive signal, .csv or .parquet.", "--drive")
    ] = None,
    json: JsonOption = None,
    report: ReportOption = None,
) -> None:
    """Which loop test narrows the band of the pipe's peak most."""
    from pipeclamp.show.narrowing import band_plan_view
    from pipeclamp_identification.campaign.drive import drive_content, refuse_drive_name
    from pipeclamp_identification.diagnosis.limits import parse_limits
    from pipeclamp_identification.planning.narrowing import plan_tests
    from pipeclamp_models.base.files import write_whole

    spare(system, outputs=(drive, json, report))
    if drive:
        refuse_drive_name(drive)
    with told("plan") as tell:
        reach = parse_limits(limits) if limits else None
        found = plan_tests(system, reach, per_cent=bands, at=at, noise_N=force_noise, progress=tell)
    if report:
        from pipeclamp.pages.narrowing import band_plan_page
        from pipeclamp.pages.page import write_report

        write_report(report, *band_plan_page(found), command_called())
    if drive and found.tests:
        write_whole(drive, drive_content(found.tests[0].plan.signal(), drive))
    show(band_plan_view(found, drive), json)
