"""The paper's studies for any campaign: tables like its 2-5 and loop overlays like its Fig. 5-8."""

from __future__ import annotations

from pipeclamp.pages.page import Section
from pipeclamp.pages.pictures import curves_picture, overlay_picture
from pipeclamp.pages.sweeps import of_energy, sweep_sections
from pipeclamp.show.metrics import (
    MEANINGS,
    MEANINGS_STATED,
    axis_of,
    metric_campaign_words,
    metric_table,
    metrics_words,
    runs_table,
    setting,
    study_table,
)
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.comparison.sentences import sentence
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.loops.metrics import Metrics, metrics_of, scatter_of
from pipeclamp_identification.loops.one_condition import Variation, loops_to_draw, principal_variations, variations_of
from pipeclamp_identification.metrics_only.campaign import MetricCampaign


def metrics_sections(campaign: Campaign, loops: Loops) -> list[Section]:
    """Give the report: one study for each quantity that varies, then every run."""
    metrics, scatter = metrics_of(loops), scatter_of(loops)
    studies = principal_variations(variations_of(campaign, loops))
    answer = Section("Answer", [metrics_words(metrics), MEANINGS])
    sections = [answer, *(_study_section(study, loops, metrics) for study in studies)]
    noted = [*(sentence(str(entry)) for entry in campaign.left_out), *(f"Note: {one}." for one in campaign.remarks)]
    return [*sections, Section("All runs", noted, [runs_table(loops, metrics, scatter)])]


def metric_campaign_sections(campaign: MetricCampaign) -> list[Section]:
    """Give the report of metrics without records: over what was varied, then every run."""
    answer = Section("Answer", [metric_campaign_words(campaign), MEANINGS_STATED])
    noted = [sentence(str(entry)) for entry in campaign.left_out]
    every = Section("All runs", noted, [metric_table(campaign)])
    return [answer, *sweep_sections(campaign, of_energy(campaign)), every]


def _study_section(study: Variation, loops: Loops, metrics: Metrics) -> Section:
    axis = axis_of(study)
    published = [row for row in study.published if row is not None]
    names = [setting(study.quantity, value, named=False) for value in study.values]
    drawn = [(name, *loop) for name, loop in zip(names, loops_to_draw(loops, study), strict=True)]
    measured = [
        (name, study.values, [float(values[row]) for row in study.rows], "lines+markers")
        for name, values in (("dW", metrics.dissipated_energy_J), ("W", metrics.max_elastic_energy_J))
    ]
    places = [value for value, row in zip(study.values, study.published, strict=True) if row]
    beside_them = [
        ("paper dW", places, [row.dissipated_energy_J for row in published], "markers"),
        ("paper W", places, [row.max_elastic_energy_J for row in published], "markers"),
    ]
    return Section(
        f"Against {axis}",
        (),
        [study_table(study, metrics)],
        [
            overlay_picture(drawn, f"Loops against {axis}"),
            curves_picture(
                axis, "energy / J", [*measured, *(beside_them if published else [])], f"Energy against {axis}"
            ),
        ],
    )
