"""The page of a campaign before any test: what hours buy, from which size each effect is named, and the order."""

from __future__ import annotations

import math

import numpy as np
import plotly.graph_objects as go

from pipeclamp.pages.page import MODEL, SERIES, Report, Section, log_axis, styled
from pipeclamp.show.campaign_plan import campaign_plan_words, effects_table, stages_table
from pipeclamp_identification.planning.campaign import CampaignPlan
from pipeclamp_identification.planning.telling import NAMED
from pipeclamp_identification.workflow.next_step import NextStep

HOURS_WORDS = (
    "Each dot is a plan that was looked at; those that can tell fewer effects are hollow. An effect's size is its rms "
    "force over the loops within the limits."
)


def campaign_plan_page(plan: CampaignPlan, following: NextStep | None = None) -> Report:
    """Give the report of a plan, with what comes next where that is known."""
    words = [*campaign_plan_words(plan), *(following.before() if following else ())]
    sections = [
        Section("The plan", words, [stages_table(plan)], command=following.line if following else ""),
        Section("What hours buy", (HOURS_WORDS,), (), [hours_picture(plan)]),
        Section(
            "From which size on",
            ("Grey: each effect; red: all of them.",),
            [effects_table(plan)],
            [effects_picture(plan)],
        ),
        Section("In which order", ("The larger a dot, the larger the run's amplitude.",), (), [order_picture(plan)]),
    ]
    return Report("Test plan", f"for a clamp like {plan.law}", sections)


def hours_picture(plan: CampaignPlan) -> go.Figure:
    """Draw what each plan that was tried names, over its hours, and the chosen one."""
    figure = go.Figure()
    most = int(plan.power.told.sum())
    for name, own, symbol in (
        (f"tells {most} effects or more", [one for one in plan.tried if one.told >= most], "circle"),
        ("tells fewer", [one for one in plan.tried if one.told < most], "circle-open"),
    ):
        known = [one for one in own if math.isfinite(one.newtons)]
        if known:
            figure.add_scatter(
                x=[one.hours for one in known], y=[one.newtons for one in known], mode="markers", name=name,
                marker={"size": 6, "color": SERIES[0], "symbol": symbol}, customdata=[one.runs for one in known],
                hovertemplate="%{x:.3g} h, %{customdata} runs: %{y:.3g} N<extra></extra>",
            )  # fmt: skip
    if math.isfinite(plan.power.from_newtons):
        figure.add_scatter(
            x=[plan.hours], y=[plan.power.from_newtons], mode="markers", name="this plan",
            marker={"size": 13, "color": MODEL, "symbol": "diamond"},
        )  # fmt: skip
    figure.update_xaxes(title_text="rig hours")
    newtons = [plan.power.from_newtons, *(one.newtons for one in plan.tried)]
    figure.update_yaxes(title_text=f"names {NAMED:.0%} of effects above / N", **log_axis(newtons))
    return styled(figure, "Plans that were looked at")


def effects_picture(plan: CampaignPlan) -> go.Figure:
    """Draw the chance that each effect is named over its size."""
    scene, told = plan.power.scene, plan.power.told
    sizes = plan.power.sizes[told]
    if not len(sizes):
        return styled(go.Figure(), "No effect is named")
    newtons = np.geomspace(sizes.min() / 4, sizes.max() * 2, 60)
    chances = np.array([plan.power.chance(size) for size in newtons])[:, told]
    figure = go.Figure()
    for place, name in enumerate(np.array(scene.effects)[told].tolist()):
        figure.add_scatter(
            x=newtons, y=100 * chances[:, place], mode="lines", name=name, showlegend=False, opacity=0.35,
            line={"color": SERIES[7], "width": 1.2}, hovertemplate=f"{name}: %{{x:.3g}} N, %{{y:.0f}}%<extra></extra>",
        )  # fmt: skip
    figure.add_scatter(
        x=newtons, y=100 * chances.mean(axis=1), mode="lines", name="all of them", showlegend=False,
        line={"color": MODEL, "width": 3}, hovertemplate="all: %{x:.3g} N, %{y:.0f}%<extra></extra>",
    )  # fmt: skip
    figure.update_xaxes(title_text="rms force of the effect / N", **log_axis(newtons))
    figure.update_yaxes(title_text="named / %", range=[0, 103])
    return styled(figure, "Chance that an effect is named")


def order_picture(plan: CampaignPlan) -> go.Figure:
    """Draw the runs over the hours: temperature, and amplitude by the size of a dot."""
    figure = go.Figure()
    highest = max(run.amplitude_mm for run in plan.runs)
    for kind, colour in (("test", SERIES[0]), ("reference", MODEL)):
        own = [run for run in plan.runs if run.kind == kind]
        figure.add_scatter(
            x=[run.start_min / 60 for run in own], y=[run.frequency_Hz for run in own], mode="markers", name=kind,
            marker={"color": colour, "size": [4 + 8 * run.amplitude_mm / highest for run in own], "opacity": 0.7},
            text=[f"{run.run}: {run.amplitude_mm:g} mm, {run.temperature_C:g} °C" for run in own],
            hovertemplate="%{x:.2f} h<br>%{text}<extra></extra>",
        )  # fmt: skip
    for block in range(1, plan.runs[-1].block + 1):
        own = [run for run in plan.runs if run.block == block]
        middle = (own[0].start_min + own[-1].start_min) / 120
        figure.add_annotation(
            x=middle, y=1.02, yref="paper", yanchor="bottom", showarrow=False, text=f"{own[0].temperature_C:g} °C"
        )
    figure.update_xaxes(title_text="rig hours")
    figure.update_yaxes(title_text="f / Hz", **log_axis(run.frequency_Hz for run in plan.runs))
    return styled(figure, "Order of the runs").update_layout(margin={"t": 80})
