"""Reports: sections of words, tables and pictures become one HTML file that opens without a network."""

from __future__ import annotations

import datetime
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import jinja2
import plotly.graph_objects as go

from pipeclamp.pages.alternative import words_of
from pipeclamp.show.report_name import refuse_report_name
from pipeclamp.show.table import Table, cell
from pipeclamp_models.base.files import write_whole
from pipeclamp_system.description.trust_mark import DOUBT

if TYPE_CHECKING:
    from pipeclamp_models.realise.reading.text import Statement

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
INK, GRID = "#1f2933", "#e4e7eb"
MEASURED, MODEL = "#52606d", "#d64545"
"""Measured data is grey and drawn first; the model is red and drawn over it, in every picture."""
SERIES = ("#1c7ed6", "#e8590c", "#2b8a3e", "#9c36b5", "#c2255c", "#0b7285", "#846358", "#495057")

HALF = 520
"""px: pictures that need no more stand side by side."""
MOST_ROWS = 40
"""Rows up to which a table stands whole on its page; longer ones, a row a run, scroll within a box."""


@dataclass(frozen=True)
class Card:
    """Words with their picture beside them."""

    title: str
    paragraphs: Sequence[str]
    figure: go.Figure


@dataclass(frozen=True)
class Section:
    """A section of a report, shown in the order of its parts.

    Attributes:
        title: its heading.
        paragraphs: sentences.
        tables: tables.
        figures: pictures.
        command: the shell line to run next, ready to be copied.
        explorer: runs to be picked and drawn, as `explored` gives them.
        cards: words with a picture each.
        formulas: shown before the sentences, which may say what stands in them.
    """

    title: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[go.Figure] = ()
    command: str = ""
    explorer: Mapping[str, Any] | None = None
    cards: Sequence[Card] = ()
    formulas: Sequence[Statement] = ()


DIGITS = ((1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 8), (1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9))
"""With which the labels of a logarithmic axis begin: of a wide one, of narrower ones."""
FEWEST_LABELS = 4
"""That should stand on it."""


def log_ticks(values: Iterable[float]) -> list[float]:
    """Give labels for a logarithmic axis that shows these values: all powers, so that it may be moved, too."""
    known = [value for value in values if math.isfinite(value) and value > 0]
    low, high = (min(known), max(known)) if known else (1.0, 1.0)
    for digits in DIGITS:
        ticks = [float(f"{digit}e{power}") for power in range(-6, 9) for digit in digits]
        if sum(low <= tick <= high for tick in ticks) >= FEWEST_LABELS:
            break
    return ticks


def log_axis(values: Iterable[float]) -> dict[str, Any]:
    """Give a logarithmic axis that shows these values, with whole numbers: Plotly writes a 2 for 0.2, 2 and 20."""
    ticks = log_ticks(values)
    return {"type": "log", "tickmode": "array", "tickvals": ticks, "ticktext": [f"{one:g}" for one in ticks]}


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


@dataclass(frozen=True)
class Drawn:
    """A picture as the page holds it.

    Attributes:
        specification: what Plotly draws.
        alternative: what it shows in words.
        least_width: px, below which it scrolls.
        wide: whether it takes the whole width of the page.
    """

    specification: str
    alternative: str
    least_width: int
    wide: bool


def with_narrow(figure: go.Figure, narrow: go.Figure) -> go.Figure:
    """Give the figure with another one that takes its place where the window is narrower than its least width.

    Where that draws the same data otherwise, the page holds them once.
    """
    instead = specification_of(narrow)
    if instead["data"] == specification_of(figure)["data"]:
        del instead["data"]
    return figure.update_layout(meta={"least_width": figure.layout.meta, "narrow": instead})


def specification_of(figure: go.Figure) -> dict[str, Any]:
    """Give what Plotly draws of a figure, and what page.js picks by the width that it has."""
    specification: dict[str, Any] = json.loads(figure.to_json())
    # it repeats Plotly's own look in each picture
    specification["layout"].pop("template", None)
    meta = specification["layout"].pop("meta", None)
    return specification | (meta if isinstance(meta, dict) else {})


def least_width(figure: go.Figure) -> int:
    """Give the width in px below which a figure scrolls; none where another takes its place."""
    meta = figure.layout.meta
    return 0 if meta is None or isinstance(meta, dict) else int(meta)


def drawn_of(figure: go.Figure) -> Drawn:
    """Give a picture as a page holds it."""
    meta = figure.layout.meta
    wide = (meta["least_width"] if isinstance(meta, dict) else meta or 0) > HALF
    return Drawn(_for_script(specification_of(figure)), words_of(figure), least_width(figure), wide)


def _for_script(content: Mapping[str, Any]) -> str:
    """Give JSON that can't end the script element that holds it."""
    return json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


@lru_cache
def asset(name: str) -> str:
    """Give the text of a file beside this module."""
    return resources.files("pipeclamp.pages").joinpath(name).read_text(encoding="utf-8")


def templates_of(package: str) -> jinja2.Environment:
    """Give the templates of a package's folder of that name: what they are given is escaped, and all there."""
    return jinja2.Environment(
        loader=jinja2.PackageLoader(package, "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


class Report(NamedTuple):
    """What a page shows: its title, one line below it, and its sections."""

    title: str
    subtitle: str
    sections: Sequence[Section]


def render(title: str, subtitle: str, sections: Sequence[Section], made: str = "") -> str:
    """Give a report as the text of one self-contained HTML file.

    Args:
        title: heading of the page.
        subtitle: one line below it.
        sections: the content.
        made: when, by which version and by which command, at its foot.
    """
    environment = templates_of("pipeclamp.pages")
    environment.filters["cell"] = cell
    drawn = [[drawn_of(figure) for figure in section.figures] for section in sections]
    cards = [[(card, drawn_of(card.figure)) for card in section.cards] for section in sections]
    explored = [_for_script(section.explorer) if section.explorer else "" for section in sections]
    scripts = [asset("templates/page.js")]
    if any(explored):
        scripts.append(asset("templates/explorer.js"))
    return environment.get_template("report.html.jinja").render(
        title=title,
        subtitle=subtitle,
        sections=list(zip(sections, drawn, cards, explored, strict=True)),
        doubt=DOUBT,
        most_rows=MOST_ROWS,
        made=made,
        style=asset("templates/page.css"),
        plotly=asset("plotly/plotly-cartesian.min.js") if any(drawn) or any(cards) or any(explored) else "",
        scripts=scripts,
    )


def write_report(path: Path, title: str, subtitle: str, sections: Sequence[Section], command: str = "") -> None:
    """Write a report, whole or not at all.

    Args:
        path: the file, .html.
        title, subtitle, sections: as for `render`.
        command: the shell line that makes it again, where there is one.

    Raises:
        UserError: the name isn't that of a page, or the folder can't be written.
    """
    refuse_report_name(path)
    by = f": {command}" if command else ""
    made = f"Made on {datetime.date.today().isoformat()} by pipeclamp {version('pipeclamp')}{by}"
    write_whole(path, render(title, subtitle, sections, made))
