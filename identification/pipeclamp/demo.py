"""The whole story on bundled data: from the printed law to a clamp that holds a vibrating pipe."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from importlib import resources
from math import isfinite
from pathlib import Path

import plotly.graph_objects as go

from pipeclamp.pages.comparison import difference_section
from pipeclamp.pages.page import Section, write_report
from pipeclamp.pages.pictures import overlay_picture
from pipeclamp.pages.sections import law_page, metrics_page
from pipeclamp.pages.system.cosim import cosim_sections
from pipeclamp.pages.waterfall import OF_METRICS, RungBars, waterfall_picture
from pipeclamp.show.comparison import how_much
from pipeclamp.show.law import change_table
from pipeclamp.show.table import Table
from pipeclamp_fmu.build import build_clamp, build_pipe
from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.comparison.laws import stages_held
from pipeclamp_identification.metrics_only.published import (
    FIGURE_14,
    READINGS,
    PublishedStep,
    Reading,
    reading_law,
    way,
)
from pipeclamp_identification.workflow.change import LawChange, add_effect
from pipeclamp_identification.workflow.next_command import after_change, after_import
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_identification.workflow.systems.next_in_system import after_cosim
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import LawFile, Provenance, law_text, read_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids
from pipeclamp_system.cosim.result import CosimResult, write_result
from pipeclamp_system.cosim.run import run_system

COMMAND = "pipeclamp demo"
EFFECTS = ("damping_temperature", "memory:2")
UNSEEN = "on tests never seen"
"""What the truth of clamp_a, a campaign of the virtual rig, holds besides a base law."""
HOT = 300.0

CAMPAIGN = "clamp_a"
AFTER_DEMO = after_import(CAMPAIGN)
"""The line with which the same begins by hand."""

Tell = Callable[[str], None]


@one_thread()
def run_demo(folder: Path, tell: Tell) -> list[Path]:
    """Run the story and write its results into a folder.

    Args:
        folder: made where it isn't there; files of an earlier demo are replaced.
        tell: is told each step.

    Returns:
        what to open, in order.

    Raises:
        UserError: the folder can't be written.
    """
    begin = time.perf_counter()
    new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{folder}: can't make the folder ({error.strerror}); expected a place to write to") from error
    try:
        opened = [
            _published_tables(folder, tell),
            *_clamp_a(folder, tell),
            *_pipe_and_clamp(folder, tell),
        ]
    except BaseException:
        if new and not any(folder.iterdir()):
            folder.rmdir()
        raise
    tell(f"done in {time.perf_counter() - begin:.0f} s")
    return opened


def _published_tables(folder: Path, tell: Tell) -> Path:
    tell("1. The published tables: dW and W of a real clamp at 11 conditions")
    steps = way()
    for step in steps:
        tell(f"   {step.title:<48} {step.errors[0]:6.2%} rms of the log ratios{_caution(step)}")
    path = folder / "1_published_tables.html"
    write_report(
        path,
        "From the printed law to one that fits",
        "Tables 2, 3, 5 of Symmetry 2020, 12(8), 1283",
        _way_sections(steps),
        COMMAND,
    )
    return path


def _caution(step: PublishedStep) -> str:
    if not step.rests_on:
        return ""
    rows = "; ".join(f"{A:g} mm, {f:g} Hz, {T:g} °C" for A, f, T in step.rests_on)
    return f"  (rests on one row: {rows})"


def _way_sections(steps: tuple[PublishedStep, ...]) -> list[Section]:
    rows: list[tuple[str | float, ...]] = [
        (step.title, *(100 * error for error in step.errors), _caution(step).strip(" ()")) for step in steps
    ]
    table = Table(
        ("law", "dW and W / %", "dW / %", "W / %", "caution"), rows, "rms of the log ratios measured/computed"
    )
    words = [
        "The printed law holds no temperature in its damping, no rise of stiffness above a temperature, and no "
        "frequency in its stiffness. Each step adds one of them and refits everything.",
        "A step that rests on one row gains less than half without that one measurement: the tables support it, they "
        "don't prove it.",
    ]
    rungs = [RungBars(step.title, {"dW and W": step.errors[0]}) for step in steps]
    falling = waterfall_picture(rungs, None, "Error against the published tables", OF_METRICS)
    return [
        Section("The way", words, [table], [falling], after_import("emwm2_tables")),
        Section(
            "The printed law's readings",
            [
                "What is printed leaves open the sign of one exponent and the scale of the temperature: four readings.",
                *(f"{_short(reading)}: {reading.notes}." for reading in READINGS),
            ],
            (),
            [_figure_14(A, f, T) for A, f, T in FIGURE_14],
        ),
    ]


def _short(reading: Reading) -> str:
    return reading.name.removeprefix("published_")


def _figure_14(A: float, f: float, T: float) -> go.Figure:
    motion = sinusoids([A], [f], [T + CELSIUS])
    loops = [
        (_short(reading), motion.y[0], force_of_law(reading_law(reading), motion).force[0]) for reading in READINGS
    ]
    return overlay_picture(loops, f"{A:g} mm, {f:g} Hz, {T:g} °C (conditions of Fig. 14)")


def _clamp_a(folder: Path, tell: Tell) -> Iterator[Path]:
    tell("2. A campaign of raw loops: clamp_a, 48 runs of an independent virtual rig")
    tests, unseen = (RecordTests(read_campaign(bundled_campaign(name))) for name in (CAMPAIGN, f"{CAMPAIGN}_heldout"))
    file = tests.identify().file(name=CAMPAIGN, provenance=Provenance(COMMAND))
    metrics = metrics_page(tests, after_import(CAMPAIGN))
    write_report(folder / "2_metrics.html", "Loop metrics of clamp_a", tests.notes, metrics, COMMAND)
    yield folder / "2_metrics.html"
    on_unseen = [unseen.compare(file)]
    tell(f"   base law: {_errors(file, on_unseen[-1])}")
    changes: list[LawChange] = []
    for effect in EFFECTS:
        changes.append(add_effect(file, effect, tests, provenance=Provenance(COMMAND)))
        file = changes[-1].after
        on_unseen.append(unseen.compare(file))
        tell(f"   + {effect}: {_errors(file, on_unseen[-1])}")
    law = folder / "clamp_a.json"
    write_whole(law, law_text(file))
    path = folder / "3_clamp_a.html"
    write_report(
        path,
        "The law of clamp_a",
        f"error {on_unseen[-1].nrmse:.2%} on tests it has never seen",
        _law_sections(file, tests, changes, on_unseen, after_change(str(law), CAMPAIGN)),
        COMMAND,
    )
    yield path


def _errors(file: LawFile, on_unseen: Comparison) -> str:
    assert file.fit is not None
    return (
        f"{file.fit.nrmse:.2%} on the tests used ({file.fit.noise_nrmse:.2%} is scatter), {on_unseen.nrmse:.2%} on "
        f"tests never seen ({on_unseen.noise_nrmse:.2%} is scatter)"
    )


def _law_sections(
    file: LawFile, tests: RecordTests, changes: list[LawChange], on_unseen: list[Comparison], following: str
) -> list[Section]:
    steps = ["base law", *(str(change.step) for change in changes)]
    falling = waterfall_picture(
        [RungBars(step, {UNSEEN: comparison.nrmse}) for step, comparison in zip(steps, on_unseen, strict=True)],
        on_unseen[-1].noise_nrmse,
        "Error on tests never seen, effect by effect",
    )
    return [
        Section("The error falls", (), [change_table(change) for change in changes], [falling], following),
        Section("On tests never seen", how_much(on_unseen[-1])),
        difference_section(on_unseen[-1], stages_held(file, on_unseen[-1]), "Difference, on tests never seen"),
        *law_page(file, tests.compare(file)),
    ]


def _pipe_and_clamp(folder: Path, tell: Tell) -> Iterator[Path]:
    tell("3. The clamp as an FMU, holding a pipe that vibrates")
    examples = resources.files("pipeclamp_identification").joinpath("data", "examples")
    for name in ("pipe.toml", "system.toml"):
        write_whole(folder / name, examples.joinpath(name).read_text(encoding="utf-8"))
    hot = (folder / "system.toml").read_text(encoding="utf-8").replace("temperature_C = 20.0", f"temperature_C = {HOT}")
    write_whole(folder / "system_hot.toml", hot)
    build_clamp(read_law(folder / "clamp_a.json"), folder / "clamp_a.fmu")
    build_pipe(reduce(read_pipe(folder / "pipe.toml")), folder / "pipe.fmu")
    tell(f"   built {folder / 'clamp_a.fmu'} and {folder / 'pipe.fmu'}")
    for number, name, temperature in ((4, "system", "20 °C"), (5, "system_hot", f"{HOT:g} °C")):
        yield co_simulated(folder / f"{name}.toml", folder / f"{number}_{name}.html", temperature, tell)


def co_simulated(system: Path, page: Path, conditions: str, tell: Tell) -> Path:
    """Co-simulate a system, write its table and its page, and tell what came out and what of it isn't to be trusted.

    Args:
        system: SYSTEM.toml; the table stands beside it.
        page: the page to write.
        conditions: named in its title and in what is told.
        tell: is told a line each.

    Returns:
        the page.

    Raises:
        UserError: the system can't be run, or the folder can't be written.
    """
    result = run_system(system)
    table = system.with_suffix(".csv")
    write_result(result, table)
    following = after_cosim(result, system, str(table), page)
    command = f"pipeclamp cosim {system.name} -o {system.stem}.csv --report {page.name}"
    write_report(page, f"Pipe and clamp at {conditions}", result.name, cosim_sections(result, None, following), command)
    tell(f"   {conditions}: {_motion(result)}")
    for mark in result.marks():
        tell(f"   {mark}")
    return page


def _motion(result: CosimResult) -> str:
    parts = [
        f"{name} {1e3 * result.amplitude(f'{name}.s'):.4g} mm" for name in (*result.clamp_names, *result.probe_names)
    ]
    said = f"amplitude at {', '.join(parts)}; the coupling made {result.coupling_share:.2%} of the energy"
    if result.step_error is None or not isfinite(result.step_error):
        return said
    return f"{said}, and the displacement errs by {result.step_error:.2%} for its steps"
