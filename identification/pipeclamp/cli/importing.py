"""The command line's part for importing; nothing is computed here."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeclamp.cli.campaigns import RecordFormat
from pipeclamp.cli.terminal import JsonOption, ReportOption, note, print_table, put, show, showing_progress, spare, warn
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import refuse_folder

if TYPE_CHECKING:
    from pipeclamp_identification.importing.answer import ImportedCampaign
    from pipeclamp_identification.importing.channels.columns import Mapped, Stated
    from pipeclamp_identification.importing.unusable import UnusableFiles

app = typer.Typer()


def _campaign_to_write(path: Path) -> Path:
    """Refuse a folder that is neither new nor a campaign, before the work."""
    if not (path / "campaign.toml").is_file():
        refuse_folder(path)
    return path


@app.command("import", epilog='Example: pipeclamp import exports -o clamp_7 --pattern "T{temperature_C}"')
def import_command(
    files: Annotated[list[Path], typer.Argument(metavar="FILES...", help="Test machines' files, or folders of them.")],
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="CAMPAIGN",
            help="A new folder, or one that was imported before.",
            callback=_campaign_to_write,
        ),
    ],
    columns: Annotated[
        str,
        typer.Option(
            metavar="OURS=CHANNEL,...",
            help="Which channel is what, where names and units don't tell: 'time=Zeit [ms],force=-Last [kN]'; a minus "
            "turns a sign, [unit] states one, segment=... parts runs (segment=each-cycle: cycle by cycle), "
            "current_A=... is a further condition.",
        ),
    ] = "",
    pattern: Annotated[
        str,
        typer.Option(
            metavar="A{amplitude_mm}_T{temperature_C}", help="What the files' names state; units by the fields' names."
        ),
    ] = "",
    conditions: Annotated[
        Path | None,
        typer.Option(metavar="TABLE.csv", help="What was set: a row a file, its name in column file."),
    ] = None,
    rate: Annotated[
        str | None,
        typer.Option(
            metavar="Hz", help="Samples per second, where no channel is time; 'none' where time was not measured."
        ),
    ] = None,
    name: Annotated[str, typer.Option(help="Name of the campaign; its folder's by default.")] = "",
    notes: Annotated[str, typer.Option(help="Notes on the campaign.")] = "",
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.parquet,
    dry_run: Annotated[bool, typer.Option("--dry-run", metavar="", help="Show it, and write nothing.")] = False,
    skip_unusable: Annotated[
        bool,
        typer.Option("--skip-unusable", metavar="", help="Leave out damaged files, and those without a test."),
    ] = False,
    yes: Annotated[bool, typer.Option("--yes", metavar="", help="Don't ask whether the columns are right.")] = False,
    json: JsonOption = None,
    report: ReportOption = None,
) -> None:
    """Test machines' files to a campaign: channels and units found, runs cut out and checked; later files join it."""
    from pipeclamp.pages.imported import import_page
    from pipeclamp.show.imported import import_view
    from pipeclamp_identification.fitting.identify import software
    from pipeclamp_identification.importing.request import ImportRequest
    from pipeclamp_identification.importing.stated import stated_options
    from pipeclamp_identification.importing.whole import import_campaign
    from pipeclamp_models.base.files import write_whole

    spare(*files, outputs=(json, report))
    called = sys.argv[1:]
    page = partial(import_page, called=called)
    asked = _at_a_terminal()
    leave_out = _may_be_left_out if asked and not skip_unusable else lambda unusable: skip_unusable
    options = stated_options(columns, pattern, conditions, rate, leave_out=leave_out, ask=_ask if asked else None)
    with showing_progress("import") as tell:
        request = ImportRequest(
            files, output, options, page=page, confirm=_confirmed if asked and not yes else None,
            dry_run=dry_run, name=name, notes=notes, software=software(), format=format.value, tell=tell,
        )  # fmt: skip
        found = import_campaign(request)
    for entry in found.left_out:
        warn(str(entry))
    for words in found.notes():
        note(words)
    if report:
        write_whole(report, page(found))
    show(import_view(found, called), json)


def _at_a_terminal() -> bool:
    """Tell whether somebody can be asked."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _ask(where: str, mapped: Mapped) -> Sequence[Stated]:
    """Ask at the terminal what names and units leave open."""
    from pipeclamp_identification.importing.channels.columns import parse_columns

    stated: list[Stated] = []
    for question in mapped.questions:
        put(f"{where}: {question.why}")
        for number, choice in enumerate(question.choices, 1):
            put(f"  {number}  {choice.text}")
        answer = typer.prompt("Which one? A number, or OURS=CHANNEL [unit]")
        if answer.isdigit() and 0 < int(answer) <= len(question.choices):
            answer = question.choices[int(answer) - 1].text
        stated += parse_columns(answer)
    return stated


def _may_be_left_out(unusable: UnusableFiles) -> bool:
    """Show which files can't be used, and ask whether the others are to be imported."""
    put("\n  ".join([f"{unusable.heading()}:", *unusable.lines()]))
    try:
        return typer.confirm(f"Leave them out, and import the other {unusable.others}?", default=False)
    except typer.Abort:
        return False


def _confirmed(found: ImportedCampaign) -> bool:
    """Show which channel is what, and ask whether that is right."""
    from pipeclamp.show.imported import columns_table

    print_table(columns_table(found.files))
    try:
        return typer.confirm("Are these channels and units right?", default=True)
    except typer.Abort as stop:
        raise UserError("nothing was written: the import wasn't confirmed") from stop
