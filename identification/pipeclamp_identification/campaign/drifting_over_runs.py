"""Sensors that drift from run to run: a zero or a gain that follows the order of the runs beyond their conditions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from pipeclamp_identification.campaign.drifting import (
    BY_ITSELF_SHARE,
    FOLLOWED_SHARE,
    GAIN_SHARE,
    OWN_SHARE,
    SEEN_STANDARD_ERRORS,
    ZERO_SHARE,
    Change,
    Watched,
    alike,
    conditions_basis,
)
from pipeclamp_identification.campaign.faults import Channel, Done, FaultKind, FaultyRun, SensorFault
from pipeclamp_identification.signals.digits import one_digit
from pipeclamp_models.base.arrays import Array

FEWEST_FREE_RUNS = 6
"""Runs that must be free of the conditions to show a trend from run to run."""
FREE_SHARE = 1 / 3
"""Share of the runs that pairs of conditions must leave free for that; otherwise conditions count one by one."""


def drifting_over_runs(runs: Sequence[Watched]) -> tuple[SensorFault, ...]:
    """Find sensors that drift from run to run, in the order of the runs, beyond what their conditions make."""
    order, unit = _order(runs)
    basis = conditions_basis(runs, pairs=True)
    if len(runs) - basis.shape[1] < FREE_SHARE * len(runs):
        basis = conditions_basis(runs)
    free = len(runs) - basis.shape[1] - 1
    own = order - basis @ (basis.T @ order)
    if free < FEWEST_FREE_RUNS or np.sum(own**2) < OWN_SHARE * np.sum((order - order.mean()) ** 2):
        return ()
    k = np.array([np.mean(run.by_cycle.stiffness) for run in runs])
    A, F = np.array([run.amplitudes for run in runs]).T
    typical = float(np.median(A)), float(np.median(F))
    means = [np.array([np.mean(each.by_cycle.displacement[:, 0].real) for each in runs]) / typical[0]]
    means.append(np.array([np.mean(each.by_cycle.force[:, 0].real) for each in runs]) / typical[1])
    span = float(np.ptp(order))

    def change(values: Array) -> Change:
        rest = values - basis @ (basis.T @ values)
        slope = float(own @ rest / (own @ own))
        error = math.sqrt(float(np.sum((rest - slope * own) ** 2)) / free / float(own @ own))
        return Change(slope * span, error * span, free)

    mean_y, mean_force = change(means[0]), change(means[1])
    followed = float(np.median(k.real / np.abs(k))) * mean_y.size
    sizes: list[tuple[Channel, FaultKind, float, Change]] = []
    if mean_force.is_real(1, ZERO_SHARE) and abs(mean_force.size - followed) > BY_ITSELF_SHARE * abs(mean_force.size):
        sizes.append(("force", "zero_drift", typical[1], mean_force))
    seen = abs(followed) > SEEN_STANDARD_ERRORS * mean_force.error and abs(mean_force.size) < FOLLOWED_SHARE * abs(
        followed
    )
    if mean_y.is_real(1, ZERO_SHARE) and seen:
        sizes.append(("displacement", "zero_drift", typical[0], mean_y))
    if np.all(k.real > 0) and np.all(k.imag > 0):
        sizes += _gains_over_runs(runs, np.log(k.real), np.log(k.imag), np.log(A), change)
    return tuple(_over_runs(*one, unit, runs) for one in sizes)


def _gains_over_runs(
    runs: Sequence[Watched], elastic: Array, damping: Array, amplitude: Array, change: Callable[[Array], Change]
) -> list[tuple[Channel, FaultKind, float, Change]]:
    """Find gains that change from run to run: of the force, or of the displacement against its stated amplitudes."""
    nominal = [run.nominal_mm for run in runs]
    moved: Change | None = None
    if all(value is not None for value in nominal):
        moved = change(amplitude - np.log(np.array(nominal, dtype=np.float64)))
    both = change(elastic), change(damping)
    together = alike(*both)
    real = together is not None and abs(together.size) >= GAIN_SHARE and all(one.is_real(1, 0.0) for one in both)
    if moved is not None and moved.is_real(1, GAIN_SHARE):
        # a displacement that reads less than it is shows each force at a smaller amplitude: both stiffer in that ratio
        if real and together is not None and abs(together.size + moved.size) < FOLLOWED_SHARE * abs(moved.size):
            return [("displacement", "gain_drift", 1.0, moved)]
        return []
    return [("force", "gain_drift", 1.0, together)] if real and together is not None else []


def _order(runs: Sequence[Watched]) -> tuple[Array, str]:
    """Give the order in which runs were made: by the records' clock where it tells, else that of runs.csv."""
    starts = np.array([run.start_s for run in runs])
    by_time = sorted(runs, key=lambda run: run.start_s)
    if len(runs) > 1 and all(one.end_s <= other.start_s for one, other in itertools.pairwise(by_time)):
        return starts, "by the records' clock"
    return np.arange(len(runs), dtype=np.float64), "in the order of runs.csv"


def _over_runs(
    channel: Channel, kind: FaultKind, scale: float, change: Change, order: str, runs: Sequence[Watched]
) -> SensorFault:
    size, error = change.size * scale, change.error * scale
    if kind == "zero_drift":
        unit = "N" if channel == "force" else "mm"
        share = f"{abs(change.size):.1%} of the amplitude"
        shown = f"{size:+.3g} {unit} ({share}, standard error {one_digit(error)} {unit})"
        words = (
            f"the zero of the {channel} channel drifts from run to run: by {shown} from the first run to the last "
            f"{order}, at alike conditions; the drift is taken off, the mean of all runs is kept; to do: set the zero "
            "before each run"
        )
        done: Done = "corrected"
    else:
        unit, done = "share", "kept"
        words = (
            f"the gain of the {channel} channel drifts from run to run: by {size:+.2%} (standard error "
            f"{100 * error:.1g}%) from the first run to the last {order}, alike conditions given, stiffness and "
            "damping in one ratio; they are kept, so that what is said of physics may be this fault's; to do: "
            "calibrate it, and repeat a first run last"
        )
    return SensorFault(
        channel=channel, fault=kind, over="campaign", size=size, unit=unit, done=done, words=words,
        runs=tuple(FaultyRun(run=run.name, size=None, standard_error=None) for run in runs),
    )  # fmt: skip


def shifts_over_runs(runs: Sequence[Watched], fault: SensorFault) -> list[float]:
    """Give by how much a zero that drifts from run to run is off in each; its mean over the runs is kept."""
    order, _ = _order(runs)
    share = (order - order.mean()) / np.ptp(order)
    shifts: list[float] = ((fault.size or 0.0) * share).tolist()
    return shifts
