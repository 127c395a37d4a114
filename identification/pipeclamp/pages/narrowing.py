"""The page of the loop tests that narrow a pipe's band: the band after each test, and what every test would leave."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import GRID, INK, MODEL, SERIES, Report, Section, log_axis, styled
from pipeclamp.pages.pictures import LIGHT_BLUES
from pipeclamp.show.narrowing import band_plan_words, tests_table
from pipeclamp_identification.planning.band_plan import BandPlan, Map, NextLoopTest
from pipeclamp_identification.workflow.next_step import NextStep

MAP_WORDS = (
    "What is left of the band's width if that test is run first, at the best temperature for each amplitude and "
    "frequency. The frame is where the law was tested; the diamond is the clamp's motion at the peak; the circle is "
    "the test that is proposed."
)


def band_plan_page(plan: BandPlan, following: NextStep | None = None) -> Report:
    """Give the report of a plan, with what comes next where that is known."""
    words = [*band_plan_words(plan), *(following.before() if following else ())]
    maps = [map_picture(one, plan.tests) for one in plan.maps]
    sections = [
        Section(
            "What to test",
            words,
            [tests_table(plan)] if plan.tests else (),
            [steps_picture(plan)],
            following.line if following else "",
        ),
        Section("Where a test narrows the band", (MAP_WORDS,), (), maps),
    ]
    return Report(f"Next loop test for {plan.system}", f"peak at {plan.point}", sections)


def steps_picture(plan: BandPlan) -> go.Figure:
    """Draw the band now, after each test, and at best."""
    told = [("now", plan.before.amplitude)]
    told += [(f"after test {number}", test.amplitude) for number, test in enumerate(plan.tests, 1)]
    told.append(("at best", plan.floor))
    figure = go.Figure()
    names = [name for name, _ in told]
    value = [band.value for _, band in told]
    figure.add_scatter(
        x=names, y=value, mode="markers", name="peak", marker={"color": SERIES[0], "size": 9},
        error_y={
            "type": "data", "symmetric": False, "color": SERIES[0], "thickness": 2, "width": 9,
            "array": [band.high - band.value for _, band in told],
            "arrayminus": [band.value - band.low for _, band in told],
        },
        showlegend=False,
    )  # fmt: skip
    figure.update_xaxes(type="category")
    figure.update_yaxes(title_text=f"peak at {plan.point} / mm")
    return styled(figure, f"{plan.per_cent:g}% band of the peak at {plan.point}", height=340)


def map_picture(one: Map, tests: tuple[NextLoopTest, ...]) -> go.Figure:
    """Draw what is left of the band's width over amplitude and frequency of the test."""
    A, f = np.unique(one.grid["A"]), np.unique(one.grid["f"])
    left = np.full((len(A), len(f)), np.nan)
    for amplitude, frequency, share in zip(one.grid["A"], one.grid["f"], one.share, strict=True):
        place = int(np.searchsorted(A, amplitude)), int(np.searchsorted(f, frequency))
        left[place] = np.fmin(left[place], share)
    figure = go.Figure(
        go.Contour(
            x=f, y=A, z=100 * left, colorscale=LIGHT_BLUES[::-1], connectgaps=False, line={"color": GRID},
            contours={"showlabels": True, "labelfont": {"size": 11, "color": INK}},
            colorbar={"title": {"text": "left / %"}},
            hovertemplate="%{y:.3g} mm, %{x:.3g} Hz: %{z:.3g}% left<extra></extra>",
        )
    )  # fmt: skip
    (A_low, A_high), (f_low, f_high) = one.tested["A"], one.tested["f"]
    figure.add_shape(type="rect", x0=f_low, x1=f_high, y0=A_low, y1=A_high, line={"color": INK, "width": 1.5})
    own = [test for test in tests if test.law == one.law][:1]
    for name, marks, symbol in (
        ("motion at the peak", [(one.motion["f"], one.motion["A"])], "diamond"),
        ("proposed", [(test.frequency_Hz, test.amplitude_mm) for test in own], "circle"),
    ):
        if marks:
            figure.add_scatter(
                x=[x for x, _ in marks], y=[y for _, y in marks], mode="markers", name=name,
                marker={"symbol": symbol, "size": 12, "color": MODEL, "line": {"color": "white", "width": 1.5}},
            )  # fmt: skip
    figure.update_xaxes(title_text="f / Hz", **log_axis(f))
    figure.update_yaxes(title_text="A / mm", **log_axis(A))
    return styled(figure, f"Tests of the clamp of {one.law}", height=460)
