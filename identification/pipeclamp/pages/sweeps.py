"""Metrics drawn over what was varied: a panel for each, a curve for each setting of what else varies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.page import SERIES, Section, log_axis, log_ticks, styled, with_narrow
from pipeclamp.pages.pictures import shade
from pipeclamp.show.metrics import STORED_AND_LOST, axis_of_quantity, setting, stored_and_lost
from pipeclamp_identification.metrics_only.campaign import MetricCampaign
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.metrics_only.sweeps import Curve, Sweep, sweeps_of, values_of
from pipeclamp_models.base.arrays import Array

MOST_NAMED = 12
"""Curves that a legend names; more are told by a scale of colours."""
PANEL_WIDTH = 300
PANEL_HEIGHT, NARROW_PANEL_HEIGHT = 330, 250
LEGEND_LINE = 29
"""px of names in a legend."""
NAMES_BESIDE = 4
"""Names that surely stand beside each other."""
WIDE_RANGE = 8.0
"""Ratio of the largest to the smallest from which on an axis goes in decades."""
MOST_FINE_DECADES = 1.7
"""Decades up to which an axis shows 1, 2 and 5 of each."""
IN_DECADES = ("frequency_Hz", "amplitude_mm")
SCALE = [(share, shade(share)) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]


@dataclass(frozen=True, eq=False)
class Measure:
    """What a panel shows: its name and unit, and the value of each test, shape (R,); nan where there is none.

    `of_law`: what a law has in its place, shape (R,), where one is held against the tests.
    """

    axis: str
    values: Array
    of_law: Array | None = None


def of_phase(campaign: MetricCampaign) -> list[Measure]:
    """Give storage and loss stiffness and loss angle."""
    columns = np.array([stored_and_lost(run) for run in campaign.runs], dtype=np.float64).T
    return [Measure(axis, values) for axis, values in zip(STORED_AND_LOST, columns, strict=True)]


def of_energy(campaign: MetricCampaign) -> list[Measure]:
    """Give stiffness and loss factor."""
    return [
        Measure("k / N/mm", np.array([run.stiffness for run in campaign.runs])),
        Measure("eta", np.array([run.loss_factor for run in campaign.runs])),
    ]


def of_energy_and_law(comparison: MetricComparison) -> list[Measure]:
    """Give stiffness and loss factor, and what the law has in their place."""
    dissipated, elastic = comparison.logs.T
    stiffness, loss_factor = of_energy(comparison.campaign)
    return [
        replace(stiffness, of_law=stiffness.values * np.exp(-elastic)),
        replace(loss_factor, of_law=loss_factor.values * np.exp(elastic - dissipated)),
    ]


def sweep_sections(campaign: MetricCampaign, measures: Sequence[Measure]) -> list[Section]:
    """Give a section for each quantity that was varied; none where nothing was."""
    beside = ["Dots are measured, crosses the law's."] if any(one.of_law is not None for one in measures) else []
    return [
        Section(
            f"Against {axis_of_quantity(sweep.quantity)}",
            [*beside, *_words(sweep)],
            (),
            [sweep_picture(campaign, measures, sweep)],
        )
        for sweep in sweeps_of(campaign)
    ]


def _words(sweep: Sweep) -> list[str]:
    """Say what a picture doesn't show by itself."""
    if sweep.drifting:
        return [
            f"{_symbols(sweep.drifting)} moves from test to test, without settings that come again: no line joins them."
        ]
    scale = _scale_of(sweep)
    others = [name for name in dict.fromkeys(name for curve in sweep.curves for name, _ in curve.held) if name != scale]
    return [f"Curves of one colour differ in {_symbols(others)}."] if scale and others else []


def _symbols(quantities: Sequence[str]) -> str:
    return " and ".join(axis_of_quantity(name).split(" / ")[0] for name in quantities)


def sweep_picture(campaign: MetricCampaign, measures: Sequence[Measure], sweep: Sweep) -> go.Figure:
    """Draw measures over a quantity, side by side; in a narrow window below each other."""
    drawn = [
        _panels(campaign, measures, sweep, columns) for columns in dict.fromkeys((len(measures), 1))
    ]  # fmt: skip
    return with_narrow(*drawn) if len(drawn) > 1 else drawn[0]


def _panels(campaign: MetricCampaign, measures: Sequence[Measure], sweep: Sweep, columns: int) -> go.Figure:
    rows = math.ceil(len(measures) / columns)
    spacing: dict[str, Any] = {"vertical_spacing": 0.14} if rows > 1 else {"horizontal_spacing": 0.09}
    figure = make_subplots(rows=rows, cols=columns, **spacing)
    scale = _scale_of(sweep)
    coloured = _Coloured.of(scale, values_of(campaign)[scale]) if scale else None
    # stiffness in phase and out of it is compared: both in decades, or none
    stiff = [measure for measure in measures if _is_stiffness(measure)]
    in_decades = stiff if any(_is_wide(measure.values) for measure in stiff) else []
    for index, measure in enumerate(measures):
        place = {"row": index // columns + 1, "col": index % columns + 1}
        for number, curve in enumerate(sweep.curves):
            rows_of = list(curve.rows)
            look = _look(sweep, number, rows_of, coloured)
            trace = go.Scatter(
                x=sweep.values[rows_of], y=measure.values[rows_of], name=_name(curve), legendgroup=str(number),
                showlegend=index == 0 and scale is None and len(sweep.curves) > 1,
                text=[campaign.runs[row].name for row in rows_of],
                hovertemplate="%{text}<br>%{x:.4g}, %{y:.4g}<extra></extra>", **look,
            )  # fmt: skip
            if measure.of_law is not None:
                law = go.Scatter(trace).update(
                    y=measure.of_law[rows_of], showlegend=False, marker={"symbol": "x-thin-open", "size": 7},
                    hovertemplate="%{text}, law<br>%{x:.4g}, %{y:.4g}<extra></extra>",
                )  # fmt: skip
                trace.update(mode="markers")
                figure.add_trace(law, **place)
            figure.add_trace(trace, **place)
        axis = _decades(sweep.values) if sweep.quantity in IN_DECADES and _is_wide(sweep.values) else {}
        figure.update_xaxes(title_text=axis_of_quantity(sweep.quantity), **axis, **place)
        axis = _decades(measure.values) if measure in in_decades else {"rangemode": "tozero"}
        figure.update_yaxes(title_text=measure.axis, **axis, **place)
    named = len(sweep.curves) if scale is None and len(sweep.curves) > 1 else 0
    # in a narrow window names stand below each other
    legend = LEGEND_LINE * (named if columns == 1 else math.ceil(named / NAMES_BESIDE))
    height = 90 + legend + rows * (PANEL_HEIGHT if columns > 1 else NARROW_PANEL_HEIGHT)
    figure = styled(figure, "", height=height, least_width=PANEL_WIDTH * columns)
    figure.update_layout(margin={"t": 30, "b": 50 + legend})
    return figure.update_layout(coloraxis=coloured.axis()) if coloured else figure


def _scale_of(sweep: Sweep) -> str | None:
    """Give the quantity that colours tell; None where a legend names the curves."""
    if sweep.drifting:
        return sweep.drifting[0]
    if len(sweep.curves) <= MOST_NAMED:
        return None
    levels = {name for curve in sweep.curves for name, _ in curve.held}
    return max(
        sorted(levels), key=lambda name: len({dict(curve.held).get(name) for curve in sweep.curves}), default=None
    )


@dataclass(frozen=True)
class _Coloured:
    """What colours tell: a quantity, its value in each test or, of a wide range, that value's logarithm, shape (R,)."""

    quantity: str
    values: Array
    in_decades: bool

    @classmethod
    def of(cls, quantity: str, values: Array) -> _Coloured:
        """Take a quantity's values."""
        in_decades = quantity in IN_DECADES and _is_wide(values)
        return cls(quantity, np.log10(values) if in_decades else values, in_decades)

    def shade_of(self, row: int) -> str:
        """Give a test's colour."""
        low, high = _span(self.values)
        share = float((self.values[row] - low) / (high - low)) if high > low else 0.5
        return shade(share if math.isfinite(share) else 0.5)

    def axis(self) -> dict[str, Any]:
        """Give the scale beside a picture."""
        low, high = _span(self.values)
        bar: dict[str, Any] = {"title": {"text": axis_of_quantity(self.quantity)}, "thickness": 12}
        if self.in_decades:
            ticks = [tick for tick in log_ticks((10**low, 10**high)) if low <= math.log10(tick) <= high]
            bar |= {"tickvals": [math.log10(tick) for tick in ticks], "ticktext": [f"{tick:g}" for tick in ticks]}
        return {"colorscale": SCALE, "colorbar": bar, "cmin": low, "cmax": high}


def _look(sweep: Sweep, number: int, rows: list[int], coloured: _Coloured | None) -> dict[str, Any]:
    """Give how a curve is drawn: by a scale's colours, or by its own place among few."""
    mode = "markers" if sweep.drifting else "lines+markers"
    if coloured is None:
        several = len(sweep.curves) > 1
        colour = shade(number / (len(sweep.curves) - 1)) if several else SERIES[0]
        return {"mode": mode, "line": {"color": colour}, "marker": {"size": 6}}
    marker = {"size": 6, "color": coloured.values[rows], "coloraxis": "coloraxis"}
    return {"mode": mode, "marker": marker, "line": {"width": 1, "color": coloured.shade_of(rows[0])}}


def _name(curve: Curve) -> str:
    told = [setting(name, value) for name, value in curve.held]
    return ", ".join(filter(None, [curve.specimen, *told]))


def _is_stiffness(measure: Measure) -> bool:
    return measure.axis.endswith("N/mm")


def _is_wide(values: Array) -> bool:
    """Tell whether values are positive and so far apart that an axis goes in decades."""
    low, high = _span(values)
    return low > 0 and high / low >= WIDE_RANGE


def _decades(values: Array) -> dict[str, Any]:
    """Give an axis in decades."""
    low, high = _span(values)
    if math.log10(high / low) <= MOST_FINE_DECADES:
        return log_axis((low, high))
    ticks = [10.0**power for power in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]
    return {"type": "log", "tickmode": "array", "tickvals": ticks, "ticktext": [f"{one:g}" for one in ticks]}


def _span(values: Array) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if len(known) else (1.0, 1.0)
