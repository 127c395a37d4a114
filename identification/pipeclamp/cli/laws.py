"""The command line's part for laws and their tests: fit, compare, diagnose, change."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pipeclamp.cli.terminal import (
    BandsOption,
    CampaignFolder,
    DeclaredOption,
    EffectsOption,
    JobsOption,
    JsonOption,
    LawArgument,
    LimitsOption,
    ReportOption,
    StrictOption,
    command_called,
    file_option,
    folder_option,
    names_in,
    opened_law,
    print_next,
    print_table,
    put,
    read_and_tell,
    show,
    showing_progress,
    spare,
    values_in,
    warn,
)
from pipeclamp.now import now
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.base.progress import Progress

if TYPE_CHECKING:
    from pipeclamp_identification.workflow.change import LawChange
    from pipeclamp_identification.workflow.tests import Tests
    from pipeclamp_models.law.file import LawFile, NamedKind, Provenance

    LawChanger = Callable[[LawFile, Tests, Provenance, Progress], Sequence[LawChange]]

app = typer.Typer()


class BaseLaw(StrEnum):
    """Base laws that can be identified."""

    power = "power"
    memory = "memory"
    series = "series"


class Meant(StrEnum):
    """How a diagnosis means an effect that it names."""

    cause = "cause"
    part = "part"


class FitMethod(StrEnum):
    """Ways to identify a law."""

    joint = "joint"
    surfaces = "surfaces"


ReproducibleOption = Annotated[bool, typer.Option("--reproducible", metavar="", help="Leave out the date.")]


@app.command(epilog="Example: pipeclamp metrics my_campaign --report metrics.html")
def metrics(
    campaign: CampaignFolder,
    output: Annotated[Path | None, folder_option("METRICS", "Write the metrics as a campaign without records.")] = None,
    json: JsonOption = None,
    report: ReportOption = None,
    strict: StrictOption = False,
) -> None:
    """Loop metrics dW, W, eta and stiffness per run, against f, A, density and T."""
    from pipeclamp.show.views import metrics_view
    from pipeclamp_identification.metrics_only.writing import write_metrics
    from pipeclamp_identification.workflow.next_command import after_import

    spare(campaign, outputs=(json, report))
    with showing_progress("metrics") as tell:
        tests = read_and_tell(campaign, strict, tell)
        view = metrics_view(tests)
    following = after_import(str(campaign))
    if output:
        for entry in write_metrics(output, tests.metrics()):
            warn(f"{output}: {entry}")
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.sections import metrics_page

        write_report(
            report, f"Loop metrics of {tests.name}", tests.notes, metrics_page(tests, following), command_called()
        )
    show(view, json)
    if not (view.whole or json or report):
        put("Every run is in --json and --report.")
    print_next(following)


@app.command(epilog="Example: pipeclamp identify my_campaign -o law.json --effects memory,damping_temperature")
def identify(
    campaign: CampaignFolder,
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="LAW.json", help="The parameter file to write; with --per a new folder of them."
        ),
    ],
    effects: EffectsOption = "",
    per: Annotated[
        str, typer.Option(metavar="COLUMN", help="A law for each group of a text column: specimen, valve, ...")
    ] = "",
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
    from pipeclamp_identification.workflow.next_command import after_identification
    from pipeclamp_models.base.files import refuse_file, refuse_folder
    from pipeclamp_models.law.declaration_files import read_effects
    from pipeclamp_models.law.file import Provenance, law_text
    from pipeclamp_models.law.law import Structure

    if per:
        refuse_folder(output)
        if report:
            raise UsageError("identify: got --report with --per; expected one of them: `pipeclamp compare` shows a law")
    else:
        refuse_file(output)
    spare(campaign, *(declared or ()), outputs=(output, report))
    with showing_progress("identify") as tell:
        ids, declarations = read_effects(names_in(effects), declared or ())
        held = tuple(sorted(values_in(freeze, "--freeze").items()))
        structure = Structure(base.value, tuple(ids), held).with_declared(declarations)
        tests = read_and_tell(campaign, strict, tell)
        provenance = Provenance(command_called(), None if reproducible else now())
        called = name or tests.name
        if per:
            from pipeclamp_identification.workflow.per_group import identify_per

            laws = identify_per(tests, per, structure, method=method.value, progress=tell)
            files = {law.stem: law.found.file(name=f"{called} {law.group}", provenance=provenance) for law in laws}
            _write_group_laws(files, per, output, campaign)
            return
        found = tests.identify(structure, method=method.value, progress=tell)
        file = found.file(name=called, provenance=provenance)
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.sections import law_page
        from pipeclamp_identification.workflow.after_comparison import after_comparison

        about = f"identified from {tests.name}"
        # the page holds the comparison already
        following = after_comparison(str(output), str(campaign), found.held)
        write_report(report, f"Law {file.name}", about, law_page(file, found.held, following), command_called())
    write_whole(output, law_text(file))
    _print_law(file, output)
    print_next(after_identification(str(output), str(campaign)))


def _write_group_laws(files: Mapping[str, LawFile], column: str, folder: Path, campaign: Path) -> None:
    """Write a law of each group of a column into a new folder, by names without ending, and tell them."""
    from pipeclamp.show.law import per_group_table
    from pipeclamp_identification.workflow.next_command import after_group_laws
    from pipeclamp_models.base.files import write_folder
    from pipeclamp_models.law.file import law_text

    write_folder(folder, ((f"{stem}.json", law_text(file).encode()) for stem, file in files.items()))
    print_table(per_group_table(column, files))
    put(str(folder))
    print_next(after_group_laws([str(folder / f"{stem}.json") for stem in files], str(campaign)))


@app.command(epilog="Example: pipeclamp compare law.json my_campaign --report compare.html")
def compare(
    laws: Annotated[
        list[str],
        typer.Argument(
            metavar="LAW...|SYSTEM.toml",
            help="Law file or name of a bundled law; several are held against the same tests; or a coupled system.",
        ),
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
    bands: BandsOption = None,
    strict: StrictOption = False,
) -> None:
    """Hold laws, or a pipe with its clamps, against measurements: how much each errs, and where."""
    from pipeclamp_models.law.declaration_files import refuse_declaration

    for law in laws:
        refuse_declaration(Path(law))
    spare(*laws, campaign, outputs=(json, report))
    if any(law.endswith(".toml") for law in laws):
        from pipeclamp.cli.on_pipe import compare_on_pipe

        if len(laws) > 1:
            raise UsageError(f"compare: got {len(laws)} systems or laws with a .toml; expected one SYSTEM.toml")
        compare_on_pipe(Path(laws[0]), campaign, json, report, bands)
        return
    if bands is not None:
        raise UsageError("--bands: a law held against its own tests has none; expected SYSTEM.toml and MEASURED")
    from pipeclamp.show.views import comparison_view, laws_view
    from pipeclamp_identification.comparison.laws import least_error
    from pipeclamp_identification.comparison.names import named_apart
    from pipeclamp_identification.workflow.after_comparison import after_comparison

    with showing_progress("compare") as tell:
        files = named_apart([opened_law(law) for law in laws], laws)
        tests = read_and_tell(campaign, strict, tell, free=True)
        held = [(file, tests.compare(file)) for file in files]
        view = comparison_view(held[0][1]) if len(held) == 1 else laws_view(held)
    best = least_error([against for _, against in held])
    following = after_comparison(laws[best], str(campaign), held[best][1])
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.sections import comparison_page, comparison_title

        write_report(report, *comparison_title(files, tests.name), comparison_page(held, following), command_called())
    show(view, json)
    print_next(following)


@app.command(epilog="Example: pipeclamp diagnose law.json my_campaign --report diagnosis.html")
def diagnose(
    law: LawArgument,
    campaign: CampaignFolder,
    json: JsonOption = None,
    report: ReportOption = None,
    auto: Annotated[Path | None, file_option("LAW2.json", "Add what is missing, again and again.", "--auto")] = None,
    limits: LimitsOption = "",
    drive: Annotated[
        Path | None, file_option("DRIVE.csv", "Write the next test's drive signal, .csv or .parquet.", "--drive")
    ] = None,
    declared: DeclaredOption = None,
    jobs: JobsOption = -1,
    strict: StrictOption = False,
) -> None:
    """Which physical effect does the law lack? Or which test would tell?"""
    from pipeclamp.cli.ladder import climbed
    from pipeclamp.show.diagnosis_views import diagnosis_view
    from pipeclamp_identification.campaign.drive import refuse_drive_name, write_drive
    from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
    from pipeclamp_identification.workflow.next_command import next_command
    from pipeclamp_models.law.declaration import merged
    from pipeclamp_models.law.declaration_files import read_declaration
    from pipeclamp_models.law.file import law_text

    spare(campaign, *(declared or ()), outputs=(json, report, drive, auto))
    spare(law, outputs=(json, report, drive))
    if drive:
        refuse_drive_name(drive)
    with showing_progress("diagnose") as tell:
        file = opened_law(law)
        own = {path: read_declaration(path) for path in declared or ()}
        declarations = merged((), own.values())
        tests = read_and_tell(campaign, strict, tell)
        reach, workers = parse_limits(limits) if limits else None, Workers(jobs, tell)
        if auto:
            settled = climbed(
                file, tests, campaign, auto, command=command_called(), declared=declarations, limits=reach,
                workers=workers,
            )  # fmt: skip
            file, found = settled.with_diagnosis(tests.name), settled.found
            ladder, rungs = settled.ladder, settled.words()
        else:
            found = tests.diagnose(file, declared=declarations, limits=reach, workers=workers)
            ladder, rungs = (), []
    paths = {declaration.id: str(path) for path, declaration in own.items()}
    following = next_command(found, str(auto or law), str(campaign), paths, driven=drive is not None)
    view = diagnosis_view(found, ladder, following, drive)
    if report:
        from pipeclamp.pages.page import write_report
        from pipeclamp.pages.sections import diagnosis_page, diagnosis_title

        sections = diagnosis_page(file, found, following, ladder)
        write_report(report, *diagnosis_title(file, tests.name), sections, command_called())
    if drive and found.proposal:
        write_drive(found.proposal.plan.signal(), drive)
    if auto:
        write_whole(auto, law_text(file))
    for line in rungs:
        put(line)
    show(view, json)


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
    from pipeclamp_identification.workflow.change import remove_effect

    def change(file: LawFile, tests: Tests, made: Provenance, tell: Progress) -> Sequence[LawChange]:
        return [remove_effect(file, effect, tests, provenance=made, progress=tell)]

    _change(change, "remove", law, campaign, output, strict, reproducible)


@app.command(epilog="Example: pipeclamp add law.json memory my_campaign -o law2.json")
def add(
    law: LawArgument,
    effect: Annotated[
        str,
        typer.Argument(
            metavar="EFFECT[,EFFECT]", help="The effect, see `pipeclamp effects`, or F.toml; or several, as --effects."
        ),
    ],
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("LAW2.json", "The parameter file to write.")],
    meant: Annotated[
        Meant | None, typer.Option("--as", help="How a diagnosis meant it: beside a part nothing is called the cause.")
    ] = None,
    declared: DeclaredOption = None,
    strict: StrictOption = False,
    reproducible: ReproducibleOption = False,
) -> None:
    """Add an effect to a law, refit everything, and say what the error did."""
    from pipeclamp_identification.workflow.change import add_effects
    from pipeclamp_models.law.declaration_files import read_effects

    names, declarations = read_effects(names_in(effect), declared or ())
    if not names:
        raise UsageError(f"EFFECT: got {effect!r}; expected the name of an effect, such as memory")
    kind: NamedKind | None = None if meant is None else meant.value

    def change(file: LawFile, tests: Tests, made: Provenance, tell: Progress) -> Sequence[LawChange]:
        return add_effects(file, names, tests, provenance=made, declared=declarations, kind=kind, progress=tell)

    _change(change, "add", law, campaign, output, strict, reproducible)


@app.command(epilog="Example: pipeclamp refit law2.json all_tests -o law3.json")
def refit(
    law: LawArgument,
    campaign: CampaignFolder,
    output: Annotated[Path, file_option("LAW2.json", "The parameter file to write.")],
    strict: StrictOption = False,
    reproducible: ReproducibleOption = False,
) -> None:
    """Fit a law with its effects to tests anew, as where others have joined, and say what the error did."""
    from pipeclamp_identification.workflow.change import refit as refitted

    def change(file: LawFile, tests: Tests, made: Provenance, tell: Progress) -> Sequence[LawChange]:
        return [refitted(file, tests, provenance=made, progress=tell)]

    _change(change, "refit", law, campaign, output, strict, reproducible)


def _change(
    changer: LawChanger,
    title: str,
    law: str,
    campaign: Path,
    output: Path,
    strict: bool,
    reproducible: bool,
) -> None:
    """Change a law step by step, refit it, write it, and print what that did."""
    from pipeclamp.show.law import change_table, not_fitted, vain_words
    from pipeclamp_identification.workflow.next_command import after_change, after_vain_addition
    from pipeclamp_models.law.file import Provenance, law_text

    spare(campaign, outputs=(output,))
    with showing_progress(title) as tell:
        file = opened_law(law)
        tests = read_and_tell(campaign, strict, tell)
        made = Provenance(command_called(), None if reproducible else now())
        steps = changer(file, tests, made, tell)
    changed = steps[-1].after
    write_whole(output, law_text(changed))
    for step in steps:
        print_table(change_table(step))
        for words in not_fitted(step):
            put(words)
    _print_fit(changed, output)
    if title == "add" and (words := vain_words(changed.history, len(steps))):
        put(words)
        added = [name for name in changed.effects if name not in file.effects]
        print_next(after_vain_addition(law, str(output), added, str(campaign)))
        return
    print_next(after_change(str(output), str(campaign)))


def _print_law(file: LawFile, output: Path) -> None:
    from pipeclamp.show.law import coefficient_table

    print_table(coefficient_table(file))
    _print_fit(file, output)


def _print_fit(file: LawFile, output: Path) -> None:
    from pipeclamp.show.law import doubts, fit_words

    for line in doubts(file):
        put(line)
    if file.fit:
        put(fit_words(file.fit))
    put(str(output))
