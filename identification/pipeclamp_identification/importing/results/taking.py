"""A file of results becomes rows of runs.csv, with where each comes from."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from pipeclamp_identification.campaign.description import ImportedColumn, ImportedCut, ImportedFile, ImportedRun
from pipeclamp_identification.importing.channels.columns import columns_option
from pipeclamp_identification.importing.channels.mapping import where_of
from pipeclamp_identification.importing.channels.naming import condition_name, is_measured, names_specimen
from pipeclamp_identification.importing.conditions import Settings, name_in, of_properties, settings_of
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.reading import SourceFile, stem_of
from pipeclamp_identification.importing.results.part_size import SIZES
from pipeclamp_identification.importing.results.recognised import holds_results
from pipeclamp_identification.importing.results.rows import (
    LOSS,
    STORAGE,
    ResultRow,
    ResultRows,
    left_out_words,
    result_rows,
)
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.unusable import UnusableFileError
from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.said import few_of

DIGITS = 6

Row = Mapping[str, float | str | None]
"""Cells of runs.csv by column."""


@dataclass(frozen=True)
class TakenResults:
    """A file of results.

    Attributes:
        file: as campaign.toml states it.
        stem: what its tests are named by.
        rows: of runs.csv, and where each is from.
        cut: rows of the file that can't be used.
        notes: what to know of it.
    """

    file: ImportedFile
    stem: str
    rows: tuple[tuple[Row, ImportedRun], ...]
    cut: tuple[ImportedCut, ...]
    notes: tuple[str, ...]


def taken_results(source: SourceFile, sha256: str, options: Options, names: Collection[str]) -> TakenResults:
    """Take a file's results.

    Args:
        source: the file.
        sha256: of its content.
        options: what the user states.
        names: of tests that are there already.

    Raises:
        UnusableFileError: it holds no results.
        UserError: what a column is, is open, or its name doesn't follow the pattern.
    """
    tables = [table for table in source.tables if holds_results(table, options.columns)]
    if not tables:
        raise UnusableFileError(
            str(source.path), "holds no results, a row a test with its frequency",
            "; expected such a table, or another campaign (-o) for records of tests",
        )  # fmt: skip
    stem = stem_of(source.path)
    stated = _stated_settings(source, stem, options)
    sizes = {column: size for column in SIZES.values() if isinstance(size := stated.pop(column, None), float)}
    columns: dict[str, ImportedColumn] = {}
    rows: list[tuple[Row, ImportedRun]] = []
    cut: list[ImportedCut] = []
    aside = [repr(table.name) for table in source.tables if not any(table is one for one in tables)]
    notes = [f"left aside, for they hold no results: {few_of(aside)}"] if aside else []
    for table in tables:
        found = _found_in(source, table, options, stated, sizes)
        columns |= _columns_of(found)
        notes += _notes_on(found, table, temperature_known="temperature_C" in stated or "temperature" in columns)
        own = f"{stem}_{table.name}" if len(tables) > 1 and table.name else stem
        name = _free_name(own, table, {*names, *(run.run for _, run in rows)})
        rows += _rows_of(found, table, name, source.name, stated)
        cut += [
            ImportedCut(file=source.name, table=table.name, samples=(first, last), why=why)
            for first, last, why in _joined(found.left_out)
        ]
    file = ImportedFile(file=source.name, sha256=sha256, format=source.format, columns=columns)
    return TakenResults(file, stem, tuple(rows), tuple(cut), tuple(notes))


def _found_in(
    source: SourceFile, table: RawTable, options: Options, stated: Settings, sizes: Mapping[str, float]
) -> ResultRows:
    """Give the results of a table, beside what is stated of them.

    Raises:
        UserError: what a column is, is open; it names the table.
    """
    try:
        return result_rows(table, options.columns, _own_settings(table), stated, sizes)
    except UsageError:
        raise
    except UserError as error:
        raise UserError(f"{where_of(source, table)}: {error}") from error


def _columns_of(found: ResultRows) -> dict[str, ImportedColumn]:
    return {
        one.quantity: ImportedColumn(
            channel=one.channel.heading, unit=one.unit, factor=one.conversion.factor,
            offset=one.conversion.offset, stated=one.stated,
        )
        for one in found.columns
    }  # fmt: skip


def _notes_on(found: ResultRows, table: RawTable, *, temperature_known: bool) -> list[str]:
    """Say what to know of a table; of a temperature above it, unless another is known."""
    notes = [*found.notes, *left_out_words(found.left_out, table.length)]
    unread = [one for one in table.unread if not (one.is_whole and names_specimen(one.name))]
    notes += [f"{one.words()}; such cells count as blank" for one in unread]
    if found.unused:
        notes.append(f"not used: {few_of([*map(repr, found.unused)])}{_as_condition(found)}")
    if table.above and not temperature_known:
        notes.append(table.above.words)
    return notes


def _as_condition(found: ResultRows) -> str:
    """Say how a column that isn't used becomes a condition, where one of them is measured."""
    likely = next((one for one in found.unused if is_measured(one)), None)
    if likely is None:
        return ""
    return f"; to keep one as a condition: {columns_option([f'{condition_name(likely)}={likely}'])}"


def _rows_of(
    found: ResultRows, table: RawTable, name: str, file: str, stated: Settings
) -> list[tuple[Row, ImportedRun]]:
    """Give rows of runs.csv, and where each is from: a table of a file, whose tests are named so."""
    own, digits = _own_settings(table), len(str(table.length))
    rows: list[tuple[Row, ImportedRun]] = []
    for place, row in enumerate(found.rows, 1):
        run = f"{name}_{place:0{digits}d}"
        specimen = _specimen_in(table, row.row)
        known = own | ({"specimen": specimen} if specimen else {}) | _measured(row) | stated
        source = ImportedRun(run=run, file=file, table=table.name, samples=(row.row, row.row))
        rows.append(({"run": run, **known, **_stiffness(row)}, source))
    return rows


def _own_settings(table: RawTable) -> Settings:
    """Give what a file states of all tests of a table, beside its columns."""
    above = table.above.temperature_C if table.above else None
    return of_properties(table.properties) | ({} if above is None else {"temperature_C": above})


def _stated_settings(source: SourceFile, stem: str, options: Options) -> Settings:
    """Give what a file's name and the table of conditions state of its tests.

    Raises:
        UserError: its name doesn't follow the pattern.
    """
    stated = settings_of(source.path, (stem,), options.pattern)
    stated |= options.conditions.get(name_in(options.conditions, (stem, source.name)), {})
    return {column: value for column, value in stated.items() if column not in ("run", "file")}


def _free_name(own: str, table: RawTable, taken: Collection[str]) -> str:
    """Give what a table's tests are named by, so that none of them is called as one that is there."""
    digits, candidate, number = len(str(table.length)), own, 1
    while any(f"{candidate}_{place:0{digits}d}" in taken for place in range(1, table.length + 1)):
        number += 1
        candidate = f"{own}_{number}"
    return candidate


def _specimen_in(table: RawTable, row: int) -> str:
    """Give the specimen that a row names in a column of texts; "" where it names none."""
    for label in table.labels:
        number = label.values[row - table.first_row]
        if names_specimen(label.name) and number == number:  # nan above the first name
            return label.texts[int(number)]
    return ""


def _joined(left_out: Sequence[tuple[int, str]]) -> list[tuple[int, int, str]]:
    """Give the first and the last of rows that follow each other and can't be used for the same reason."""
    spans: list[tuple[int, int, str]] = []
    for row, why in left_out:
        if spans and spans[-1][1:] == (row - 1, why):
            spans[-1] = (spans[-1][0], row, why)
        else:
            spans.append((row, row, why))
    return spans


def _measured(row: ResultRow) -> Settings:
    return {name: _digits(value) for name, value in row.settings.items()}


def _stiffness(row: ResultRow) -> Settings:
    return {STORAGE: _digits(row.storage_N_mm), LOSS: _digits(row.loss_N_mm)}


def _digits(value: float) -> float:
    return rounded_to(value, DIGITS)
