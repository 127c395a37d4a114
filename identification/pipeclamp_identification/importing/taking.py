"""Files become drafts of runs: each is cut out, repaired, looked at and written before the next; no other is held."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.description import ImportedColumn, ImportedFile
from pipeclamp_identification.campaign.faults import SensorFailure
from pipeclamp_identification.campaign.free_motion import free_motion
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_identification.campaign.seen import SeenRecord, seen_free, seen_sine
from pipeclamp_identification.campaign.writing import Format, encoded
from pipeclamp_identification.importing.channels.columns import (
    Column,
    Mapped,
    OpenChannelsError,
    Stated,
    refuse_open_questions,
)
from pipeclamp_identification.importing.channels.mapping import Open, mapped_tables, where_of
from pipeclamp_identification.importing.channels.naming import SEGMENT
from pipeclamp_identification.importing.channels.questions import MOST_FALLS, NONE
from pipeclamp_identification.importing.channels.traces import (
    Trace,
    first_motion,
    label_column,
    moved_words,
    segment_of,
    time_of,
    trace_of,
)
from pipeclamp_identification.importing.conditions import Settings, of_properties
from pipeclamp_identification.importing.raw import Above, RawTable, Unread
from pipeclamp_identification.importing.reading import SourceFile, digest_of, read_file
from pipeclamp_identification.importing.samples.blanks import without_blanks
from pipeclamp_identification.importing.samples.clipped import without_clipped_cycles
from pipeclamp_identification.importing.samples.repair import at_own_rate, evened, without_spikes
from pipeclamp_identification.importing.samples.split import SampleRange, irregular, levels, piece_bounds, unsteady
from pipeclamp_identification.importing.samples.untimed import laid_out
from pipeclamp_identification.importing.stated import Ask
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError
from pipeclamp_identification.units.stated import unit_in_name
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import cores, spread
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.tables import pl

OURS = {"time": "time_s", "displacement": "displacement_mm", "force": "force_N", "temperature": "temperature_C"}
BLANK = "blank samples, and what lies behind them"
"""Why a part of a run isn't in it."""
WIDEST_OVERVIEW = 600
"""Stretches that a picture of a whole table is thinned out to."""
WORTH_PROCESSES = 24_000_000
"""Bytes of files from which on they are taken by several processes, which take a second or two to begin."""
LARGE = 64_000_000
"""Bytes of a file that one process reads by itself; its parts are handed to others."""


@dataclass(frozen=True)
class Way:
    """How files are taken, as far as it is the same for all of them.

    Attributes:
        columns: what was stated of channels.
        rate: samples per second, where no channel holds the time.
        timed: whether these are the logger's.
        ask: whether somebody can say what is open.
        records: folder that records are written into, and their format.
        known: SHA-256 of files that aren't read again.
    """

    columns: tuple[Stated, ...]
    rate: float | None
    timed: bool
    ask: bool
    records: Path
    format: Format
    known: frozenset[str]


@dataclass(frozen=True)
class Draft:
    """A run before it has a name.

    Attributes:
        samples: the first and the last, as the file counts them; and their times.
        record: the file that they were written into.
        seen: what they show.
        done: to them.
        further: mean of each further channel, by column of runs.csv.
        temperature: mean, and by how much it moved; None where it wasn't measured.
        label: that the file gives it in a column of texts; "" where it gives none.
    """

    samples: tuple[int, int]
    span: tuple[float, float]
    record: Path
    seen: SeenRecord
    done: tuple[str, ...]
    further: Mapping[str, float]
    temperature: tuple[float, float] | None
    label: str = ""


@dataclass(frozen=True)
class CutPart:
    """Samples that are in no run, as the file counts them; their times; and why."""

    samples: tuple[int, int]
    span: tuple[float, float]
    why: str


@dataclass(frozen=True)
class TakenPart:
    """What became of a table, or of a part of it.

    Attributes:
        drafts: of its runs.
        runs: into which it was cut, usable or not.
        cut: what is in no run.
        time, displacement: thinned out to stretches, shape (n,), and the least and largest of each, (n, 2).
    """

    drafts: tuple[Draft, ...]
    runs: int
    cut: tuple[CutPart, ...]
    time: Array
    displacement: Array


@dataclass(frozen=True)
class TakenTable:
    """A table that was taken.

    Attributes:
        name: within the file.
        mapped: its channels that are ours.
        unused: headings of the others.
        unread: what isn't numbers in those that are ours.
        joined: what was done to put its channels on one time.
        stated: of its runs, by the file's properties.
        above: what stands above it of the temperature.
        taken: what became of it.
    """

    name: str
    mapped: Mapped
    unused: tuple[str, ...]
    unread: tuple[Unread, ...]
    joined: tuple[str, ...]
    stated: Settings
    above: Above | None
    taken: TakenPart


@dataclass(frozen=True)
class TakenFile:
    """A file that was taken: as campaign.toml states it, its tables, and the names of those that were left aside."""

    file: ImportedFile
    tables: tuple[TakenTable, ...]
    aside: tuple[str, ...]


@dataclass(frozen=True)
class KnownFile:
    """A file that isn't taken, because what it holds is there already."""

    sha256: str


@dataclass(frozen=True)
class Piece:
    """Rows of a table between two that surely part runs.

    Attributes:
        where: names the table in errors.
        table: these rows of it.
        begin: rows before them.
        label: of them, in the column of texts that tells runs apart.
        record: path of the records' files, to which a number and an ending are added.
        timed: whether its time was measured.
        stretches: that a picture of it is thinned out to.
    """

    where: str
    table: RawTable
    columns: tuple[Column, ...]
    rate: float | None
    timed: bool
    begin: int
    label: str
    record: Path
    format: Format
    stretches: int


Over = Callable[[Callable[[Piece], "TakenPart | UserError"], Iterable[Piece]], Iterator["TakenPart | UserError"]]
"""Applies a function to each piece, here or in other processes."""


def take_file(path: Path, number: int, way: Way, over: Over = map) -> TakenFile | KnownFile | Open:
    """Take a file.

    Args:
        path: of the file.
        number: tells its records from those of others.
        way: how files are taken.
        over: goes through its pieces.

    Raises:
        UserError: it can't be read, or what a channel is, is open and nobody can be asked.
    """
    digest = digest_of(path)
    if digest in way.known:
        return KnownFile(digest)
    source = read_file(path)
    used = mapped_tables(source, way.columns, way.rate, ask=way.ask)
    if isinstance(used, Open):
        return used
    tables = []
    for index, (table, mapped) in enumerate(used.tables):
        record = way.records / f"{number:05d}_{index:03d}"
        taken = _taken(source, table, mapped, record, way, over)
        headings = {column.heading for column in mapped.columns}
        unused = tuple(one.heading for one in table.channels if one.heading not in headings)
        # a column that is nothing but text serves as the names of runs, as it is
        unread = tuple(one for one in table.unread if one.channel.heading in headings and not one.is_whole)
        stated = of_properties(table.properties)
        # who states that there is none means that above the table, too
        none = any(one.ours == "temperature" and one.channel.casefold() == NONE for one in way.columns)
        above = None if none else table.above
        tables.append(TakenTable(table.name, mapped, unused, unread, table.joined, stated, above, taken))
    first, mapped = used.tables[0]
    above_first = [tables[0].above.words] if tables[0].above else []
    file = ImportedFile(
        file=source.name,
        sha256=digest,
        format=source.format,
        read_as="; ".join([*first.told, *first.joined, *(one.words() for one in tables[0].unread), *above_first]),
        columns={OURS.get(one.ours, one.ours): _imported(one) for one in mapped.columns},
    )
    return TakenFile(file, tuple(tables), used.aside)


def _taken(source: SourceFile, table: RawTable, mapped: Mapped, record: Path, way: Way, over: Over) -> TakenPart:
    """Take a table, piece by piece."""
    parts: list[TakenPart] = []
    for part in over(take_piece, _pieces(where_of(source, table), table, mapped.columns, record, way)):
        if isinstance(part, UserError):
            raise part
        parts.append(part)
    drafts = tuple(draft for part in parts for draft in part.drafts)
    cut = tuple(one for part in parts for one in part.cut)
    # one run from end to end needs no picture of where it lies
    drawn = parts if cut or len(drafts) > 1 else parts[:0]
    return TakenPart(
        drafts,
        sum(part.runs for part in parts),
        cut,
        np.concatenate([np.empty(0), *(part.time for part in drawn)]),
        np.concatenate([np.empty((0, 2)), *(part.displacement for part in drawn)]),
    )


def _pieces(where: str, table: RawTable, columns: tuple[Column, ...], record: Path, way: Way) -> Iterator[Piece]:
    """Give the pieces of a table, with the channels that are ours alone."""
    headings = {column.heading for column in columns}
    channels = [channel for channel in (*table.channels, *table.labels) if channel.heading in headings]
    time = time_of(table, columns, way.rate)
    finite = np.isfinite(time)
    timed = None if np.all(finite) else np.flatnonzero(finite)
    own = time if timed is None else time[timed]
    bounds = np.zeros(2, dtype=np.intp)
    if (falls := np.count_nonzero(own[1:] < own[:-1])) > MOST_FALLS * len(own):
        raise UnusableFileError(
            where,
            f"its time falls in {falls} of {len(own) - 1} steps, {own[0]:g}, {own[1]:g}, ...; expected one "
            "that rises: another channel by --columns, or the samples per second by --columns time=none --rate",
        )
    if len(own):
        surely = any(column.ours == SEGMENT and column.stated for column in columns)
        segment = segment_of(table, columns, timed)
        bounds = piece_bounds(own, lambda: first_motion(table, columns, timed), segment, surely=surely)
    inner = bounds[1:-1] if timed is None else timed[bounds[1:-1]]
    begins = [0, *inner.tolist(), table.length]
    del time, own
    label = label_column(table, columns)
    for number, (first, last) in enumerate(itertools.pairwise(begins)):
        rows = tuple(replace(channel, values=channel.values[first:last]) for channel in channels)
        yield Piece(
            where=where,
            table=RawTable(table.name, rows, table.first_row + first, table.told),
            columns=columns,
            rate=way.rate,
            timed=is_timed(columns, way.timed),
            begin=first,
            label=label.of(np.arange(first, last)[finite[first:last]]) if label else "",
            record=record.with_name(f"{record.name}_{number:05d}"),
            format=way.format,
            stretches=max(1, round(WIDEST_OVERVIEW * (last - first) / table.length)),
        )


def take_piece(piece: Piece) -> TakenPart | UserError:
    """Take a piece of a table; a mistake of the user's is given, not raised, so that the first one is told first."""
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of numbers that a check refuses
            return _taken_piece(piece)
    except UserError as error:
        return error


def _taken_piece(piece: Piece) -> TakenPart:
    trace = trace_of(piece.where, piece.table, piece.columns, piece.rate, piece.begin)
    y = trace.motion
    if np.count_nonzero(np.isfinite(y)) < 2:
        rows = piece.table.first_row, piece.table.first_row + piece.table.length - 1
        nowhere = CutPart(rows, (0.0, 0.0), "no samples of displacement")
        return TakenPart((), 0, (nowhere,), np.empty(0), np.empty((0, 2)))
    found = levels(trace.record.time_s, y)
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
    record, seen, words = _usable(repaired.record, piece.timed)
    path.write_bytes(encoded(pl.DataFrame(record.channels), piece.format))
    known = record.temperature_C
    further = {name: values[kept.first : kept.last] for name, values in trace.further.items()}
    draft = Draft(
        samples=_samples(piece.table, trace, kept),
        span=_span(trace, kept),
        record=path,
        seen=seen,
        done=(
            *(*trace.told, *whole.told, *slow.told, *clean.told, *repaired.told, *words),
            *(moved for name, values in further.items() if (moved := moved_words(name, values))),
        ),
        further={name: _mean(values) for name, values in further.items()},
        temperature=None if known is None else (float(np.mean(known)), float(np.ptp(known))),
        label=piece.label,
    )
    beside = (SampleRange(part.first, kept.first, BLANK), SampleRange(kept.last, part.last, BLANK))
    return draft, [one for one in beside if one.last > one.first]


def is_timed(columns: Sequence[Column], rate_is_measured: bool) -> bool:
    """Tell whether the time of a table was measured: by a channel, or by a logger of known rate."""
    return rate_is_measured or any(one.ours == "time" for one in columns)


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
        cycles = find_cycles(record)
    except UnusableRecord as fault:
        return record, seen_free(record, free_motion(record)), (f"its motion is no sine ({fault}): it is free",)
    words: tuple[str, ...] = ()
    try:
        # a sensor is clipped where it enters its end at speed, which nobody knows without a time
        if timed:
            check_clipping(record, cycles)
    except SensorFailure as failure:
        record, told = without_clipped_cycles(record, cycles, failure)
        words = (told,)
        cycles = find_cycles(record)
        check_clipping(record, cycles)
    if change := unsteady(record.displacement_mm, cycles.steady, cycles.count):
        if disorder := irregular(record.displacement_mm):
            return record, seen_free(record, free_motion(record)), (f"its motion is no sine ({disorder}): it is free",)
        words = (*words, change)
    return record, seen_sine(record, cycles), words


def _imported(column: Column) -> ImportedColumn:
    return ImportedColumn(
        channel=column.heading,
        unit=column.unit,
        factor=column.conversion.factor,
        offset=column.conversion.offset,
        stated=column.stated,
    )


def _samples(table: RawTable, trace: Trace, part: SampleRange) -> tuple[int, int]:
    """Give the first and the last sample of a part as the file counts them."""
    return (
        int(trace.places[part.first]) + table.first_row,
        int(trace.places[part.last - 1]) + table.first_row,
    )


def _span(trace: Trace, part: SampleRange) -> tuple[float, float]:
    """Give a part's first and last time."""
    return float(trace.record.time_s[part.first]), float(trace.record.time_s[part.last - 1])


Job = tuple[int, Path, Way]
Outcome = TakenFile | KnownFile | Open | UserError
"""Of taking a file: an UnusableFileError lets the others go on."""


def _take(job: Job) -> Outcome:
    """Take a file in a process of its own; a mistake is given, not raised, so that the first one is told first."""
    return _outcome(*job)


def _outcome(number: int, path: Path, way: Way, over: Over = map) -> Outcome:
    try:
        return take_file(path, number, way, over)
    except UserError as error:
        return error


def taken_files(
    paths: Sequence[Path], way: Way, ask: Ask | None, progress: Progress
) -> Iterator[TakenFile | KnownFile | UnusableFileError]:
    """Take files, in their order. What is answered of one holds for all that come after it.

    Args:
        paths: of the files.
        way: how they are taken.
        ask: for what names and units leave open; None where nobody can answer.
        progress: hears which file is being taken.

    Raises:
        UserError: what is stated of one doesn't serve.
    """
    sizes = [path.stat().st_size for path in paths]
    processes = cores() if sum(sizes) > WORTH_PROCESSES else 1
    large = max(sizes, default=0) > LARGE
    over: Over = partial(spread, processes=processes) if large else map
    handed_out: Iterator[Outcome] = iter(())
    begun = way
    units: dict[str, str] = {}
    for number, path in enumerate(paths):
        progress(f"{number + 1} of {len(paths)}: {file_name(path)}")
        if number == 1 and not large:
            # what was answered of the first file is known to the others
            begun = way
            handed_out = spread(_take, [(later, paths[later], begun) for later in range(1, len(paths))], processes)
        outcome, made = next(handed_out, None), begun
        while outcome is None or isinstance(outcome, Open) or made.columns != way.columns:
            if isinstance(outcome, Open) and made.columns == way.columns and ask:
                way = replace(way, columns=(*way.columns, *ask(outcome.where, outcome.mapped.as_others(units))))
            made, outcome = way, _outcome(number, path, way, over)
        if isinstance(outcome, UserError) and not isinstance(outcome, UnusableFileError):
            if isinstance(outcome, OpenChannelsError):
                refuse_open_questions(outcome.where, outcome.mapped.as_others(units))
            raise outcome
        if isinstance(outcome, TakenFile):
            units |= {unit_in_name(one.channel)[0]: one.unit for one in outcome.file.columns.values()}
        yield outcome
