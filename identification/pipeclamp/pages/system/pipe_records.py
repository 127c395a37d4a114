"""The report of records against the coupled model: over time, over frequency, by probe."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.error_pictures import bars_of, error_bars
from pipeclamp.pages.page import MEASURED, MODEL, Section, styled
from pipeclamp.show.comparison import parts_table
from pipeclamp_identification.on_pipe.measurement import QUANTITIES
from pipeclamp_identification.on_pipe.records import RecordPair, RecordsComparison, records_words

DRAWN = 4000
"""Samples of a record that are drawn at most."""
ROW = 260


def records_sections(comparison: RecordsComparison) -> list[Section]:
    """Give the report of a comparison with records."""
    broken = comparison.breakdowns()
    bars = error_bars([bars_of("", parts.by, parts) for parts in broken], "Percent of the rms of what was measured")
    pictures = [record_picture(comparison, pair) for pair in comparison.pairs]
    return [
        Section("How much, over time", records_words(comparison)),
        Section("Measured and computed, over time", (), (), pictures),
        Section("Where, over time", (), [parts_table(parts) for parts in broken], [bars]),
    ]


def record_picture(comparison: RecordsComparison, pair: RecordPair) -> go.Figure:
    """Draw a record over time and its spectrum, a row a probe."""
    probes = comparison.description.probes
    figure = make_subplots(
        rows=len(probes), cols=2, column_widths=[0.65, 0.35],
        horizontal_spacing=0.08, vertical_spacing=0.3 / len(probes),
        subplot_titles=[title for probe in probes for title in (probe.name, f"{probe.name}, spectrum")],
    )  # fmt: skip
    stride = max(1, pair.time.size // DRAWN)
    frequency, *_ = pair.spectra
    inside = (frequency > 0) & (frequency <= comparison.edges[-1])
    for row, probe in enumerate(probes, 1):
        for values, name, colour, width in (
            (pair.measured, "measured", MEASURED, 3.0),
            (pair.computed, "model", MODEL, 1.2),
        ):
            shown = values[:, row - 1] / probe.scale
            lines = 2 * np.abs(np.fft.rfft(shown)) / shown.size
            style = {"mode": "lines", "name": name, "legendgroup": name, "line": {"color": colour, "width": width}}
            over_time = go.Scatter(x=pair.time[::stride], y=shown[::stride], showlegend=row == 1, **style)
            figure.add_trace(over_time, row=row, col=1)
            over_frequency = go.Scatter(x=frequency[inside], y=lines[inside], showlegend=False, **style)
            figure.add_trace(over_frequency, row=row, col=2)
        figure.update_yaxes(title_text=f"{QUANTITIES[probe.order]} / {probe.unit}", row=row, col=1)
    figure.update_xaxes(title_text="t / s", row=len(probes), col=1)
    figure.update_xaxes(title_text="f / Hz", row=len(probes), col=2)
    figure.update_annotations(font={"size": 12})
    figure = styled(figure, f"Record {pair.name}", height=110 + ROW * len(probes), least_width=640)
    return figure.update_layout(margin={"t": 80, "b": 80})
