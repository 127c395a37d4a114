"""The page of an import: which channel is what, each run's loop and cycles, what was cut and why."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import singledispatch

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.alternative import words_of
from pipeclamp.pages.page import GRID, MEASURED, SERIES, Report, Section, render, specification_of, styled
from pipeclamp.pages.pictures import LoopPanel, loops_picture
from pipeclamp.pages.sweeps import of_phase, sweep_picture, sweep_sections
from pipeclamp.show.imported import (
    columns_table,
    cut_table,
    following_import,
    import_lines,
    imported_table,
    left_out_table,
)
from pipeclamp.show.metrics import OF_A_SINE
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.importing.answer import ImportAnswer, ImportedCampaign
from pipeclamp_identification.importing.plan import Overview
from pipeclamp_identification.importing.records.imported import ImportedRecords
from pipeclamp_identification.importing.records.looked_at import CYCLES, ShownLoop
from pipeclamp_identification.importing.results.imported import ImportedResults
from pipeclamp_identification.metrics_only.sweeps import sweeps_of
from pipeclamp_models.base.said import counted

PANELS = 24
"""Loops in a picture."""
GLANCE = 12
"""Loops that tell at a glance whether channels and units are right."""
GLANCE_PER_ROW = 3
"""Of them beside each other in the studio's column."""
LONGEST_NAME_SHOWN = 24
"""Characters of a run's name above its loop."""
MOST_OVERVIEWS, MOST_LABELS = 40, 24
FINEST = 600
"""Part of a picture's width that can be seen."""
KEPT, CUT = SERIES[0], SERIES[1]
CUT_WORDS = {
    "run": "Samples are lines of the file where it is a text.",
    "test": "Rows of the files that can't be used, as the files count them.",
}


def import_page(found: ImportedCampaign, called: Sequence[str] = ()) -> str:
    """Give the page of an import as HTML; `called` are the command's words, so that it can be said anew."""
    return render(*import_report(found, called))


def import_report(found: ImportedCampaign, called: Sequence[str] = ()) -> Report:
    """Give the page of an import; `called` as for `import_page`."""
    return Report(f"Import of {found.name}", found.folder.name, import_sections(found, called))


def import_sections(found: ImportedCampaign, called: Sequence[str] = ()) -> list[Section]:
    """Give the sections of an import's page; `called` as for `import_page`."""
    answer = found.answer()
    head, *lines = import_lines(found, answer, called)
    notes = [*(f"Note: {note}." for note in found.notes()), *(sentence(str(one)) for one in found.left_out)]
    sections = [
        Section(
            "What was imported",
            [head, *map(sentence, lines), *notes],
            [columns_table(found.imported.files)],
            command=following_import(found, answer, called),
        ),
        *_drawn(found, answer),
    ]
    if answer.left_out_files:
        sections.append(Section("Files that were left out", (), [left_out_table(answer)]))
    if answer.cut:
        sections.append(Section("What was cut", [CUT_WORDS[found.thing]], [cut_table(answer)]))
    return sections


@singledispatch
def _drawn(found: ImportedCampaign, answer: ImportAnswer) -> list[Section]:
    """Give the sections of what tests look like, and the table of all of them."""
    raise NotImplementedError(type(found))


@_drawn.register
def _(found: ImportedRecords, answer: ImportAnswer) -> list[Section]:
    every = Section("All runs", (), [imported_table(found, answer)])
    return [*_overviews(found.plan.overviews, timed=not found.plan.untimed), *_loops(found), every]


@_drawn.register
def _(found: ImportedResults, answer: ImportAnswer) -> list[Section]:
    drawn = sweep_sections(found.campaign, of_phase(found.campaign))
    every = Section("All tests", [] if drawn else [OF_A_SINE], [imported_table(found, answer)])
    if drawn:
        drawn[0] = replace(drawn[0], paragraphs=[OF_A_SINE, *drawn[0].paragraphs])
    return [*drawn, every]


def _loops(found: ImportedRecords) -> list[Section]:
    shown = [_panel(loop) for loop in found.looked.loops]
    if not shown:
        return []
    pictures = [
        loops_picture(
            shown[begin : begin + PANELS],
            f"Loops {begin + 1} to {min(begin + PANELS, len(shown))}" if len(shown) > 1 else "The loop",
        )
        for begin in range(0, len(shown), PANELS)
    ]
    words = [f"Up to {CYCLES} steady cycles of each run, as measured."]
    if len(found.judged.sines) > len(shown):
        words.append(f"Drawn are {len(shown)} of {len(found.judged.sines)} runs, evenly over the campaign.")
    return [Section("Loops", words, (), pictures)]


@singledispatch
def first_look(found: ImportedCampaign) -> dict[str, str] | None:
    """Give what the studio draws of files, with a title and words; None where there is nothing.

    Of records it is a few loops, evenly over the campaign, of results stiffness and loss angle over what was varied.
    """
    raise NotImplementedError(type(found))


@first_look.register
def _(found: ImportedResults) -> dict[str, str] | None:
    sweeps = sweeps_of(found.campaign)
    if not sweeps:
        return None
    figure = sweep_picture(found.campaign, of_phase(found.campaign), sweeps[0])
    return _first_look(f"Stiffness and loss angle of {counted(len(found.campaign.runs), 'test')}", figure)


@first_look.register
def _(found: ImportedRecords) -> dict[str, str] | None:
    shown = found.looked.loops
    if not shown:
        return None
    places = np.unique(np.linspace(0, len(shown) - 1, min(GLANCE, len(shown))).astype(np.intp)).tolist()
    title = f"Loops of {len(places)} of {len(found.judged.sines)} runs" if len(places) > 1 else "The loop"
    return _first_look(title, loops_picture([_panel(shown[place]) for place in places], title, per_row=GLANCE_PER_ROW))


def _first_look(title: str, figure: go.Figure) -> dict[str, str]:
    words = words_of(figure)
    return {
        "title": title,
        "words": words,
        "specification": json.dumps(specification_of(figure.update_layout(title=None))),
    }


def _panel(loop: ShownLoop) -> LoopPanel:
    name = loop.run if len(loop.run) <= LONGEST_NAME_SHOWN else f"{loop.run[:LONGEST_NAME_SHOWN]}…"
    return LoopPanel(f"{name} ({counted(loop.cycles, 'cycle')})", loop.displacement, loop.force, None)


def _overviews(overviews: tuple[Overview, ...], *, timed: bool) -> list[Section]:
    cut = [one for one in overviews if one.cut or len(one.runs) > 1][:MOST_OVERVIEWS]
    if not cut:
        return []
    words = [
        "Files of which parts are in no run, or that hold several: blue is a run, of several with the end of its name; "
        "orange is cut."
    ]
    return [Section("Where the runs lie", words, (), [overview_picture(one, timed=timed) for one in cut])]


def _joined(spans: list[tuple[float, float]], near: float) -> list[tuple[float, float]]:
    """Give spans of time, those joined between which nobody could see a gap."""
    found: list[tuple[float, float]] = []
    for first, last in spans:
        if found and 0 <= first - found[-1][1] < near and len(spans) > MOST_LABELS:
            found[-1] = (found[-1][0], last)
        else:
            found.append((first, last))
    return found


def overview_picture(overview: Overview, *, timed: bool = True) -> go.Figure:
    """Draw a table's displacement over time, or in its order where none was measured; runs and what was cut marked."""
    time = np.repeat(overview.time, 2)
    # where the motion goes down, a stretch begins at its largest value: the line would have a tooth there otherwise
    falls = np.gradient(overview.displacement.mean(axis=1)) < 0 if len(overview.time) > 1 else np.zeros(1, dtype=bool)
    drawn = np.where(falls[:, None], overview.displacement[:, ::-1], overview.displacement)
    figure = go.Figure(
        go.Scatter(x=time, y=drawn.ravel(), mode="lines", line={"color": MEASURED, "width": 1}, name="y")
    )
    near = float(np.ptp(overview.time)) / FINEST
    figure.update_layout(
        shapes=[
            {
                "type": "rect", "xref": "x", "yref": "paper", "x0": first, "x1": last, "y0": 0, "y1": 1,
                "fillcolor": colour, "opacity": 0.18, "line": {"width": 0}, "layer": "below",
            }
            for spans, colour in ((overview.runs, KEPT), (overview.cut, CUT))
            for first, last in _joined([(first, last) for _, first, last in spans], near)
        ]
    )  # fmt: skip
    for name, first, last in overview.runs if 1 < len(overview.runs) <= MOST_LABELS else ():
        figure.add_annotation(
            x=(first + last) / 2, y=1.0, yref="paper", yanchor="bottom", text=name.rpartition("_")[2],
            showarrow=False, font={"size": 10, "color": KEPT},
        )  # fmt: skip
    along = "t / s" if timed else "in the order measured"
    figure.update_xaxes(title_text=along, showticklabels=timed, gridcolor=GRID).update_yaxes(title_text="y / mm")
    return styled(figure, overview.title, height=260).update_layout(showlegend=False)
