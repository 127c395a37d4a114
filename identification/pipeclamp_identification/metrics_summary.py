"""What `pipeclamp metrics --json` says: metrics, harmonics and decomposition per run, and the studies."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from pipeclamp.symbols import CELSIUS
from pipeclamp_identification.campaign import Campaign
from pipeclamp_identification.decomposition import Decomposition, PowerSeries, decompose
from pipeclamp_identification.harmonics import Array
from pipeclamp_identification.loops import Loops, per_cycle
from pipeclamp_identification.metrics import Metrics, metrics_of, scatter_of
from pipeclamp_identification.studies import Study, studies_of


def metrics_json(campaign: Campaign, loops: Loops) -> dict[str, Any]:
    """Return everything that is measured of a campaign's loops, ready for `json.dumps`.

    Args:
        campaign: the campaign.
        loops: its loops, one row per run.

    Returns:
        "runs" with the fields of CONTRACT.md and more, "studies", "left_out", "noise_nrmse"; what isn't known is None.
    """
    metrics, scatter = metrics_of(loops), scatter_of(loops)
    single = metrics_of(per_cycle(loops))
    ends = np.cumsum([len(cycles) for cycles in loops.cycles])
    decompositions = decompose(loops)
    runs = []
    for row, run in enumerate(campaign.runs):
        cycles = slice(int(ends[row]) - len(loops.cycles[row]), int(ends[row]))
        runs.append(
            {
                "run": run.name,
                "specimen": run.specimen,
                "amplitude_mm": loops.amplitude_mm[row],
                "frequency_Hz": loops.frequency_Hz[row],
                "temperature_C": loops.temperature_K[row] - CELSIUS,
                "density_g_cm3": loops.density_g_cm3[row],
                **{name: values[row] for name, values in loops.conditions.items()},
                "cycle": loops.cycle[row],
                "cycles": len(loops.cycles[row]),
                **_row(metrics, row),
                "cycle_to_cycle": _row(scatter, row),
                "per_cycle": {"cycle": loops.cycles[row], **_row(single, cycles)},
                "mean_force_N": decompositions[row].mean_force_N,
                "mean_displacement_mm": decompositions[row].mean_displacement_mm,
                "noise_nrmse": loops.noise_rms_N[row] / loops.force_rms_N[row] if loops.show_scatter[row] else None,
                "force_in_phase_N": loops.force[row, 1:].real,
                "force_in_quadrature_N": loops.force[row, 1:].imag,
                "force_standard_error_N": loops.force_standard_error[row, 1:],
                "decomposition": _decomposition(decompositions[row]),
            }
        )
    summary = {
        "campaign": campaign.name,
        "fingerprint": campaign.fingerprint,
        "runs": runs,
        "left_out": [asdict(one) for one in campaign.left_out],
        "studies": [_study(study, loops, metrics) for study in studies_of(campaign, loops)],
        "noise_nrmse": loops.noise_nrmse if any(loops.show_scatter) else None,
    }
    plain: dict[str, Any] = _plain(summary)
    return plain


def _row(metrics: Metrics, row: int | slice) -> dict[str, Array]:
    return {name: values[row] for name, values in vars(metrics).items()}


def _decomposition(parts: Decomposition) -> dict[str, Any]:
    def series(part: PowerSeries) -> list[dict[str, float]]:
        columns = zip(part.powers, part.coefficients, part.standard_errors, strict=True)
        return [{"power": power, "value": value, "standard_error": error} for power, value, error in columns]

    return {
        "order": parts.order,
        "elastic": series(parts.elastic),
        "damping": series(parts.damping),
        "misfit": parts.misfit,
    }


def _study(study: Study, loops: Loops, metrics: Metrics) -> dict[str, Any]:
    rows = [
        {
            "run": loops.run[row],
            study.quantity: value,
            **_row(metrics, row),
            "published": None if published is None else asdict(published),
        }
        for row, value, published in zip(study.rows, study.values, study.published, strict=True)
    ]
    return {"quantity": study.quantity, "held": dict(study.held), "rows": rows}


def _plain(value: Any) -> Any:
    """Turn arrays into lists, numpy's numbers into Python's, and what is not finite into None, for JSON has neither."""
    if isinstance(value, dict):
        return {key: _plain(member) for key, member in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(member) for member in value]
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value
