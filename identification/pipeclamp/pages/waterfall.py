"""The falling error: one rung an effect, what it took, and what the best effects would do next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import plotly.graph_objects as go

from pipeclamp.pages.page import MODEL, SERIES, styled
from pipeclamp_models.law.file import LawFile

RUNG_WIDTH = 130
USED, LEFT_OUT = "on the tests used", "on left-out conditions"
ESTIMATED = "on left-out conditions, estimated from the fit to all"
"""Another quantity than the error of fits that never saw the conditions: a diagnosis has no time for those."""
COLOURS = {USED: "#9fb3c8", LEFT_OUT: SERIES[0], ESTIMATED: "#5f9bd1"}


@dataclass(frozen=True)
class Rung:
    """One step of a law's way.

    Attributes:
        label: what was done.
        errors: rms error over rms force after it, by the tests that it is on.
        promised: whether it isn't done yet: what the step would do.
    """

    label: str
    errors: Mapping[str, float]
    promised: bool = False


def rungs_of(file: LawFile) -> list[Rung]:
    """Give the rungs of a law's history."""
    return [
        Rung(step.step, {USED: step.nrmse} | ({} if step.heldout_nrmse is None else {LEFT_OUT: step.heldout_nrmse}))
        for step in file.history
    ]


def with_promised(rungs: Sequence[Rung], now: Rung, coming: Sequence[Rung]) -> list[Rung]:
    """Give a law's way, and what would come next.

    Args:
        rungs: the law's way; its last one is the law as it is.
        now: the law as it is, with its error as the rungs that would come have theirs.
        coming: what would come.
    """
    last = rungs[-1] if rungs else now
    if coming or LEFT_OUT not in last.errors:
        last = replace(last, errors={**last.errors, **now.errors})
    return [*rungs[:-1], last, *coming]


def waterfall_picture(rungs: Sequence[Rung], scatter: float | None, title: str, error: str = "RMS error") -> go.Figure:
    """Draw the error falling rung by rung, with the scatter that no law can explain as a line.

    Args:
        rungs: in their order.
        scatter: as a share of the rms force, where it is known.
        title: the picture's title.
        error: the error's name.
    """
    names = dict.fromkeys(name for rung in rungs for name in rung.errors)
    labels = [_label(index, rungs, scatter) for index in range(len(rungs))]
    figure = go.Figure(
        [
            go.Bar(
                x=labels,
                y=[100 * rung.errors[name] if name in rung.errors else None for rung in rungs],
                name=name,
                text=[f"{100 * rung.errors[name]:.3g} %" if name in rung.errors else "" for rung in rungs],
                textposition="outside", cliponaxis=False,
                marker={
                    "color": COLOURS.get(name, SERIES[0]),
                    "pattern": {"shape": ["/" if rung.promised else "" for rung in rungs]},
                },
            )
            for name in names
        ]
    )  # fmt: skip
    if scatter is not None:
        figure.add_hline(
            y=100 * scatter, line={"color": MODEL, "dash": "dash"},
            annotation={"text": f"scatter<br>{100 * scatter:.2g} %", "x": 1.0, "xanchor": "left", "yanchor": "middle"},
        )  # fmt: skip
    figure.update_xaxes(tickangle=0, type="category")
    figure.update_yaxes(title_text=f"{error} / % of rms force", rangemode="tozero")
    figure = styled(figure, title, least_width=min(150 + RUNG_WIDTH * len(rungs), 1100))
    return figure.update_layout(showlegend=len(names) > 1, margin={"r": 70, "b": 90}, bargap=0.25)


def _label(index: int, rungs: Sequence[Rung], scatter: float | None) -> str:
    """Give a rung's name, and below it the share that it took of what was missing before."""
    # one effect a line, so that the names stand beside each other; a blank keeps those alike apart
    name = rungs[index].label.replace(" + ", "<br>+ ").replace("or<br>+ ", "or + ") + " " * sum(
        rung.label == rungs[index].label for rung in rungs[:index]
    )
    before = next((rung for rung in reversed(rungs[:index]) if not rung.promised), None)
    shared = [key for key in (ESTIMATED, LEFT_OUT, *rungs[index].errors) if before and key in rungs[index].errors]
    shared = [key for key in shared if before and key in before.errors]
    if before is None or not shared:
        return name
    floor = (scatter or 0.0) ** 2
    missing, left = (rung.errors[shared[0]] ** 2 - floor for rung in (before, rungs[index]))
    if missing <= 0.0:
        return name
    took = min(1.0 - left / missing, 1.0)
    verb = ("would take" if rungs[index].promised else "took") if took >= 0 else "gave back"
    return f"{name}<br>{verb} {abs(took):.0%}"
