"""Which tables of a file hold tests, and which of their channels are ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pipeclamp_identification.importing.channels.columns import (
    ContradictedUnitError,
    Mapped,
    Stated,
    map_columns,
    refuse_open_questions,
)
from pipeclamp_identification.importing.channels.combined import with_combined
from pipeclamp_identification.importing.channels.naming import EACH_CYCLE, SEGMENT, rank
from pipeclamp_identification.importing.channels.rates import by_own_times, joined_rates
from pipeclamp_identification.importing.channels.traces import with_cycles_numbered
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.reading import SourceFile
from pipeclamp_identification.importing.results.recognised import holds_results, results_words
from pipeclamp_identification.importing.unusable import ResultsFileError, UnusableFileError
from pipeclamp_models.base.errors import UserError

MOVED = ("displacement", "force")


@dataclass(frozen=True)
class Open:
    """A table of which somebody must say what a channel is."""

    where: str
    mapped: Mapped


def where_of(source: SourceFile, table: RawTable) -> str:
    """Name a table in errors."""
    return f"{source.path}, {table.name}" if table.name else str(source.path)


@dataclass(frozen=True)
class MappedFile:
    """The tables of a file that hold tests, with their channels known; and the names of those that are left aside."""

    tables: tuple[tuple[RawTable, Mapped], ...]
    aside: tuple[str, ...] = ()


def mapped_tables(source: SourceFile, stated: Sequence[Stated], rate: float | None, *, ask: bool) -> MappedFile | Open:
    """Find the tables of a file that hold tests.

    Args:
        source: the file.
        stated: what the user says of channels.
        rate: samples per second, where no channel holds the time.
        ask: give what is open, where somebody can answer.

    Raises:
        UserError: no table does, or what a channel is, is open and nobody can be asked.
    """
    results = [table for table in source.tables if holds_results(table, stated)]
    records = tuple(table for table in source.tables if not any(table is one for one in results))
    if not records:
        raise ResultsFileError(where_of(source, results[0]), results_words(results[0], stated))
    numbered = any(one.ours == SEGMENT and one.channel.casefold() == EACH_CYCLE for one in stated)
    if numbered:
        stated = [one for one in stated if one.ours != SEGMENT]
    tables = _brought_together(tuple(with_combined(table, stated) for table in records), stated)
    found = [(table, _mapped(source, table, stated, rate, several=len(tables) > 1)) for table in tables]
    complete = any(mapped and not mapped.questions for _, mapped in found)
    used = [(table, mapped) for table, mapped in found if mapped and not (complete and _lacks_something(mapped))]
    for table, mapped in used:
        if ask and _can_be_answered(mapped):
            return Open(where_of(source, table), mapped)
        refuse_open_questions(where_of(source, table), mapped)
    if not used:
        table = max(tables, key=lambda one: len(one.channels))
        refuse_open_questions(where_of(source, table), _mapped_or_refused(source, table, stated))
    aside = [table for table in tables if not any(table is one for one, _ in used)]
    taken = [_cycle_by_cycle(*one) for one in used] if numbered else used
    return MappedFile(tuple(taken), tuple(table.name for table in (*aside, *results)))


def _cycle_by_cycle(table: RawTable, mapped: Mapped) -> tuple[RawTable, Mapped]:
    """Give a table whose each cycle is a run, in the place of what names tell."""
    numbered, column = with_cycles_numbered(table, mapped.columns)
    others = [one for one in mapped.columns if one.ours != SEGMENT]
    return numbered, replace(mapped, columns=(*others, column))


def _lacks_something(mapped: Mapped) -> bool:
    """Tell whether nothing in the table looks like one of the quantities."""
    return any(one.is_missing for one in mapped.questions)


def _can_be_answered(mapped: Mapped) -> bool:
    """Tell whether something is open that somebody can answer with the table's channels."""
    return bool(mapped.questions) and mapped.is_answerable() and not mapped.without_time


def _brought_together(tables: tuple[RawTable, ...], stated: Sequence[Stated]) -> tuple[RawTable, ...]:
    """Give tables with those joined that hold channels of one test, each with a time of its own."""
    whole = [table for table in tables if _is_whole(table, stated)]
    if not whole or len(tables) == 1:
        # displacement and force are a test, which others join; an event's few samples don't cut it short
        parts = by_own_times(tables[0]) if len(tables) == 1 else tables
        moved = [any(rank(one, own) for one in MOVED for own in table.channels) for table in parts]
        test = _joined_test([table for table, moves in zip(parts, moved, strict=True) if moves], stated)
        if test:
            tables = (test, *(table for table, moves in zip(parts, moved, strict=True) if not moves))
            whole = [test]
    if len(tables) > 1 and len(whole) < 2:
        joined = _joined_test(tables, stated, whole[0] if whole else None)
        return (joined,) if joined else tables
    for one in whole:
        tables = _with_its_group(tables, one, stated)
    return tables


def _with_its_group(tables: tuple[RawTable, ...], test: RawTable, stated: Sequence[Stated]) -> tuple[RawTable, ...]:
    """Give tables with those joined to a test that share its group, where it is the one test of that."""
    group = [table for table in tables if table.group == test.group]
    if not test.group or len(group) < 2 or sum(_is_whole(table, stated) for table in group) > 1:
        return tables
    joined = _joined_test(group, stated, test)
    if joined is None:
        return tables
    called = replace(joined, name=test.group)
    others = [called if table is test else table for table in tables]
    return tuple(table for table in others if table is called or table.group != test.group)


def _joined_test(
    tables: Sequence[RawTable], stated: Sequence[Stated], whole: RawTable | None = None
) -> RawTable | None:
    """Give tables on the times of one, the whole test's if there is one; None where no test comes of it."""
    joined = joined_rates(tables, whole)
    return joined if joined and _is_whole(joined, stated) else None


def _is_whole(table: RawTable, stated: Sequence[Stated]) -> bool:
    """Tell whether a table has both displacement and force."""
    try:
        found = map_columns(table, stated)
    except UserError:
        return False
    open_yet = {one.ours for one in found.questions if not one.is_missing}
    return {"displacement", "force"} <= {one.ours for one in found.columns} | open_yet


def _mapped_or_refused(source: SourceFile, table: RawTable, stated: Sequence[Stated]) -> Mapped:
    """Give the channels of a table.

    Raises:
        UnusableFileError: what is stated of them doesn't fit.
        ContradictedUnitError: a unit that is stated isn't the file's.
    """
    try:
        return map_columns(table, stated)
    except ContradictedUnitError as error:
        raise ContradictedUnitError(f"{where_of(source, table)}: {error}") from error
    except UserError as error:
        raise UnusableFileError(where_of(source, table), str(error)) from error


def _mapped(
    source: SourceFile, table: RawTable, stated: Sequence[Stated], rate: float | None, *, several: bool
) -> Mapped | None:
    """Give the channels of a table; None for one that holds no test, beside others that do."""
    try:
        mapped = _mapped_or_refused(source, table, stated)
    except UserError:
        if several:
            return None
        raise
    if rate:
        mapped = replace(mapped, questions=tuple(one for one in mapped.questions if one.ours != "time"))
    if mapped.questions and several and not {"displacement", "force"} & {one.ours for one in mapped.columns}:
        return None
    return mapped
