"""One loop that the fit never saw, and the law as it grows."""

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from pipeclamp.demo import EFFECTS
from pipeclamp.pages.page import MEASURED, MODEL, styled
from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.comparison.compare import Comparison
from pipeclamp_identification.fitting.misfit import DRAWN_SAMPLES, force_of_rows, loop_of_run
from pipeclamp_identification.workflow.change import add_effect
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.law.file import Provenance

RUN = "A0p35_f4_T60"
HEIGHT = 600


def comparisons() -> list[tuple[str, Comparison]]:
    """The law of clamp_a after each step, held against the campaign that it never saw."""
    tests, unseen = (RecordTests(read_campaign(bundled_campaign(name))) for name in ("clamp_a", "clamp_a_heldout"))
    file = tests.identify().file(name="clamp_a", provenance=Provenance(""))
    steps = [("base law", unseen.compare(file))]
    for effect in EFFECTS:
        file = add_effect(file, effect, tests, provenance=Provenance("")).after
        steps.append((f"+ {effect}", unseen.compare(file)))
    return steps


def picture() -> go.Figure:
    """Loops above, what is left of the force below, one column a step."""
    steps = comparisons()
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
        y, measured = loop_of_run(comparison.loops, row)
        computed = force_of_rows(comparison.law, comparison.loops, DRAWN_SAMPLES)[row]
        y = np.append(y, y[0])
        for place, force, name, colour, width in (
            (1, measured, "measured", MEASURED, 4.0),
            (1, computed, "law", MODEL, 1.6),
            (2, measured - computed, "measured less law", "#1c7ed6", 1.6),
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
    return figure.update_layout(margin={"t": 60, "b": 70, "l": 70})
