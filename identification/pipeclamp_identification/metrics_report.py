"""The paper's studies for any campaign: tables like its 2-5 and loop overlays like its Fig. 5-8."""

from __future__ import annotations

import math

from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.loops import Loops
from pipeclamp_identification.metrics import Metrics, metrics_of, scatter_of
from pipeclamp_identification.pictures import curves_picture, overlay_picture
from pipeclamp_identification.report import Section, Table
from pipeclamp_identification.studies import Study, loops_to_draw, principal_studies, studies_of

AXES = {
    "frequency_Hz": "f / Hz",
    "amplitude_mm": "A / mm",
    "density_g_cm3": "density / g/cm³",
    "temperature_C": "T / °C",
}


def metrics_sections(campaign: Campaign, loops: Loops) -> list[Section]:
    """Give the report: one study for each quantity that varies, then every run."""
    metrics, scatter = metrics_of(loops), scatter_of(loops)
    studies = principal_studies(studies_of(campaign, loops))
    sections = [_study_section(study, loops, metrics) for study in studies]
    noted = [*(f"Left out: {entry}." for entry in campaign.left_out), *(f"Note: {one}." for one in campaign.remarks)]
    return [*sections, Section("All runs", noted, [_runs_table(loops, metrics, scatter)])]


def _study_section(study: Study, loops: Loops, metrics: Metrics) -> Section:
    axis = AXES.get(study.quantity, study.quantity)
    published = [row for row in study.published if row is not None]
    header = [axis, "dW / J", "W / J", "eta", "k / N/mm"]
    if published:
        header += ["published dW / J", "published W / J", "published eta"]
    rows: list[list[str | float | None]] = []
    for value, row, beside in zip(study.values, study.rows, study.published, strict=True):
        entries: list[str | float | None] = [
            value,
            float(metrics.dissipated_energy_J[row]),
            float(metrics.max_elastic_energy_J[row]),
            float(metrics.loss_factor[row]),
            float(metrics.stiffness_N_mm[row]),
        ]
        if published:
            entries += (
                [beside.dissipated_energy_J, beside.max_elastic_energy_J, beside.loss_factor] if beside else [None] * 3
            )
        rows.append(entries)
    measured = [
        (name, study.values, [float(values[row]) for row in study.rows], "lines+markers")
        for name, values in (("dW", metrics.dissipated_energy_J), ("W", metrics.max_elastic_energy_J))
    ]
    places = [value for value, row in zip(study.values, study.published, strict=True) if row]
    beside_them = [
        ("published dW", places, [row.dissipated_energy_J for row in published], "markers"),
        ("published W", places, [row.max_elastic_energy_J for row in published], "markers"),
    ]
    return Section(
        f"Against {axis}",
        [f"Held: {', '.join(f'{name} {value}' for name, value in study.held) or 'nothing'}."],
        [Table(header, rows, f"Loop metrics {study.title}")],
        [
            overlay_picture(loops_to_draw(loops, study), f"Loops against {axis}"),
            curves_picture(
                axis, "energy / J", [*measured, *(beside_them if published else [])], f"Energy against {axis}"
            ),
        ],
    )


def _runs_table(loops: Loops, metrics: Metrics, scatter: Metrics) -> Table:
    rows = [
        (
            run,
            float(loops.amplitude_mm[row]),
            float(loops.frequency_Hz[row]),
            _known(loops.temperature_K[row] - CELSIUS),
            float(metrics.dissipated_energy_J[row]),
            _known(scatter.dissipated_energy_J[row]),
            float(metrics.max_elastic_energy_J[row]),
            _known(scatter.max_elastic_energy_J[row]),
            float(metrics.loss_factor[row]),
            float(metrics.stiffness_N_mm[row]),
        )
        for row, run in enumerate(loops.run)
    ]
    header = ("run", "A / mm", "f / Hz", "T / °C", "dW / J", "± dW", "W / J", "± W", "eta", "k / N/mm")
    caption = "Jiang et al. 2020, Eq. 1-6, of the cycle-averaged loop; ± is the scatter from cycle to cycle"
    return Table(header, rows, caption)


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
