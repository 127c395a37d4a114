"""Campaigns: the loop tests of one clamp on one rig, read whole from their folder (docs/reference/campaign.md)."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign import runs_table
from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import Cycles, find_cycles
from pipeclamp_identification.campaign.description import CampaignDescription, read_description
from pipeclamp_identification.campaign.drifting import without
from pipeclamp_identification.campaign.faults import SensorFailure, SensorFault, runs_named
from pipeclamp_identification.campaign.fingerprint import Digests, digests_of
from pipeclamp_identification.campaign.free_motion import FreeRun, free_motion
from pipeclamp_identification.campaign.judging import JudgedRuns, judge_runs
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples, read_record
from pipeclamp_identification.campaign.runs_table import RunRow, RunsTable, Setup, read_runs_table
from pipeclamp_identification.campaign.seen import LeftOut, SeenRecord, seen_free, seen_sine
from pipeclamp_identification.campaign.smoothing import Smoothing, find_smoothing
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import read_content
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.threads import in_threads

BYTES_OF_A_NUMBER = 8
"""As a record's file holds it, about, whatever its format."""


@dataclass(frozen=True)
class Run:
    """One usable run of a sine.

    Attributes:
        name: as runs.csv has it.
        setup: the conditions of the test.
        amplitude_mm, frequency_Hz: of the motion that was set; None where not known, or where the record shows another.
        record: its samples, repaired where that could be.
        cycles: the steady ones.
        mean_known: whether the mean of its force counts. Where it doesn't, it is taken off the samples; where a zero
            drifted, so is the drift, but nobody knows where it stood.
        file: its record, relative to the campaign's folder.
    """

    name: str
    setup: Setup
    amplitude_mm: float | None
    frequency_Hz: float | None
    record: Record
    cycles: Cycles
    mean_known: bool = True
    file: str = ""


@dataclass(frozen=True)
class Campaign:
    """The loop tests of one clamp.

    Attributes:
        name, notes: of its description.
        fingerprint: SHA-256 over all that it was read from, see `read_campaign`.
        runs: usable ones whose motion is a sine, in runs.csv's order.
        left_out: those that can't be used, and why.
        condition_columns: of runs.csv, of further conditions.
        smoothing: how records were smoothed before they came here.
        remarks: what sensors do wrong in runs that are used, where records show other settings than runs.csv states,
            and which units are likely wrong.
        free: usable runs whose motion is no sine.
        faults: of sensors; where one could be repaired, the records here are the repaired ones.
        digests: of the files, for the fingerprint of some of the runs.
        doubts: which units are likely wrong.
        time_measured: whether seconds are seconds: otherwise records count cycles for time, and speeds and frequencies
            mean nothing.
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
    time_measured: bool = True

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
        names, many = runs_named([run.name for run in self.free]), len(self.free) > 1
        if not self.runs:
            raise UserError(
                f"{self.name}: {'all its runs have' if many else 'its only run has'} free motion ({names}); expected "
                "sines: `pipeclamp compare` holds a law against free motion; `pipeclamp import --columns "
                "segment=each-cycle` makes each cycle of a program a run"
            )
        remark = (
            f"{counted(len(self.free), 'run')} of free motion {'are' if many else 'is'} left out ({names}): "
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
    read = partial(read_run, folder, description)
    records = in_threads(read, table.rows, _numbers_in_a_file(folder, table))
    digests = digests_of(folder, {row.file: digest for row, (digest, _) in zip(table.rows, records, strict=True)})
    size = sum(len(record.time_s) for _, record in records) / len(records)
    jobs = [(row, record) for row, (_, record) in zip(table.rows, records, strict=True)]
    looked = in_threads(partial(_looked_at, time_measured=description.time_measured), jobs, size)
    checked = [one for one, _ in looked]
    seen = {row.run: one for row, (_, one) in zip(table.rows, looked, strict=True)}
    judged = judge_runs(folder, table.rows, seen, strict, time_measured=description.time_measured)
    runs = tuple(_judged(one, judged) for one in checked if isinstance(one, Run) and one.name in judged.sines)
    return Campaign(
        name=description.name,
        notes=description.notes,
        fingerprint=digests.fingerprint,
        runs=runs,
        left_out=judged.left_out,
        condition_columns=table.condition_columns,
        smoothing=find_smoothing([(run.record, run.cycles) for run in runs]),
        remarks=judged.remarks,
        free=tuple(_shifted(one, judged) for one in checked if isinstance(one, FreeRun) and one.name in judged.free),
        faults=judged.faults,
        digests=digests,
        doubts=judged.doubts,
        time_measured=description.time_measured,
    )


def _numbers_in_a_file(folder: Path, table: RunsTable) -> float:
    """Give about how many numbers a record's file holds, on average; 0 where one can't be found."""
    # whoever reads it says why
    with suppress(OSError, ValueError):
        size = sum((folder / row.file).stat().st_size for row in table.rows)
        return size / (BYTES_OF_A_NUMBER * len(table.rows))
    return 0.0


def _looked_at(job: tuple[RunRow, Record], time_measured: bool) -> tuple[Run | FreeRun | LeftOut, SeenRecord | LeftOut]:
    """Give a run of its row and record, and what the record shows."""
    run = checked_run(*job, time_measured=time_measured)
    return run, seen_of(run)


def _judged(run: Run, judged: JudgedRuns) -> Run:
    """Give a run with its record as the sensors leave it, and what was stated where the record doesn't contradict."""
    amplitude, frequency = judged.settings[run.name]
    seen, mean_known = judged.sines[run.name], run.name not in judged.without_mean
    record = judged.sensors.repaired(run.name, run.record, seen)
    return replace(
        run,
        setup=run.setup.measured_at(seen.temperature_C),
        record=record if mean_known else without(record, "force", float(np.mean(record.force_N[run.cycles.steady]))),
        mean_known=mean_known and run.name not in judged.sensors.of_unknown_mean,
        amplitude_mm=amplitude,
        frequency_Hz=frequency,
    )


def _shifted(run: FreeRun, judged: JudgedRuns) -> FreeRun:
    """Give a run of free motion with its sensors' zeros where they belong."""
    record = judged.sensors.shifted(run.name, run.record)
    off = run.record.displacement_mm[0] - record.displacement_mm[0]
    mean_known = run.name not in judged.without_mean
    if not mean_known:
        record = without(record, "force", float(np.mean(record.force_N)))
    return replace(run, record=record, motion=replace(run.motion, y=run.motion.y - off), mean_known=mean_known)


def seen_of(run: Run | FreeRun | LeftOut) -> SeenRecord | LeftOut:
    """Give what the record of a run shows."""
    if isinstance(run, Run):
        return seen_sine(run.record, run.cycles)
    return seen_free(run.record, run.motion) if isinstance(run, FreeRun) else run


def seen_in(folder: Path, description: CampaignDescription, row: RunRow) -> SeenRecord | LeftOut:
    """Read a run's record and give what it shows, as `checked_run` and `seen_of` do.

    Raises:
        UserError: the file is missing or broken.
    """
    record = read_run(folder, description, row)[1]
    return seen_of(checked_run(row, record, time_measured=description.time_measured))


def read_run(folder: Path, description: CampaignDescription, row: RunRow) -> tuple[str, Record]:
    """Read a run's record, with its file's SHA-256.

    Raises:
        UserError: the file is missing or broken.
    """
    path = folder / row.file
    where = f"{folder / runs_table.FILE_NAME}, row {row.row}, column 'file': {row.file!r}"
    content = read_content(path, f"the record of run {row.run!r} there, relative to {folder}", where)
    return hashlib.sha256(content).hexdigest(), read_record(path, content, description.columns.given())


def checked_run(row: RunRow, record: Record, *, time_measured: bool = True) -> Run | FreeRun | LeftOut:
    """Give a run of its row and record; or why it can't be used."""
    try:
        check_samples(record)
        if row.free:
            return FreeRun(row.run, row.setup, record, free_motion(record))
        cycles = find_cycles(record, timed=time_measured)
        if time_measured:  # a sensor is clipped where it enters its end at speed
            check_clipping(record, cycles)
    except UnusableRecord as fault:
        return LeftOut(row.run, str(fault), fault if isinstance(fault, SensorFailure) else None)
    return Run(row.run, row.setup, row.amplitude_mm, row.frequency_Hz, record, cycles, file=row.file)
