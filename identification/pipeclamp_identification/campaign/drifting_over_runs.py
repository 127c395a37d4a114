"""Sensors that drift from run to run: a zero or a gain that follows the order of the runs beyond their conditions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.campaign.clipping import CHANNEL_UNITS
from pipeclamp_identification.campaign.drift_words import gain_drift_over_runs_words, zero_drift_over_runs_words
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
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.base.digits import one_digit

FEWEST_FREE_RUNS = 6
"""Runs that must be free of the conditions to show a trend from run to run."""
FREE_SHARE = 1 / 3
"""Share of the runs that pairs of conditions must leave free for that; otherwise conditions count one by one."""


@dataclass(frozen=True, eq=False)
class _Trend:
    """What the order of the runs may do to them beyond their conditions.

    Attributes:
        basis: orthonormal, of what conditions may do to runs, (R, c).
        order: of the runs, less what conditions explain of it, (R,).
        span: from the first run to the last, in the units of the order.
        free: degrees of freedom that conditions and order leave.
    """

    basis: Array
    order: Array
    span: float
    free: int

    def change(self, values: Array) -> Change:
        """Give by how much a value of each run, (R,), changes from the first run to the last, conditions given."""
        rest = values - self.basis @ (self.basis.T @ values)
        slope = float(self.order @ rest / (self.order @ self.order))
        squares = float(np.sum((rest - slope * self.order) ** 2))
        error = math.sqrt(squares / self.free / float(self.order @ self.order))
        return Change(slope * self.span, error * self.span, self.free)


class _Drift(NamedTuple):
    """A channel whose zero or gain changes from run to run, by a change that counts in a scale (N, mm; 1 for gains)."""

    channel: Channel
    kind: FaultKind
    scale: float
    change: Change


def drifting_over_runs(runs: Sequence[Watched]) -> tuple[SensorFault, ...]:
    """Find sensors that drift from run to run, in the order of the runs, beyond what their conditions make."""
    order, order_words = _order(runs)
    trend = _trend(runs, order)
    if trend is None:
        return ()
    drifts = [*_zeros_over_runs(runs, trend), *_gains_over_runs(runs, trend)]
    return tuple(_over_runs(drift, order_words, runs) for drift in drifts)


def _trend(runs: Sequence[Watched], order: Array) -> _Trend | None:
    """Give what the order may do to the runs; None where their conditions leave too little of it."""
    basis = conditions_basis(runs, pairs=True)
    if len(runs) - basis.shape[1] < FREE_SHARE * len(runs):
        basis = conditions_basis(runs)
    free = len(runs) - basis.shape[1] - 1
    own = order - basis @ (basis.T @ order)
    if free < FEWEST_FREE_RUNS or np.sum(own**2) < OWN_SHARE * np.sum((order - order.mean()) ** 2):
        return None
    return _Trend(basis, own, float(np.ptp(order)), free)


def _zeros_over_runs(runs: Sequence[Watched], trend: _Trend) -> list[_Drift]:
    """Find zeros that change from run to run: of a force without its position, of a position without its force."""
    A, F = (float(np.median(sizes)) for sizes in np.array([run.amplitudes for run in runs]).T)
    k = _stiffness(runs)
    mean_y = trend.change(np.array([np.mean(run.by_cycle.displacement[:, 0].real) for run in runs]) / A)
    mean_force = trend.change(np.array([np.mean(run.by_cycle.force[:, 0].real) for run in runs]) / F)
    followed = float(np.median(k.real / np.abs(k))) * mean_y.size
    drifts = []
    by_itself = abs(mean_force.size - followed) > BY_ITSELF_SHARE * abs(mean_force.size)
    if mean_force.is_real(1, ZERO_SHARE) and by_itself:
        drifts.append(_Drift("force", "zero_drift", F, mean_force))
    shows = abs(followed) > SEEN_STANDARD_ERRORS * mean_force.error
    if mean_y.is_real(1, ZERO_SHARE) and shows and abs(mean_force.size) < FOLLOWED_SHARE * abs(followed):
        drifts.append(_Drift("displacement", "zero_drift", A, mean_y))
    return drifts


def _gains_over_runs(runs: Sequence[Watched], trend: _Trend) -> list[_Drift]:
    """Find gains that change from run to run: of the force, or of the displacement against its stated amplitudes."""
    k = _stiffness(runs)
    if not (np.all(k.real > 0) and np.all(k.imag > 0)):
        return []
    nominal = [run.nominal_mm for run in runs]
    moved: Change | None = None
    if all(value is not None for value in nominal):
        amplitude = np.log(np.array([run.amplitudes[0] for run in runs]))
        moved = trend.change(amplitude - np.log(np.array(nominal, dtype=np.float64)))
    both = trend.change(np.log(k.real)), trend.change(np.log(k.imag))
    together = alike(*both)
    real = together is not None and abs(together.size) >= GAIN_SHARE and all(one.is_real(1, 0.0) for one in both)
    if moved is not None and moved.is_real(1, GAIN_SHARE):
        # a displacement that reads less than it is shows each force at a smaller amplitude: both stiffer in that ratio
        if real and together is not None and abs(together.size + moved.size) < FOLLOWED_SHARE * abs(moved.size):
            return [_Drift("displacement", "gain_drift", 1.0, moved)]
        return []
    return [_Drift("force", "gain_drift", 1.0, together)] if real and together is not None else []


def _stiffness(runs: Sequence[Watched]) -> ComplexArray:
    """Give the dynamic stiffness of each run, N/mm, (R,)."""
    return np.array([np.mean(run.by_cycle.stiffness) for run in runs])


def _order(runs: Sequence[Watched]) -> tuple[Array, str]:
    """Give the order in which runs were made: by the records' clock where it tells, else that of runs.csv."""
    starts = np.array([run.start_s for run in runs])
    by_time = sorted(runs, key=lambda run: run.start_s)
    if len(runs) > 1 and all(one.end_s <= other.start_s for one, other in itertools.pairwise(by_time)):
        return starts, "by the records' clock"
    return np.arange(len(runs), dtype=np.float64), "in the order of runs.csv"


def _over_runs(drift: _Drift, order: str, runs: Sequence[Watched]) -> SensorFault:
    """Give a drift as the fault of a sensor, its size in the channel's unit; `order` says that of the runs."""
    channel, change = drift.channel, drift.change
    size, error = change.size * drift.scale, change.error * drift.scale
    done: Done = "corrected" if drift.kind == "zero_drift" else "kept"
    if drift.kind == "zero_drift":
        unit = CHANNEL_UNITS[channel]
        share = f"{abs(change.size):.1%} of the amplitude"
        shown = f"{size:+.3g} {unit} ({share}, standard error {one_digit(error)} {unit})"
        words = zero_drift_over_runs_words(channel, shown, order)
    else:
        unit = "share"
        words = gain_drift_over_runs_words(channel, f"{size:+.2%} (standard error {100 * error:.1g}%)", order)
    return SensorFault(
        channel=channel, fault=drift.kind, over="campaign", size=size, unit=unit, done=done, words=words,
        runs=tuple(FaultyRun(run=run.name, size=None, standard_error=None) for run in runs),
    )  # fmt: skip


def shifts_over_runs(runs: Sequence[Watched], fault: SensorFault) -> list[float]:
    """Give by how much a zero that drifts from run to run is off in each; its mean over the runs is kept."""
    order, _ = _order(runs)
    share = (order - order.mean()) / np.ptp(order)
    shifts: list[float] = ((fault.size or 0.0) * share).tolist()
    return shifts
