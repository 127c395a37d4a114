"""Reports: sections of words, tables and pictures become one HTML file that opens without a network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from pipeclamp.show.table import Table, cell
from pipeclamp_models.base.files import write_whole
from pipeclamp_system.description.trust_mark import DOUBT

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
INK, GRID = "#1f2933", "#e4e7eb"
MEASURED, MODEL = "#52606d", "#d64545"
"""Measured data is grey and drawn first; the model is red and drawn over it, in every picture."""
SERIES = ("#1c7ed6", "#e8590c", "#2b8a3e", "#9c36b5", "#c2255c", "#0b7285", "#846358", "#495057")

MOST_ROWS = 40
"""Rows up to which a table stands whole on its page; longer ones, a row a run, scroll within a box."""


@dataclass(frozen=True)
class Section:
    """A section of a report: a title, paragraphs, tables and pictures, shown in this order."""

    title: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[go.Figure] = ()


def styled(figure: go.Figure, title: str, height: int = 420, least_width: int = 0) -> go.Figure:
    """Give the figure in the house's look, with its title; in a narrower window than `least_width` px it scrolls."""
    figure.update_layout(
        meta=least_width,
        title={"text": title, "font": {"size": 15}, "x": 0.01, "xanchor": "left"},
        font={"family": FONT, "size": 12, "color": INK},
        colorway=SERIES,
        plot_bgcolor="white",
        paper_bgcolor="white",
        height=height,
        margin={"l": 60, "r": 20, "t": 50, "b": 50},
        legend={"orientation": "h", "yref": "container", "yanchor": "bottom", "y": 0, "x": 0},
        hovermode="closest",
    )
    figure.update_xaxes(gridcolor=GRID, zerolinecolor=GRID, linecolor=INK, ticks="outside", automargin=True)
    figure.update_yaxes(gridcolor=GRID, zerolinecolor=GRID, linecolor=INK, ticks="outside", automargin=True)
    return figure


def doubted(figure: go.Figure) -> go.Figure:
    """Give the figure with the mark of a result that can't be used below its title, where a narrow window shows it."""
    text = f"{figure.layout.title.text}<br><span style='color:{MODEL}'><b>{DOUBT}</b></span>"
    return figure.update_layout(title_text=text, margin={"t": 70})


def render(title: str, subtitle: str, sections: Sequence[Section]) -> str:
    """Give a report as the text of one self-contained HTML file.

    Args:
        title: heading of the page.
        subtitle: one line below it.
        sections: the content.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pipeclamp.pages", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["cell"] = cell
    drawn = [
        [
            (
                figure.to_html(full_html=False, include_plotlyjs=False, div_id=f"figure-{row}-{column}",
                               config={"responsive": True, "displayModeBar": False}),
                figure.layout.meta or 0,
            )
            for column, figure in enumerate(section.figures)
        ]
        for row, section in enumerate(sections)
    ]  # fmt: skip
    return environment.get_template("report.html.jinja").render(
        title=title,
        subtitle=subtitle,
        sections=list(zip(sections, drawn, strict=True)),
        doubt=DOUBT,
        most_rows=MOST_ROWS,
        plotly_script=get_plotlyjs() if any(drawn) else "",
    )


def write_report(path: Path, title: str, subtitle: str, sections: Sequence[Section]) -> None:
    """Write a report, whole or not at all.

    Raises:
        UserError: the folder can't be written.
    """
    write_whole(path, render(title, subtitle, sections))
