"""What `compare` answers of a law and metrics without records; errors are logs of ratios measured/computed."""

from __future__ import annotations

from pydantic import Field

from pipeclamp_identification.metrics_only.law import MetricComparison, rms
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs

MEASURE = "rms of log(measured/computed) of dW and W: the campaign has no records"


class RunMetricComparison(AnswerModel):
    """The error of one run: the rms log ratio of its dW and W, and each log ratio."""

    run: str
    nrmse: float
    noise_nrmse: None = Field(description="metrics without records show no scatter from cycle to cycle")
    dissipated_energy_log_ratio: float
    max_elastic_energy_log_ratio: float
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float | None
    outside_range: str | None = Field(description="what lies outside the range that the law was identified in")


class MetricComparisonAnswer(AnswerModel):
    """The answer of `pipeclamp compare --json` for metrics without records."""

    nrmse: float = Field(description="rms log ratio of dW and W over all runs")
    noise_nrmse: None
    measure: str = Field(description="what the error measures")
    dissipated_energy_nrmse: float
    max_elastic_energy_nrmse: float
    runs: tuple[RunMetricComparison, ...]
    left_out: tuple[LeftOutRun, ...]


def metric_comparison_answer(comparison: MetricComparison) -> MetricComparisonAnswer:
    """Give what a comparison with metrics found."""
    runs = zip(comparison.campaign.runs, comparison.logs, strict=True)
    dissipated, elastic = (rms(column) for column in comparison.logs.T)
    return MetricComparisonAnswer(
        nrmse=comparison.nrmse,
        noise_nrmse=None,
        measure=MEASURE,
        dissipated_energy_nrmse=dissipated,
        max_elastic_energy_nrmse=elastic,
        runs=tuple(
            RunMetricComparison(
                run=run.name,
                nrmse=rms(logs),
                noise_nrmse=None,
                dissipated_energy_log_ratio=float(logs[0]),
                max_elastic_energy_log_ratio=float(logs[1]),
                amplitude_mm=run.amplitude_mm,
                frequency_Hz=run.frequency_Hz,
                temperature_C=run.setup.temperature_C,
                outside_range=comparison.outside.get(run.name),
            )
            for run, logs in runs
        ),
        left_out=left_out_runs(comparison.campaign.left_out),
    )
