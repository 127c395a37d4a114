"""How sure a simulation is: bands drawn beside its curves, and where they come from."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import SERIES, Section
from pipeclamp.show.table import Table
from pipeclamp_models.base.arrays import Array
from pipeclamp_system.bands.band import Band, figures
from pipeclamp_system.bands.ensemble import RunBands
from pipeclamp_system.bands.quantities import KIND_WORDS
from pipeclamp_system.bands.response_bands import PieceBand, ResponseBands
from pipeclamp_system.response.curves import label
from pipeclamp_system.steady.states import SteadyState

FAINT = 0.18
"""Opacity of a band."""
DENSE = 0.6
"""Of one that is narrow beside what it is of."""
BAND_KEY = "#777777"
"""Colour by which the legend names bands of any colour."""

WORDS = (
    "A curve's band is drawn where most of the laws that are as likely have such a state. Shares are of the variance "
    "of the peak. Run to run is what one mounting does; left-out tests are what the law leaves over on tests that "
    "were left out, and more where the law is used beyond its tests."
)

RUN_WORDS = (
    "Shares are of the variance. Run to run is what one mounting does; left-out tests are what the law's form leaves "
    "over on tests that were left out, and more where the law is used beyond its tests."
)


def bands_section(bands: ResponseBands) -> Section:
    """Give the part of a report that tells how sure a response is."""
    header = (
        "clamps, level", "at", "peak / mm", "low", "high", "at f / Hz", "low", "high",
        "parameters", "run to run", "left-out tests", "solver",
    )  # fmt: skip
    rows: list[tuple[str | float, ...]] = []
    for curve, own in zip(bands.response.curves, bands.curves, strict=True):
        for point, peak in zip(bands.response.points, own.peaks, strict=True):
            name = label(curve.temperature, curve.level)
            ends = (*figures(peak.amplitude), *figures(peak.frequency))
            rows.append((name, point, *ends, *shares_of(peak.amplitude)))
    table = Table(header, rows, f"peaks with their {bands.per_cent:g}% bands, and the shares of their variance")
    return Section("How sure", (*bands.words(), WORDS), [table])


def run_bands_section(bands: RunBands) -> Section:
    """Give the part of a report that tells how sure a run in time is."""
    header = ("", "value", "low", "high", "unit", "parameters", "run to run", "left-out tests", "steps")
    rows: list[tuple[str | float, ...]] = [
        (one.name, one.band.value, one.band.low, one.band.high, one.unit, *shares_of(one.band)) for one in bands.values
    ]
    table = Table(header, rows, f"{bands.per_cent:g}% bands, and the shares of their variance")
    return Section("How sure", (*bands.words(), RUN_WORDS), [table])


def add_area(
    figure: go.Figure, x: Array, low: Array, high: Array, name: str, colour: str = SERIES[1], opacity: float = DENSE,
    **place: int,
) -> None:  # fmt: skip
    """Fill what lies between two curves, behind all others; with a name it stands in the legend.

    Panels of a figure are placed by row and col.
    """
    area = go.Scatter(
        x=np.concatenate([x, x[::-1]]), y=np.concatenate([low, high[::-1]]), mode="none", fill="toself",
        fillcolor=colour, opacity=opacity, name=name, showlegend=bool(name), hoverinfo="skip",
    )  # fmt: skip
    figure.add_trace(area, **place)
    figure.data = (figure.data[-1], *figure.data[:-1])


def add_band_key(figure: go.Figure, name: str) -> None:
    """Name faint bands in the legend, whatever the colours of their curves."""
    look = {"symbol": "square", "size": 13, "color": BAND_KEY, "opacity": 2 * FAINT}
    figure.add_scatter(x=[None], y=[None], mode="markers", name=name, marker=look)


def shares_of(band: Band) -> list[str]:
    """Give the shares of a band's variance, as texts, in the order of the kinds."""
    return [f"{band.shares[kind]:.0%}" for kind in KIND_WORDS]


def add_band(figure: go.Figure, piece: Sequence[SteadyState], band: PieceBand, colour: str) -> None:
    """Draw the band of a piece of a curve, each stretch that turns back nowhere by itself."""
    frequency = np.array([state.frequency for state in piece])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(frequency)))) + 1
    for first, last in pairwise([0, *turns.tolist(), len(frequency) - 1]):
        there = np.flatnonzero(np.isfinite(band.low[first : last + 1])) + first
        add_area(figure, frequency[there], band.low[there], band.high[there], "", colour, FAINT)
