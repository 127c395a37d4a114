"""Pictures of a law's error: over conditions, along the loop, by harmonic, along cycles; its scatter beside each."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.page import INK, MEASURED, MODEL, SERIES, styled
from pipeclamp.show.comparison import percent
from pipeclamp_identification.comparison.error_parts import Breakdown
from pipeclamp_models.base.arrays import Array

ERROR, SCATTER = SERIES[0], INK
PANELS_PER_ROW = 3
EXCESSES = (1, 3, 10, 30)
"""Of the error over the scatter, on the colours' scale; 1 is as good as can be."""
CELLS_ACROSS = 22
"""More cells side by side than this have no room for their numbers."""
LABEL = 14
"""Characters of a bar's label on one line."""
REVERSAL = "rgba(82, 96, 109, 0.12)"
"""Colour of the zones near the reversals."""


@dataclass(frozen=True)
class ConditionsMap:
    """Error and scatter over amplitude and frequency, one panel a level of a further condition.

    Attributes:
        A, f, panels: names of the levels, I of the amplitude (mm), J of the frequency (Hz) and P of the further one.
        error: percent, nan where there is no test, shape (P, I, J).
        scatter: percent, nan where it isn't known, same shape.
        rows: what stands in the amplitude's place, with its unit, where that is something else.
    """

    A: Sequence[str]
    f: Sequence[str]
    panels: Sequence[str]
    error: Array
    scatter: Array
    rows: str = "A / mm"


def conditions_picture(conditions: ConditionsMap, title: str) -> go.Figure:
    """Draw the map: rows are amplitudes, columns frequencies; the worst cell is framed.

    Colours tell the error over the scatter, alike on all pages; the bare error only where no scatter is known.
    """
    panels, across = len(conditions.panels), len(conditions.f)
    classes = any(" to " in label for label in conditions.f)
    columns = min(panels, max(1, CELLS_ACROSS // across))
    rows = math.ceil(panels / columns)
    height = 70 + 50 * max(len(conditions.A), 3)
    figure = make_subplots(
        rows=rows,
        cols=columns,
        shared_yaxes=True,
        subplot_titles=conditions.panels,
        horizontal_spacing=min(0.02, 0.2 / columns),
        vertical_spacing=(90 if classes else 75) / (height * rows) if rows > 1 else 0.0,
    )
    places = [{"row": panel // columns + 1, "col": panel % columns + 1} for panel in range(panels)]
    level, scale = _levels(conditions)
    for panel, place in enumerate(places):
        figure.add_trace(
            go.Heatmap(
                z=level[panel], customdata=conditions.error[panel],
                x=_ticks(conditions.f), y=list(conditions.A), coloraxis="coloraxis",
                text=_cell_texts(conditions.error[panel], conditions.scatter[panel]), texttemplate="%{text}",
                hovertemplate=f"{conditions.rows} %{{y}}, f / Hz %{{x}}: %{{customdata:.4g}}%<extra></extra>",
                hoverongaps=False,
            ),
            **place,
        )  # fmt: skip
        if panel >= panels - columns:
            figure.update_xaxes(title_text="f / Hz", **place)
    worst, at_A, at_f = (int(at) for at in np.unravel_index(np.nanargmax(conditions.error), conditions.error.shape))
    figure.add_shape(
        type="rect", x0=at_f - 0.5, x1=at_f + 0.5, y0=at_A - 0.5, y1=at_A + 0.5,
        line={"color": INK, "width": 3}, **places[worst],
    )  # fmt: skip
    figure.update_xaxes(type="category", tickangle=0).update_yaxes(type="category").update_yaxes(
        title_text=conditions.rows, col=1
    )
    cell = 56 if classes else 48
    figure = styled(figure, title, height=80 + height * rows, least_width=170 + cell * columns * across)
    return figure.update_layout(coloraxis=scale, margin={"t": 80})


def _levels(conditions: ConditionsMap) -> tuple[Array, dict[str, Any]]:
    """Give what the cells' colours tell, shape (P, I, J), and their scale."""
    error, scatter = conditions.error, conditions.scatter
    if np.isfinite(scatter[np.isfinite(error)]).all() and np.nanmin(scatter, initial=1.0) > 0.0:
        ticks = {"tickvals": [math.log10(excess) for excess in EXCESSES], "ticktext": [f"{one}" for one in EXCESSES]}
        bar = {"title": {"text": "error<br>over scatter"}, **ticks}
        top = math.log10(EXCESSES[-1])
        return np.log10(error / scatter), {"colorscale": "YlOrRd", "cmin": 0.0, "cmax": top, "colorbar": bar}
    top = float(np.nanmax(error))
    bar = {"title": {"text": "error / %"}}
    return error, {"colorscale": "YlOrRd", "cmin": 0.0, "cmax": top, "colorbar": bar}


def _ticks(labels: Sequence[str]) -> list[str]:
    """Give labels of classes on two lines, and long ones on several, so that they stand beside each other."""
    return [
        textwrap.fill(label.replace(" to ", "\nto "), LABEL, replace_whitespace=False).replace("\n", "<br>")
        for label in labels
    ]


def _cell_texts(error: Array, scatter: Array) -> list[list[str]]:
    def text(value: float, noise: float) -> str:
        if not math.isfinite(value):
            return ""
        below = f"<br>({noise:.2g})" if math.isfinite(noise) else ""
        return f"{value:.3g}{below}"

    return [[text(*cell) for cell in zip(*rows, strict=True)] for rows in zip(error, scatter, strict=True)]


@dataclass(frozen=True)
class ErrorBars:
    """Errors of parts, and their scatter.

    Attributes:
        title: what is above the panel.
        axis: what the parts are.
        labels: of the parts, or where they lie along the axis.
        error, scatter: percent, None where there is none; scatter alone is None where it isn't known at all.
    """

    title: str
    axis: str
    labels: Sequence[str] | Sequence[float]
    error: Sequence[float | None]
    scatter: Sequence[float | None] | None


def bars_of(title: str, axis: str, parts: Breakdown, *, short: bool = False) -> ErrorBars:
    """Give a breakdown as bars; `short` leaves the word cycle out of its labels."""
    labels = [part.label for part in parts.parts]
    if short:
        labels = [label.removeprefix("cycles ").removeprefix("cycle ") for label in labels]
    known = any(part.noise_nrmse is not None for part in parts.parts)
    scatter = [percent(part.noise_nrmse) for part in parts.parts]
    return ErrorBars(title, axis, labels, [percent(part.nrmse) for part in parts.parts], scatter if known else None)


def error_bars(panels: Sequence[ErrorBars], title: str) -> go.Figure:
    """Draw panels of bars for the errors, with a mark for the scatter in each."""
    columns = min(PANELS_PER_ROW, len(panels))
    rows = math.ceil(len(panels) / columns)
    height = 110 + 240 * rows
    figure = make_subplots(
        rows=rows,
        cols=columns,
        subplot_titles=[panel.title for panel in panels],
        horizontal_spacing=0.06,
        vertical_spacing=90 / (height - 160),
    )
    for index, panel in enumerate(panels):
        row, column = index // columns + 1, index % columns + 1
        shown = replace(panel, labels=_ticks([str(label) for label in panel.labels]))
        _add_bars(figure, shown, row, column, named=index == 0)
        figure.update_xaxes(title_text=panel.axis, type="category", tickangle=0, row=row, col=column)
    highest = max((error for panel in panels for error in panel.error if error is not None), default=1.0)
    figure.update_yaxes(range=[0, 1.05 * highest]).update_yaxes(title_text="error / %", col=1)
    return _with_room(styled(figure, title, height=height, least_width=330 * columns))


def _add_bars(figure: go.Figure, panel: ErrorBars, row: int, column: int, *, named: bool) -> None:
    figure.add_trace(
        go.Bar(
            x=list(panel.labels), y=list(panel.error), name="error", marker={"color": ERROR},
            legendgroup="error", showlegend=named,
        ),
        row=row, col=column,
    )  # fmt: skip
    if panel.scatter is not None:
        figure.add_trace(
            go.Scatter(
                x=list(panel.labels), y=list(panel.scatter), name="of it scatter, which no law can explain",
                mode="markers", legendgroup="scatter", showlegend=named,
                marker={"symbol": "line-ew", "size": 16, "line": {"color": SCATTER, "width": 3}},
            ),
            row=row, col=column,
        )  # fmt: skip


def _with_room(figure: go.Figure) -> go.Figure:
    """Leave room above for panels' titles, and gaps between bars."""
    return figure.update_layout(margin={"t": 80, "b": 80}, bargap=0.25)


def cycles_picture(bars: ErrorBars, measured: Array, computed: Array, title: str) -> go.Figure:
    """Draw the error along cycles, and the force's amplitude, measured and by the law.

    Args:
        bars: error and scatter of each cycle, or of groups of them.
        measured, computed: amplitude of the first harmonic in each cycle, percent of its mean over the record, shape
            (n,).
        title: the picture's title.
    """
    figure = make_subplots(
        rows=1, cols=2, horizontal_spacing=0.1, subplot_titles=[bars.title, "force amplitude, % of its mean"]
    )
    _add_bars(figure, bars, 1, 1, named=True)
    number = np.arange(1, len(measured) + 1)
    for amplitude, name, colour, width in ((measured, "measured", MEASURED, 4.0), (computed, "law", MODEL, 1.5)):
        trace = go.Scatter(
            x=number, y=amplitude, name=name, mode="lines+markers", line={"color": colour, "width": width}
        )
        figure.add_trace(trace, row=1, col=2)
    figure.update_xaxes(title_text=bars.axis).update_xaxes(type="category", row=1, col=1)
    figure.update_yaxes(title_text="error / %", rangemode="tozero", row=1, col=1)
    return _with_room(styled(figure, title, height=380, least_width=640))


@dataclass(frozen=True)
class LoopInTime:
    """One run's force along its cycle.

    Attributes:
        name: the run.
        phase: degrees after the largest displacement, shape (n,).
        measured, computed: N, shape (n,) each.
    """

    name: str
    phase: Array
    measured: Array
    computed: Array


def along_loop_picture(bars: ErrorBars, loop: LoopInTime, near_deg: float, title: str) -> go.Figure:
    """Draw one run's force over the cycle, measured and by the law, and below it the error of all runs by phase.

    Args:
        bars: error and scatter, labelled by phase in degrees.
        loop: the run above.
        near_deg: how many degrees before and after a reversal are shaded.
        title: the picture's title.
    """
    figure = make_subplots(
        rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.12, subplot_titles=[loop.name, bars.title]
    )
    for force, name, colour, width in (
        (loop.measured, "measured", MEASURED, 4.0),
        (loop.computed, "law", MODEL, 1.5),
    ):
        trace = go.Scatter(
            x=loop.phase, y=force, mode="lines", name=name, line={"color": colour, "width": width, "simplify": False}
        )
        figure.add_trace(trace, row=1, col=1)
    _add_bars(figure, bars, 2, 1, named=True)
    for reversal in (0.0, 180.0, 360.0):
        for row in (1, 2):
            figure.add_vrect(
                x0=max(reversal - near_deg, 0.0), x1=min(reversal + near_deg, 360.0),
                fillcolor=REVERSAL, line_width=0, layer="below", row=row, col=1,
            )  # fmt: skip
    for middle, branch in ((90.0, "unloading"), (270.0, "loading")):
        figure.add_annotation(
            x=middle, y=1.0, yref="y domain", yanchor="top", text=branch, showarrow=False, row=1, col=1
        )
    figure = styled(figure, title, height=560)
    figure.update_xaxes(range=[0, 360], tickvals=list(range(0, 361, 45)))
    figure.update_xaxes(title_text=bars.axis, row=2, col=1)
    figure.update_yaxes(title_text="F / N", row=1, col=1)
    figure.update_yaxes(title_text="error / %", rangemode="tozero", row=2, col=1)
    return _with_room(figure)


@dataclass(frozen=True)
class HarmonicLevels:
    """Harmonics in phase or in quadrature: force, measured and by the law, and the error with its scatter.

    Attributes:
        title: what is above the panels.
        order: of the harmonics, shape (n,).
        measured, computed: rms over all runs, percent of the rms force, same shape.
        error, scatter: likewise; scatter None where it isn't known.
    """

    title: str
    order: Array
    measured: Array
    computed: Array
    error: Array
    scatter: Array | None


def harmonics_picture(levels: Sequence[HarmonicLevels], title: str) -> go.Figure:
    """Draw harmonics: above the force, measured and by the law, below the error with its scatter."""
    figure = make_subplots(
        rows=2, cols=len(levels), shared_yaxes=True, vertical_spacing=0.12, horizontal_spacing=0.04,
        subplot_titles=[level.title for level in levels],
    )  # fmt: skip
    for column, level in enumerate(levels, 1):
        for force, name, colour, symbol, size in (
            (level.measured, "measured", MEASURED, "circle", 11),
            (level.computed, "law", MODEL, "x-thin", 8),
        ):
            figure.add_trace(
                go.Scatter(
                    x=level.order, y=force, mode="markers", name=name, legendgroup=name, showlegend=column == 1,
                    marker={"color": colour, "symbol": symbol, "size": size, "line": {"color": colour, "width": 2}},
                ),
                row=1, col=column,
            )  # fmt: skip
        scatter = None if level.scatter is None else level.scatter.tolist()
        bars = ErrorBars("", "harmonic", level.order.tolist(), level.error.tolist(), scatter)
        _add_bars(figure, bars, 2, column, named=column == 1)
        figure.update_xaxes(title_text="harmonic", row=2, col=column)
    figure = styled(figure, title, height=600, least_width=760)
    figure.update_xaxes(dtick=2, range=[-0.7, 0.7 + max(float(level.order[-1]) for level in levels)])
    figure.update_yaxes(type="log", dtick=1, exponentformat="none", row=1)
    figure.update_yaxes(title_text="force / %", row=1, col=1)
    figure.update_yaxes(title_text="error / %", rangemode="tozero", row=2, col=1)
    return _with_room(figure)
