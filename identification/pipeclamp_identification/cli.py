"""The command line: reads, calls, writes and prints; nothing is computed here.

What a command needs is imported inside it, so that `--help` and light commands start fast.
"""

from __future__ import annotations

import datetime
import sys
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pipeclamp.errors import InterruptError, UsageError, UserError
from pipeclamp.files import write_whole
from pipeclamp_identification import cli_campaigns, cli_simulation
from pipeclamp_identification.terminal import (
    DeclaredOption,
    EffectsOption,
    JobsOption,
    JsonOption,
    LawArgument,
    ReportOption,
    StrictOption,
    command_called,
    console,
    errors,
    file_option,
    folder_option,
    names_in,
    opened_law,
    print_table,
    show,
    told,
    values_in,
    write,
)

if TYPE_CHECKING:
    from pipeclamp_identification.add import Addition
    from pipeclamp_identification.campaign import Campaign
    from pipeclamp_identification.fit import Progress as Tell
    from pipeclamp_identification.metric_campaign import MetricCampaign

app = typer.Typer(
    name="pipeclamp",
    help="Identify the law of a pipe clamp from loop tests, see where it fails, and carry it into system simulation.",
    epilog="Example: pipeclamp identify my_campaign -o law.json && pipeclamp compare law.json my_campaign",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    add_completion=False,
)
app.add_typer(cli_campaigns.app)
app.add_typer(cli_simulation.app)


class BaseLaw(StrEnum):
    """Base laws that can be identified."""

    power = "power"
    memory = "memory"
    series = "series"


class FitMethod(StrEnum):
    """Ways to identify a law."""

    joint = "joint"
    surfaces = "surfaces"


CampaignFolder = Annotated[
    Path, typer.Argument(metavar="CAMPAIGN", help="Folder with campaign.toml and runs.csv, or a bundled campaign.")
]
ReproducibleOption = Annotated[bool, typer.Option("--reproducible", metavar="", help="Leave out the date.")]


def _tell_version(wanted: bool) -> None:
    if wanted:
        from pipeclamp_identification.identify import software

        console.print(software(), highlight=False)
        raise typer.Exit


TYPER_INTERRUPTED = 130
"""Exit status that Typer makes of Ctrl-C."""


def main() -> None:
    """Run the command line; a user's mistake is one message on stderr and status 1 or (usage) 2.

    Raises:
        KeyboardInterrupt: the user stopped it; how to go on, where it isn't the same command from its start.
    """
    try:
        app(prog_name="pipeclamp")
    except SystemExit as end:
        if end.code == TYPER_INTERRUPTED:
            raise KeyboardInterrupt from end
        raise
    except InterruptError as error:
        raise KeyboardInterrupt(str(error)) from error
    except (UserError, OSError) as error:
        errors.print(f"pipeclamp: {error}", style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(2 if isinstance(error, UsageError) else 1)


@app.callback()
def program(
    version: Annotated[
        bool,
        typer.Option("--version", metavar="", is_eager=True, callback=_tell_version, help="Show the version and exit."),
    ] = False,
) -> None:
    """Take what stands before a command; the help is the program's own."""


@app.command(epilog="Example: pipeclamp metrics my_campaign --report metrics.html")
def metrics(
    campaign: CampaignFolder,
    output: Annotated[Path | None, folder_option("METRICS", "Write the metrics as a campaign without records.")] = None,
    json: JsonOption = None,
    report: ReportOption = None,
    strict: StrictOption = False,
) -> None:
    """Loop metrics dW, W, eta and stiffness per run, against f, A, density and T."""
    from pipeclamp.files import write_folder
    from pipeclamp_identification.findings import metrics_found
    from pipeclamp_identification.metric_writing import metric_files

    with told("metrics") as tell:
        tests = _read(campaign, strict, tell)
        found, bare = metrics_found(tests)
    if output:
        write_folder(output, metric_files(bare))
    show(found, json, report, f"Loop metrics of {tests.name}", tests.notes)


@app.command(epilog="Example: pipeclamp identify my_campaign -o law.json --effects memory,damping_temperature")
def identify(
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("LAW.json", "The parameter file to write.")],
    effects: EffectsOption = "",
    base: Annotated[
        BaseLaw, typer.Option(help="Base law, of Jiang et al. 2020: Eq. 17 (power), 14 (memory), 10 (series).")
    ] = BaseLaw.power,
    method: Annotated[
        FitMethod, typer.Option(help="All at once, or the route of Jiang et al. 2020 by itself.")
    ] = FitMethod.joint,
    freeze: Annotated[str, typer.Option(metavar="name=value,...", help="Parameters that are held, not fitted.")] = "",
    declared: DeclaredOption = None,
    name: Annotated[str | None, typer.Option(help="Name of the law; the campaign's by default.")] = None,
    report: ReportOption = None,
    strict: StrictOption = False,
    reproducible: ReproducibleOption = False,
) -> None:
    """Fit a law to all runs of a campaign and write its parameter file."""
    from pipeclamp.declaration import read_effects
    from pipeclamp.parameter_file import law_text
    from pipeclamp_identification.findings import identified

    with told("identify") as tell:
        ids, declarations = read_effects(names_in(effects), declared or ())
        tests = _read(campaign, strict, tell)
        file, sections = identified(
            tests, base=base.value, effects=ids, frozen=values_in(freeze), method=method.value, declared=declarations,
            name=name or tests.name, command=command_called(), date=None if reproducible else _now(),
            with_report=report is not None, progress=tell,
        )  # fmt: skip
    write(None, report, None, f"Law {file.name}", f"identified from {tests.name}", sections)
    write_whole(output, law_text(file))
    _print_law(file, output)


@app.command(epilog="Example: pipeclamp compare law.json my_campaign --report compare.html")
def compare(
    law: Annotated[
        str,
        typer.Argument(metavar="LAW|SYSTEM.toml", help="Law file, name of a bundled law, or a coupled system."),
    ],
    campaign: Annotated[
        Path,
        typer.Argument(
            metavar="CAMPAIGN|MEASURED",
            help="For a law: folder with campaign.toml and runs.csv, or a bundled campaign. For a system: folder with "
            "measurement.toml, what was measured on the pipe.",
        ),
    ],
    json: JsonOption = None,
    report: ReportOption = None,
    strict: StrictOption = False,
) -> None:
    """Hold a law, or a pipe with its clamps, against measurements: how much it errs, and where."""
    from pipeclamp.declaration import refuse_declaration
    from pipeclamp_identification.findings import compared, compared_on_pipe
    from pipeclamp_identification.pipe_measurement import is_system

    refuse_declaration(Path(law))
    if is_system(Path(law)):
        from pipeclamp_identification.pipe_compared import compare_measured

        with told("compare") as tell:
            tell(f"hold {law} against {campaign}")
            held = compare_measured(Path(law), campaign)
            found = compared_on_pipe(held, with_report=report is not None, progress=tell)
        title = f"{held.system.name} against {held.description.name}"
        show(found, json, report, title, held.description.notes or "pipe and clamps")
        return
    with told("compare") as tell:
        file = opened_law(law)
        tests = _read(campaign, strict, tell)
        found = compared(file, tests, with_report=report is not None)
    effects = ", ".join(file.effects) or "none"
    show(found, json, report, f"Law {file.name} against {tests.name}", f"base {file.base}, effects: {effects}")


@app.command(epilog="Example: pipeclamp diagnose law.json my_campaign --report diagnosis.html")
def diagnose(
    law: LawArgument,
    campaign: CampaignFolder,
    json: JsonOption = None,
    report: ReportOption = None,
    auto: Annotated[Path | None, file_option("LAW2.json", "Add what is missing, again and again.", "--auto")] = None,
    limits: Annotated[
        str, typer.Option(metavar="A=0.1..2,f=0.5..20,T=20..300", help="What the rig can do, for the next test.")
    ] = "",
    declared: DeclaredOption = None,
    jobs: JobsOption = -1,
    strict: StrictOption = False,
) -> None:
    """Which physical effect does the law lack? Or which test would tell?"""
    from pipeclamp.declaration import read_effects
    from pipeclamp.parameter_file import law_text
    from pipeclamp_identification.auto import add_until_settled, answer_to
    from pipeclamp_identification.findings import diagnosed
    from pipeclamp_identification.next_test import parse_limits

    with told("diagnose") as tell:
        file = opened_law(law)
        _, declarations = read_effects((), declared or ())
        tests = _read(campaign, strict, tell)
        reach = parse_limits(limits) if limits else None
        if auto:
            settled = add_until_settled(
                file, tests, command=command_called(), declared=declarations, limits=reach, jobs=jobs, progress=tell
            )
            file, answer = settled.file, settled.answer
        else:
            settled = None
            answer = answer_to(file, tests, declared=declarations, limits=reach, jobs=jobs, progress=tell)
        found = diagnosed(answer, with_report=report is not None, additions=settled.additions if settled else ())
    if auto and settled:
        write_whole(auto, law_text(file))
        for line in settled.words():
            console.print(line, highlight=False)
    show(found, json, report, f"Diagnosis of {file.name}", tests.name)


@app.command(epilog="Example: pipeclamp remove law2.json memory my_campaign -o law.json")
def remove(
    law: LawArgument,
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="The effect to take out.")],
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("LAW2.json", "The parameter file to write.")],
    strict: StrictOption = False,
    reproducible: ReproducibleOption = False,
) -> None:
    """Take an effect out of a law, refit the rest, and say what the error did."""
    from pipeclamp_identification.add import remove_effect

    _change(partial(remove_effect, effect=effect), "remove", law, campaign, output, strict, reproducible)


@app.command(epilog="Example: pipeclamp add law.json memory my_campaign -o law2.json")
def add(
    law: LawArgument,
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="The effect, see `pipeclamp effects`, or F.toml.")],
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("LAW2.json", "The parameter file to write.")],
    declared: DeclaredOption = None,
    strict: StrictOption = False,
    reproducible: ReproducibleOption = False,
) -> None:
    """Add an effect to a law, refit everything, and say what the error did."""
    from pipeclamp.declaration import read_effects
    from pipeclamp_identification.add import add_effect

    (name,), declarations = read_effects((effect,), declared or ())
    change = partial(add_effect, effect=name, declared=declarations)
    _change(change, "add", law, campaign, output, strict, reproducible)


@app.command(epilog="Example: pipeclamp effects")
def effects(declared: DeclaredOption = None) -> None:
    """The catalogue: every effect, what it looks like when it is missing, and what imitates it."""
    from pipeclamp.catalogue import entries, find_effect
    from pipeclamp.declaration import effect_of, read_effects
    from pipeclamp_identification.report import Table

    needs_argument = {name for name, entry in entries().items() if getattr(entry, "default", "") is None}
    catalogue = [find_effect(f"{name}:column" if name in needs_argument else name) for name in entries()]
    catalogue += [effect_of(declaration) for declaration in read_effects((), declared or ())[1]]
    rows = [
        (effect.name, effect.part, effect.looks_like, ", ".join(effect.imitated_by), effect.told_apart_by)
        for effect in catalogue
    ]
    print_table(Table(("id", "part", "looks like, when missing", "imitated by", "told apart by"), rows))


@app.command(epilog="Example: pipeclamp demo my_demo")
def demo(
    folder: Annotated[Path, typer.Argument(metavar="[FOLDER]", help="Where the results go.")] = Path("pipeclamp_demo"),
) -> None:
    """The whole story on bundled data, in about a minute."""
    from pipeclamp_identification.demo import run_demo

    for path in run_demo(folder, lambda line: console.print(line, highlight=False)):
        console.print(f"  open {path}", highlight=False)


@app.command(epilog="Example: pipeclamp schema > law.schema.json")
def schema() -> None:
    """The JSON schema of parameter files."""
    from pipeclamp.parameter_file import schema_text

    sys.stdout.write(schema_text())


def _read(folder: Path, strict: bool, tell: Tell) -> Campaign | MetricCampaign:
    from pipeclamp_identification.bundled_campaigns import campaign_folder
    from pipeclamp_identification.campaign import Campaign
    from pipeclamp_identification.metric_campaign import read_tests

    tell(f"read {folder}")
    tests = read_tests(campaign_folder(folder), strict=strict)
    for entry in tests.left_out:
        errors.print(f"warning: {entry}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    if isinstance(tests, Campaign):
        for words in filter(None, (*tests.remarks, tests.smoothing.words())):
            errors.print(f"note: {words}", markup=False, highlight=False, soft_wrap=True)
    return tests


def _change(
    change: Callable[..., Addition],
    title: str,
    law: str,
    campaign: Path,
    output: Path,
    strict: bool,
    reproducible: bool,
) -> None:
    """Change a law by an effect, refit it, write it, and print what that did."""
    from pipeclamp.parameter_file import law_text
    from pipeclamp_identification.add import addition_table

    with told(title) as tell:
        file = opened_law(law)
        tests = _read(campaign, strict, tell)
        date = None if reproducible else _now()
        changed = change(file, campaign=tests, command=command_called(), date=date, progress=tell)
    write_whole(output, law_text(changed.after))
    print_table(addition_table(changed))
    _print_law(changed.after, output)


def _print_law(file: Any, output: Path) -> None:
    from pipeclamp_identification.identify_report import coefficient_table, doubts, fit_words

    print_table(coefficient_table(file))
    for line in doubts(file):
        console.print(line, highlight=False, markup=False)
    if file.fit:
        console.print(fit_words(file.fit), highlight=False)
    console.print(str(output), highlight=False)


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
