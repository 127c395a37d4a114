"""The report of records against the coupled model: over time, over frequency, by probe."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.error_pictures import bars_of, error_bars
from pipeclamp.pages.page import MEASURED, MODEL, SERIES, Section, styled, with_narrow
from pipeclamp.pages.pictures import thinned
from pipeclamp.show.comparison import parts_table
from pipeclamp_identification.on_pipe.measurement import QUANTITIES
from pipeclamp_identification.on_pipe.record_motion import RecordPrediction
from pipeclamp_identification.on_pipe.records import RecordPair, RecordsComparison, records_words
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import unit_shown

ROW = 260
PERIODS = 15
"""Of the strongest line of what was measured, in the stretch that is shown first."""


def records_sections(
    comparison: RecordsComparison, corrected: Sequence[RecordPrediction] | None = None
) -> list[Section]:
    """Give the report of a comparison with records; the model also as it is once what is found wrong is put right."""
    broken = comparison.breakdowns()
    bars = error_bars([bars_of("", parts.by, parts) for parts in broken], "Percent of the rms of what was measured")
    others: Sequence[RecordPrediction | None] = corrected or [None] * len(comparison.pairs)
    pictures = [record_picture(comparison, *both) for both in zip(comparison.pairs, others, strict=True)]
    return [
        Section("How much, over time", records_words(comparison)),
        Section("Measured and computed, over time", (), (), pictures),
        Section("Where, over time", (), [parts_table(parts) for parts in broken], [bars]),
    ]


def record_picture(
    comparison: RecordsComparison, pair: RecordPair, corrected: RecordPrediction | None = None
) -> go.Figure:
    """Draw a record over time and its spectrum, a row a probe; what the model says, and what a corrected one does.

    Over time it shows the stretch where the model errs most, in which the lines can be told apart; a double click shows
    all of it. In a narrow window each spectrum stands below its history.
    """
    wide, narrow = (_record_in(columns, comparison, pair, corrected) for columns in (2, 1))
    return with_narrow(wide, narrow)


def _record_in(
    columns: int, comparison: RecordsComparison, pair: RecordPair, corrected: RecordPrediction | None
) -> go.Figure:
    probes = comparison.description.probes
    rows = 2 * len(probes) // columns
    figure = make_subplots(
        rows=rows, cols=columns, column_widths=[0.65, 0.35] if columns == 2 else None,
        horizontal_spacing=0.08, vertical_spacing=0.3 / rows,
        subplot_titles=[title for probe in probes for title in (probe.name, f"{probe.name}, spectrum")],
    )  # fmt: skip
    frequency, *_ = pair.spectra
    inside = (frequency > 0) & (frequency <= comparison.edges[-1])
    stretch = worst_stretch(pair, comparison.scales, comparison.edges[-1])
    begin, end = (float(pair.time[place]) for place in (stretch.start, stretch.stop - 1))
    drawn = [(pair.measured, "measured", MEASURED, 3.0), (pair.computed, "model", MODEL, 1.2)]
    if corrected is not None:
        drawn.append((corrected.computed, "model, corrected", SERIES[0], 1.2))
    for index, probe in enumerate(probes):
        over_time, over_frequency = (
            {"row": 1 + place // columns, "col": 1 + place % columns} for place in (2 * index, 2 * index + 1)
        )
        for values, name, colour, width in drawn:
            shown = values[:, index] / probe.scale
            lines = 2 * np.abs(np.fft.rfft(shown)) / shown.size
            style = {"mode": "lines", "name": name, "legendgroup": name, "line": {"color": colour, "width": width}}
            time, thin = _thinned_around(stretch, pair.time, shown)
            figure.add_trace(go.Scatter(x=time, y=thin, showlegend=index == 0, **style), **over_time)
            spectrum = go.Scatter(x=frequency[inside], y=lines[inside], showlegend=False, **style)
            figure.add_trace(spectrum, **over_frequency)
        last = index == len(probes) - 1
        figure.update_yaxes(title_text=f"{QUANTITIES[probe.order]} / {unit_shown(probe.unit)}", **over_time)
        figure.update_xaxes(range=[begin, end], matches="x", title_text="t / s" if last else None, **over_time)
        figure.update_xaxes(title_text="f / Hz" if last else None, **over_frequency)
    figure.update_annotations(font={"size": 12})
    title = f"Record {pair.name}, from {begin:.4g} to {end:.4g} s, where the model errs most; a double click shows all"
    figure = styled(figure, title, height=110 + ROW * rows, least_width=640 if columns == 2 else 0)
    # beside each other, or below, as the legend finds room
    return figure.update_layout(margin={"t": 80, "b": 80 if columns == 2 else 110})


def worst_stretch(pair: RecordPair, scales: Array, highest: float) -> slice:
    """Give the samples of some periods in which the model errs most.

    Args:
        pair: a record, and what the model says of it.
        scales: rms of what was measured by each probe, (probes,).
        highest: frequency that is compared, Hz.
    """
    frequency, measured, _ = pair.spectra
    compared = np.sum(measured / scales**2, axis=1) * ((frequency > 0) & (frequency <= highest))
    samples = round(PERIODS / (float(frequency[np.argmax(compared)]) * pair.record.step))
    count = min(max(samples, 2), pair.time.size)
    error = np.concatenate([[0.0], np.cumsum(np.sum(((pair.measured - pair.computed) / scales) ** 2, axis=1))])
    first = int(np.argmax(error[count:] - error[:-count]))
    return slice(first, first + count)


def _thinned_around(stretch: slice, time: Array, values: Array) -> tuple[Array, Array]:
    """Give all samples of a stretch, and few of the others."""
    parts = [slice(0, stretch.start), stretch, slice(stretch.stop, time.size)]
    shown = [
        (time[part], values[part]) if part is stretch or part.start == part.stop else thinned(time[part], values[part])
        for part in parts
    ]
    times, drawn = zip(*shown, strict=True)
    return np.concatenate(times), np.concatenate(drawn)
