"""Files become drafts of runs: each is cut out, repaired, looked at and written before the next; no other is held."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.description import ImportedColumn, ImportedFile
from pipeclamp_identification.campaign.writing import Format
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
from pipeclamp_identification.importing.channels.traces import first_motion, label_column, segment_of, time_of
from pipeclamp_identification.importing.conditions import numbers_of_properties, of_properties
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.reading import SourceFile, digest_of, read_file
from pipeclamp_identification.importing.records.drafts import KnownFile, TakenFile, TakenPart, TakenTable, is_timed
from pipeclamp_identification.importing.records.joined import joined_rows, rows_apart
from pipeclamp_identification.importing.records.piece import Piece, take_piece
from pipeclamp_identification.importing.samples.split import piece_bounds
from pipeclamp_identification.importing.stated import Ask
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError
from pipeclamp_identification.units.stated import unit_in_name
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import cores, spread
from pipeclamp_models.base.progress import Progress

OURS = {"time": "time_s", "displacement": "displacement_mm", "force": "force_N", "temperature": "temperature_C"}
WIDEST_OVERVIEW = 600
"""Stretches that a picture of a whole table is thinned out to."""
WORTH_PROCESSES = 24_000_000
"""Bytes of files from which on they are taken by several processes, which take a second or two to begin."""
MOST_CHANGES = 0.25
"""Share of samples that a column which parts runs may change at: four are too few for a loop."""
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
        free: names of files and runs whose motion is stated to be free: they aren't parted by levels.
    """

    columns: tuple[Stated, ...]
    rate: float | None
    timed: bool
    ask: bool
    records: Path
    format: Format
    known: frozenset[str]
    free: frozenset[str] = frozenset()


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
        numbers = {**table.stated_above, **numbers_of_properties(table.properties)}
        tables.append(TakenTable(table.name, mapped, unused, unread, table.joined, stated, above, numbers, taken))
    first, mapped = used.tables[0]
    above_first = [tables[0].above.words] if tables[0].above else []
    file = ImportedFile(
        file=source.name,
        sha256=digest,
        format=source.format,
        read_as="; ".join([*first.read_as, *first.joined, *(one.words() for one in tables[0].unread), *above_first]),
        columns={OURS.get(one.ours, one.ours): _imported(one) for one in mapped.columns},
    )
    return TakenFile(file, tuple(tables), used.aside)


def _taken(source: SourceFile, table: RawTable, mapped: Mapped, record: Path, way: Way, over: Over) -> TakenPart:
    """Take a table, piece by piece."""
    parts: list[TakenPart] = []
    for part in over(take_piece, _pieces(source, table, mapped.columns, record, way)):
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


def _pieces(
    source: SourceFile, table: RawTable, columns: tuple[Column, ...], record: Path, way: Way
) -> Iterator[Piece]:
    """Give the pieces of a table, with the channels that are ours alone."""
    where = where_of(source, table)
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
        if surely and (changes := len(bounds) - 2) > MOST_CHANGES * len(own):
            raise UnusableFileError(
                where,
                f"--columns {SEGMENT}: it changes {changes} times in {len(own)} samples; expected a channel that stays "
                "the same within a run, such as a number of the block or of the cycle",
            )
    inner = bounds[1:-1] if timed is None else timed[bounds[1:-1]]
    begins = [0, *inner.tolist(), table.length]
    del time, own
    label = label_column(table, columns)
    timed_here = is_timed(columns, way.timed)
    if not timed_here and (rate := next((one for one in columns if one.conversion.integrated), None)):
        raise UserError(
            f"{where}, channel {rate.heading!r}: a displacement can't be integrated where time was not measured; "
            "expected samples over time, or a channel of the displacement"
        )
    pieces = (rows_apart if timed_here else joined_rows)(table, channels, columns, begins)
    for number, ((first, last), rows) in enumerate(zip(itertools.pairwise(begins), pieces, strict=True)):
        called = label.of(np.arange(first, last)[finite[first:last]]) if label else ""
        yield Piece(
            where=where,
            table=RawTable(table.name, rows.channels, table.first_row + rows.begin, table.read_as),
            columns=columns,
            rate=way.rate,
            timed=timed_here,
            begin=rows.begin,
            cycles_before=rows.cycles_before,
            places=rows.places,
            label=called,
            free=not way.free.isdisjoint((called, source.name, Path(source.name).stem)),
            record=record.with_name(f"{record.name}_{number:05d}"),
            format=way.format,
            stretches=max(1, round(WIDEST_OVERVIEW * (last - first) / table.length)),
        )


def _imported(column: Column) -> ImportedColumn:
    return ImportedColumn(
        channel=column.heading,
        unit=column.unit,
        factor=column.conversion.factor,
        offset=column.conversion.offset,
        integrated=column.conversion.integrated,
        stated=column.stated,
    )


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
