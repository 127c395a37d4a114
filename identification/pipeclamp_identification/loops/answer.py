"""What `metrics` answers of records: metrics, harmonics and decomposition of each run, and the studies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict

import numpy as np
from pydantic import ConfigDict, Field

from pipeclamp_identification.campaign.faults import SensorFault
from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.loops.decomposition import Decomposition, PowerSeries, decompose
from pipeclamp_identification.loops.loops import Loops, per_cycle
from pipeclamp_identification.loops.metrics import Metrics, metrics_of, scatter_of
from pipeclamp_identification.loops.one_condition import Variation, variations_of
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, known, known_numbers, left_out_runs
from pipeclamp_models.base.units import CELSIUS


class LoopMetrics(AnswerModel):
    """Metrics of a loop, Eq. 1-6 of Symmetry 2020, 12(8), 1283, or their scatter from cycle to cycle."""

    dissipated_energy_J: float | None = Field(description="dW: the loop's area, J")
    max_elastic_energy_J: float | None = Field(description="W, J")
    loss_factor: float | None = Field(description="eta = dW/(2 pi W)")
    stiffness_N_mm: float | None = Field(description="k = (Fmax - Fmin)/(2 X0), N/mm")
    force_max_N: float | None
    force_min_N: float | None


class MetricsPerCycle(AnswerModel):
    """The same of each cycle, one entry a cycle."""

    cycle: tuple[float | None, ...] = Field(description="load cycles that the specimen had seen")
    dissipated_energy_J: tuple[float | None, ...]
    max_elastic_energy_J: tuple[float | None, ...]
    loss_factor: tuple[float | None, ...]
    stiffness_N_mm: tuple[float | None, ...]
    force_max_N: tuple[float | None, ...]
    force_min_N: tuple[float | None, ...]


class SeriesTerm(AnswerModel):
    """One term of a power series: N over mm, or over mm/s, to the power."""

    power: int
    value: float | None
    standard_error: float | None


class LoopDecomposition(AnswerModel):
    """A loop as an elastic force, a series in y, and a damping force, a series in v (Eq. 7-10)."""

    order: int
    elastic: tuple[SeriesTerm, ...]
    damping: tuple[SeriesTerm, ...]
    misfit: float | None = Field(description="what the two leave over, as a share of the force")


class RunConditions(AnswerModel):
    """A run's conditions."""

    run: str
    specimen: str | None
    amplitude_mm: float | None
    frequency_Hz: float | None
    temperature_C: float | None
    density_g_cm3: float | None
    cycle: float | None = Field(description="load cycles that the specimen had seen, in the middle of the record")
    cycles: int


class RunMetrics(LoopMetrics, RunConditions):
    """A run by its loop; further columns of runs.csv stand beside by their own names."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, float | None]

    cycle_to_cycle: LoopMetrics = Field(description="standard deviation from cycle to cycle")
    per_cycle: MetricsPerCycle
    mean_force_N: float | None
    mean_displacement_mm: float | None
    noise_nrmse: float | None = Field(description="cycle-to-cycle scatter as a share of the rms force")
    force_in_phase_N: tuple[float | None, ...] = Field(
        description="amplitude of each harmonic in phase with the displacement"
    )
    force_in_quadrature_N: tuple[float | None, ...]
    force_standard_error_N: tuple[float | None, ...]
    decomposition: LoopDecomposition


class PublishedMetrics(AnswerModel):
    """A row of the paper's tables at the same conditions."""

    table: int
    specimen: str
    density_g_cm3: float
    amplitude_mm: float
    frequency_Hz: float
    temperature_C: float
    loss_factor: float
    dissipated_energy_J: float
    max_elastic_energy_J: float


class RunName(AnswerModel):
    """Which run."""

    run: str


class StudyRow(LoopMetrics, RunName):
    """One run of a study; the value of what is varied stands beside by its own name."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, float | None]

    published: PublishedMetrics | None


class StudyAnswer(AnswerModel):
    """Runs between which one quantity varies while the others are held."""

    quantity: str
    held: Mapping[str, float | str]
    rows: tuple[StudyRow, ...]


class MetricsAnswer(AnswerModel):
    """The answer of `pipeclamp metrics --json` for records."""

    campaign: str
    fingerprint: str
    runs: tuple[RunMetrics, ...]
    left_out: tuple[LeftOutRun, ...]
    sensors: tuple[SensorFault, ...] = Field(description="gross faults of sensors, and what was done about them")
    studies: tuple[StudyAnswer, ...]
    noise_nrmse: float | None = Field(
        description="scatter over all runs as a share of the force; None of single cycles"
    )


def metrics_answer(campaign: Campaign, loops: Loops) -> MetricsAnswer:
    """Give everything that is measured of a campaign's loops.

    Args:
        campaign: the campaign.
        loops: its loops, one row per run.
    """
    metrics, scatter = metrics_of(loops), scatter_of(loops)
    single = metrics_of(per_cycle(loops))
    ends = np.cumsum([len(cycles) for cycles in loops.cycles])
    decompositions = decompose(loops)
    runs = []
    for row, run in enumerate(campaign.runs):
        cycles = slice(int(ends[row]) - len(loops.cycles[row]), int(ends[row]))
        runs.append(
            RunMetrics.model_validate(
                {
                    "run": run.name,
                    "specimen": run.setup.specimen,
                    "amplitude_mm": known(loops.amplitude_mm[row]),
                    "frequency_Hz": known(loops.frequency_Hz[row]),
                    "temperature_C": known(loops.temperature_K[row] - CELSIUS),
                    "density_g_cm3": known(loops.density_g_cm3[row]),
                    **{name: known(values[row]) for name, values in loops.conditions.items()},
                    "cycle": known(loops.cycle[row]),
                    "cycles": len(loops.cycles[row]),
                    **_of_row(metrics, row),
                    "cycle_to_cycle": _of_row(scatter, row),
                    "per_cycle": {
                        "cycle": known_numbers(loops.cycles[row]),
                        **{name: known_numbers(values[cycles]) for name, values in vars(single).items()},
                    },
                    "mean_force_N": known(decompositions[row].mean_force_N),
                    "mean_displacement_mm": known(decompositions[row].mean_displacement_mm),
                    "noise_nrmse": _scatter_share(loops, row),
                    "force_in_phase_N": known_numbers(loops.force[row, 1:].real),
                    "force_in_quadrature_N": known_numbers(loops.force[row, 1:].imag),
                    "force_standard_error_N": known_numbers(loops.force_standard_error[row, 1:]),
                    "decomposition": _decomposition(decompositions[row]),
                }
            )
        )
    return MetricsAnswer(
        campaign=campaign.name,
        fingerprint=campaign.fingerprint,
        runs=tuple(runs),
        left_out=left_out_runs(campaign.left_out),
        sensors=campaign.faults,
        studies=tuple(_study(study, loops, metrics) for study in variations_of(campaign, loops)),
        noise_nrmse=known(loops.noise_nrmse) if any(loops.shows_scatter) else None,
    )


def _of_row(metrics: Metrics, row: int) -> dict[str, float | None]:
    return {name: known(values[row]) for name, values in vars(metrics).items()}


def _scatter_share(loops: Loops, row: int) -> float | None:
    return known(loops.noise_rms_N[row] / loops.force_rms_N[row]) if loops.shows_scatter[row] else None


def _decomposition(parts: Decomposition) -> LoopDecomposition:
    def terms(series: PowerSeries) -> tuple[SeriesTerm, ...]:
        columns = zip(series.powers, series.coefficients, series.standard_errors, strict=True)
        return tuple(
            SeriesTerm(power=int(power), value=known(value), standard_error=known(error))
            for power, value, error in columns
        )

    return LoopDecomposition(
        order=parts.order, elastic=terms(parts.elastic), damping=terms(parts.damping), misfit=known(parts.misfit)
    )


def _study(study: Variation, loops: Loops, metrics: Metrics) -> StudyAnswer:
    rows = tuple(
        StudyRow.model_validate(
            {
                "run": loops.run[row],
                study.quantity: known(value),
                **_of_row(metrics, row),
                "published": None if published is None else asdict(published),
            }
        )
        for row, value, published in zip(study.rows, study.values, study.published, strict=True)
    )
    return StudyAnswer(quantity=study.quantity, held=dict(study.held), rows=rows)
