"""Files of results become a campaign of metrics: its runs.csv and campaign.toml, whole or not at all."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.description import FILE_NAME as DESCRIPTION
from pipeclamp_identification.campaign.description import description_text
from pipeclamp_identification.campaign.runs_table import FILE_NAME
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import Found, ImportAnswer, ImportedRunAnswer
from pipeclamp_identification.importing.columns import listed
from pipeclamp_identification.importing.conditions import Settings, guessed_pattern, name_in, settings_of
from pipeclamp_identification.importing.mapping import where_of
from pipeclamp_identification.importing.reading import SourceFile, files_in, read_file, stem_of
from pipeclamp_identification.importing.results.recognised import frequency_of_results
from pipeclamp_identification.importing.results.rows import LOSS, STORAGE, ResultRow, left_out_words, result_rows
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import ResultsFileError, UnusableFileError
from pipeclamp_identification.importing.whole import import_whole
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.files import refuse_folder, write_folder
from pipeclamp_models.base.said import counted

METRICS = "stiffness and loss of a test, without a record"
FIRST = ("run", "amplitude_mm", "frequency_Hz", "temperature_C")
DIGITS = 6
WEAK = 0.01
"""Share of the largest force amplitude below which that of a test is told."""


Row = dict[str, float | str]
"""Cells of runs.csv by column."""


@dataclass(frozen=True)
class FoundResults:
    """What files of results became.

    Attributes:
        folder, name: of the campaign.
        columns: by file, the channel of each quantity and its factor.
        rows: of runs.csv, and the file of each.
        pattern: that the names of files seem to follow, where they state what nothing else does.
        remarks: what to know of it.
        written: whether anything was.
    """

    folder: Path
    name: str
    columns: dict[str, dict[str, str]]
    rows: tuple[Row, ...]
    sources: tuple[str, ...]
    pattern: str
    remarks: tuple[str, ...]
    written: bool

    def notes(self) -> tuple[str, ...]:
        """Give what to know of the campaign."""
        return self.remarks

    def answer(self) -> ImportAnswer:
        """Give it as data."""
        runs = [
            ImportedRunAnswer(
                run=str(row["run"]),
                file=source,
                amplitude_mm=_number(row, "amplitude_mm"),
                frequency_Hz=_number(row, "frequency_Hz"),
                temperature_C=_number(row, "temperature_C"),
                cycles=None,
                new=True,
                done=(METRICS,),
            )
            for row, source in zip(self.rows, self.sources, strict=True)
        ]
        return ImportAnswer(
            campaign=str(self.folder), written=self.written, new_files=tuple(self.columns), known_files=(),
            columns=self.columns, runs=tuple(runs), cut=(), left_out=(), left_out_files=(), pattern=self.pattern,
            notes=self.remarks,
        )  # fmt: skip


def import_any(
    paths: Sequence[Path],
    folder: Path,
    options: Options,
    *,
    page: Callable[[Found], str],
    confirm: Callable[[Found], bool] | None = None,
    dry_run: bool = False,
    name: str = "",
    notes: str = "",
    software: str = "",
    format: Format = "parquet",
    progress: Callable[[str], None] | None = None,
) -> Found | FoundResults:
    """Import files: of records, as `import_whole` does, whose arguments these are; or of results.

    Raises:
        UserError: a file, or what the campaign would be, can't serve.
    """
    try:
        return import_whole(
            paths, folder, options, page=page, confirm=confirm, dry_run=dry_run, name=name, notes=notes,
            software=software, format=format, progress=progress,
        )  # fmt: skip
    except ResultsFileError:
        return import_results(paths, folder, options, dry_run=dry_run, name=name, notes=notes, progress=progress)


def import_results(
    paths: Sequence[Path],
    folder: Path,
    options: Options,
    *,
    dry_run: bool = False,
    name: str = "",
    notes: str = "",
    progress: Callable[[str], None] | None = None,
) -> FoundResults:
    """Make a campaign of metrics of files of results.

    Args:
        paths: of files, or of folders with them; each holds results.
        folder: of the campaign, a new one.
        options: what the user states.
        dry_run: write nothing.
        name, notes: of the campaign; its folder's name by default.
        progress: is told what is being done.

    Raises:
        UserError: a file can't serve, no row does, or the folder is there already.
    """
    if folder.exists():
        raise UserError(
            f"{folder}: exists already, and results join no campaign; expected a new folder, and all files of them at "
            "once"
        )
    refuse_folder(folder)
    taken: list[_TakenResults] = []
    for path in files_in(paths):
        if progress:
            progress(file_name(path))
        taken.append(_taken(read_file(path), options))
    rows = [row for one in taken for row in one.rows]
    alike: dict[str, list[str]] = {}
    for one in taken:
        for words in one.told:
            alike.setdefault(words, []).append(one.file)
    told = [f"{listed(names, most=1)}: {words}" for words, names in alike.items()]
    if not rows:
        raise UserError("\n  ".join(["no row of results can be used", *told]))
    unknown = any("temperature_C" not in row for row in rows)
    found = FoundResults(
        folder=folder,
        name=name or file_name(folder.resolve()),
        columns={one.file: one.columns for one in taken},
        rows=tuple(rows),
        sources=tuple(one.file for one in taken for _ in one.rows),
        pattern=guessed_pattern([one.stem for one in taken]) if unknown and not options.pattern else "",
        remarks=(*told, *_weak_words([force for one in taken for force in one.forces])),
        written=not dry_run,
    )
    if not dry_run:
        table = (FILE_NAME, _table(rows).encode())
        write_folder(folder, [table, (DESCRIPTION, description_text(found.name, notes).encode())])
    return found


@dataclass(frozen=True)
class _TakenResults:
    """A file of results: its name and stem, its columns, rows of runs.csv, amplitudes of force, and what is told."""

    file: str
    stem: str
    columns: dict[str, str]
    rows: tuple[Row, ...]
    forces: tuple[float, ...]
    told: tuple[str, ...]


def _taken(source: SourceFile, options: Options) -> _TakenResults:
    """Take a file's results.

    Raises:
        UnusableFileError: it can't serve.
    """
    tables = [table for table in source.tables if frequency_of_results(table)]
    if not tables:
        raise UnusableFileError(str(source.path), "holds no results, as the other files do")
    stem = stem_of(source.path)
    settings = _settings(source, stem, options)
    columns: dict[str, str] = {}
    rows: list[Row] = []
    forces: list[float] = []
    told: list[str] = []
    for table in tables:
        try:
            found = result_rows(table, options.columns, tuple(settings))
        except UsageError:
            raise
        except UserError as error:
            raise UnusableFileError(where_of(source, table), str(error)) from error
        columns |= {one.quantity: f"{one.channel.heading} {one.conversion.words()}" for one in found.columns}
        told += [*found.notes, *left_out_words(found.left_out, table.length)]
        if found.unused:
            told.append(f"not used: {listed([*map(repr, found.unused)])}")
        own = f"{stem}_{table.name}" if len(tables) > 1 and table.name else stem
        digits = len(str(table.length))
        rows += [_cells(f"{own}_{place:0{digits}d}", row, settings) for place, row in enumerate(found.rows, 1)]
        forces += [row.force for row in found.rows if row.force is not None]
    return _TakenResults(source.name, stem, columns, tuple(rows), tuple(forces), tuple(told))


def _settings(source: SourceFile, stem: str, options: Options) -> Settings:
    """Give what the file's name and the table of conditions state of its tests.

    Raises:
        UserError: its name doesn't follow the pattern.
    """
    stated = settings_of(source.path, (stem,), options.pattern) | options.conditions.get(
        name_in(options.conditions, (stem, source.name)), {}
    )
    return {column: value for column, value in stated.items() if column not in ("run", "file")}


def _weak_words(forces: Sequence[float]) -> list[str]:
    """Say which tests had forces so small beside others that a load cell may hardly tell them."""
    largest = max(forces, default=0.0)
    weak = sum(force < WEAK * largest for force in forces)
    if not weak:
        return []
    return [
        f"the force's amplitude of {weak} of {counted(len(forces), 'test')} is below {WEAK:.0%} of the largest, "
        f"{largest:.3g} N: each test counts alike, however little its load cell tells; where these scatter, take their "
        "rows out of runs.csv"
    ]


def _cells(run: str, row: ResultRow, settings: Settings) -> Row:
    measured = {name: _digits(value) for name, value in row.settings.items()}
    return {
        "run": run, **measured, **settings, STORAGE: _digits(row.storage_N_mm), LOSS: _digits(row.loss_N_mm)
    }  # fmt: skip


def _table(rows: Sequence[Row]) -> str:
    """Give runs.csv."""
    names = dict.fromkeys(name for row in rows for name in row)
    header = [*(name for name in FIRST if name in names), *(name for name in names if name not in FIRST)]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, header, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def _number(row: Row, column: str) -> float | None:
    value = row.get(column)
    return value if isinstance(value, float) else None


def _digits(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
