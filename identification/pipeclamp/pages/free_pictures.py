"""Pictures of free motions: force, error and motion over time, and the force over the displacement."""

from __future__ import annotations

import itertools

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.error_pictures import ERROR
from pipeclamp.pages.page import INK, MEASURED, MODEL, SERIES, styled
from pipeclamp_identification.fitting.free_misfit import FreeMisfit
from pipeclamp_models.base.arrays import Array, IntArray

STRETCHES = 600
"""Parts of a record of which the extremes are drawn: a pixel or two each."""
PATH_POINTS = 6000
"""Points of a path: a few pixels apart, once back and forth for each of a hundred cycles."""


def drawn_samples(*channels: Array) -> IntArray:
    """Give the samples that a picture needs: of each of many short stretches the ends and each channel's extremes."""
    samples = len(channels[0])
    edges = np.unique(np.linspace(0, samples, STRETCHES + 1).astype(np.intp))
    extremes = [
        int(first + extreme(values[first:last]))
        for values in channels
        for extreme in (np.argmin, np.argmax)
        for first, last in itertools.pairwise(edges)
    ]
    return np.unique([*np.minimum(edges, samples - 1).tolist(), *extremes])


def drawn_path(y: Array, force: Array) -> IntArray:
    """Give the samples that a picture of a path needs: evenly along it, both axes scaled to their range."""
    way = np.abs(np.diff(y)) / np.ptp(y) + np.abs(np.diff(force)) / max(float(np.ptp(force)), np.finfo(float).tiny)
    gone = np.concatenate([[0.0], np.cumsum(way)])
    return np.unique(np.searchsorted(gone, np.linspace(0.0, gone[-1], PATH_POINTS)).clip(0, len(y) - 1))


def over_time_picture(run: FreeMisfit, title: str) -> go.Figure:
    """Draw a run's force, measured and by the law, the error, and the motion with its tracked amplitude, over time."""
    figure = make_subplots(
        rows=3, cols=1, shared_xaxes=True, vertical_spacing=0.07, row_heights=[0.45, 0.25, 0.3],
        subplot_titles=["force", "error: measured less law", "displacement, and the tracked amplitude"],
    )  # fmt: skip
    at = drawn_samples(run.measured, run.computed, run.y)
    time = run.time[at]
    curves = (
        (1, run.measured, "measured", MEASURED, 2.5),
        (1, run.computed, "law", MODEL, 1.2),
        (2, run.measured - run.computed, "error", ERROR, 1.2),
        (3, run.y, "displacement", INK, 1.5),
        (3, run.amplitude, "tracked amplitude", SERIES[1], 1.5),
    )
    for row, values, name, colour, width in curves:
        trace = go.Scatter(
            x=time, y=values[at], mode="lines", name=name, line={"color": colour, "width": width, "simplify": False}
        )
        figure.add_trace(trace, row=row, col=1)
    figure.update_xaxes(title_text="time / s", row=3, col=1)
    for row, text in ((1, "F / N"), (2, "F / N"), (3, "y / mm")):
        figure.update_yaxes(title_text=text, row=row, col=1)
    figure.update_annotations(font={"size": 12})
    return styled(figure, title, height=720, least_width=420).update_layout(margin={"t": 80, "b": 90})


def path_picture(run: FreeMisfit, title: str) -> go.Figure:
    """Draw a run's force over its displacement, measured and by the law."""
    figure = go.Figure(
        [
            go.Scatter(
                x=run.y[at], y=force[at], mode="lines", name=name,
                line={"color": colour, "width": width, "simplify": False},
            )
            for force, name, colour, width in (
                (run.measured, "measured", MEASURED, 2.5),
                (run.computed, "law", MODEL, 1.2),
            )
            for at in (drawn_path(run.y, force),)
        ]
    )  # fmt: skip
    figure.update_xaxes(title_text="y / mm").update_yaxes(title_text="F / N")
    return styled(figure, title, height=460, least_width=420).update_layout(margin={"b": 80})
