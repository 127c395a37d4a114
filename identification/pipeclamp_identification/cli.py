"""The command line: reads, calls, writes and prints; nothing is computed here.

What a command needs is imported inside it, so that `--help` and light commands start fast.
"""

from __future__ import annotations

import datetime
import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table as RichTable

from pipeclamp.errors import UserError
from pipeclamp.files import write_whole

if TYPE_CHECKING:
    from pipeclamp_fmu.native_fmu import Built
    from pipeclamp_identification.add import Addition
    from pipeclamp_identification.campaign import Campaign
    from pipeclamp_identification.findings import Findings
    from pipeclamp_identification.fit import Progress as Tell
    from pipeclamp_identification.metric_campaign import MetricCampaign
    from pipeclamp_identification.report import Section, Table

app = typer.Typer(
    name="pipeclamp",
    help="Identify the law of a pipe clamp from loop tests, see where it fails, and carry it into system simulation.",
    epilog="Example: pipeclamp identify my_campaign -o law.json && pipeclamp compare law.json my_campaign",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    add_completion=False,
)
WIDE = 150
console = Console(width=None if sys.stdout.isatty() else WIDE)
errors = Console(stderr=True)


class BaseLaw(StrEnum):
    """Base laws that can be identified."""

    power = "power"
    memory = "memory"
    series = "series"


class FitMethod(StrEnum):
    """Ways to identify a law."""

    joint = "joint"
    surfaces = "surfaces"


class FmuKind(StrEnum):
    """Kinds of FMUs that can be built."""

    python = "python"
    native = "native"


class FmiVersion(StrEnum):
    """Versions of FMI that native FMUs can be of."""

    fmi2 = "2"
    fmi3 = "3"


class RecordFormat(StrEnum):
    """Formats of records that the virtual rig writes."""

    csv = "csv"
    csv_gz = "csv.gz"
    parquet = "parquet"


CampaignFolder = Annotated[
    Path, typer.Argument(metavar="CAMPAIGN", help="Folder with campaign.toml and runs.csv, or a bundled campaign.")
]
KindOption = Annotated[
    FmuKind, typer.Option(help="python: needs a Python in the importing tool; native: C, needs nothing.")
]
FmiOption = Annotated[FmiVersion | None, typer.Option(help="Native: version of FMI, 2 by default.")]
PlatformsOption = Annotated[
    str | None,
    typer.Option(metavar="linux64,win64,darwin64", help="Native: this machine's by default; '' for sources alone."),
]
LawArgument = Annotated[str, typer.Argument(metavar="LAW", help="Law file, or the name of a bundled law.")]
JsonOption = Annotated[Path | None, typer.Option("--json", metavar="F", help="Write the answer as JSON.")]
ReportOption = Annotated[Path | None, typer.Option("--report", metavar="F.html", help="Write a report with pictures.")]
StrictOption = Annotated[bool, typer.Option("--strict", help="A run that can't be used is an error.")]
EffectsOption = Annotated[
    str, typer.Option("--effects", metavar="a,b,...", help="Effects, see `pipeclamp effects`, or F.toml.")
]
DeclaredOption = Annotated[
    list[Path] | None,
    typer.Option("--declared", metavar="F.toml", help="An effect of your own, by declaration; any number of times."),
]
ReproducibleOption = Annotated[bool, typer.Option("--reproducible", help="Leave out the date.")]


def main() -> None:
    """Run the command line; a user's mistake is one message on stderr and exit status 1."""
    try:
        app(prog_name="pipeclamp")
    except UserError as error:
        errors.print(f"pipeclamp: {error}", style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
    except OSError as error:
        errors.print(f"pipeclamp: {error}", style="red", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)


@app.command(epilog="Example: pipeclamp metrics my_campaign --report metrics.html")
def metrics(
    campaign: CampaignFolder,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="METRICS", help="Write the metrics as a campaign without records."),
    ] = None,
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
    _show(found, json, report, f"Loop metrics of {tests.name}", tests.notes)


@app.command(epilog="Example: pipeclamp identify my_campaign -o law.json --effects memory,damping_temperature")
def identify(
    campaign: CampaignFolder,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LAW.json", help="The parameter file to write.")],
    effects: EffectsOption = "",
    base: Annotated[
        BaseLaw, typer.Option(help="Base law: Eq. 17 (power), Eq. 14 (memory), Eq. 10 (series).")
    ] = BaseLaw.power,
    method: Annotated[FitMethod, typer.Option(help="All at once, or the paper's route by itself.")] = FitMethod.joint,
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
        ids, declarations = read_effects(_names(effects), declared or ())
        tests = _read(campaign, strict, tell)
        file, sections = identified(
            tests, base=base.value, effects=ids, frozen=_values(freeze), method=method.value, declared=declarations,
            name=name or tests.name, command=_command(), date=None if reproducible else _now(),
            with_report=report is not None, progress=tell,
        )  # fmt: skip
    _write(None, report, None, f"Law {file.name}", f"identified from {tests.name}", sections)
    write_whole(output, law_text(file))
    _print_law(file, output)


@app.command(epilog="Example: pipeclamp compare law.json my_campaign --report compare.html")
def compare(
    law: LawArgument,
    campaign: CampaignFolder,
    json: JsonOption = None,
    report: ReportOption = None,
    strict: StrictOption = False,
) -> None:
    """Hold a law against measurements: how much it errs, and where."""
    from pipeclamp.bundled import open_law
    from pipeclamp_identification.findings import compared

    with told("compare") as tell:
        file = open_law(law)
        tests = _read(campaign, strict, tell)
        found = compared(file, tests, with_report=report is not None)
    effects = ", ".join(file.effects) or "none"
    _show(found, json, report, f"Law {file.name} against {tests.name}", f"base {file.base}, effects: {effects}")


@app.command(epilog="Example: pipeclamp diagnose law.json my_campaign --report diagnosis.html")
def diagnose(
    law: LawArgument,
    campaign: CampaignFolder,
    json: JsonOption = None,
    report: ReportOption = None,
    auto: Annotated[
        Path | None, typer.Option("--auto", metavar="LAW2.json", help="Add what is missing, again and again.")
    ] = None,
    limits: Annotated[
        str, typer.Option(metavar="A=0.1..2,f=0.5..20,T=20..300", help="What the rig can do, for the next test.")
    ] = "",
    declared: DeclaredOption = None,
    jobs: Annotated[int, typer.Option(help="Processes for large campaigns; -1: one a core.")] = -1,
    strict: StrictOption = False,
) -> None:
    """Which physical effect does the law lack? Or which test would tell?"""
    from pipeclamp.bundled import open_law
    from pipeclamp.declaration import read_effects
    from pipeclamp.parameter_file import law_text
    from pipeclamp_identification.auto import add_until_settled, answer_to
    from pipeclamp_identification.findings import diagnosed
    from pipeclamp_identification.next_test import parse_limits

    with told("diagnose") as tell:
        file = open_law(law)
        _, declarations = read_effects((), declared or ())
        tests = _read(campaign, strict, tell)
        reach = parse_limits(limits) if limits else None
        if auto:
            settled = add_until_settled(
                file, tests, command=_command(), declared=declarations, limits=reach, jobs=jobs, progress=tell
            )
            file, answer = settled.file, settled.answer
        else:
            settled = None
            answer = answer_to(file, tests, declared=declarations, limits=reach, jobs=jobs, progress=tell)
        found = diagnosed(answer, with_report=report is not None)
    if auto and settled:
        write_whole(auto, law_text(file))
        for line in settled.words():
            console.print(line, highlight=False)
    _show(found, json, report, f"Diagnosis of {file.name}", tests.name)


@app.command(epilog="Example: pipeclamp remove law2.json memory my_campaign -o law.json")
def remove(
    law: LawArgument,
    effect: Annotated[str, typer.Argument(metavar="EFFECT", help="The effect to take out.")],
    campaign: CampaignFolder,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LAW2.json", help="The parameter file to write.")],
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
    output: Annotated[Path, typer.Option("-o", "--output", metavar="LAW2.json", help="The parameter file to write.")],
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
    _print_table(Table(("id", "part", "looks like, when missing", "imitated by", "told apart by"), rows))


@app.command(epilog="Example: pipeclamp rig law.json -o virtual --effects viscous --set c1=2 --temperatures 20,150,300")
def rig(
    law: LawArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="CAMPAIGN", help="The folder to write; it must not exist.")
    ],
    effects: EffectsOption = "",
    declared: DeclaredOption = None,
    set_values: Annotated[
        str, typer.Option("--set", metavar="name=value,...", help="Of parameters and further columns.")
    ] = "",
    amplitudes: Annotated[str, typer.Option(metavar="mm,...")] = "0.2,0.5,0.8,1",
    frequencies: Annotated[str, typer.Option(metavar="Hz,...")] = "1,3,5",
    temperatures: Annotated[str, typer.Option(metavar="degC,...")] = "20,100,200,300",
    cycles: Annotated[float, typer.Option(help="Cycles per record; need not be whole.")] = 5.0,
    ramp_cycles: Annotated[float, typer.Option(help="Cycles of ramp-in before them.")] = 0.0,
    rate: Annotated[float, typer.Option(help="Samples per second.")] = 1000.0,
    force_noise: Annotated[float, typer.Option(help="Rms noise of the force sensor, N.")] = 3.0,
    displacement_noise: Annotated[float, typer.Option(help="Rms noise of the displacement sensor, mm.")] = 0.0002,
    force_step: Annotated[float, typer.Option(help="Quantisation of the force, N.")] = 0.1,
    displacement_step: Annotated[float, typer.Option(help="Quantisation of the displacement, mm.")] = 0.0001,
    distortion: Annotated[float, typer.Option(help="Third harmonic of the drive, share of the amplitude.")] = 0.005,
    amplitude_error: Annotated[float, typer.Option(help="Rms error of the amplitude, as a share.")] = 0.005,
    temperature_error: Annotated[float, typer.Option(help="Rms error of the temperature, K.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Of the random numbers.")] = 0,
    format: Annotated[RecordFormat, typer.Option(help="Format of the records.")] = RecordFormat.csv,
) -> None:
    """A virtual campaign of a law: would this test plan see that effect?"""
    from pipeclamp.bundled import open_law
    from pipeclamp.declaration import read_effects
    from pipeclamp_identification import rig as virtual

    with told("rig") as tell:
        plan = virtual.TestPlan(
            amplitudes=_numbers(amplitudes, "--amplitudes"),
            frequencies=_numbers(frequencies, "--frequencies"),
            temperatures=_numbers(temperatures, "--temperatures"),
            cycles=cycles,
            ramp_cycles=ramp_cycles,
            rate=rate,
            force_noise=force_noise,
            displacement_noise=displacement_noise,
            force_step=force_step,
            displacement_step=displacement_step,
            distortion=distortion,
            amplitude_error=amplitude_error,
            temperature_error=temperature_error,
            seed=seed,
        )
        ids, declarations = read_effects(_names(effects), declared or ())
        truth, conditions = virtual.truth_law(open_law(law), ids, _values(set_values), declarations)
        count = virtual.write_campaign(
            output, virtual.virtual_runs(truth, plan, conditions), name=output.name, notes=f"Virtual rig: {_command()}",
            format=format.value, progress=tell,
        )  # fmt: skip
    console.print(f"{output}: {count} runs")


@app.command("build-fmu", epilog="Example: pipeclamp build-fmu law.json -o clamp.fmu")
def build_fmu(
    law: LawArgument,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="CLAMP.fmu", help="The FMU to write.")],
    kind: KindOption = FmuKind.python,
    fmi: FmiOption = None,
    platforms: PlatformsOption = None,
) -> None:
    """Package a law as an FMU with A, f and T parameters."""
    from pipeclamp.bundled import open_law
    from pipeclamp_fmu.build import build_clamp, build_native_clamp

    with told("build-fmu"):
        made = "FMI 2.0 co-simulation, python"
        if kind is FmuKind.native:
            built = build_native_clamp(open_law(law), output, int(fmi or FmiVersion.fmi2), _platforms(platforms))
            made = f"FMI {built.fmi}.0 co-simulation and model exchange, native ({_libraries(built)})"
        else:
            _refuse_native_options(fmi, platforms)
            build_clamp(open_law(law), output)
    console.print(f"{output}: {made}")


@app.command("set-parameters", epilog="Example: pipeclamp set-parameters clamp.fmu law2.json")
def set_parameters(
    fmu: Annotated[Path, typer.Argument(metavar="CLAMP.fmu", help="An FMU made by build-fmu.")],
    law: LawArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="CLAMP2.fmu", help="The FMU to write; the same by default.")
    ] = None,
) -> None:
    """Put another law's parameters into a finished clamp FMU, without a compiler."""
    from pipeclamp.bundled import open_law
    from pipeclamp_fmu import set_parameters as setting

    with told("set-parameters"):
        file = open_law(law)
        setting.set_parameters(fmu, file, output or fmu)
    console.print(f"{output or fmu}: parameters of {file.name}")


@app.command("build-pipe", epilog="Example: pipeclamp build-pipe pipe.toml -o pipe.fmu")
def build_pipe(
    pipe: Annotated[Path, typer.Argument(metavar="PIPE.toml", help="Description of the pipe.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PIPE.fmu", help="The FMU to write.")],
    kind: KindOption = FmuKind.python,
    fmi: FmiOption = None,
    platforms: PlatformsOption = None,
) -> None:
    """Package a pipe as an FMU with a port for each of its clamps."""
    from pipeclamp.pipe import reduce
    from pipeclamp.pipe_description import read_pipe
    from pipeclamp_fmu.build import build_native_pipe, build_pipe

    with told("build-pipe"):
        reduced = reduce(read_pipe(pipe))
        made = "FMI 2.0 co-simulation, python"
        if kind is FmuKind.native:
            built = build_native_pipe(reduced, output, int(fmi or FmiVersion.fmi2), _platforms(platforms))
            made = f"FMI {built.fmi}.0 co-simulation and model exchange, native ({_libraries(built)})"
        else:
            _refuse_native_options(fmi, platforms)
            build_pipe(reduced, output)
    for line in reduced.summary().splitlines():
        console.print(line, style="bold red" if line.startswith("UNSTABLE") else None, markup=False, highlight=False)
    console.print(f"{output}: {made}")


@app.command(epilog="Example: pipeclamp cosim system.toml -o result.csv --report result.html")
def cosim(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="RESULT.csv", help="The result to write.")],
    report: ReportOption = None,
) -> None:
    """Couple a pipe FMU with clamp FMUs and run them."""
    from pipeclamp_identification.cosim import run_system
    from pipeclamp_identification.cosim_report import cosim_sections
    from pipeclamp_identification.cosim_result import write_result

    with told("cosim") as tell:
        result = run_system(system, lambda share: tell(f"{share:.0%}"))
        sections = cosim_sections(result)
    if report:
        _write(None, report, None, f"Co-simulation {system.stem}", "pipe and clamps", sections)
    write_result(result, output)
    for line in sections[0].paragraphs:
        shown, style = (errors, "bold red") if line.startswith("NOT TO BE TRUSTED") else (console, None)
        shown.print(line, style=style, markup=False, highlight=False, soft_wrap=True)
    console.print(str(output))


@app.command(epilog="Example: pipeclamp response system.toml -o response.csv --report response.html")
def response(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="RESPONSE.csv", help="The curves to write.")],
    report: ReportOption = None,
) -> None:
    """Frequency response with the clamps: steady states, stable or not, and co-simulations on them."""
    from pipeclamp_identification.frequency_response import run_response, write_response
    from pipeclamp_identification.response_report import response_sections

    with told("response") as tell:
        found = run_response(system, tell)
        sections = response_sections(found)
    if report:
        _write(None, report, None, f"Frequency response {system.stem}", "pipe and clamps", sections)
    write_response(found, output)
    for line in sections[0].paragraphs:
        console.print(line, highlight=False)
    console.print(str(output))


@app.command("system", epilog="Example: pipeclamp system system.toml -o system.ssp --kind native")
def system_structure(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="SYSTEM.ssp", help="The SSP to write.")],
    kind: Annotated[FmuKind, typer.Option(help="Of all that isn't an FMU yet.")] = FmuKind.python,
) -> None:
    """Package a coupled system, FMUs, connections and parameters, as an SSP 1.0 for other masters."""
    from pipeclamp_identification.cosim import NATIVE, PYTHON
    from pipeclamp_identification.system_ssp import write_system

    with told("system"):
        write_system(system, output, PYTHON if kind is FmuKind.python else NATIVE)
    console.print(f"{output}: SSP 1.0, {kind.value}")


@app.command(epilog="Example: pipeclamp sweep study.toml -o study.parquet --report study.html")
def sweep(
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The system and what is varied in it.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="STUDY.parquet", help="The table to write.")],
    jobs: Annotated[int, typer.Option(help="Processes; -1 for all cores.")] = -1,
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler that takes the cases.")] = None,
    report: ReportOption = None,
) -> None:
    """Vary a system over thousands of cases; after a kill the same command goes on."""
    from pipeclamp_identification.study import read_study
    from pipeclamp_identification.study_report import study_sections
    from pipeclamp_identification.study_run import run_study

    read = read_study(study)
    columns = (TextColumn("sweep"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as shown:
        task = shown.add_task("sweep", total=read.description.count)
        frame = run_study(read, output, jobs, dask, lambda done, _: shown.update(task, completed=done))
    sections = study_sections(read, frame)
    if report:
        _write(None, report, None, f"Study {study.stem}", read.description.notes, sections)
    for line in sections[0].paragraphs:
        console.print(line, highlight=False, markup=False)
    console.print(str(output))


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


@contextmanager
def told(title: str) -> Iterator[Tell]:
    """Show what is being done, with the time it takes; on a terminal only, so that logs stay clean."""
    from pipeclamp.one_thread import one_thread

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    shown = Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal)
    with one_thread(), shown as progress:
        task = progress.add_task(title)
        yield lambda what: progress.update(task, description=f"{title}: {what}")


def _read(folder: Path, strict: bool, tell: Tell) -> Campaign | MetricCampaign:
    from pipeclamp_identification.bundled_campaigns import campaign_folder
    from pipeclamp_identification.campaign import Campaign
    from pipeclamp_identification.metric_campaign import read_tests

    tell(f"read {folder}")
    tests = read_tests(campaign_folder(folder), strict=strict)
    for entry in tests.left_out:
        errors.print(f"warning: {entry}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    if isinstance(tests, Campaign) and tests.smoothing.words():
        errors.print(f"note: {tests.smoothing.words()}", markup=False, highlight=False, soft_wrap=True)
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
    from pipeclamp.bundled import open_law
    from pipeclamp.parameter_file import law_text
    from pipeclamp_identification.add import addition_table

    with told(title) as tell:
        file = open_law(law)
        tests = _read(campaign, strict, tell)
        date = None if reproducible else _now()
        changed = change(file, campaign=tests, command=_command(), date=date, progress=tell)
    write_whole(output, law_text(changed.after))
    _print_table(addition_table(changed))
    _print_law(changed.after, output)


def _show(found: Findings, json_path: Path | None, report: Path | None, title: str, subtitle: str) -> None:
    """Write a command's findings where wanted, and print them."""
    _write(json_path, report, found.answer, title, subtitle, found.sections)
    for table in found.tables:
        _print_table(table)
    for line in found.lines:
        console.print(line, highlight=False, markup=False)


def _write(
    json_path: Path | None,
    report: Path | None,
    answer: dict[str, Any] | None,
    title: str,
    subtitle: str,
    sections: Sequence[Section],
) -> None:
    if json_path:
        write_whole(json_path, json.dumps(answer, indent=1, allow_nan=False) + "\n")
    if report:
        from pipeclamp_identification.report import write_report

        write_report(report, title, subtitle, sections)


def _print_table(table: Table) -> None:
    from pipeclamp_identification.report import cell

    shown = RichTable(title=table.caption or None, title_justify="left", title_style="italic")
    for index, head in enumerate(table.header):
        numeric = any(isinstance(row[index], float) for row in table.rows)
        shown.add_column(head, justify="right" if numeric else "left", overflow="fold")
    for row in table.rows:
        shown.add_row(*(cell(value) for value in row))
    console.print(shown, highlight=False)


def _print_law(file: Any, output: Path) -> None:
    from pipeclamp_identification.identify_report import coefficient_table

    _print_table(coefficient_table(file))
    for entry in file.correlations:
        pair = " and ".join(entry.pair)
        console.print(f"{pair} can hardly be told apart (correlation {entry.value:.3f})", highlight=False)
    if file.fit:
        noise = f" (scatter {file.fit.noise_nrmse:.2%})" if file.fit.noise_nrmse is not None else ""
        of = "in dW and W (rms of log ratios)" if file.fit.method == "metrics" else "of the rms force"
        console.print(f"error {file.fit.nrmse:.2%} {of}{noise}", highlight=False)
    console.print(str(output), highlight=False)


def _refuse_native_options(fmi: FmiVersion | None, platforms: str | None) -> None:
    if platforms is not None or fmi is not None:
        raise UserError(
            "--fmi and --platforms are for --kind native; a Python FMU is of FMI 2.0, for linux64 and win64"
        )


def _platforms(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else _names(text)


def _libraries(built: Built) -> str:
    return ", ".join(built.platforms) or "sources alone: the importing tool compiles them"


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _values(text: str) -> dict[str, float]:
    values = {}
    for entry in _names(text):
        name, equals, number = entry.partition("=")
        if not equals:
            raise UserError(f"got {entry!r}; expected name=value, for example k1_T=0")
        values[name.strip()] = _numbers(number, name)[0]
    return values


def _numbers(text: str, where: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(entry) for entry in _names(text))
    except ValueError as error:
        raise UserError(f"{where}: got {text!r}; expected numbers separated by commas") from error
    if not numbers or not all(math.isfinite(number) for number in numbers):
        raise UserError(f"{where}: got {text!r}; expected finite numbers separated by commas")
    return numbers


def _command() -> str:
    """Give the command as it was called, paths by their last part, so that it reads the same everywhere."""

    def last(word: str) -> str:
        return ",".join(Path(part).name or part for part in word.split(","))

    words = [word if word.startswith("-") else last(word) for word in sys.argv[1:]]
    return " ".join(["pipeclamp", *words])


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
