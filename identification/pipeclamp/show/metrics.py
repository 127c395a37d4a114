"""Loop metrics told: the paper's studies for any campaign, tables like its 2-5, and every run."""

from __future__ import annotations

import math

import numpy as np

from pipeclamp.show.table import Table
from pipeclamp.show.view import View
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.loops.answer import metrics_answer
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.loops.metrics import Metrics, metrics_of
from pipeclamp_identification.loops.one_condition import Variation, principal_variations, variations_of
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, MetricRun
from pipeclamp_identification.metrics_only.metrics_answer import metric_rows_answer
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.units import CELSIUS

MOST_SHOWN = 60
"""Runs that a terminal shows; thousands would only scroll by."""


def metric_table(campaign: MetricCampaign, most: int | None = None) -> Table:
    """Give a campaign of metrics as a table, or the first `most` runs of it."""
    rows = [
        (
            run.name, run.amplitude_mm, run.frequency_Hz, run.setup.temperature_C, run.dissipated_energy_J,
            run.max_elastic_energy_J, run.loss_factor, run.stiffness,
        )
        for run in campaign.runs[:most]
    ]  # fmt: skip
    more = f"; the first {len(rows)} of {len(campaign.runs)} runs" if len(rows) < len(campaign.runs) else ""
    return Table(
        ("run", "A / mm", "f / Hz", "T / °C", "dW / J", "W / J", "eta", "k / N/mm"),
        rows,
        f"Jiang et al. 2020, Eq. 1-6, as stated{more}",
    )


MEANINGS = (
    "dW is the energy dissipated in a cycle and W the largest elastic energy, eta = dW/(2 pi W) the loss factor, and k "
    "the stiffness: the range of the force over that of the displacement."
)


STORED_AND_LOST = ("k' / N/mm", "k'' / N/mm", "δ / °")
"""Heads of what `stored_and_lost` gives."""
OF_A_SINE = (
    "k' is the storage stiffness, in phase with the displacement, k'' the loss stiffness, a quarter of a cycle before "
    "it, and δ the loss angle between force and displacement: tan δ = k''/k'."
)


def stored_and_lost(run: MetricRun) -> tuple[float | None, float | None, float | None]:
    """Give a test's storage and loss stiffness in N/mm and its loss angle in degrees; None where no sine has them."""
    angle = run.loss_angle
    if math.isnan(angle):
        return None, None, None
    return run.stiffness * math.cos(angle), run.stiffness * math.sin(angle), math.degrees(angle)


def metrics_words(metrics: Metrics) -> str:
    """Say over which ranges the metrics of runs lie."""
    return _ranges_words(metrics.dissipated_energy_J, metrics.loss_factor, metrics.stiffness_N_mm)


MEANINGS_STATED = (
    "dW is the energy dissipated in a cycle and W the largest elastic energy, eta = dW/(2 pi W) the loss factor, and "
    "k = 2 W/X0² the stiffness, with X0 the amplitude."
)


def metric_campaign_words(campaign: MetricCampaign) -> str:
    """Say over which ranges metrics without records lie."""
    runs = [(run.dissipated_energy_J, run.loss_factor, run.stiffness) for run in campaign.runs]
    return _ranges_words(*np.array(runs).T)


def _ranges_words(dissipated_energy_J: Array, loss_factor: Array, stiffness_N_mm: Array) -> str:
    ranges = (
        (dissipated_energy_J, "dissipated energy {} J a cycle"),
        (loss_factor, "loss factor {}"),
        (stiffness_N_mm, "stiffness {} N/mm"),
    )
    told = [words.format(_range(values)) for values, words in ranges]
    return f"{counted(len(loss_factor), 'run')}: {', '.join(told)}."


def _range(values: Array) -> str:
    low, high = (f"{value:.4g}" for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def axis_of(study: Variation) -> str:
    """Give the name and unit of what a study varies."""
    return axis_of_quantity(study.quantity)


def axis_of_quantity(quantity: str) -> str:
    """Give the name and unit of a column of runs.csv."""
    return AXES.get(quantity, quantity)


def study_title(study: Variation) -> str:
    """Give what varies and what is held: "against f, at A 0.8 mm, T 20 °C"."""
    symbol, *_ = axis_of(study).split(" / ")
    held = ", ".join(setting(name, value) for name, value in study.held)
    return f"against {symbol}, at {held}" if held else f"against {symbol}"


def setting(name: str, value: float | str, *, named: bool = True) -> str:
    """Give a setting in words, "A 0.8 mm"; without its name where that is said elsewhere."""
    symbol, *unit = AXES.get(name, name).split(" / ", 1)
    number = value if isinstance(value, str) else f"{value:.3g}"
    return " ".join([*([symbol] if named or not unit else []), number, *unit])


def study_table(study: Variation, metrics: Metrics) -> Table:
    """Give the metrics of a study's runs, beside the published ones where there are any."""
    published = [row for row in study.published if row is not None]
    header = [axis_of(study), "dW / J", "W / J", "eta", "k / N/mm"]
    if published:
        header += ["paper dW / J", "paper W / J", "paper eta"]
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
    of = f"; paper: {PUBLISHED}" if published else ""
    return Table(header, rows, f"Loop metrics {study_title(study)}{of}")


PUBLISHED = "the specimen of Jiang et al. 2020, Tables 2-5, at these conditions; no measurement of this campaign"

AXES = {
    "frequency_Hz": "f / Hz",
    "amplitude_mm": "A / mm",
    "density_g_cm3": "density / g/cm³",
    "temperature_C": "T / °C",
    "first_cycle": "cycles before",
}


def runs_table(loops: Loops, metrics: Metrics, scatter: Metrics) -> Table:
    """Give the metrics of every run, with their scatter from cycle to cycle."""
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


def metrics_view(campaign: Campaign, loops: Loops) -> View:
    """Tell the metrics of records' loops: a table for each quantity that varies."""
    metrics = metrics_of(loops)
    studies = principal_variations(variations_of(campaign, loops))
    tables = [study_table(study, metrics) for study in studies]
    shown = {row for study in studies for row in study.rows}
    lines = (metrics_words(metrics), MEANINGS)
    return View(metrics_answer(campaign, loops), tables, lines, whole=len(shown) == len(campaign.runs))


def metric_rows_view(campaign: MetricCampaign) -> View:
    """Tell metrics that were stated without records."""
    lines = (metric_campaign_words(campaign), f"They are known by metrics alone, without records. {MEANINGS_STATED}")
    tables = [metric_table(campaign, MOST_SHOWN)]
    return View(metric_rows_answer(campaign), tables, lines, whole=len(campaign.runs) <= MOST_SHOWN)
