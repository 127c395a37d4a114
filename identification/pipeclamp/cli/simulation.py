"""The command line's part for simulation: FMUs, pipes, coupled systems."""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from pipeclamp.cli.terminal import (
    BandsOption,
    JobsOption,
    LawArgument,
    ReportOption,
    command_called,
    errors,
    file_option,
    names_in,
    note,
    opened_law,
    print_next,
    put,
    say,
    showing_progress,
    spare,
)
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.base.files import FMU, SSP, refuse_ending
from pipeclamp_models.base.units import CELSIUS

if TYPE_CHECKING:
    from pipeclamp.pages.page import Section
    from pipeclamp_fmu.native.packing import Built
    from pipeclamp_identification.workflow.next_step import NextStep
    from pipeclamp_system.bands.ensemble import RunBands
    from pipeclamp_system.bands.response_bands import ResponseBands

app = typer.Typer()


Source = TypeVar("Source")


class FmuKind(StrEnum):
    """Kinds of FMUs that can be built."""

    python = "python"
    native = "native"


class FmiVersion(StrEnum):
    """Versions of FMI that native FMUs can be of."""

    fmi2 = "2"
    fmi3 = "3"


KindOption = Annotated[
    FmuKind | None,
    typer.Option(
        help="native: C, needs nothing; python: needs a Python in the importing tool. Native by default, python where "
        "no C compiler is found."
    ),
]
FmiOption = Annotated[FmiVersion | None, typer.Option(help="Native: version of FMI, 2 by default.")]
PlatformsOption = Annotated[
    str | None,
    typer.Option(metavar="linux64,win64,darwin64", help="Native: this machine's by default; '' for sources alone."),
]


LimitOption = Annotated[
    list[str] | None,
    typer.Option(metavar="POINT=MM", help="With --bands: how likely a clamp or probe moves farther than that."),
]


def _start_option(unit: str, help: str, least: float = 0.0) -> Any:
    """Give the option of a start value of the clamp's FMU, above the least one."""

    def checked(value: float | None) -> float | None:
        if value is not None and not least < value < math.inf:
            raise typer.BadParameter(f"got {value:g} {unit}; expected a number above {least:g} {unit}")
        return value

    return typer.Option(metavar=unit, help=help, callback=checked)


@app.command("build-fmu", epilog="Example: pipeclamp build-fmu law.json -o clamp.fmu")
def build_fmu(
    law: LawArgument,
    output: Annotated[Path, file_option("CLAMP.fmu", "The FMU to write.")],
    kind: KindOption = None,
    fmi: FmiOption = None,
    platforms: PlatformsOption = None,
    amplitude: Annotated[
        float | None, _start_option("mm", "A at the start; the middle of the law's range by default.")
    ] = None,
    frequency: Annotated[float | None, _start_option("Hz", "f at the start, likewise.")] = None,
    temperature: Annotated[
        float | None, _start_option("°C", "T at the start, likewise; 20 °C without a range.", -CELSIUS)
    ] = None,
    track: Annotated[bool, typer.Option("--track", metavar="", help="Follow A and f of the motion.")] = False,
    temperature_input: Annotated[
        bool, typer.Option("--temperature-input", metavar="", help="T_in as an input to connect, in place of T.")
    ] = False,
    no_events: Annotated[
        bool, typer.Option("--no-events", metavar="", help="Native: reversals are no events of model exchange.")
    ] = False,
    memory_as_states: Annotated[
        bool,
        typer.Option("--memory-as-states", metavar="", help="Native: memory as continuous states of model exchange."),
    ] = False,
) -> None:
    """Package a law as an FMU with A, f and T parameters."""
    from pipeclamp.show.of_rig import of_rig_words
    from pipeclamp_fmu.build import build_clamp, build_native_clamp, passivity
    from pipeclamp_fmu.contents.clamp_model import ClampStart
    from pipeclamp_fmu.contents.clamp_of_law import clamp_model
    from pipeclamp_identification.workflow.next_built import after_clamp_fmu

    start = ClampStart(
        A=None if amplitude is None else amplitude / 1000,
        f=frequency,
        T=None if temperature is None else temperature + CELSIUS,
        track=track,
        connected_temperature=temperature_input,
        events=not no_events,
        memory_as_states=memory_as_states,
    )
    build_python, build_native = partial(build_clamp, start=start), partial(build_native_clamp, start=start)
    for asked, option in ((no_events, "--no-events"), (memory_as_states, "--memory-as-states")):
        if asked and kind is FmuKind.python:
            raise typer.BadParameter("it is for --kind native: a Python FMU has no model exchange", param_hint=option)
    kind = FmuKind.native if no_events or memory_as_states else kind
    spare(law, outputs=(output,))
    refuse_ending(output, FMU, "an FMU")
    with showing_progress("build-fmu"):
        file = opened_law(law)
        made = _built(file, output, build_python, build_native, kind, fmi, platforms)
        clamp = clamp_model(file, start)
        held = passivity(clamp, file).words()
    if not file.data.is_timed:
        note(
            f"no time was measured in the tests of law {file.name}: its forces are those of cycles of one second, and "
            "at any other frequency the FMU's damping follows a speed that nobody tested"
        )
    if about := file.data.about_mm:
        note(
            f"the tests of law {file.name} moved about {about:.3g} mm, and the FMU's displacement counts as theirs did"
        )
    if clamp.further:
        note(f"parameters of the FMU: {'; '.join(condition.words() for condition in clamp.further)}")
    if words := of_rig_words(file):
        note(words)
    put(f"law {file.name} {held}")
    put(f"{output}: {made}")
    say([after_clamp_fmu(str(output)).words()])


@app.command("set-parameters", epilog="Example: pipeclamp set-parameters clamp.fmu law2.json")
def set_parameters(
    fmu: Annotated[Path, typer.Argument(metavar="CLAMP.fmu", help="An FMU made by build-fmu.")],
    law: LawArgument,
    output: Annotated[Path | None, file_option("CLAMP2.fmu", "The FMU to write; the same by default.")] = None,
) -> None:
    """Put another law's parameters into a finished clamp FMU, without a compiler."""
    from pipeclamp_fmu import set_parameters as setting
    from pipeclamp_identification.workflow.next_built import after_clamp_fmu

    spare(law, outputs=(output,))
    if output:
        refuse_ending(output, FMU, "an FMU")
    with showing_progress("set-parameters"):
        file = opened_law(law)
        setting.set_parameters(fmu, file, output or fmu)
    put(f"{output or fmu}: parameters of {file.name}")
    say([after_clamp_fmu(str(output or fmu)).words()])


@app.command("build-pipe", epilog="Example: pipeclamp build-pipe pipe.toml -o pipe.fmu")
def build_pipe(
    pipe: Annotated[Path, typer.Argument(metavar="PIPE.toml", help="Description of the pipe.")],
    output: Annotated[Path, file_option("PIPE.fmu", "The FMU to write.")],
    kind: KindOption = None,
    fmi: FmiOption = None,
    platforms: PlatformsOption = None,
) -> None:
    """Package a pipe as an FMU with a port for each of its clamps."""
    from pipeclamp_fmu.build import build_native_pipe, build_pipe
    from pipeclamp_identification.workflow.next_built import after_pipe_fmu
    from pipeclamp_models.pipe.description import read_pipe
    from pipeclamp_models.pipe.modes import reduce

    spare(pipe, outputs=(output,))
    refuse_ending(output, FMU, "an FMU")
    with showing_progress("build-pipe"):
        reduced = reduce(read_pipe(pipe))
        made = _built(reduced, output, build_pipe, build_native_pipe, kind, fmi, platforms)
    for line in reduced.summary().splitlines():
        put(line, style="bold red" if line.startswith("UNSTABLE") else None)
    put(f"{output}: {made}")
    say([after_pipe_fmu(str(output)).words()])


@app.command(epilog="Example: pipeclamp cosim system.toml -o result.csv --report result.html")
def cosim(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, file_option("RESULT.csv", "The result to write.")],
    report: ReportOption = None,
    bands: BandsOption = None,
) -> None:
    """Couple a pipe FMU with clamp FMUs and run them."""
    from pipeclamp.pages.system.cosim import cosim_page
    from pipeclamp_identification.workflow.systems.computed import co_simulate
    from pipeclamp_identification.workflow.systems.next_in_system import after_cosim
    from pipeclamp_system.cosim.result import write_result

    spare(system, outputs=(output, report))
    with showing_progress("cosim") as tell:
        found = co_simulate(system, bands, tell)
        result, banded = found.result, found.bands
        following = after_cosim(result, system, str(output), report, bands)
        page = cosim_page(result, system.name, banded, following)
    if report:
        from pipeclamp.pages.page import write_report

        write_report(report, *page, command_called())
    write_result(result, output)
    _say_all(page.sections[0], banded, output, following)


@app.command(epilog="Example: pipeclamp response system.toml -o response.csv --report response.html")
def response(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, file_option("RESPONSE.csv", "The curves to write.")],
    report: ReportOption = None,
    bands: BandsOption = None,
    limit: LimitOption = None,
) -> None:
    """Frequency response with the clamps: steady states, stable or not, and co-simulations on them."""
    from pipeclamp.pages.system.response import response_page
    from pipeclamp_identification.workflow.systems.computed import respond
    from pipeclamp_identification.workflow.systems.next_in_system import after_response
    from pipeclamp_system.response.table import write_response

    spare(system, outputs=(output, report))
    with showing_progress("response") as tell:
        responded = respond(system, bands, _limits(limit), tell)
        found, banded = responded.found, responded.bands
        following = after_response(found, system, str(output), report, bands)
        page = response_page(found, system.name, banded, following)
    if report:
        from pipeclamp.pages.page import write_report

        write_report(report, *page, command_called())
    write_response(found, output, banded.columns() if banded else None)
    _say_all(page.sections[0], banded, output, following)


def _say_all(answer: Section, banded: RunBands | ResponseBands | None, output: Path, following: NextStep) -> None:
    """Print what came out, how sure it is, the file, and what comes next."""
    lines = [line for line in answer.paragraphs if line not in following.before()]
    say([*lines, *(banded.words() if banded else ()), str(output), following.words()])


def _limits(texts: list[str] | None) -> dict[str, float]:
    """Read what clamps and probes may move, mm, by name."""
    limits = {}
    for text in texts or ():
        name, _, value = text.partition("=")
        try:
            limits[name.strip()] = float(value)
        except ValueError:
            raise UsageError(f"--limit: got {text!r}; expected a clamp or probe and mm, such as clamp1=0.8") from None
    return limits


@app.command("system", epilog="Example: pipeclamp system system.toml -o system.ssp --kind native")
def system_structure(
    system: Annotated[Path, typer.Argument(metavar="SYSTEM.toml", help="Description of the coupled system.")],
    output: Annotated[Path, file_option("SYSTEM.ssp", "The SSP to write.")],
    kind: Annotated[
        FmuKind | None,
        typer.Option(help="Of all that isn't an FMU yet; native by default, python where no C compiler is found."),
    ] = None,
) -> None:
    """Package a coupled system, FMUs, connections and parameters, as an SSP 1.0 for other masters."""
    from pipeclamp.show.packaged import parallel_words
    from pipeclamp_fmu.native.compiler import kind_unasked
    from pipeclamp_identification.workflow.next_built import after_packaging
    from pipeclamp_system.cosim.building import NATIVE, PYTHON
    from pipeclamp_system.cosim.ssp import write_system

    spare(system, outputs=(output,))
    refuse_ending(output, SSP, "an SSP")
    with showing_progress("system") as tell:
        made = kind or FmuKind(kind_unasked())
        found = write_system(system, output, PYTHON if made is FmuKind.python else NATIVE, tell)
    put(f"{output}: SSP 1.0, {made.value}")
    say([parallel_words(found)])
    print_next(after_packaging(str(system)))


@app.command(epilog="Example: pipeclamp sweep study.toml -o study.parquet --report study.html")
def sweep(
    study: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The system and what is varied in it.")],
    output: Annotated[Path, file_option("STUDY.parquet", "The table to write.")],
    jobs: JobsOption = -1,
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A Dask scheduler that takes the cases.")] = None,
    report: ReportOption = None,
    bands: BandsOption = None,
) -> None:
    """Vary a system over thousands of cases; after a kill the same command goes on."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from pipeclamp.pages.system.study import study_page
    from pipeclamp_identification.workflow.systems.next_in_system import after_sweep
    from pipeclamp_system.study.description import read_study
    from pipeclamp_system.study.run import run_study

    spare(study, outputs=(output, report))
    read = read_study(study, bands)
    columns = (TextColumn("sweep"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors(), transient=True, disable=not errors().is_terminal) as shown:
        task = shown.add_task("sweep", total=read.description.count)
        frame = run_study(
            read, output, jobs, dask, lambda done, _: shown.update(task, completed=done),
            lambda: errors().print("the cases that run are finished first; Ctrl-C again ends at once", highlight=False),
        )  # fmt: skip
    following = after_sweep(read, frame, study, str(output), report)
    page = study_page(read, frame, following)
    if report:
        from pipeclamp.pages.page import write_report

        write_report(report, *page, command_called())
    _say_all(page.sections[0], None, output, following)


def _built(
    source: Source,
    output: Path,
    build_python: Callable[[Source, Path], object],
    build_native: Callable[[Source, Path, int, tuple[str, ...] | None], Built],
    kind: FmuKind | None,
    fmi: FmiVersion | None,
    platforms: str | None,
) -> str:
    """Build an FMU of a kind, where None of the one that is made unasked, and say what was made."""
    from pipeclamp_fmu.native.compiler import kind_unasked

    only_native = platforms is not None or fmi is not None
    chosen = kind or (FmuKind.native if only_native else FmuKind(kind_unasked()))
    if chosen is FmuKind.native:
        named = None if platforms is None else names_in(platforms)
        built = build_native(source, output, int(fmi or FmiVersion.fmi2), named)
        libraries = ", ".join(built.platforms) or "sources alone: the importing tool compiles them"
        libraries += "; others by --platforms" if named is None and built.platforms else ""
        return f"FMI {built.fmi}.0 co-simulation and model exchange, native ({libraries})"
    if only_native:
        raise UsageError(
            "--fmi and --platforms are for --kind native; a Python FMU is of FMI 2.0, for linux64 and win64"
        )
    build_python(source, output)
    unasked = "" if kind else "no C compiler was found: "
    return (
        f"{unasked}FMI 2.0 co-simulation, run by Python. A tool that unpacks it to a path with + ( ) or letters beyond "
        "ASCII crashes; an FMU of --kind native runs from any path"
    )
