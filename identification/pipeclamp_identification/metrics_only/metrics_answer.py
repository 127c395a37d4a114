"""What `metrics` answers of a campaign that holds metrics without records."""

from __future__ import annotations

from pydantic import ConfigDict

from pipeclamp_identification.metrics_only.campaign import MetricCampaign
from pipeclamp_identification.metrics_only.writing import metric_rows
from pipeclamp_models.base.answer import AnswerModel


class MetricRow(AnswerModel):
    """A run by its metrics; further columns of runs.csv stand beside by their own names."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, float | None]

    run: str
    specimen: str | None
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    density_g_cm3: float | None
    first_cycle: float
    dissipated_energy_J: float
    max_elastic_energy_J: float
    loss_factor: float
    stiffness_N_mm: float


class MetricRowsAnswer(AnswerModel):
    """The answer of `pipeclamp metrics --json` for metrics without records."""

    runs: tuple[MetricRow, ...]


def metric_rows_answer(campaign: MetricCampaign) -> MetricRowsAnswer:
    """Give a campaign's metrics."""
    return MetricRowsAnswer(runs=tuple(MetricRow.model_validate(row) for row in metric_rows(campaign)))
