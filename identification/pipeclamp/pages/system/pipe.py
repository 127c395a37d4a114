"""The report of a comparison on the pipe: measured against computed response at each probe, and where it fails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.error_pictures import ConditionsMap, bars_of, conditions_picture, error_bars
from pipeclamp.pages.page import MEASURED, MODEL, SERIES, Section, styled
from pipeclamp.pages.system.bands import FAINT, add_area
from pipeclamp.show.comparison import beside_even, parts_table
from pipeclamp_identification.on_pipe.bands import PipeBands
from pipeclamp_identification.on_pipe.measurement import QUANTITIES, ProbeTable
from pipeclamp_identification.on_pipe.prediction import SAME_LEVEL, Prediction
from pipeclamp_identification.on_pipe.series import Series, series_of
from pipeclamp_identification.on_pipe.sines import PipeComparison
from pipeclamp_identification.on_pipe.where import beyond_laws, how_much, where_words
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.arrays import ComplexArray
from pipeclamp_models.base.units import unit_shown

MEASURED_NAME = "measured"
CORRECTED = SERIES[0]

MOST_PANELS = 6
"""Series of sines side by side in a picture; of more, the worst."""
PANEL_WIDTH = 250
EVEN = (
    f"{beside_even('the model erred by the same part of what was measured everywhere')} "
    "Amplitude and phase are each held against the whole."
)


def pipe_comparison_sections(
    comparison: PipeComparison, corrected: Prediction | None = None, bands: PipeBands | None = None
) -> list[Section]:
    """Give the report of a comparison: the numbers, the responses, the map, the breakdowns.

    Args:
        comparison: the model as it is stated, against the measurement.
        corrected: what the model says once what is found wrong is put right.
        bands: how sure the model is, where that was asked.
    """
    series = series_of(comparison.measurement.steady)
    probes = comparison.measurement.description.probes
    pictures = [response_picture(comparison, series, index, corrected, bands) for index in range(len(probes))]
    broken = [
        comparison.by_probe(),
        *([comparison.by_kind()] if comparison.phased else []),
        *(comparison.by_condition(entry) for entry in comparison.conditions),
    ]
    bars = error_bars([bars_of("", parts.by, parts) for parts in broken], "Percent of the rms of what was measured")
    return [
        Section("How much", [*how_much(comparison), *where_words(comparison), *(bands.words() if bands else ())]),
        Section("Measured and computed response", (), (), pictures),
        Section("Where", (), (), [map_picture(comparison, series)]),
        Section("By probe and condition", [EVEN], [parts_table(parts) for parts in broken], [bars]),
    ]


def response_picture(
    comparison: PipeComparison, series: Sequence[Series], column: int, corrected: Prediction | None = None,
    bands: PipeBands | None = None,
) -> go.Figure:  # fmt: skip
    """Draw amplitude and phase over frequency at one probe, a panel a series of sines; a corrected model, bands too."""
    probe = comparison.measurement.description.probes[column]
    shown = _worst(comparison, series, column)
    figure = make_subplots(
        rows=2, cols=len(shown), shared_xaxes=True, vertical_spacing=0.08, horizontal_spacing=0.06,
        row_heights=[0.65, 0.35], subplot_titles=[_panel_title(comparison, one, column) for one in shown],
    )  # fmt: skip
    steady = comparison.measurement.steady
    drawn: list[tuple[ComplexArray, str, dict[str, Any]]] = [
        (steady.response, MEASURED_NAME, {"mode": "markers", "marker": {"color": MEASURED, "size": 7}}),
        (comparison.prediction.response, "model", {"mode": "lines", "line": {"color": MODEL, "width": 1.6}}),
    ]
    if corrected is not None:
        line = {"color": CORRECTED, "width": 1.8, "dash": "dash"}
        drawn.append((corrected.response, "model, corrected", {"mode": "lines", "line": line}))
    beyond = np.asarray(beyond_laws(comparison).any(axis=1))
    if beyond.any():
        outside = np.where(beyond[:, None], comparison.prediction.response, np.nan)
        ring = {"color": MODEL, "size": 9, "symbol": "circle-open"}
        drawn.append((outside, "model beyond its clamps' data", {"mode": "markers", "marker": ring}))
    for panel, one in enumerate(shown, 1):
        drive = steady.drive[one.rows]
        for response, name, style in drawn:
            values = response[one.rows, column]
            common = {"x": steady.frequency[one.rows], "name": name, "legendgroup": name, **style}
            if one.rows.size == 1:
                common["mode"] = "markers"
            amplitude = go.Scatter(y=np.abs(values) * drive / probe.scale, showlegend=panel == 1, **common)
            figure.add_trace(amplitude, row=1, col=panel)
            if name != MEASURED_NAME or steady.phased[one.rows, column].all():
                phase = np.degrees(np.unwrap(np.angle(values)))
                phase -= 360 * np.round(np.nanmean(phase) / 360) if np.isfinite(phase).any() else 0.0
                figure.add_trace(go.Scatter(y=phase, showlegend=False, **common), row=2, col=panel)
        if bands is not None:
            x = steady.frequency[one.rows]
            low, high = (end[one.rows, column] * drive / probe.scale for end in (bands.low, bands.high))
            there = np.flatnonzero(np.isfinite(low))
            there = there[np.argsort(x[there], kind="stable")]
            name = f"{bands.per_cent:g}% band" if panel == 1 else ""
            add_area(figure, x[there], low[there], high[there], name, MODEL, FAINT, row=1, col=panel)
        figure.update_xaxes(title_text="f / Hz", row=2, col=panel)
    figure.update_yaxes(title_text=_axis(probe), row=1, col=1)
    figure.update_yaxes(rangemode="tozero", row=1)
    figure.update_yaxes(title_text="phase / deg", row=2, col=1)
    figure.update_annotations(font={"size": 12})
    figure = styled(figure, f"Response at {probe.name}", height=520, least_width=PANEL_WIDTH * len(shown))
    return figure.update_layout(margin={"t": 80, "b": 80})


def _worst(comparison: PipeComparison, series: Sequence[Series], column: int) -> list[Series]:
    """Give the series that are drawn, in their order."""
    chosen = np.array([column])
    errors = [comparison.part("", one.rows, chosen).nrmse or 0.0 for one in series]
    kept = sorted(np.argsort(errors)[::-1][:MOST_PANELS].tolist())
    return [series[index] for index in kept]


def _panel_title(comparison: PipeComparison, one: Series, column: int) -> str:
    error = comparison.part("", one.rows, np.array([column])).nrmse
    return f"{one.label}<br>error {100 * error:.3g}%" if error is not None else one.label


def _axis(probe: ProbeTable) -> str:
    return f"{QUANTITIES[probe.order]} / {unit_shown(probe.unit)}"


def map_picture(comparison: PipeComparison, series: Sequence[Series]) -> go.Figure:
    """Draw the error over frequency and probe, a panel a series of sines."""
    frequency = number_levels(comparison.measurement.steady.frequency, relative=SAME_LEVEL / 3)
    shape = (len(series), len(comparison.probes), len(frequency))
    error, scatter = np.full(shape, np.nan), np.full(shape, np.nan)
    for panel, column, cell in np.ndindex(shape):
        rows = np.intersect1d(series[panel].rows, frequency[cell].rows)
        part = comparison.part("", rows, np.array([column]))
        if rows.size and part.nrmse is not None:
            error[panel, column, cell] = 100 * part.nrmse
            noise = part.noise_nrmse
            scatter[panel, column, cell] = math.nan if noise is None else 100 * noise
    labels = [one.label for one in series]
    shown = ConditionsMap(comparison.probes, [level.label for level in frequency], labels, error, scatter, rows="probe")
    known = "; in brackets the scatter" if np.isfinite(scatter).any() else ""
    return conditions_picture(shown, f"Error over probe and f / Hz{known}; the worst is framed")
