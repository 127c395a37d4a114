"""The report of a frequency response: curves with their unstable branches, co-simulations as dots."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby

import plotly.graph_objects as go

from pipeclamp.pages.page import SERIES, Report, Section, log_axis, styled
from pipeclamp.pages.system.bands import add_band, add_band_key, bands_section
from pipeclamp.pages.system.cosim import answer_section
from pipeclamp.show.table import Table
from pipeclamp_identification.workflow.next_step import NextStep
from pipeclamp_system.bands.response_bands import ResponseBands
from pipeclamp_system.description.trust_mark import DOUBT
from pipeclamp_system.response.curves import Curve, FrequencyResponse, label
from pipeclamp_system.response.dots import Dot
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady.states import SteadyState, amplitudes_of

WIDE = 4.0
"""Levels that differ by more than this factor are drawn on a logarithmic axis."""

WORDS = "Half the peak-to-peak displacement; the stronger a line's colour, the higher its level. Dotted: unstable."

BEYOND = "a clamp's law beyond its data"
BEYOND_COLOUR = "#f08c00"

IN_TIME = "found in time"

TRUSTED_MARK = {"size": 7, "line": {"color": "white", "width": 1}}
DOUBTFUL_MARK = {"size": 9, "symbol": "x-thin-open", "line": {"width": 2}}
"""Marks of co-simulations."""


def response_page(response: FrequencyResponse, system: str, bands: ResponseBands | None, following: NextStep) -> Report:
    """Give the page of the frequency response of a system, by its file's name."""
    return Report(f"Frequency response: {response.name}", system, response_sections(response, bands, following))


def response_sections(
    response: FrequencyResponse, bands: ResponseBands | None = None, following: NextStep | None = None
) -> list[Section]:
    """Give the report of a frequency response; the first section holds the summary in words, and what comes next, the
    second one its bands."""
    pictures = [response_picture(response, index, bands) for index in range(len(response.points))]
    header = (
        "clamps", "level", "f / Hz", *(f"{name} / mm" for name in response.points), "off the curve",
        "curve leaves out", "step / ms", "remark",
    )  # fmt: skip
    rows: list[tuple[str | float | None, ...]] = [
        (
            "as stated" if dot.temperature is None else f"{dot.temperature:g} °C",
            dot.level, dot.frequency, *dot.amplitudes,
            f"{dot.difference:.2%}", None if dot.truncated is None else f"{dot.truncated:.2%}", 1e3 * dot.step,
            _remark(dot),
        )
        for dot in response.dots
    ]  # fmt: skip
    tables = [Table(header, rows, "co-simulations, and how far they are off the nearest stable branch")] if rows else []
    return [
        answer_section(response_summary(response).splitlines(), following),
        *([bands_section(bands)] if bands else []),
        Section("Frequency response", (WORDS,), (), pictures),
        *([Section("Co-simulations", (), tables)] if tables else []),
    ]


def _remark(dot: Dot) -> str:
    """Give what a table says besides of a co-simulation."""
    remarks = {"not settled": not dot.settled, "differs from cycle to cycle": not dot.repeats, DOUBT: not dot.trusted}
    told = [words for words, said in remarks.items() if said]
    return ", ".join(told) or "–"


def response_picture(response: FrequencyResponse, point: int, bands: ResponseBands | None = None) -> go.Figure:
    """Draw all curves at one point (its index), temperatures by colour, their bands, the co-simulations on them."""
    figure = go.Figure()
    temperatures = list(dict.fromkeys(curve.temperature for curve in response.curves))
    colours = {temperature: SERIES[index % len(SERIES)] for index, temperature in enumerate(temperatures)}
    for curve, banded in zip(response.curves, bands.curves if bands else (), strict=False):
        for followed, of_points in zip(curve.pieces, banded.pieces, strict=True):
            add_band(figure, followed, of_points[point], colours[curve.temperature])
    levels = [curve.level for curve in response.curves]
    for curve in response.curves:
        _add_curve(figure, curve, point, colours[curve.temperature], 0.45 + 0.55 * curve.level / max(levels))
        _add_dots(figure, response, curve, point, colours[curve.temperature])
    _add_legend(figure, response, point, colours)
    if bands:
        add_band_key(figure, f"{bands.per_cent:g}% band")
    wide = max(levels) > WIDE * min(levels)
    figure.update_xaxes(title_text="f / Hz")
    amplitudes = [amplitudes_of(state)[point] for curve in response.curves for state in curve.states]
    figure.update_yaxes(title_text="amplitude / mm", **(log_axis(amplitudes) if wide else {}))
    return styled(figure, f"Displacement at {response.points[point]}", height=480)


def _add_curve(figure: go.Figure, curve: Curve, point: int, colour: str, opacity: float) -> None:
    """Add a curve at a point: where its laws are beyond their data, what was followed, and what was found in time."""
    for piece in beyond_pieces(curve):
        figure.add_scatter(
            x=[state.frequency for state in piece], y=[amplitudes_of(state)[point] for state in piece],
            mode="lines", name=BEYOND, showlegend=False, hoverinfo="skip",
            line={"color": BEYOND_COLOUR, "width": 7}, opacity=0.3,
        )  # fmt: skip
    for stable, piece in pieces(curve):
        figure.add_scatter(
            x=[state.frequency for state in piece], y=[amplitudes_of(state)[point] for state in piece],
            mode="lines", name=label(curve.temperature, curve.level), showlegend=False,
            line={"color": colour, "width": 1.6, "dash": "solid" if stable else "dot"}, opacity=opacity,
        )  # fmt: skip
    for way in in_time(curve, point):
        figure.add_scatter(
            x=[frequency for frequency, _ in way], y=[amplitude for _, amplitude in way], mode="lines+markers",
            name=label(curve.temperature, curve.level), showlegend=False, marker={"color": colour, "size": 4},
            line={"color": colour, "width": 1.6, "dash": "dash"}, opacity=opacity,
        )  # fmt: skip


def _add_dots(figure: go.Figure, response: FrequencyResponse, curve: Curve, point: int, colour: str) -> None:
    """Add the co-simulations on a curve."""
    for trusted, mark in ((True, TRUSTED_MARK), (False, DOUBTFUL_MARK)):
        own = [
            dot for dot in response.dots
            if (dot.temperature, dot.level, dot.trusted) == (curve.temperature, curve.level, trusted)
        ]  # fmt: skip
        if own:
            figure.add_scatter(
                x=[dot.frequency for dot in own], y=[dot.amplitudes[point] for dot in own], mode="markers",
                name=label(curve.temperature, curve.level), showlegend=False, marker={"color": colour, **mark},
            )  # fmt: skip


def _add_legend(
    figure: go.Figure, response: FrequencyResponse, point: int, colours: Mapping[float | None, str]
) -> None:
    """Add what the legend names: temperatures, and the kinds of curves and dots that there are."""
    for temperature, colour in colours.items():
        name = "clamps as stated" if temperature is None else f"{temperature:g} °C"
        figure.add_scatter(x=[None], y=[None], mode="lines", name=name, line={"color": colour, "width": 2})
    if any(any(state.beyond) for curve in response.curves for state in curve.states):
        line = {"color": BEYOND_COLOUR, "width": 7}
        figure.add_scatter(x=[None], y=[None], mode="lines", name=BEYOND, line=line, opacity=0.3)
    if any(in_time(curve, point) for curve in response.curves):
        figure.add_scatter(
            x=[None], y=[None], mode="lines+markers", name=IN_TIME, marker={"color": "#777777", "size": 4},
            line={"color": "#777777", "width": 1.6, "dash": "dash"},
        )  # fmt: skip
    for trusted, mark in ((True, TRUSTED_MARK), (False, DOUBTFUL_MARK)):
        if any(dot.trusted == trusted for dot in response.dots):
            name = "co-simulation" if trusted else "co-simulation, not to be trusted"
            figure.add_scatter(x=[None], y=[None], mode="markers", name=name, marker={"color": "#777777", **mark})


def beyond_pieces(curve: Curve) -> list[list[SteadyState]]:
    """Give the pieces of a curve on which a clamp's law is used beyond its data."""
    runs = (groupby(followed, key=lambda state: any(state.beyond)) for followed in curve.pieces)
    return [list(group) for run in runs for beyond, group in run if beyond]


def in_time(curve: Curve, point: int) -> list[list[tuple[float, float]]]:
    """Give frequency (Hz) and amplitude (mm) at a point of what was found in time, piece by piece; of a motion that
    isn't steady its smallest and its largest cycle."""
    steady = [[(state.frequency, amplitudes_of(state)[point]) for state in way] for way in curve.followed.in_time]
    unsteady = [[(one.frequency, end[point]) for end in (one.low, one.high)] for one in curve.followed.unsteady]
    return steady + unsteady


def pieces(curve: Curve) -> list[tuple[bool, list[SteadyState]]]:
    """Cut a curve into stable and unstable pieces that share their ends; a gap in it stays open."""
    cut: list[tuple[bool, list[SteadyState]]] = []
    for followed in curve.pieces:
        before: list[SteadyState] = []
        for stable, group in groupby(followed, key=lambda state: state.stable or state.neutral):
            piece = [*before[-1:], *group]
            cut.append((stable, piece))
            before = piece
    return cut
