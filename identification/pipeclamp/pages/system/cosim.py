"""The report of a co-simulation: motion, the clamps' loops, and where the energy went."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import Report, Section, doubted, styled
from pipeclamp.pages.pictures import curves_picture, thinned
from pipeclamp.pages.system.bands import add_area, run_bands_section
from pipeclamp.show.table import Table
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_system.bands.ensemble import RunBands
from pipeclamp_system.cosim.beating import cycle_amplitudes
from pipeclamp_system.cosim.energy import NAMES
from pipeclamp_system.cosim.repetition import LAST_SHARE
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.cosim.summary import summary_of

SYMBOLS = {"s": "y", "A_used": "A"}
"""Of the columns that are drawn, as the clamp's law has them."""


def cosim_page(result: CosimResult, system: str, bands: RunBands | None, following: NextStep) -> Report:
    """Give the page of a co-simulation of a system, by its file's name."""
    return Report(f"Co-simulation: {result.name}", system, cosim_sections(result, bands, following))


def cosim_sections(
    result: CosimResult, bands: RunBands | None = None, following: NextStep | None = None
) -> list[Section]:
    """Give the report of a co-simulation; the first section holds the summary in words, and what comes next."""
    points = [*result.clamp_names, *result.probe_names]
    histories = [history_picture(result, f"{name}.s", 1e3, "mm", f"Displacement at {name}") for name in points]
    loops = [_loop_picture(result, name) for name in result.clamp_names]
    tracked = [
        history_picture(result, f"{name}.A_used", 1e3, "mm", f"Amplitude that the law of {name} was given")
        for name in result.clamp_names
        if np.ptp(result.columns[f"{name}.A_used"]) > 0
    ]
    final = result.energy.final()
    rows = [(NAMES[name], value) for name, value in final.items()]
    energy = Table(("energy at the end", "J"), rows, "the first two together are what all the others make")
    balance = _energy_picture(result)
    if not result.trusted:
        for picture in (*histories, *tracked, *loops, balance):
            doubted(picture)
    return [
        answer_section(summary_of(result).splitlines(), following),
        *_beats_section(result),
        *([run_bands_section(bands)] if bands else []),
        Section("Motion", (), (), histories + tracked),
        Section("The clamps' loops", (), (), loops),
        Section("Energy", (), [energy], [balance]),
    ]


def answer_first(lines: Sequence[str]) -> list[str]:
    """Give a summary as a page tells it, in sentences: what came out before how it was computed."""
    how, *what = lines
    return [*map(sentence, what), sentence(how)]


def answer_section(lines: Sequence[str], following: NextStep | None) -> Section:
    """Give a summary's section, and what comes next in it."""
    words = answer_first(lines)
    if following is None:
        return Section("What came out", words)
    return Section("What came out", [*words, *following.before()], command=following.line)


def _beats_section(result: CosimResult) -> list[Section]:
    """Show a swing beside what the clamp does with its A and f held."""
    beats, frequency = result.beats, result.system.excitation.frequency_Hz
    if beats is None or beats.held_motion is None or frequency is None:
        return []
    runs = {
        "with A and f tracked": (result.time, result.columns[f"{beats.name}.s"]),
        f"with A = {1e3 * beats.held_at:.4g} mm and f held": (beats.held_motion[0], beats.held_motion[1]),
    }
    curves = []
    for label, (time, displacement) in runs.items():
        ends, amplitude = cycle_amplitudes(time, displacement, frequency, int(time[-1] * frequency))
        curves.append((label, ends.tolist(), (1e3 * amplitude).tolist(), "lines"))
    title = f"Amplitude at {beats.name}, cycle by cycle"
    return [Section("Beats", (), (), [curves_picture("t / s", "amplitude / mm", curves, title)])]


def history_picture(result: CosimResult, column: str, factor: float, unit: str, title: str) -> go.Figure:
    """Draw one column over time."""
    time, values = thinned(result.time, factor * result.columns[column])
    name = SYMBOLS[column.rpartition(".")[2]]
    figure = curves_picture("t / s", f"{name} / {unit}", [(column, time.tolist(), values.tolist(), "lines")], title)
    if f"{column}_low" in result.columns:
        shown = np.searchsorted(result.time, time)
        low, high = (factor * result.columns[f"{column}_{end}"][shown] for end in ("low", "high"))
        add_area(figure, time, low, high, "its band")
    return figure


def _loop_picture(result: CosimResult, name: str) -> go.Figure:
    last = slice(int(np.searchsorted(result.time, (1 - LAST_SHARE) * result.time[-1])), None)
    y, force = 1e3 * result.columns[f"{name}.s"][last], result.columns[f"{name}.f"][last]
    figure = go.Figure(go.Scatter(x=y, y=force, mode="lines", name=name, line={"width": 1.2}))
    figure.update_xaxes(title_text="y / mm").update_yaxes(title_text="F / N")
    return styled(figure, f"Loop of {name}, last fifth of the run")


def _energy_picture(result: CosimResult) -> go.Figure:
    parts = {
        NAMES["excitation"]: result.energy.excitation,
        NAMES["clamps_dissipated"]: result.energy.clamps_dissipated,
        NAMES["pipe_dissipated"]: result.energy.pipe_dissipated,
        "stored in pipe and clamps": result.energy.pipe_stored + result.energy.clamps_stored,
        NAMES["coupling"]: result.energy.coupling,
    }
    curves = []
    for name, values in parts.items():
        time, thin = thinned(result.time, values)
        curves.append((name, time.tolist(), thin.tolist(), "lines"))
    return curves_picture("t / s", "energy / J", curves, "Where the energy went")
