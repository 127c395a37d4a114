"""The frequency response of a pipe and its clamp: levels by colour, temperatures side by side."""

from pathlib import Path

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.pages.page import SERIES, styled
from pipeclamp.pages.system.response import pieces
from pipeclamp_system.response.curves import FrequencyResponse
from pipeclamp_system.response.run import run_response
from pipeclamp_system.response.summary import response_summary
from pipeclamp_system.steady.states import amplitudes_of

SYSTEM = Path(__file__).parent / "system" / "system.toml"
ACCELERATION = 0.5
"""m/s2, of SYSTEM at level 1."""
POINT = 0
"""Which of the system's points is drawn: its clamp."""
HEIGHT = 520


def picture() -> go.Figure:
    """Amplitude over frequency, one column a temperature."""
    found = run_response(SYSTEM, print)
    print(response_summary(found))
    return drawn(found)


def drawn(found: FrequencyResponse) -> go.Figure:
    """Draw curves with their unstable branches, and the co-simulations on them."""
    temperatures = list(dict.fromkeys(curve.temperature for curve in found.curves))
    levels = sorted({curve.level for curve in found.curves}, reverse=True)
    titles = [f"clamp at {temperature:g} °C" for temperature in temperatures]
    figure = make_subplots(cols=len(titles), subplot_titles=titles, shared_yaxes=True, horizontal_spacing=0.03)
    for curve in sorted(found.curves, key=lambda curve: -curve.level):
        column, colour = 1 + temperatures.index(curve.temperature), SERIES[levels.index(curve.level)]
        for number, (stable, piece) in enumerate(pieces(curve)):
            figure.add_scatter(
                x=[state.frequency for state in piece], y=[amplitudes_of(state)[POINT] for state in piece],
                mode="lines", name=f"{ACCELERATION * curve.level:g} m/s²", showlegend=number == 0 and column == 1,
                line={"color": colour, "width": 2.2, "dash": "solid" if stable else "dot"}, row=1, col=column,
            )  # fmt: skip
        own = [dot for dot in found.dots if (dot.temperature, dot.level) == (curve.temperature, curve.level)]
        figure.add_scatter(
            x=[dot.frequency for dot in own], y=[dot.amplitudes[POINT] for dot in own], mode="markers",
            marker={"color": colour, "size": 9, "line": {"color": "white", "width": 1.5}}, showlegend=False,
            row=1, col=column,
        )  # fmt: skip
    for name, form in (
        ("unstable", {"mode": "lines", "line": {"color": "#777777", "width": 2.2, "dash": "dot"}}),
        ("co-simulation", {"mode": "markers", "marker": {"color": "#777777", "size": 9}}),
    ):
        figure.add_scatter(x=[None], y=[None], name=name, **form, row=1, col=1)
    figure = styled(figure, "", height=HEIGHT).update_xaxes(title_text="frequency / Hz")
    figure.update_yaxes(rangemode="tozero").update_yaxes(title_text="amplitude at the clamp / mm", row=1, col=1)
    figure.update_annotations(font={"size": 16})
    return figure.update_layout(font={"size": 15}, margin={"t": 40, "b": 90, "l": 70})
