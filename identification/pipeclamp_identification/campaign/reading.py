"""Campaigns: the loop tests of one clamp on one rig, read whole from their folder (docs/reference/campaign.md)."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign import runs_table
from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import Cycles, find_cycles
from pipeclamp_identification.campaign.description import CampaignDescription, read_description
from pipeclamp_identification.campaign.faults import SensorFailure, SensorFault, faults_of_failures
from pipeclamp_identification.campaign.fingerprint import Digests, digests_of
from pipeclamp_identification.campaign.free_motion import FreeRun, free_motion, fundamental_of_motion
from pipeclamp_identification.campaign.plausibility import (
    CycleByCycle,
    Fundamental,
    contradiction,
    cycle_by_cycle,
    fundamental_of,
    implausible,
    unless_contradicted,
)
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples, read_record
from pipeclamp_identification.campaign.runs_table import RunRow, RunsTable, read_runs_table
from pipeclamp_identification.campaign.sensors import Observed, Sensors, sensors_of
from pipeclamp_identification.campaign.smoothing import Smoothing, find_smoothing
from pipeclamp_identification.units.doubts import ShownRun, contradicted_units, unlikely_units
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import read_content

# threads that read records: more than most machines' cores for it, because each also waits for the disk
READERS = 4


@dataclass(frozen=True)
class Run:
    """One usable run: what was set (None where not known), its samples and its steady cycles; labels by column.

    Where a zero drifted, the drift is taken off the samples, but nobody knows where it stood: `mean_known` is False,
    and the mean force says nothing.
    """

    name: str
    specimen: str | None
    amplitude_mm: float | None
    frequency_Hz: float | None
    temperature_C: float | None
    density_g_cm3: float | None
    first_cycle: float
    conditions: Mapping[str, float]
    record: Record
    cycles: Cycles
    mean_known: bool = True
    labels: Mapping[str, str] = field(default_factory=dict)
    file: str = ""
    """Its record, relative to the campaign's folder."""

    @property
    def texts(self) -> dict[str, str]:
        """Texts that may group runs, by column of runs.csv, the specimen among them; blank where there is none."""
        return {"specimen": self.specimen or "", **self.labels}


@dataclass(frozen=True)
class LeftOut:
    """A run that can't be used, and why; with the failure, where a sensor's is the reason."""

    run: str
    reason: str
    failure: SensorFailure | None = None

    def __str__(self) -> str:
        return f"run {self.run!r} is left out: {self.reason}"


@dataclass(frozen=True)
class Campaign:
    """The loop tests of one clamp: usable runs in runs.csv's order, those left out, and how records were smoothed.

    `remarks` say what sensors do wrong in runs that are used, and where records show other settings than runs.csv
    states; those runs' settings are None. Of the runs in `runs` the motion is a sine, of those in `free` it isn't.
    `faults` are those of sensors; where one could be repaired, the records here are the repaired ones. `doubts` say
    which units are likely wrong; remarks hold them, too.
    """

    name: str
    notes: str
    fingerprint: str
    runs: tuple[Run, ...]
    left_out: tuple[LeftOut, ...]
    condition_columns: tuple[str, ...]
    smoothing: Smoothing = field(default_factory=Smoothing)
    remarks: tuple[str, ...] = ()
    free: tuple[FreeRun, ...] = ()
    faults: tuple[SensorFault, ...] = ()
    digests: Digests = field(default_factory=Digests)
    doubts: tuple[str, ...] = ()

    def of_runs(self, runs: tuple[Run, ...]) -> Campaign:
        """Give the campaign of some of its runs, with the fingerprint of what these were read from."""
        files = {run.file for run in runs}
        return replace(self, runs=runs, fingerprint=self.digests.of(files).fingerprint)

    def of_sines(self) -> Campaign:
        """Give the campaign without its runs of free motion, with a remark that names them.

        Raises:
            UserError: it has no others.
        """
        if not self.free:
            return self
        names, many = ", ".join(run.name for run in self.free), len(self.free) > 1
        if not self.runs:
            raise UserError(
                f"{self.name}: {'all its runs have' if many else 'its only run has'} free motion ({names}); expected "
                "sines, which a law is fitted to and metrics are of: `pipeclamp compare` holds a law against these"
            )
        remark = (
            f"{len(self.free)} run{'s' if many else ''} of free motion {'are' if many else 'is'} left out ({names}): "
            "laws are fitted to sines alone so far; compare takes them"
        )
        return replace(self, free=(), remarks=(*self.remarks, remark))


def read_campaign(folder: Path, strict: bool = False) -> Campaign:
    """Read a campaign: every file once, checked, its records split into cycles.

    Args:
        folder: the campaign's folder, in the layout of docs/reference/campaign.md.
        strict: a run that can't be used is an error.

    Returns:
        The campaign. Its fingerprint is a SHA-256 over the bytes of campaign.toml, runs.csv and the records,
        with their names, in the order of these; where the folder lies and other files in it don't matter.

    Raises:
        UserError: a file is missing or not as expected; no run can be used; or, with `strict`, one can't.
    """
    folder = Path(folder)
    description = read_description(folder)
    table = read_runs_table(folder, description)
    if table.without_records:
        raise UserError(
            f"{folder}: holds metrics without records; expected records of the loops (metrics, identify, compare, "
            "diagnose, add and remove can do with metrics)"
        )
    return campaign_of(folder, description, table, strict)


def campaign_of(folder: Path, description: CampaignDescription, table: RunsTable, strict: bool) -> Campaign:
    """Read the records of a campaign whose description and table have been read, as `read_campaign` does."""
    with ThreadPoolExecutor(max_workers=READERS) as readers:
        # parsing lets other threads run; the many small steps of finding cycles don't, and come after it
        records = list(readers.map(partial(_read_run, folder, description), table.rows))
    digests = digests_of(folder, {row.file: digest for row, (digest, _) in zip(table.rows, records, strict=True)})
    outcomes = [_checked_run(row, record) for row, (_, record) in zip(table.rows, records, strict=True)]
    by_cycle = {one.name: cycle_by_cycle(one.record, one.cycles) for one in outcomes if isinstance(one, Run)}
    shown = {
        one.name: fundamental_of(one.record, one.cycles, by_cycle[one.name]) for one in outcomes if isinstance(one, Run)
    }
    freely = {one.name: fundamental_of_motion(one.record, one.motion) for one in outcomes if isinstance(one, FreeRun)}
    seen = [_seen(one, shown[one.name]) for one in outcomes if isinstance(one, Run)]
    if wrong := contradicted_units(seen):
        raise UserError(f"{folder}: {wrong}")
    doubts = unlikely_units(seen)
    faults = implausible(shown | freely)
    outcomes = [
        LeftOut(row.run, faults[row.run]) if row.run in faults else one
        for row, one in zip(table.rows, outcomes, strict=True)
    ]
    sensors = sensors_of(
        [_observed(one, by_cycle[one.name], shown[one.name]) for one in outcomes if isinstance(one, Run)]
    )
    outcomes = [_as_sensors_say(one, sensors) if isinstance(one, Run) else one for one in outcomes]
    runs = tuple(outcome for outcome in outcomes if isinstance(outcome, Run))
    free = tuple(outcome for outcome in outcomes if isinstance(outcome, FreeRun))
    left_out = tuple(outcome for outcome in outcomes if isinstance(outcome, LeftOut))
    if left_out and (strict or not (runs or free)):
        heading = f"{folder}: {len(left_out)} of {len(outcomes)} runs can't be used; mend their records"
        remedy = ", take their rows out of runs.csv, or don't be strict" if runs or free else ""
        raise UserError("\n".join([heading + remedy, *(f"  {one}" for one in left_out)]))
    runs, remarks = _without_wrong_settings(runs, shown)
    return Campaign(
        name=description.name,
        notes=description.notes,
        fingerprint=digests.fingerprint,
        runs=runs,
        left_out=left_out,
        condition_columns=table.condition_columns,
        smoothing=find_smoothing([(run.record, run.cycles) for run in runs]),
        remarks=(
            *doubts,
            *(fault.words for fault in sensors.faults if fault.done != "left out"),
            *remarks,
            *_moving_from_the_start(free),
        ),
        free=free,
        faults=(
            *faults_of_failures(
                [(one.run, one.failure) for one in left_out if one.failure and one.run not in sensors.failed]
            ),
            *sensors.faults,
        ),
        digests=digests,
        doubts=doubts,
    )


def _seen(run: Run, shown: Fundamental) -> ShownRun:
    """Give a run as its units are doubted."""
    time, temperature = run.record.time_s, run.record.temperature_C
    known = np.empty(0) if temperature is None else temperature[np.isfinite(temperature)]
    return ShownRun(
        run=run.name,
        amplitude_mm=(run.amplitude_mm, shown.amplitude_mm),
        frequency_Hz=(run.frequency_Hz, run.cycles.frequency_Hz),
        temperature_C=(run.temperature_C, float(np.mean(known)) if len(known) else math.nan),
        stiffness=abs(shown.stiffness),
        step_s=float(time[-1] - time[0]) / (len(time) - 1),
    )


def _observed(run: Run, by_cycle: CycleByCycle, shown: Fundamental) -> Observed:
    """Give a run as its sensors show it."""
    density = math.nan if run.density_g_cm3 is None else run.density_g_cm3
    return Observed(
        name=run.name,
        record=run.record,
        cycles=run.cycles,
        nominal_mm=run.amplitude_mm,
        temperature_C=run.temperature_C,
        further={"density_g_cm3": density, **run.conditions},
        labels=run.texts,
        by_cycle=by_cycle,
        shown=shown,
    )


def _as_sensors_say(run: Run, sensors: Sensors) -> Run | LeftOut:
    """Give a run with its record as the sensors leave it; what failed is left out."""
    if run.name in sensors.failed:
        failure = sensors.failed[run.name]
        return LeftOut(run.name, str(failure), failure)
    record = sensors.records[run.name]
    return replace(run, record=record, mean_known=run.name not in sensors.of_unknown_mean)


def _moving_from_the_start(runs: tuple[FreeRun, ...]) -> tuple[str, ...]:
    """Say which runs of free motion don't begin at rest."""
    names = [run.name for run in runs if not run.begins_at_rest]
    if not names:
        return ()
    return (
        f"{len(names)} of {len(runs)} runs of free motion {'begin' if len(names) > 1 else 'begins'} in motion "
        f"({', '.join(names)}); a law follows them from rest, so that it may err until its memory has caught up",
    )


def _read_run(folder: Path, description: CampaignDescription, row: RunRow) -> tuple[str, Record]:
    path = folder / row.file
    where = f"{folder / runs_table.FILE_NAME}, row {row.row}, column 'file': {row.file!r}"
    content = read_content(path, f"the record of run {row.run!r} there, relative to {folder}", where)
    return hashlib.sha256(content).hexdigest(), read_record(path, content, description.columns.given())


def _checked_run(row: RunRow, record: Record) -> Run | FreeRun | LeftOut:
    try:
        check_samples(record)
        if row.free:
            return FreeRun(
                name=row.run,
                specimen=row.specimen,
                temperature_C=row.temperature_C,
                density_g_cm3=row.density_g_cm3,
                first_cycle=row.first_cycle,
                conditions=row.conditions,
                record=record,
                motion=free_motion(record),
            )
        cycles = find_cycles(record)
        check_clipping(record, cycles)
    except UnusableRecord as fault:
        return LeftOut(row.run, str(fault), fault if isinstance(fault, SensorFailure) else None)
    return Run(
        name=row.run,
        specimen=row.specimen,
        amplitude_mm=row.amplitude_mm,
        frequency_Hz=row.frequency_Hz,
        temperature_C=row.temperature_C,
        density_g_cm3=row.density_g_cm3,
        first_cycle=row.first_cycle,
        conditions=row.conditions,
        record=record,
        cycles=cycles,
        labels=row.labels,
        file=row.file,
    )


def _without_wrong_settings(
    runs: tuple[Run, ...], shown: Mapping[str, Fundamental]
) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Give the runs without the amplitudes and frequencies that their records contradict, and words about these."""
    amplitudes = [(run.amplitude_mm, shown[run.name].amplitude_mm) for run in runs]
    frequencies = [(run.frequency_Hz, run.cycles.frequency_Hz) for run in runs]
    words = (contradiction("amplitude_mm", amplitudes), contradiction("frequency_Hz", frequencies))
    kept = tuple(
        replace(run, amplitude_mm=unless_contradicted(*amplitude), frequency_Hz=unless_contradicted(*frequency))
        for run, amplitude, frequency in zip(runs, amplitudes, frequencies, strict=True)
    )
    return kept, tuple(filter(None, words))
