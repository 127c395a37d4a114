"""All runs of a campaign judged together, by what their records show: units, sensors, settings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pipeclamp_identification.campaign.description import UNTIMED
from pipeclamp_identification.campaign.faults import SensorFault, faults_of_failures, runs_named
from pipeclamp_identification.campaign.plausibility import (
    contradiction,
    falls_with_displacement,
    implausible,
    lack_means,
    makes_energy,
    unless_contradicted,
)
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.seen import LeftOut, SeenFree, SeenRecord, SeenSine
from pipeclamp_identification.campaign.sensors import Observed, Sensors, sensors_of
from pipeclamp_identification.units.doubts import ShownRun, StatedAndShown, contradicted_units, unlikely_units
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import counted


class NominalSettings(NamedTuple):
    """Amplitude in mm and frequency in Hz as they were set, None where unknown or where the record contradicts them."""

    amplitude_mm: float | None
    frequency_Hz: float | None


@dataclass(frozen=True)
class JudgedRuns:
    """What a campaign's runs show together.

    Attributes:
        sines, free: what the records of the runs that can be used show, by name in runs.csv's order.
        left_out: the others.
        settings: amplitude and frequency that count of each sine, by name.
        sensors: what they do wrong, and what repairs a record.
        faults: of sensors, those of runs that are left out among them.
        doubts: which units are likely wrong.
        remarks: all that is to be said of runs that are used.
        without_mean: names of those whose mean force isn't known, as is stated or as all sines show.
    """

    sines: Mapping[str, SeenSine]
    free: Mapping[str, SeenFree]
    left_out: tuple[LeftOut, ...]
    settings: Mapping[str, NominalSettings]
    sensors: Sensors
    faults: tuple[SensorFault, ...]
    doubts: tuple[str, ...]
    remarks: tuple[str, ...]
    without_mean: frozenset[str]


def judge_runs(
    folder: Path,
    rows: Sequence[RunRow],
    seen: Mapping[str, SeenRecord | LeftOut],
    strict: bool = False,
    *,
    time_measured: bool = True,
) -> JudgedRuns:
    """Judge the runs of a campaign.

    Args:
        folder: the campaign's, for errors.
        rows: of its runs.csv.
        seen: what the record of each run shows, or why it can't be used, by name.
        strict: a run that can't be used is an error.
        time_measured: whether seconds are seconds.

    Raises:
        UserError: units are contradicted by all records; no run can be used; or, with `strict`, one can't.
    """
    sines = {row.run: (row, one) for row in rows if isinstance(one := seen[row.run], SeenSine)}
    free = {row.run: one for row in rows if isinstance(one := seen[row.run], SeenFree)}
    stated = [_stated(row, one) for row, one in sines.values()]
    if wrong := contradicted_units(stated):
        raise UserError(f"{folder}: {wrong}")
    doubts = unlikely_units(stated)
    unusable = {row.run: one for row in rows if isinstance(one := seen[row.run], LeftOut)}
    unusable |= _implausible(sines, free)
    moving = {run: one for run, one in free.items() if run not in unusable}
    sensors = sensors_of([_observed(row, one) for run, (row, one) in sines.items() if run not in unusable], moving)
    unusable |= {run: LeftOut(run, str(failure), failure) for run, failure in sensors.failed.items()}
    left_out = tuple(unusable[row.run] for row in rows if row.run in unusable)
    if left_out and (strict or len(left_out) == len(rows)):
        raise _unusable_runs(folder, left_out, len(rows))
    kept = {run: one for run, one in sines.items() if run not in unusable}
    settings, contradicted = _settings(kept)
    fundamentals = {run: one.shown for run, (_, one) in kept.items()}
    without_mean, lacking = _without_mean([row for row in rows if row.run not in unusable], kept)
    every = fundamentals | {run: one.shown for run, one in moving.items()}
    failures = [(one.run, one.failure) for one in left_out if one.failure and one.run not in sensors.failed]
    return JudgedRuns(
        sines={run: one for run, (_, one) in kept.items()},
        free=moving,
        left_out=left_out,
        settings=settings,
        sensors=sensors,
        faults=(*faults_of_failures(failures), *sensors.faults),
        doubts=doubts,
        remarks=(
            *(() if time_measured else (UNTIMED,)),
            *doubts,
            *sensors.remarks,
            # of a gain each run says its own size, and this what it may be
            *(fault.words for fault in sensors.faults if fault.done != "left out" or fault.fault == "gain_drift"),
            *contradicted,
            *lacking,
            *filter(None, [makes_energy(every), falls_with_displacement(fundamentals)]),
            *(_moving_from_the_start(moving) if time_measured else ()),
        ),
        without_mean=without_mean,
    )


def _implausible(sines: Mapping[str, tuple[RunRow, SeenSine]], free: Mapping[str, SeenFree]) -> dict[str, LeftOut]:
    """Give the runs whose loops no clamp makes, beside all others."""
    shown = {run: one.shown for run, (_, one) in sines.items()} | {run: one.shown for run, one in free.items()}
    return {run: LeftOut(run, why) for run, why in implausible(shown).items()}


def _unusable_runs(folder: Path, left_out: Sequence[LeftOut], count: int) -> UserError:
    """Give the error that names the runs, of so many, that can't be used, and says what to do."""
    remedy = ", take their rows out of runs.csv, or don't be strict" if len(left_out) < count else ""
    heading = f"{folder}: {len(left_out)} of {count} runs can't be used; mend their records{remedy}"
    return UserError("\n".join([heading, *(f"  {one}" for one in left_out)]))


def _stated(row: RunRow, seen: SeenSine) -> ShownRun:
    """Give a run as its units are doubted."""
    return ShownRun(
        run=row.run,
        amplitude_mm=StatedAndShown(row.amplitude_mm, seen.shown.amplitude_mm),
        frequency_Hz=StatedAndShown(row.frequency_Hz, seen.cycles.frequency_Hz),
        temperature_C=StatedAndShown(row.setup.temperature_C, seen.temperature_C),
        stiffness=abs(seen.shown.stiffness),
        load=abs(seen.mean_force_N) + abs(seen.shown.stiffness) * seen.shown.amplitude_mm,
        step_s=seen.step_s,
    )


def _observed(row: RunRow, seen: SeenSine) -> Observed:
    """Give a run as its sensors show it."""
    return Observed(
        name=row.run, nominal_mm=row.amplitude_mm, setup=row.setup.measured_at(seen.temperature_C), seen=seen
    )


def _settings(sines: Mapping[str, tuple[RunRow, SeenSine]]) -> tuple[dict[str, NominalSettings], tuple[str, ...]]:
    """Give amplitudes and frequencies but for those that records contradict, and words about these."""
    amplitudes = {run: StatedAndShown(row.amplitude_mm, one.shown.amplitude_mm) for run, (row, one) in sines.items()}
    frequencies = {run: StatedAndShown(row.frequency_Hz, one.cycles.frequency_Hz) for run, (row, one) in sines.items()}
    words = (contradiction("amplitude_mm", amplitudes), contradiction("frequency_Hz", frequencies))
    settings = {
        run: NominalSettings(unless_contradicted(*amplitudes[run]), unless_contradicted(*frequencies[run]))
        for run in sines
    }
    return settings, tuple(filter(None, words))


def _without_mean(
    rows: Sequence[RunRow], sines: Mapping[str, tuple[RunRow, SeenSine]]
) -> tuple[frozenset[str], tuple[str, ...]]:
    """Give the names of runs whose mean force isn't known, and words about them.

    Args:
        rows: of all runs that can be used.
        sines: of those, by name.
    """
    stated = [row.run for row in rows if row.mean_known is False]
    unstated = [row.run for row in rows if row.mean_known is None]
    even = {run: one.even for run, (row, one) in sines.items() if row.mean_known is None}
    found = unstated if lack_means(list(even.values())) else []
    words = []
    if stated:
        words.append(
            f"the mean force of {counted(len(stated), 'run')} isn't known, as is stated ({runs_named(stated)}): it is "
            "taken off, and doesn't count"
        )
    if found:
        most = max(even, key=lambda run: abs(even[run].second))
        words.append(
            f"the force channel passes no mean, as a piezoelectric cell does: in all {len(even)} runs the mean force "
            f"is near zero, though the force is larger at one end of the cycle (in run {most!r} by "
            f"{newtons(2 * abs(even[most].second))}), and what makes that makes a mean force too; means don't count "
            '(they do with mean_force = "known" in [defaults] of campaign.toml)'
        )
    return frozenset((*stated, *found)), tuple(words)


def _moving_from_the_start(free: Mapping[str, SeenFree]) -> tuple[str, ...]:
    """Say which runs of free motion don't begin at rest."""
    names = [run for run, one in free.items() if not one.begins_at_rest]
    if not names:
        return ()
    return (
        f"{len(names)} of {len(free)} runs of free motion {'begin' if len(names) > 1 else 'begins'} in motion "
        f"({', '.join(names)}); a law follows them from rest, so that it may err until its memory has caught up",
    )
