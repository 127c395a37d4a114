"""The README's picture: one loop that the fit never saw, and the law as it grows.

Run: python build_scripts/readme_picture.py        (needs a Chromium to turn the page into docs/law_grows.png)
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp_identification.add import add_effect
from pipeclamp_identification.bundled_campaigns import bundled_campaign
from pipeclamp_identification.campaign import read_campaign
from pipeclamp_identification.compare import Comparison, compare
from pipeclamp_identification.comparison_report import loop_panels
from pipeclamp_identification.demo import EFFECTS
from pipeclamp_identification.identify import identify, law_file
from pipeclamp_identification.report import MEASURED, MODEL, styled

OUTPUT = Path(__file__).parents[1] / "docs" / "law_grows.png"
RUN = "A0p35_f4_T60"
WIDTH, HEIGHT = 1080, 600
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")


def comparisons() -> list[tuple[str, Comparison]]:
    """The law of clamp_a after each step, held against the campaign that it never saw."""
    tests, unseen = read_campaign(bundled_campaign("clamp_a")), read_campaign(bundled_campaign("clamp_a_heldout"))
    file = law_file(identify(tests), tests, name="clamp_a", command="", date=None)
    steps = [("base law", compare(file, unseen))]
    for effect in EFFECTS:
        file = add_effect(file, effect, tests, command="", date=None).after
        steps.append((f"+ {effect}", compare(file, unseen)))
    return steps


def picture(steps: list[tuple[str, Comparison]]) -> go.Figure:
    """Loops above, what is left of the force below, one column a step."""
    row = next(index for index, run in enumerate(steps[0][1].runs) if run.run == RUN)
    titles = [
        f"{name}<br><span style='font-size:12px'>{run.runs[row].nrmse:.1%} here, {run.nrmse:.1%} over 18 runs</span>"
        for name, run in steps
    ]
    figure = make_subplots(
        rows=2, cols=len(steps), subplot_titles=titles, shared_xaxes=True, shared_yaxes=True,
        row_heights=[0.64, 0.36], horizontal_spacing=0.02, vertical_spacing=0.05,
    )  # fmt: skip
    for column, (_, comparison) in enumerate(steps, 1):
        (panel,) = loop_panels(comparison, [row])
        assert panel.measured is not None
        assert panel.computed is not None
        y = np.append(panel.y, panel.y[0])
        for place, force, name, colour, width in (
            (1, panel.measured, "measured", MEASURED, 4.0),
            (1, panel.computed, "law", MODEL, 1.6),
            (2, panel.measured - panel.computed, "measured less law", "#1c7ed6", 1.6),
        ):
            figure.add_trace(
                go.Scatter(
                    x=y, y=np.append(force, force[0]), name=name, mode="lines",
                    line={"color": colour, "width": width}, showlegend=column == 1,
                ),
                row=place, col=column,
            )  # fmt: skip
        figure.update_xaxes(title_text="y / mm", row=2, col=column)
    figure = styled(figure, "", height=HEIGHT)
    figure.update_yaxes(title_text="F / N", row=1, col=1)
    figure.update_yaxes(title_text="F / N", row=2, col=1)
    figure.update_annotations(font={"size": 15})
    return figure.update_layout(width=WIDTH, margin={"t": 60, "b": 70, "l": 70}, legend={"y": -0.12})


def main() -> None:
    """Draw the picture and let a browser turn it into a PNG."""
    browser = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if browser is None:
        sys.exit(f"no browser found; expected one of {', '.join(BROWSERS)} on the path")
    OUTPUT.parent.mkdir(exist_ok=True)
    figure = picture(comparisons())
    with tempfile.TemporaryDirectory() as temporary:
        page = Path(temporary) / "picture.html"
        body = figure.to_html(full_html=False, include_plotlyjs=True, config={"displayModeBar": False})
        page.write_text(f"<!DOCTYPE html><meta charset='utf-8'><body style='margin:0'>{body}</body>", encoding="utf-8")
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=4000"]
        subprocess.run(
            [browser, *options, f"--user-data-dir={temporary}/profile", f"--window-size={WIDTH},{HEIGHT}",
             f"--screenshot={OUTPUT}", page.as_uri()],
            check=True, capture_output=True, timeout=120,
        )  # fmt: skip
    print(f"{OUTPUT}: {OUTPUT.stat().st_size / 1024:.0f} kB")


if __name__ == "__main__":
    main()
