"""Pictures in words, for those who can't see them: what each trace is and how far it reaches."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import plotly.graph_objects as go

from pipeclamp_models.base.said import few_of

MOST_BARS = 12
MOST_TRACES = 8
TRACE_KINDS = {"bar": "bars", "heatmap": "map", "contour": "contours", "scatter": "line"}


def words_of(figure: go.Figure) -> str:
    """Say what a picture shows: its title, and each trace with its kind and its range, those alike once."""
    title = _plain(figure.layout.title.text or "Picture")
    told = list(dict.fromkeys(filter(None, (_trace_words(figure, trace) for trace in figure.data))))
    return f"{title}. {few_of(told, MOST_TRACES, '; ')}." if told else f"{title}."


def _trace_words(figure: go.Figure, trace: Any) -> str:
    values = trace.z if trace.type in ("heatmap", "contour") else trace.y
    kind = "points" if trace.type == "scatter" and "lines" not in (trace.mode or "lines") else TRACE_KINDS[trace.type]
    axis = _axis(figure, trace.yaxis, "yaxis")
    name = f"{_plain(trace.name)}, {kind}" if trace.name else kind
    if trace.type == "bar" and values is not None and len(values) <= MOST_BARS:
        pairs = (f"{_plain(str(x))} {y:.3g}" for x, y in zip(trace.x, values, strict=True) if y is not None)
        return f"{name}, {axis}: {', '.join(pairs)}"
    numbers = np.asarray(values if values is not None else [], dtype=float)
    if trace.customdata is not None and trace.type == "heatmap":
        numbers = np.asarray(trace.customdata, dtype=float)
    numbers = numbers[np.isfinite(numbers)]
    if not len(numbers):
        return ""
    over = _axis(figure, trace.xaxis, "xaxis")
    return f"{name}, {axis} from {numbers.min():.3g} to {numbers.max():.3g} over {over}"


def _axis(figure: go.Figure, name: str | None, first: str) -> str:
    """Give the title of a trace's axis; of panels that share one, that of the first which has any."""
    number = (name or "")[1:]
    own = figure.layout[f"{first}{number}"].title.text
    titles = [own, *(axis.title.text for axis in figure.select_xaxes() if first == "xaxis")]
    titles += [axis.title.text for axis in figure.select_yaxes() if first == "yaxis"]
    return _plain(next(filter(None, titles), first[0]))


def _plain(text: str) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", text)).strip().rstrip(".")
