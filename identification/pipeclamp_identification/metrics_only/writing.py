"""A campaign's loops turned into a campaign of metrics: what a table in a paper would have kept of them."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pipeclamp_identification.campaign.description import description_text
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.loops.metrics import metrics_of
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, MetricRun
from pipeclamp_models.base.digits import plain, rounded_to
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_folder
from pipeclamp_models.base.units import celsius_of

METRIC_DIGITS = 6
"""Significant digits of metrics and measured conditions: more than loops repeat to."""


def as_metrics(campaign: Campaign, loops: Loops) -> MetricCampaign:
    """Give a campaign's loops by their metrics; amplitude and frequency are the measured ones.

    Args:
        campaign: the tests.
        loops: `loops_of(campaign)`.
    """
    metrics = metrics_of(loops)
    half_a_unit = 0.5 * 10.0 ** (1 - METRIC_DIGITS) / math.sqrt(3)
    runs = tuple(
        MetricRun(
            name=run.name,
            setup=replace(
                run.setup,
                temperature_C=_known(celsius_of(loops.temperature_K[row])),
                density_g_cm3=_known(loops.density_g_cm3[row]),
                first_cycle=_digits(loops.cycle[row]),
            ),
            amplitude_mm=_digits(loops.amplitude_mm[row]),
            frequency_Hz=_digits(loops.frequency_Hz[row]),
            dissipated_energy_J=_digits(metrics.dissipated_energy_J[row]),
            max_elastic_energy_J=_digits(metrics.max_elastic_energy_J[row]),
            rounding=(half_a_unit, half_a_unit),
        )
        for row, run in enumerate(campaign.runs)
    )
    return MetricCampaign(
        campaign.name, campaign.notes, campaign.fingerprint, runs, campaign.left_out, campaign.condition_columns,
        campaign.time_measured,
    )  # fmt: skip


def metric_rows(campaign: MetricCampaign) -> list[dict[str, str | float | None]]:
    """Give a campaign of metrics as the rows of its runs.csv."""
    return [
        {
            "run": run.name,
            "specimen": run.setup.specimen,
            "amplitude_mm": run.amplitude_mm,
            "frequency_Hz": run.frequency_Hz,
            "temperature_C": run.setup.temperature_C,
            "density_g_cm3": run.setup.density_g_cm3,
            "first_cycle": run.setup.first_cycle,
            **{name: _known(run.setup.conditions[name]) for name in campaign.condition_columns},
            "dissipated_energy_J": run.dissipated_energy_J,
            "max_elastic_energy_J": run.max_elastic_energy_J,
            "loss_factor": _digits(run.loss_factor),
            "stiffness_N_mm": _digits(run.stiffness),
        }
        for run in campaign.runs
    ]


def write_metrics(folder: Path, campaign: MetricCampaign) -> tuple[LeftOut, ...]:
    """Write a campaign of metrics into a new folder; it appears whole or not at all.

    Returns:
        runs that are left out, for their loops make energy: metrics are held against laws by the logs of their ratios.

    Raises:
        UserError: no run is left, the folder exists, or its parent can't be written.
    """
    left_out = tuple(
        LeftOut(run.name, f"its loop makes energy: dW is {plain(run.dissipated_energy_J, 3)} J a cycle")
        for run in campaign.runs
        if run.dissipated_energy_J <= 0.0
    )
    names = [one.run for one in left_out]
    kept = tuple(run for run in campaign.runs if run.name not in names)
    if not kept:
        raise UserError(
            f"{campaign.name}: all its loops make energy, as no passive device does, so that no metrics can be "
            "written; expected dW above 0: check the sign of force and displacement, and a delay between them"
        )
    said = f"Left out, for their loops make energy: {', '.join(names)}." if names else ""
    notes = " ".join(filter(None, [campaign.notes, said]))
    write_folder(folder, metric_files(replace(campaign, runs=kept, notes=notes)))
    return left_out


def metric_files(campaign: MetricCampaign) -> Iterator[tuple[str, bytes]]:
    """Give the files of a campaign of metrics as (path inside the folder, content)."""
    rows = metric_rows(campaign)
    stream = io.StringIO()
    table = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    table.writeheader()
    table.writerows({name: "" if cell is None else cell for name, cell in row.items()} for row in rows)
    yield "runs.csv", stream.getvalue().encode()
    text = description_text(campaign.name, campaign.notes, time_measured=campaign.time_measured)
    yield "campaign.toml", text.encode()


def _digits(value: float) -> float:
    return rounded_to(value, METRIC_DIGITS)


def _known(value: float) -> float | None:
    return _digits(value) if math.isfinite(value) else None
