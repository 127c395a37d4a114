"""The report of records against the coupled model: over time, over frequency, by probe."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.error_pictures import bars_of, error_bars
from pipeclamp.pages.page import MEASURED, MODEL, SERIES, Section, styled
from pipeclamp.pages.pictures import thinned
from pipeclamp.show.comparison import parts_table
from pipeclamp_identification.on_pipe.measurement import QUANTITIES
from pipeclamp_identification.on_pipe.record_motion import RecordPrediction
from pipeclamp_identification.on_pipe.records import RecordPair, RecordsComparison, records_words

ROW = 260


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
    """Draw a record over time and its spectrum, a row a probe; what the model says, and what a corrected one does."""
    probes = comparison.description.probes
    figure = make_subplots(
        rows=len(probes), cols=2, column_widths=[0.65, 0.35],
        horizontal_spacing=0.08, vertical_spacing=0.3 / len(probes),
        subplot_titles=[title for probe in probes for title in (probe.name, f"{probe.name}, spectrum")],
    )  # fmt: skip
    frequency, *_ = pair.spectra
    inside = (frequency > 0) & (frequency <= comparison.edges[-1])
    drawn = [(pair.measured, "measured", MEASURED, 3.0), (pair.computed, "model", MODEL, 1.2)]
    if corrected is not None:
        drawn.append((corrected.computed, "model, corrected", SERIES[0], 1.2))
    for row, probe in enumerate(probes, 1):
        for values, name, colour, width in drawn:
            shown = values[:, row - 1] / probe.scale
            lines = 2 * np.abs(np.fft.rfft(shown)) / shown.size
            style = {"mode": "lines", "name": name, "legendgroup": name, "line": {"color": colour, "width": width}}
            time, thin = thinned(pair.time, shown)
            over_time = go.Scatter(x=time, y=thin, showlegend=row == 1, **style)
            figure.add_trace(over_time, row=row, col=1)
            over_frequency = go.Scatter(x=frequency[inside], y=lines[inside], showlegend=False, **style)
            figure.add_trace(over_frequency, row=row, col=2)
        figure.update_yaxes(title_text=f"{QUANTITIES[probe.order]} / {probe.unit}", row=row, col=1)
    figure.update_xaxes(title_text="t / s", row=len(probes), col=1)
    figure.update_xaxes(title_text="f / Hz", row=len(probes), col=2)
    figure.update_annotations(font={"size": 12})
    figure = styled(figure, f"Record {pair.name}", height=110 + ROW * len(probes), least_width=640)
    return figure.update_layout(margin={"t": 80, "b": 80})
