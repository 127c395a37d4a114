"""A piece of a table becomes drafts of runs: cut at levels, repaired, looked at, and written."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.faults import SensorFailure
from pipeclamp_identification.campaign.free_motion import free_motion
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_identification.campaign.seen import SeenRecord, seen_free, seen_sine
from pipeclamp_identification.campaign.writing import Format, encoded
from pipeclamp_identification.importing.channels.columns import Column
from pipeclamp_identification.importing.channels.traces import Trace, moved_words, trace_of
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.records.drafts import CutPart, Draft, TakenPart
from pipeclamp_identification.importing.samples.blanks import without_blanks
from pipeclamp_identification.importing.samples.clipped import without_clipped_cycles
from pipeclamp_identification.importing.samples.integrated import integrated
from pipeclamp_identification.importing.samples.repair import at_own_rate, evened, without_spikes
from pipeclamp_identification.importing.samples.split import Cut, SampleRange, irregular, levels, unsteady
from pipeclamp_identification.importing.samples.untimed import cycles_of, hardly_turns_words, laid_out
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.tables import pl

BLANK = "blank samples, and what lies behind them"
"""Why a part of a run isn't in it."""
STATED_FREE = "as --conditions states"
"""Why a record of which the user says so is no sine."""


@dataclass(frozen=True)
class Piece:
    """Rows of a table between two that surely part runs.

    Attributes:
        where: names the table in errors.
        table: these rows of it.
        begin: rows before them.
        cycles_before: that its specimen surely had before; nan where nothing tells.
        places: of its samples in the table, where some lie between two of its rows; None where none does.
        label: of them, in the column of texts that tells runs apart.
        record: path of the records' files, to which a number and an ending are added.
        timed: whether its time was measured.
        free: whether its motion is stated to be free.
        stretches: that a picture of it is thinned out to.
    """

    where: str
    table: RawTable
    columns: tuple[Column, ...]
    rate: float | None
    timed: bool
    begin: int
    cycles_before: float
    places: Array | None
    label: str
    free: bool
    record: Path
    format: Format
    stretches: int

    @property
    def of_displacement(self) -> Conversion:
        """What turns its channel of the displacement into mm."""
        return next(one.conversion for one in self.columns if one.ours == "displacement")


def take_piece(piece: Piece) -> TakenPart | UserError:
    """Take a piece of a table; a mistake of the user's is given, not raised, so that the first one is told first."""
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of numbers that a check refuses
            return _taken_piece(piece)
    except UserError as error:
        return error


def _taken_piece(piece: Piece) -> TakenPart:
    trace = trace_of(piece.where, piece.table, piece.columns, piece.rate, piece.begin)
    if piece.places is not None and piece.rate:
        trace = replace(trace, record=replace(trace.record, time_s=piece.places / piece.rate))
    y = trace.motion
    if np.count_nonzero(np.isfinite(y)) < 2:
        rows = piece.table.first_row, piece.table.first_row + piece.table.length - 1
        nowhere = CutPart(rows, (0.0, 0.0), "no samples of displacement")
        return TakenPart((), 0, (nowhere,), np.empty(0), np.empty((0, 2)))
    found = Cut((SampleRange(0, len(y)),), ()) if piece.free else levels(trace.record.time_s, y)
    drafts: list[Draft] = []
    left = list(found.left)
    for part in found.runs:
        try:
            record = piece.record.with_name(f"{piece.record.name}_{len(drafts):03d}.{piece.format}")
            draft, cut_off = _draft(piece, trace, part, record)
            drafts.append(draft)
            left += cut_off
        except UnusableRecord as fault:
            left.append(replace(part, why=str(fault)))
    cut = tuple(
        CutPart(_samples(piece.table, trace, part), _span(trace, part), part.why)
        for part in sorted(left, key=lambda part: part.first)
    )
    if piece.of_displacement.integrated:  # no picture in mm of what isn't any
        return TakenPart(tuple(drafts), len(found.runs), cut, np.empty(0), np.empty((0, 2)))
    edges = np.unique(np.linspace(0, len(y), min(piece.stretches, len(y)) + 1).astype(np.intp))
    thinned = np.stack([np.minimum.reduceat(y, edges[:-1]), np.maximum.reduceat(y, edges[:-1])], axis=1)
    return TakenPart(tuple(drafts), len(found.runs), cut, trace.record.time_s[edges[:-1]], thinned)


def _draft(piece: Piece, trace: Trace, part: SampleRange, path: Path) -> tuple[Draft, list[SampleRange]]:
    """Give a part as a run, its record written, and what of the part isn't in it.

    Raises:
        UnusableRecord: it can't be one.
    """

    def row(sample: int) -> int:
        return int(trace.places[part.first + sample]) + piece.table.first_row

    whole = without_blanks(trace.record.part(part.first, part.last), row)
    kept = SampleRange(part.first + whole.first, part.first + whole.last)
    check_samples(whole.record, lambda sample: row(whole.first + sample))
    slow = at_own_rate(whole.record)
    clean = without_spikes(slow.record)
    repaired = evened(clean.record) if piece.timed else laid_out(clean.record)
    times = piece.of_displacement.integrated
    even = integrated(repaired.record, times, free=piece.free) if times else repaired.record
    if piece.free:
        usable = _free(even, STATED_FREE)
    elif piece.timed or repaired.done:
        usable = _usable(even, piece.timed)
    else:  # what isn't laid out has the time of its samples, in which cycles mean nothing
        usable = _free(clean.record, hardly_turns_words(clean.record.displacement_mm))
    record, seen, words = usable
    path.write_bytes(encoded(pl.DataFrame(record.channels), piece.format))
    known = record.temperature_C
    # what the machine counted, or a curve without a time as it is laid out; then what of the piece lies before the run
    known_before = not math.isnan(piece.cycles_before)
    before = piece.cycles_before + cycles_of(trace.motion[: kept.first + 1]) if known_before else 0.0
    after = (f"cycles of its specimen before it: {before:.4g}",) if before else ()
    further = {name: values[kept.first : kept.last] for name, values in trace.further.items()}
    draft = Draft(
        samples=_samples(piece.table, trace, kept),
        span=_span(trace, kept),
        record=path,
        seen=seen,
        done=(
            *(*after, *trace.done, *whole.done, *slow.done, *clean.done, *repaired.done),
            *filter(None, [piece.of_displacement.integrated_words]),
            *words,
            *(moved for name, values in further.items() if (moved := moved_words(name, values))),
        ),
        further={name: _mean(values) for name, values in further.items()},
        temperature=None if known is None else (float(np.mean(known)), float(np.ptp(known))),
        label=piece.label,
        cycles_before=before,
    )
    beside = (SampleRange(part.first, kept.first, BLANK), SampleRange(kept.last, part.last, BLANK))
    return draft, [one for one in beside if one.last > one.first]


def _mean(values: Array) -> float:
    """Give the mean of samples of which some may be blank; nan where all are."""
    finite = values[np.isfinite(values)]
    return float(np.mean(finite)) if len(finite) else math.nan


def _usable(record: Record, timed: bool) -> tuple[Record, SeenRecord, tuple[str, ...]]:
    """Give a record that can be used, what it shows, and what was cut out of it.

    Raises:
        UnusableRecord: it can't be.
    """
    try:
        cycles = find_cycles(record, timed=timed)
    except UnusableRecord as fault:
        return _free(record, str(fault))
    words: tuple[str, ...] = ()
    try:
        # a sensor is clipped where it enters its end at speed, which nobody knows without a time
        if timed:
            check_clipping(record, cycles)
    except SensorFailure as failure:
        record, cut = without_clipped_cycles(record, cycles, failure)
        words = (cut,)
        cycles = find_cycles(record)
        check_clipping(record, cycles)
    if change := unsteady(record.time_s, record.displacement_mm, cycles.steady, cycles.count):
        if disorder := irregular(record.displacement_mm):
            return _free(record, disorder)
        words = (*words, change)
    return record, seen_sine(record, cycles), words


def _free(record: Record, why: str) -> tuple[Record, SeenRecord, tuple[str, ...]]:
    """Give a record of any motion, what it shows, and why it is no sine."""
    return record, seen_free(record, free_motion(record)), (f"its motion is no sine ({why}): it is free",)


def _samples(table: RawTable, trace: Trace, part: SampleRange) -> tuple[int, int]:
    """Give the first and the last sample of a part as the file counts them."""
    return (
        int(trace.places[part.first]) + table.first_row,
        int(trace.places[part.last - 1]) + table.first_row,
    )


def _span(trace: Trace, part: SampleRange) -> tuple[float, float]:
    """Give a part's first and last time."""
    return float(trace.record.time_s[part.first]), float(trace.record.time_s[part.last - 1])
