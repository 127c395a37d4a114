"""Pictures: measured and computed loops, coefficients over conditions, the falling error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go
from plotly.colors import sample_colorscale
from plotly.subplots import make_subplots

from pipeclamp.pages.page import MEASURED, MODEL, SERIES, styled, with_narrow
from pipeclamp_models.base.arrays import Array

Drawn = npt.NDArray[np.float32]

PANELS_PER_ROW = 4
ALONE = 0.5
"""Share of the width that a loop takes which stands alone."""
ALONE_HEIGHT = 440
PANEL_HEIGHT, NARROW_PANEL_HEIGHT = 250, 200
LEAST_PANEL_WIDTH = 230
FEW = 12
DIGITS = range(3, 7)
LIGHT_BLUES = sample_colorscale("Blues", np.linspace(0.0, 0.6, 7).tolist())
"""Light enough for dark numbers in the cells, six to one at least, also where the page is dark."""
PUBLISHED_BESIDE = "published "
ROOM = 0.03
"""Share of a loop's width that is left beside its turns."""
MOST_OF_HISTORY = 4000
"""Points of a curve over time that are drawn at most."""


@dataclass(frozen=True)
class LoopPanel:
    """One loop: measured and, where there is one, computed force over the displacement.

    Attributes:
        title: what is above the panel.
        y: displacement in mm, shape (n,), closed by the picture.
        measured, computed: force in N, shape (n,) each; None where there is none.
    """

    title: str
    y: Array
    measured: Array | None
    computed: Array | None


def loops_picture(
    panels: Sequence[LoopPanel],
    title: str,
    names: tuple[str, str] = ("measured", "law"),
    per_row: int = PANELS_PER_ROW,
) -> go.Figure:
    """Draw loops, one a panel, measured in grey and computed in red over it, under these names.

    In a narrow window they stand below each other.
    """
    wide = _loops_in(min(per_row, len(panels)), panels, title, names)
    if len(panels) == 1:  # drawn over the whole width, a loop is a line
        wide.update_xaxes(domain=[0.0, ALONE]).update_annotations(x=ALONE / 2)
        wide.update_layout(height=ALONE_HEIGHT, meta=3 * LEAST_PANEL_WIDTH)
    return with_narrow(wide, _loops_in(1, panels, title, names))


def _loops_in(columns: int, panels: Sequence[LoopPanel], title: str, names: tuple[str, str]) -> go.Figure:
    rows = math.ceil(len(panels) / columns)
    figure = make_subplots(
        rows=rows,
        cols=columns,
        subplot_titles=[panel.title for panel in panels],
        horizontal_spacing=0.1,
        vertical_spacing=min(0.12, 0.35 / rows),
    )
    for index, panel in enumerate(panels):
        place = {"row": index // columns + 1, "col": index % columns + 1}
        for force, name, colour, width in (
            (panel.measured, names[0], MEASURED, 4.0),
            (panel.computed, names[1], MODEL, 1.5),
        ):
            if force is not None:
                figure.add_trace(
                    go.Scatter(
                        x=_closed(panel.y), y=_closed(force), mode="lines", name=name, legendgroup=name,
                        showlegend=index == 0, line={"color": colour, "width": width, "simplify": False},
                    ),
                    **place,
                )  # fmt: skip
    figure.update_annotations(font={"size": 12})
    for index, panel in enumerate(panels):
        place = {"row": index // columns + 1, "col": index % columns + 1}
        figure.update_xaxes(range=with_room(panel.y), **place)
    for column in range(1, columns + 1):
        figure.update_xaxes(title_text="y / mm", row=rows, col=column)
    for row in range(1, rows + 1):
        figure.update_yaxes(title_text="F / N", row=row, col=1)
    height = PANEL_HEIGHT if columns > 1 else NARROW_PANEL_HEIGHT
    figure = styled(figure, title, height=90 + height * rows, least_width=LEAST_PANEL_WIDTH * columns)
    return figure.update_layout(margin={"t": 80, "b": 80})


def _closed(samples: Array) -> Drawn:
    """Give a loop closed, in single precision: a picture shows no more, and its page is half as large."""
    return np.append(samples, samples[:1]).astype(np.float32)


def overlay_picture(loops: Sequence[tuple[str, Array, Array]], title: str) -> go.Figure:
    """Draw loops (name, y in mm, force in N) over one another, as the paper's figures 5-8 do."""
    figure = go.Figure(
        [
            go.Scatter(
                x=_closed(y),
                y=_closed(force),
                mode="lines",
                name=name,
                line={"color": shade(index / max(len(loops) - 1, 1))},
            )
            for index, (name, y, force) in enumerate(loops)
        ]
    )
    every = np.concatenate([y for _, y, _ in loops])
    figure.update_xaxes(title_text="y / mm", range=with_room(every)).update_yaxes(title_text="F / N")
    return styled(figure, title)


def with_room(y: Array) -> tuple[float, float]:
    """Give the range of an axis on which a loop's turns are seen whole: Plotly's own ends where lines do."""
    low, high = float(np.nanmin(y)), float(np.nanmax(y))
    room = ROOM * ((high - low) or 1.0)
    return low - room, high + room


def shade(share: float) -> str:
    """Give a colour from blue (0) by purple to red (1): neighbouring conditions get neighbouring colours.

    None is as light as yellow or green, which a white page swallows, or as dark as a dark page.
    """
    return f"hsl({210 + 150 * share:.0f}, 70%, 57%)"


def curves_picture(
    x: str, y: str, curves: Sequence[tuple[str, Sequence[float], Sequence[float], str]], title: str
) -> go.Figure:
    """Draw curves (name, abscissae, ordinates, mode "lines", "markers" or "lines+markers") with axis titles x and y.

    A curve named "published ..." gets the colour of the one without that word, and open markers.
    """
    named = list(dict.fromkeys(name.removeprefix(PUBLISHED_BESIDE) for name, *_ in curves))
    figure = go.Figure(
        [
            go.Scatter(
                x=list(xs), y=list(ys), mode=mode, name=name,
                marker={"symbol": "circle-open" if name.startswith(PUBLISHED_BESIDE) else "circle", "size": 8},
                line={"color": SERIES[named.index(name.removeprefix(PUBLISHED_BESIDE)) % len(SERIES)]},
            )
            for name, xs, ys, mode in curves
        ]
    )  # fmt: skip
    figure.update_xaxes(title_text=x).update_yaxes(title_text=y)
    return styled(figure, title)


def thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Give at most `MOST_OF_HISTORY` points, about: the first, the last and the extremes of each stretch between.

    A sample out of so many would hide peaks, and draw a fast motion as a slow one.
    """
    if time.size <= MOST_OF_HISTORY:
        return time, values
    length = math.ceil(2 * time.size / MOST_OF_HISTORY)
    count = time.size // length
    block = values[: count * length].reshape(count, length)
    base = np.arange(count) * length
    ends = [0, time.size - 1]
    chosen = np.unique(np.concatenate([base + block.argmin(axis=1), base + block.argmax(axis=1), ends]))
    return time[chosen], values[chosen]


def surface_picture(x: str, y: str, xs: Array, ys: Array, level: Array, label: str, title: str) -> go.Figure:
    """Draw a surface as contours with their values.

    Args:
        x, y: axis titles.
        xs, ys: the grid, shapes (n,) and (m,).
        level: shape (m, n).
        label: name and unit of what is drawn.
        title: the picture's title.
    """
    figure = go.Figure(
        go.Contour(
            x=xs, y=ys, z=level, colorscale="Blues", ncontours=14,
            contours={"showlabels": True, "labelfont": {"size": 11}}, colorbar={"title": {"text": label}},
        )
    )  # fmt: skip
    figure.update_xaxes(title_text=x).update_yaxes(title_text=y)
    return styled(figure, title)


def few(values: Array) -> list[str] | Array:
    """Give few values as names of no more digits than tell them apart: cells are then alike in size."""
    if len(values) > FEW:
        return values
    names = ([f"{value:.{digits}g}" for value in values] for digits in DIGITS)
    return next((each for each in names if len(set(each)) == len(values)), values)


def cells_picture(x: str, y: str, xs: Array, ys: Array, level: Array, label: str, title: str) -> go.Figure:
    """Draw positive values as coloured cells, one a point of the grid, the colours by the logarithm.

    Args:
        x, y: axis titles.
        xs, ys: the grid, shapes (n,) and (m,).
        level: shape (m, n); nan where there is none.
        label: unit of what is drawn.
        title: the picture's title.
    """
    low, high = float(np.nanmin(level)), float(np.nanmax(level))
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [step * 10.0**decade for decade in decades for step in (1, 2, 5)]
    ticks = [tick for tick in ticks if low <= tick <= high] or [low, high]
    figure = go.Figure(
        go.Heatmap(
            x=few(xs), y=few(ys), z=np.log10(level), customdata=level, colorscale=LIGHT_BLUES, xgap=1, ygap=1,
            hovertemplate=f"{x} %{{x}}<br>{y} %{{y}}<br>%{{customdata:.4g}} {label}<extra></extra>",
            colorbar={
                "title": {"text": label},
                "tickvals": [math.log10(tick) for tick in ticks],
                "ticktext": [f"{tick:g}" for tick in ticks],
            },
        )
    )  # fmt: skip
    if max(len(xs), len(ys)) <= FEW:
        texts = [[f"{value:.3g}" if math.isfinite(value) else "" for value in row] for row in level.tolist()]
        figure.update_traces(text=texts, texttemplate="%{text}", textfont={"color": "#111111"})
    for values, update in ((xs, figure.update_xaxes), (ys, figure.update_yaxes)):
        if len(values) <= FEW:
            update(type="category")
    figure.update_xaxes(title_text=x).update_yaxes(title_text=y)
    return styled(figure, title)
