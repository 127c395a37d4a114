"""The sensors of a campaign, asked before any law: what failed, what drifts, and the records without it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeclamp_identification.campaign.clipping import CHANNEL_UNITS, at_common_end
from pipeclamp_identification.campaign.drift_words import gain_drift_in_run_words
from pipeclamp_identification.campaign.drifting import Watched, drifting, repaired, without
from pipeclamp_identification.campaign.drifting_over_runs import drifting_over_runs, shifts_over_runs
from pipeclamp_identification.campaign.faults import (
    Channel,
    SensorFailure,
    SensorFault,
    faults_of_failures,
    faults_of_parts,
)
from pipeclamp_identification.campaign.plausibility import SURE_STANDARD_ERRORS
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.campaign.seen import SeenFree, SeenRecord, SeenSine
from pipeclamp_identification.signals.levels import SAME_KELVIN, SAME_SHARE, Level, group_names, number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import newtons, plain

DEAD_BELOW = 0.1
"""A force that the motion doesn't show in, and that stays below this share of what other runs show, is no clamp's."""
FEWEST_OTHERS = 3
FAR = 2.0
"""A mean lies far off where it exceeds so many of the largest amplitudes: clamps are held within them."""
FAR_ALONE = 20.0
"""And where others of the campaign don't, so many: tests may hold a clamp off its rest in some runs, but not so far."""
UNANSWERED = 0.1
"""Share of stiffness times mean displacement that a mean force reaches where the displacement is real: a stiffness that
softens with the power -0.4 of the amplitude still answers with a third of it at fifteen amplitudes."""
CLEARLY = 3.0
"""Standard errors within which a mean force may follow the mean displacement."""
MEAN_ALONE = np.array([1.0, 0.0])
"""What a zero changes of mean and fundamental."""


@dataclass(frozen=True)
class Observed:
    """A run as its sensors show it, and what was stated of it; None where it isn't known.

    Attributes:
        nominal_mm: stated amplitude.
        setup: what was tested.
        seen: what its record shows.
    """

    name: str
    nominal_mm: float | None
    setup: Setup
    seen: SeenSine


@dataclass(frozen=True)
class Sensors:
    """What the sensors of a campaign's usable runs show.

    Attributes:
        faults: found, those of left-out runs among them.
        failed: why runs are left out, by name.
        drifts: channels whose zero's drift inside the record is to be taken off, by name of the run.
        shifts: by how much the zeros of channels are off all through the record, by name of the run.
        remarks: what is to be said of them beside faults.
    """

    faults: tuple[SensorFault, ...]
    failed: Mapping[str, SensorFailure]
    drifts: Mapping[str, Sequence[Channel]] = field(default_factory=dict)
    shifts: Mapping[str, Sequence[tuple[Channel, float]]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def repaired(self, run: str, record: Record, seen: SeenSine) -> Record:
        """Give the record of a run of a sine that is kept, repaired where that can be done."""
        if drifts := self.drifts.get(run):
            record = repaired(record, seen.cycles, seen.by_cycle, drifts)
        return self.shifted(run, record)

    def shifted(self, run: str, record: Record) -> Record:
        """Give the record of a run with its channels' zeros where they belong."""
        for channel, shift in self.shifts.get(run, ()):
            record = without(record, channel, shift)
        return record

    @property
    def of_unknown_mean(self) -> frozenset[str]:
        """Names of the runs inside which a zero drifted: where it stood before isn't known."""
        drifted = (one for one in self.faults if (one.done, one.over) == ("corrected", "record"))
        return frozenset(run.run for fault in drifted for run in fault.runs)


def sensors_of(runs: Sequence[Observed], free: Mapping[str, SeenFree] | None = None) -> Sensors:
    """Ask the sensors of runs whose records can be used one by one.

    Args:
        runs: of sines, in runs.csv's order.
        free: what records of free motion show, by name of the run: where zeros stand, and nothing else.
    """
    free = free or {}
    failed = {**_at_the_end_of_their_range(runs), **_dead(runs)}
    broken = faults_of_failures(list(failed.items()))
    runs = [run for run in runs if run.name not in failed]
    if not runs and not free:
        return Sensors(broken, failed)
    zeros = zeros_elsewhere([*(run.seen for run in runs), *free.values()])
    shifts: dict[str, list[tuple[Channel, float]]] = {name: [] for name in (*(run.name for run in runs), *free)}
    if zeros is not None:
        for name, zero in zip(shifts, zeros.tolist(), strict=True):
            shifts[name].append(("displacement", zero))
    watched = _watched(runs, np.zeros(len(runs)) if zeros is None else zeros) if runs else []
    drifts = drifting(watched) if watched else ()
    failed |= _failures_of(drifts)
    kept = [run for run in watched if run.name not in failed]
    parts = faults_of_parts({run.name: run.seen.stuck for run in runs if run.seen.stuck and run.name not in failed})
    over_runs = drifting_over_runs(kept) if kept else ()
    for fault in over_runs:
        if fault.done == "corrected":
            for run, shift in zip(kept, shifts_over_runs(kept, fault), strict=True):
                shifts[run.name].append((fault.channel, shift))
    remarks = (*(() if zeros is None else (zero_words(zeros),)), *force_words(list(free.values())))
    return Sensors((*broken, *parts, *drifts, *over_runs), failed, _taken_off(drifts), shifts, remarks)


def _failures_of(drifts: Sequence[SensorFault]) -> dict[str, SensorFailure]:
    """Give why runs are left out for a drift, by name."""
    return {
        run.run: SensorFailure(
            gain_drift_in_run_words(fault.channel, run.size, run.standard_error),
            fault.channel,
            fault.fault,
            run.size,
            fault.unit,
        )
        for fault in drifts
        if fault.done == "left out"
        for run in fault.runs
        if run.size is not None and run.standard_error is not None
    }


def _taken_off(drifts: Sequence[SensorFault]) -> dict[str, list[Channel]]:
    """Give the channels whose drift is to be taken off, by name of the run."""
    channels: dict[str, list[Channel]] = {}
    for fault in drifts:
        if fault.done == "corrected":
            for run in fault.runs:
                channels.setdefault(run.run, []).append(fault.channel)
    return channels


def zeros_elsewhere(runs: Sequence[SeenRecord]) -> Array | None:
    """Give what is to be taken off each run's displacement, mm, shape (n,); None where its zero may be the clamp's.

    An absolute position, or a sensor that wasn't set to zero: a law takes a mean displacement for a real one. A spring
    that was moved so far would answer with a mean force; where no run has one, it wasn't moved. Nothing is taken off
    runs that don't lie far off where others do, very far: the sensor was set between them.

    A constant load, as of pulses that only press, makes a mean force wherever the zero is: then the runs' means tell.
    Where they move far from run to run and the force doesn't follow, the specimen creeps, and none is a spring's.

    It is one for all where they lie within the largest amplitude of each other: those differences may be real. Else the
    sensor was set anew, and it is each run's own. Sines tell it best, for they go as far to each side, then free
    motions that begin at rest, and last the means of others.
    """
    place, force = (np.array([getattr(one, name) for one in runs]) for name in ("place_mm", "mean_force_N"))
    stiffness = np.array([one.shown.stiffness.real for one in runs])
    largest = max(one.shown.amplitude_mm for one in runs)
    far = np.abs(place) > FAR * largest
    if not np.all(far):
        far = np.abs(place) > FAR_ALONE * largest
    answered = np.abs(force) >= UNANSWERED * stiffness * np.abs(place)
    if not np.any(far):
        return None
    if np.any(answered[far]):
        return place if _creeps(place, force, stiffness, largest) else None
    doubt = np.array([0 if isinstance(one, SeenSine) else 2 - _begins_at_rest(one) for one in runs])
    common = float(np.median(place[far & (doubt == np.min(doubt[far]))]))
    own = common if np.all(np.abs(place[far] - common) <= largest) else place
    return np.where(far, own, 0.0)


def _creeps(place: Array, force: Array, stiffness: Array, largest: float) -> bool:
    """Tell whether mean displacements move far from run to run, and mean forces surely don't follow them.

    Args:
        place: mean displacement of each run, mm, shape (n,).
        force: mean force, N, and
        stiffness: N/mm, of the same shape.
        largest: amplitude of all runs, mm.
    """
    if len(place) < FEWEST_OTHERS or np.ptp(place) <= FAR * largest:
        return False
    moved = place - np.mean(place)
    slope = float(moved @ force / (moved @ moved))
    rest = force - np.mean(force) - slope * moved
    error = math.sqrt(float(rest @ rest) / (len(place) - 2) / float(moved @ moved))
    return abs(slope) + CLEARLY * error < UNANSWERED * float(np.median(stiffness))


def _begins_at_rest(seen: SeenRecord) -> bool:
    return isinstance(seen, SeenFree) and seen.begins_at_rest


def zero_words(zeros: Array) -> str:
    """Say that zeros are taken off."""
    off = zeros[zeros != 0.0]
    least, most = float(np.min(off)), float(np.max(off))
    shown = f"{least:.5g} mm" if least == most else f"{least:.5g} to {most:.5g} mm, each run's own,"
    where = "" if len(off) == len(zeros) else f" in {len(off)} of {len(zeros)} runs"
    return (
        f"the displacement's zero is not where the clamp rests: a mean of {shown} is taken off{where}, for no mean "
        "force answers it"
    )


def force_words(free: Sequence[SeenFree]) -> tuple[str, ...]:
    """Say that a force stands far off zero all through free motions; of sines, a diagnosis says what it may be."""
    if not free:
        return ()
    mean = np.array([one.mean_force_N for one in free])
    if np.any(np.abs(mean) <= FAR * max(one.shown.amplitude_mm * abs(one.shown.stiffness) for one in free)):
        return ()
    least, most = plain(float(np.min(mean)), 4), plain(float(np.max(mean)), 4)
    shown = least if least == most else f"{least} to {most}"
    return (
        f"a mean force of {shown} N stands in all runs of free motion, more than twice the largest amplitude of the "
        "force: a preload, or a sensor that wasn't set to zero; it stays in the records, and laws follow it by the "
        "effect offset alone",
    )


def _at_the_end_of_their_range(runs: Sequence[Observed]) -> dict[str, SensorFailure]:
    """Give the runs of different amplitude that stop at one and the same value, however shortly."""
    found: dict[str, SensorFailure] = {}
    for channel, unit in CHANNEL_UNITS.items():
        ends = {run.name: run.seen.ends[channel] for run in runs}
        for run, end in at_common_end(ends).items():
            reason = f"clipped sensor: {channel}_{unit} stops at {end:g} as in other runs of other amplitude"
            found.setdefault(run, SensorFailure(reason, channel, "clipped", end, unit))
    return found


def _dead(runs: Sequence[Observed]) -> dict[str, SensorFailure]:
    """Give the runs whose force doesn't show the motion, where others' does."""
    shown = [run.seen.shown for run in runs]
    force = np.array([one.amplitude_mm * abs(one.stiffness) for one in shown])
    seen = np.array([abs(one.stiffness) > SURE_STANDARD_ERRORS * one.standard_error for one in shown], dtype=np.bool_)
    if np.count_nonzero(seen) < FEWEST_OTHERS:
        return {}
    usual = float(np.median(force[seen]))
    return {
        runs[row].name: SensorFailure(
            f"dead sensor: the force doesn't show the motion ({force[row]:.2g} N of its fundamental, "
            f"{newtons(usual)} in most runs)", "force", "dead", float(force[row]), "N",
        )
        for row in np.flatnonzero(~seen & (force < DEAD_BELOW * usual)).tolist()
    }  # fmt: skip


def _watched(runs: Sequence[Observed], zeros: Array) -> list[Watched]:
    """Give the runs as they are watched for drifts, their conditions by level, zeros taken off their displacement."""
    further = [{"density_g_cm3": run.setup.density, **run.setup.conditions} for run in runs]
    numbers = {
        "amplitude_mm": number_levels(np.array([run.seen.shown.amplitude_mm for run in runs]), relative=SAME_SHARE),
        "frequency_Hz": number_levels(np.array([run.seen.cycles.frequency_Hz for run in runs]), relative=SAME_SHARE),
        "temperature_C": number_levels(np.array([run.setup.kelvin for run in runs]), absolute=SAME_KELVIN),
        **{
            name: number_levels(np.array([values[name] for values in further]), relative=SAME_SHARE)
            for name in further[0]
        },
    }
    labels = {name: _label_of_each(levels, len(runs)) for name, levels in numbers.items()}
    stated = [run.setup.texts for run in runs]
    texts = {name: [own[name] for own in stated] for name in stated[0]}
    texts = {name: own for name, own in texts.items() if group_names(own)}
    return [
        Watched(
            name=run.name,
            start_s=run.seen.start_s,
            end_s=run.seen.end_s,
            nominal_mm=run.nominal_mm,
            conditions={name: own[row] for name, own in (labels | texts).items()},
            by_cycle=replace(run.seen.by_cycle, displacement=run.seen.by_cycle.displacement - zeros[row] * MEAN_ALONE),
        )
        for row, run in enumerate(runs)
    ]


def _label_of_each(levels: Sequence[Level], count: int) -> list[str]:
    found = [""] * count
    for level in levels:
        for row in level.rows:
            found[int(row)] = level.label
    return found
