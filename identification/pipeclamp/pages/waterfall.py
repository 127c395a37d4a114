"""The falling error: one rung an effect, what it took, and what the best effects would do next."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import plotly.graph_objects as go

from pipeclamp.pages.page import MODEL, SERIES, styled, with_narrow
from pipeclamp_models.law.file import LawFile

RUNG_WIDTH, WIDEST = 160, 1100
"""px of a rung that holds a label of `LONGEST_LABEL`, and of the picture from which on it is drawn so, however many
rungs."""
WIDTH_BESIDE, CHARACTER = 130, 7
"""px beside all rungs, and of a character."""
OF_FORCE, OF_METRICS = "RMS error / % of rms force", "rms log ratio of dW and W / %"
"""What errors of records and of metrics alone are called."""
LONGEST_LABEL = 22
"""Characters of a label beside others."""
MOST_BARS_WITHOUT_UNIT = 3
"""Bars of a rung beside each other between whose numbers there is no room for the unit, which the axis has."""
LINE_HEIGHT = 22
"""px, of a bar where rungs stand below each other."""
USED, LEFT_OUT = "on the tests used", "on left-out conditions"
ESTIMATED = "on left-out conditions, estimated from the fit to all"
"""Another quantity than the error of fits that never saw the conditions: a diagnosis has no time for those."""
COLOURS = {USED: "#9fb3c8", LEFT_OUT: SERIES[0], ESTIMATED: "#5f9bd1"}


@dataclass(frozen=True)
class RungBars:
    """One step of a law's way.

    Attributes:
        label: what was done.
        errors: rms error over rms force after it, by the tests that it is on.
        promised: whether it isn't done yet: what the step would do.
        explained: the share of what is missing that a promised step would take, as the diagnosis tells it.
    """

    label: str
    errors: Mapping[str, float]
    promised: bool = False
    explained: float | None = None


def rungs_of(file: LawFile) -> list[RungBars]:
    """Give the rungs of a law's history."""
    return [
        RungBars(
            step.step, {USED: step.nrmse} | ({} if step.refitted_nrmse is None else {LEFT_OUT: step.refitted_nrmse})
        )
        for step in file.history
    ]


def with_promised(rungs: Sequence[RungBars], now: RungBars, coming: Sequence[RungBars]) -> list[RungBars]:
    """Give a law's way, and what would come next.

    Args:
        rungs: the law's way; its last one is the law as it is.
        now: the law as it is, with its error as the rungs that would come have theirs.
        coming: what would come.
    """
    last = rungs[-1] if rungs else now
    if coming or LEFT_OUT not in last.errors:
        last = replace(last, errors={**last.errors, **now.errors})
    return [*rungs[:-1], last, *coming]


def waterfall_picture(rungs: Sequence[RungBars], scatter: float | None, title: str, axis: str = OF_FORCE) -> go.Figure:
    """Draw the error falling rung by rung, with the scatter that no law can explain as a line.

    In a narrow window the rungs stand below each other.

    Args:
        rungs: in their order.
        scatter: as a share of the rms force, where it is known.
        title: the picture's title.
        axis: the error's name and unit.
    """
    return with_narrow(_side_by_side(rungs, scatter, title, axis), _below_each_other(rungs, scatter, title, axis))


def _side_by_side(rungs: Sequence[RungBars], scatter: float | None, title: str, axis: str) -> go.Figure:
    names = _names(rungs)
    longest = min(LONGEST_LABEL, (WIDEST - WIDTH_BESIDE) // (CHARACTER * max(len(rungs), 1)))
    labels = [
        "<br>".join(
            [*(part for line in _name(index, rungs) for part in _wrapped(line, longest)), *_did(index, rungs, scatter)]
        )
        for index in range(len(rungs))
    ]
    unit = "%" if len(names) < MOST_BARS_WITHOUT_UNIT else ""
    figure = go.Figure(
        [
            go.Bar(
                x=labels,
                y=[100 * rung.errors[name] if name in rung.errors else None for rung in rungs],
                text=[_percent(rung.errors[name], unit) if name in rung.errors else "" for rung in rungs],
                **_look(name, rungs),
            )
            for name in names
        ]
    )
    if scatter is not None:
        figure.add_hline(
            y=100 * scatter, line={"color": MODEL, "dash": "dash"},
            annotation={"text": f"scatter<br>{100 * scatter:.2g}%", "x": 1.0, "xanchor": "left", "yanchor": "middle"},
        )  # fmt: skip
    figure.update_xaxes(tickangle=0, type="category")
    figure.update_yaxes(title_text=axis, rangemode="tozero")
    figure = styled(figure, title, least_width=min(WIDTH_BESIDE + RUNG_WIDTH * len(rungs), WIDEST))
    return figure.update_layout(showlegend=True, margin={"r": 70, "b": 105}, bargap=0.25 if rungs[1:] else 0.75)


def _below_each_other(rungs: Sequence[RungBars], scatter: float | None, title: str, axis: str) -> go.Figure:
    """Draw the rungs from top to bottom: the words of each stand above its bars, as long as they are."""
    names = _names(rungs)
    places: dict[str, list[tuple[float, RungBars]]] = {name: [] for name in names}
    words, below = [], 0.0
    for index, rung in enumerate(rungs):
        for line in filter(None, (*_name(index, rungs), " ".join(_did(index, rungs, scatter)))):
            words.append((below, line))
            below += 0.8
        for name in rung.errors:
            places[name].append((below, rung))
            below += 1.0
        below += 0.6
    figure = go.Figure(
        [
            go.Bar(
                x=[100 * rung.errors[name] for _, rung in there], y=[place for place, _ in there], orientation="h",
                width=0.9, text=[_percent(rung.errors[name]) for _, rung in there],
                **_look(name, [rung for _, rung in there]),
            )
            for name, there in places.items()
        ]
    )  # fmt: skip
    for place, line in words:
        figure.add_annotation(
            x=0, xref="paper", xanchor="left", y=place, yanchor="middle", text=line, showarrow=False, align="left",
            bgcolor="white", borderpad=0,
        )  # fmt: skip
    most = max((error for rung in rungs for error in rung.errors.values()), default=0.0)
    if scatter is not None:
        figure.add_vline(
            x=100 * scatter, line={"color": MODEL, "dash": "dash"},
            annotation={"text": f"scatter {100 * scatter:.2g}%", "y": 1.0, "yanchor": "bottom", "xanchor": "left"},
        )  # fmt: skip
    figure.update_yaxes(range=[below - 0.5, -0.7], visible=False)
    legend = 20 * len(names)
    figure = styled(figure, title, height=round(130 + legend + LINE_HEIGHT * below))
    figure.update_xaxes(title_text=axis, range=[0, 125 * max(most, scatter or 0.0) or 1.0])
    figure.update_yaxes(automargin=False)
    legend_look = {"showlegend": True, "legend": {"traceorder": "normal", "orientation": "v"}}
    return figure.update_layout(margin={"l": 10, "r": 10, "t": 70, "b": 55 + legend}, **legend_look)


def _names(rungs: Sequence[RungBars]) -> list[str]:
    """Give the names of the errors, in the order in which they come."""
    return list(dict.fromkeys(name for rung in rungs for name in rung.errors))


def _look(name: str, rungs: Sequence[RungBars]) -> dict[str, Any]:
    """Give the look of an error's bars; what is promised is hatched."""
    return {
        "name": name,
        "textposition": "outside",
        "cliponaxis": False,
        "marker": {
            "color": COLOURS.get(name, SERIES[0]),
            "pattern": {"shape": ["/" if rung.promised else "" for rung in rungs]},
        },
    }


def _percent(error: float, unit: str = "%") -> str:
    return f"{100 * error:.3g}{unit}"


def _name(index: int, rungs: Sequence[RungBars]) -> list[str]:
    """Give a rung's name, one effect a line, so that the names stand beside each other."""
    label = rungs[index].label
    # a blank keeps those alike apart
    name = label + " " * sum(other.label == label for other in rungs[:index])
    return name.replace(" + ", "\n+ ").replace("or\n+ ", "or + ").split("\n")


def _wrapped(line: str, longest: int) -> list[str]:
    """Give a long line in several, names broken behind an underscore; blanks at its end stay: they keep names apart."""
    words = line.rstrip()
    joined = words.replace("+ ", "+\N{NO-BREAK SPACE}")
    parts = textwrap.wrap(joined, longest, break_long_words=False) if len(words) > longest else [words]
    *first, last = (shorter for part in parts for shorter in _broken(part, longest))
    return [*first, last + line[len(words) :]]


def _broken(name: str, longest: int) -> list[str]:
    """Give a name in lines that are no longer than that, as far as its underscores allow."""
    lines = [""]
    for part in re.findall(r"[^_]*_|[^_]+", name):
        if lines[-1] and len(lines[-1] + part) > longest:
            lines.append("")
        lines[-1] += part
    return lines


def _did(index: int, rungs: Sequence[RungBars], scatter: float | None) -> list[str]:
    """Say what a rung did, in lines.

    A step that was done is told by what it took of the squared error, by the errors that are drawn; one that is
    promised by the share of what is missing that the diagnosis states: another quantity, under another name.
    """
    rung = rungs[index]
    if rung.promised:
        return [] if rung.explained is None else [f"would take {rung.explained:.0%}", "of what is missing"]
    before = rungs[index - 1] if index else None
    shared = [key for key in (LEFT_OUT, *rung.errors) if before and key in rung.errors and key in before.errors]
    if before is None or not shared:
        return []
    floor = (scatter or 0.0) ** 2
    missing, left = (each.errors[shared[0]] ** 2 - floor for each in (before, rung))
    if missing <= 0.0:
        return []
    change = max(left / missing - 1.0, -1.0)
    beyond = ["above scatter"] if scatter else []
    return ["squared error", *beyond, f"{change:+.0%}".replace("-", "\N{MINUS SIGN}")]
