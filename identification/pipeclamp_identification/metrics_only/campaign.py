"""Campaigns of metrics: loops whose records aren't there, known by their dissipated and elastic energy alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.description import CampaignDescription
from pipeclamp_identification.campaign.fingerprint import digests_of
from pipeclamp_identification.campaign.runs_table import FILE_NAME, METRIC_COLUMNS, RunRow, RunsTable, Setup
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.fitting.observations import assumed_signals, known_temperature
from pipeclamp_identification.loops.energies import stiffness_of_energy
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import condition_signal
from pipeclamp_models.realise.motion import sinusoids

SCATTER_BEFOREHAND = 0.01
"""Share by which metrics scatter from run to run before any data says so: a good rig's fraction of a percent, and what
reading a loop's extremes adds."""
SAMPLES_PER_CYCLE = 256
"""Points of the cycle at which laws are evaluated: an extreme between two of them is higher by less than 0.01 %."""
MOST_DISSIPATED = 8.0
"""dW over W of the fullest loop that there is, a rectangle: 2 X0 by Fmax - Fmin, and W is a quarter of Fmax - Fmin by
X0."""
OF_A_PHASE = ("storage_stiffness_N_mm", "loss_stiffness_N_mm")
"""Stiffness in phase with the displacement and with the velocity: of a sine, k = |k' + i k''|, dW = pi k'' X0^2."""
RECKONED = 1e50
"""Largest number, and the reciprocal of the smallest, of which squares and products are surely numbers, too."""
AGREEING_SHARE = 0.01
"""A third metric that is stated beside two others must agree with them to this share, rounding aside."""


@dataclass(frozen=True)
class MetricRun:
    """One loop by its metrics.

    Attributes:
        name: of the run.
        setup: the conditions of the test.
        amplitude_mm, frequency_Hz: of its motion.
        dissipated_energy_J, max_elastic_energy_J: dW and W.
        rounding: what it leaves open of dW and of W, as shares.
    """

    name: str
    setup: Setup
    amplitude_mm: float
    frequency_Hz: float
    dissipated_energy_J: float
    max_elastic_energy_J: float
    rounding: tuple[float, float]

    @property
    def stiffness(self) -> float:
        """Stiffness in N/mm that belongs to W: k = 2 W/X0^2, Eq. 4."""
        return stiffness_of_energy(self.max_elastic_energy_J, self.amplitude_mm)

    @property
    def loss_factor(self) -> float:
        """Loss factor, eta = dW/(2 pi W), Eq. 6."""
        return self.dissipated_energy_J / (2 * math.pi * self.max_elastic_energy_J)

    @property
    def loss_angle(self) -> float:
        """Angle in rad by which the force of a sine leads the displacement, sin(delta) = eta; nan of a fuller loop."""
        return math.asin(self.loss_factor) if self.loss_factor <= 1 else math.nan


@dataclass(frozen=True)
class MetricCampaign:
    """The loops of one clamp by their metrics.

    Attributes:
        name, notes: of its description.
        fingerprint: SHA-256 over all that it was read from.
        runs: in runs.csv's order.
        left_out: those that can't be used, and why.
        condition_columns: of runs.csv, of further conditions.
        time_measured: whether its frequencies are: otherwise loops were taken without a time.
    """

    name: str
    notes: str
    fingerprint: str
    runs: tuple[MetricRun, ...]
    left_out: tuple[LeftOut, ...]
    condition_columns: tuple[str, ...]
    time_measured: bool = True


def metric_campaign_of(
    folder: Path, description: CampaignDescription, table: RunsTable, strict: bool
) -> MetricCampaign:
    """Give the metrics of a campaign whose description and table have been read.

    Raises:
        UserError: no run can be used; or, with `strict`, one can't.
    """
    _refuse_half(folder / FILE_NAME, table)
    runs: list[MetricRun] = []
    left_out: list[LeftOut] = []
    first: dict[tuple[object, ...], str] = {}
    for row in table.rows:
        reason = _unusable(row)
        run = None if reason else _run(folder / FILE_NAME, row)
        if run:
            reason = _impossible(run)
        twin = first.setdefault(_numbers_of(run), run.name) if run and not reason else row.run
        if twin != row.run:
            reason = f"it has the same numbers as run {twin!r}: one measurement, counted once"
        if reason:
            left_out.append(LeftOut(row.run, reason))
        elif run:
            runs.append(run)
    if left_out and (strict or not runs):
        heading = f"{folder}: {len(left_out)} of {len(table.rows)} runs can't be used; fill in or take out their rows"
        raise UserError("\n".join([heading, *(f"  {one}" for one in left_out)]))
    return MetricCampaign(
        name=description.name,
        notes=description.notes,
        fingerprint=digests_of(folder, {}).fingerprint,
        runs=tuple(runs),
        left_out=tuple(left_out),
        condition_columns=table.condition_columns,
        time_measured=description.time_measured,
    )


def _refuse_half(path: Path, table: RunsTable) -> None:
    """Refuse a table that tells only how much loops dissipate, or only how stiff they are."""
    stated = {column for row in table.rows for column in row.metrics}
    energies = stated - set(OF_A_PHASE)
    if not stated >= set(OF_A_PHASE) and (len(energies) < 2 or energies == {"max_elastic_energy_J", "stiffness_N_mm"}):
        raise UserError(
            f"{path}: states {' and '.join(sorted(stated)) or 'no metric'} only; expected two of "
            f"{', '.join(METRIC_COLUMNS)} that give dW and W: a law's damping follows from one, its stiffness from the "
            "other"
        )


def _unusable(row: RunRow) -> str:
    """Say why a row can't be used; empty where it can."""
    for column, value in (("amplitude_mm", row.amplitude_mm), ("frequency_Hz", row.frequency_Hz)):
        if value is None:
            return f"{column} isn't known, and there is no record to measure it from"
    numbers = [row.amplitude_mm, row.frequency_Hz, *(metric.value for metric in row.metrics.values())]
    if any(number and not 1 / RECKONED <= number <= RECKONED for number in numbers):
        return f"a number of it is below {1 / RECKONED:g} or above {RECKONED:g}, as none of a test is"
    stated = set(row.metrics)
    if stated >= set(OF_A_PHASE):
        return ""
    if not stated & {"max_elastic_energy_J", "stiffness_N_mm"} and not stated >= {"dissipated_energy_J", "loss_factor"}:
        return "its elastic energy isn't known"
    if not stated & {"dissipated_energy_J", "loss_factor"}:
        return "its dissipated energy isn't known"
    return ""


def _run(path: Path, row: RunRow) -> MetricRun:
    """Give a row's dW and W, from whichever two metrics it states; a third must agree."""
    assert row.amplitude_mm is not None
    assert row.frequency_Hz is not None
    half_square = row.amplitude_mm**2 / 2e3
    stated = {column: (metric.value, metric.rounding / metric.value) for column, metric in row.metrics.items()}
    stiffness, factor = stated.get("stiffness_N_mm"), stated.get("loss_factor")
    elastic, dissipated = stated.get("max_elastic_energy_J"), stated.get("dissipated_energy_J")
    if set(stated) >= set(OF_A_PHASE):
        of_sine = _of_a_sine(stated, half_square)
        dissipated, elastic = dissipated or of_sine[0], elastic or of_sine[1]
    if elastic is None:
        if stiffness is not None:
            elastic = stiffness[0] * half_square, stiffness[1]
        else:
            assert dissipated is not None
            assert factor is not None
            elastic = dissipated[0] / (2 * math.pi * factor[0]), math.hypot(dissipated[1], factor[1])
    if dissipated is None:
        assert factor is not None
        dissipated = 2 * math.pi * factor[0] * elastic[0], math.hypot(factor[1], elastic[1])
    expected = {
        "stiffness_N_mm": elastic[0] / half_square,
        "loss_factor": dissipated[0] / (2 * math.pi * elastic[0]),
    }
    for column, value in expected.items():
        if column in stated:
            got, rounding = stated[column]
            if abs(got / value - 1) > AGREEING_SHARE + 4 * math.hypot(rounding, dissipated[1], elastic[1]):
                raise UserError(
                    f"{path}, row {row.row}, column {column!r}: got {got:g}, but the row's energies make it "
                    f"{value:.4g}; expected eta = dW/(2 pi W) and k = 2 W/X0^2 with X0 the amplitude; check the units"
                )
    return MetricRun(
        name=row.run,
        setup=row.setup,
        amplitude_mm=row.amplitude_mm,
        frequency_Hz=row.frequency_Hz,
        dissipated_energy_J=dissipated[0],
        max_elastic_energy_J=elastic[0],
        rounding=(dissipated[1], elastic[1]),
    )


def _of_a_sine(
    stated: Mapping[str, tuple[float, float]], half_square: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Give dW and W of storage and loss stiffness, each with what rounding leaves open of it, as a share."""
    (storage, of_storage), (loss, of_loss) = (stated[column] for column in OF_A_PHASE)
    whole = math.hypot(storage, loss)
    rounding = math.hypot((storage / whole) ** 2 * of_storage, (loss / whole) ** 2 * of_loss)
    return (2 * math.pi * loss * half_square, of_loss), (whole * half_square, rounding)


def _impossible(run: MetricRun) -> str:
    """Say that no loop has such energies; empty where one has."""
    ratio = run.dissipated_energy_J / run.max_elastic_energy_J
    if ratio <= MOST_DISSIPATED * (1 + AGREEING_SHARE + 4 * math.hypot(*run.rounding)):
        return ""
    return (
        f"its dW is {ratio:.3g} times its W, and no loop encloses more than {MOST_DISSIPATED:g} times: W is of the "
        f"largest force, Fmax X0/2; where it is that of a storage modulus, state {' and '.join(OF_A_PHASE)} instead"
    )


def _numbers_of(run: MetricRun) -> tuple[object, ...]:
    """Give what two rows that are one measurement share, as tables repeat the row that they have in common."""
    setup = run.setup
    known = tuple((name, value) for name, value in setup.conditions.items() if not math.isnan(value))
    tested = (setup.specimen, setup.temperature_C, setup.density_g_cm3, setup.first_cycle, known)
    loop = (run.amplitude_mm, run.frequency_Hz, run.dissipated_energy_J, run.max_elastic_energy_J, run.rounding)
    return (*tested, *loop)


def metric_observations(campaign: MetricCampaign, samples: int = SAMPLES_PER_CYCLE) -> MetricObservations:
    """Give a campaign's metrics as observations.

    Args:
        campaign: R runs.
        samples: points of the cycle at which laws are evaluated.

    Raises:
        UserError: the temperature is known for some runs only.
    """
    runs = campaign.runs
    T = np.array([run.setup.kelvin for run in runs])
    motion = sinusoids(
        [run.amplitude_mm for run in runs],
        [run.frequency_Hz for run in runs],
        known_temperature(T, [run.name for run in runs]),
        samples,
    )
    rounding = np.array([run.rounding for run in runs])
    columns = {
        "N": [run.setup.first_cycle for run in runs],
        "rho": [run.setup.density for run in runs],
        **{condition_signal(name): [run.setup.conditions[name] for run in runs] for name in campaign.condition_columns},
    }
    slow = {**motion.slow, **{name: np.array(values)[:, None] for name, values in columns.items()}}
    return MetricObservations(
        replace(motion, slow=slow, assumed=assumed_signals(T)),
        np.array([run.dissipated_energy_J for run in runs]),
        np.array([run.max_elastic_energy_J for run in runs]),
        np.hypot(SCATTER_BEFOREHAND, rounding),
        rounding,
    )
