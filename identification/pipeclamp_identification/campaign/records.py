"""Records: the samples of one run, read from CSV, gzipped CSV or Parquet."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from pipeclamp_identification.campaign.description import ColumnSource, RecordColumn
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.quiet import quietly
from pipeclamp_models.base.tables import pl
from pipeclamp_models.base.units import CELSIUS


class _LineReader(Protocol):
    """Rows of a CSV reader, and the line that it is at."""

    @property
    def line_num(self) -> int: ...

    def __iter__(self) -> Iterator[list[str]]: ...

    def __next__(self) -> list[str]: ...


NEEDED: tuple[RecordColumn, ...] = ("time_s", "displacement_mm", "force_N")
OPTIONAL: tuple[RecordColumn, ...] = ("temperature_C",)
OWN = {name: ColumnSource.model_validate({"from": name}) for name in (*NEEDED, *OPTIONAL)}
"""Our columns under our own names."""
MOST_RECORD_BYTES = 1_000_000_000
"""Of a record of one run, unpacked."""
PARQUET = b"PAR1"
"""What such a file begins and ends with."""
ROWS_PER_BYTE, FEW_ROWS = 1000, 100_000
"""Rows that a byte of a Parquet file may hold, as columns of one value compress; and those of any file."""
LARGEST_VALUE = 1e13
"""No test lasts longer (s), moves further (mm) or pushes harder (N); a time may count milliseconds from 1970."""


@dataclass(frozen=True)
class Record:
    """The samples of one run; blank cells are nan.

    Attributes:
        time_s, displacement_mm, force_N: shape (n,) each.
        temperature_C: likewise; None where it wasn't recorded.
    """

    time_s: Array
    displacement_mm: Array
    force_N: Array
    temperature_C: Array | None = None

    @property
    def channels(self) -> dict[str, Array]:
        """Give the samples of each channel that it has, by name."""
        return {name: values for name, values in vars(self).items() if values is not None}

    def part(self, first: int, last: int) -> Record:
        """Give its samples from the first on, before the last."""
        return Record(**{name: values[first:last] for name, values in self.channels.items()})


def read_record(path: Path, content: bytes, columns: Mapping[RecordColumn, ColumnSource]) -> Record:
    """Turn the bytes of a record's file into samples.

    Args:
        path: the file, whose ending says the format, for the errors too.
        content: what is in it.
        columns: the names and factors of campaign.toml's [columns]; a column that isn't there has our name.

    Returns:
        The samples, in our units.

    Raises:
        UserError: the file is broken, has no such column, or a cell that is no number.
    """
    sources = {**OWN, **columns}
    read = _parquet_channels if path.name.lower().endswith(".parquet") else _csv_channels
    channels = read(path, content, sources, required=(*NEEDED, *columns))
    turned = {ours: sources[ours].conversion(ours) for ours in channels}
    return Record(
        **{ours: np.asarray(samples * turned[ours].factor + turned[ours].offset) for ours, samples in channels.items()}
    )


def read_channels(path: Path, content: bytes, names: Sequence[RecordColumn]) -> dict[RecordColumn, Array]:
    """Turn the bytes of a file into those of a record's columns that are asked for, by our names, in our units.

    Raises:
        UserError: as of `read_record`.
    """
    sources = {name: OWN[name] for name in names}
    read = _parquet_channels if path.name.lower().endswith(".parquet") else _csv_channels
    return read(path, content, sources, required=tuple(names))


class UnusableRecord(Exception):  # noqa: N818 - it says what the record is, and is no defect of the program
    """A record that can't be used, with the reason: its run is left out."""


def check_samples(record: Record, row: Callable[[int], int] = lambda sample: sample + 2) -> None:
    """Check what holds for the samples of any usable record.

    Args:
        record: the samples.
        row: gives the row of the file that a sample stands in; by default the header is row 1.

    Raises:
        UnusableRecord: with the row of the file where the fault shows first.
    """
    if len(record.time_s) == 0:
        raise UnusableRecord("no full cycle: the record has no samples")
    for name in NEEDED:
        bad = np.flatnonzero(~np.isfinite(getattr(record, name)))
        if len(bad):
            raise UnusableRecord(f"non-finite samples: {len(bad)} in {name}, the first in row {row(int(bad[0]))}")
        huge = np.flatnonzero(np.abs(getattr(record, name)) > LARGEST_VALUE)
        if len(huge):
            raise UnusableRecord(
                f"impossible samples: {len(huge)} in {name} beyond {LARGEST_VALUE:g}, "
                f"the first in row {row(int(huge[0]))}"
            )
    if record.temperature_C is not None:
        cold = np.flatnonzero((record.temperature_C <= -CELSIUS) | (record.temperature_C > LARGEST_VALUE))
        if len(cold):
            raise UnusableRecord(
                f"impossible samples: temperature_C is {record.temperature_C[cold[0]]:g} °C in row "
                f"{row(int(cold[0]))}; expected above {-CELSIUS:g}"
            )
    back = np.flatnonzero(np.diff(record.time_s) < 0.0)
    if len(back):
        before, after = record.time_s[back[0]], record.time_s[back[0] + 1]
        raise UnusableRecord(f"time goes back in row {row(int(back[0]) + 1)}, from {before:g} s to {after:g} s")
    if np.ptp(record.displacement_mm) == 0.0:
        raise UnusableRecord(f"constant displacement: {record.displacement_mm[0]:g} mm in every row")


def _chosen_columns(
    path: Path, present: list[str], sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, str]:
    """Find which of the file's columns are ours, by their names without surrounding blanks."""
    chosen: dict[RecordColumn, str] = {}
    for ours, source in sources.items():
        matches = [name for name in present if name.strip() == source.name.strip()]
        if len(matches) > 1:
            raise UserError(f"{path}: has {len(matches)} columns {source.name!r}; expected one; rename the others")
        if matches:
            taken = next((other for other, name in chosen.items() if name == matches[0]), None)
            if taken is not None:
                raise UserError(
                    f"{path}: column {source.name!r} would be {taken} and {ours}; expected a column for each: see the "
                    "table [columns] in campaign.toml"
                )
            chosen[ours] = matches[0]
        elif ours in required:
            there = f"it has {', '.join(map(repr, present))}" if present else "its first row is empty"
            raise UserError(
                f"{path}: has no column {source.name!r} (for {ours}); {there}; "
                "expected comma-separated columns with these names in row 1, or a table [columns] in campaign.toml "
                "that says which columns they are"
            )
    return chosen


def _csv_channels(
    path: Path, content: bytes, sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, Array]:
    if path.name.lower().endswith(".gz"):
        content = _unpacked(path, content)
    if b"\n" not in content:  # line ends of old Macs, and of some machines still
        content = content.replace(b"\r", b"\n")
    # blank rows at the end are how some programs finish a file; in the middle they are missing samples
    if content[-2:].isspace():
        content = content.rstrip()
    first = io.BytesIO(content).readline()
    try:
        header = next(csv.reader([first.decode("utf-8-sig")]), [])
    except UnicodeDecodeError as error:
        raise UserError(f"{path}, row 1: is not UTF-8 text (byte {error.start}); save the file as UTF-8") from error
    except csv.Error as error:
        raise UserError(f"{path}, row 1: is no valid CSV: {error}; expected the columns' names") from error
    chosen = _chosen_columns(path, header, sources, required)
    theirs = list(chosen.values())
    try:
        types = dict.fromkeys(theirs, pl.Float64)
        frame = pl.read_csv(content, columns=theirs, schema_overrides=types, infer_schema_length=0)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise UserError(_first_bad_cell(path, content, header, theirs) or f"{path}: can't be read: {error}") from error
    # a float column's missing values become nan
    return {ours: frame[name].to_numpy() for ours, name in chosen.items()}


def _first_bad_cell(path: Path, content: bytes, header: list[str], theirs: list[str]) -> str | None:
    """Look once more, slowly, for the cell that the fast reader stumbled over."""
    reader = csv.reader(io.StringIO(content.decode("utf-8-sig", errors="replace"), newline=""))
    try:
        return _first_bad_row(path, reader, header, theirs)
    except csv.Error as error:
        return f"{path}, row {reader.line_num}: is no valid CSV: {error}"


def _first_bad_row(path: Path, reader: _LineReader, header: list[str], theirs: list[str]) -> str | None:
    next(reader, None)
    for cells in reader:
        if len(cells) > len(header):
            return (
                f"{path}, row {reader.line_num}: has {len(cells)} cells; expected {len(header)} as in row 1; "
                "separate cells by commas and write decimals with a point"
            )
        for name, cell in zip(header, cells, strict=False):
            try:
                float(cell if name in theirs and cell.strip() else "0")
            except ValueError:
                return f"{path}, row {reader.line_num}, column {name.strip()!r}: got {cell!r}; expected a number"
    return None


def _unpacked(path: Path, content: bytes) -> bytes:
    """Unpack a gzip file, of no more than a record's size: a file of kilobytes may claim to hold all of the memory.

    Raises:
        UserError: it isn't whole, or holds more.
    """
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(content)) as stream:
            unpacked = stream.read(MOST_RECORD_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise UserError(f"{path}: is no whole gzip file ({error}); write or copy it again") from error
    if len(unpacked) > MOST_RECORD_BYTES:
        raise UserError(f"{path}: unpacks to more than {MOST_RECORD_BYTES / 1e9:g} GB; expected the record of one run")
    return unpacked


def _parquet_channels(
    path: Path, content: bytes, sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, Array]:
    if not (content.startswith(PARQUET) and content.endswith(PARQUET)):
        raise UserError(f"{path}: is no whole Parquet file; write or copy it again")
    try:
        with quietly():
            schema = pl.read_parquet_schema(io.BytesIO(content))
            rows = int(pl.scan_parquet(io.BytesIO(content)).select(pl.len()).collect().item())
        if not 0 <= rows <= FEW_ROWS + ROWS_PER_BYTE * len(content):
            raise UserError(
                f"{path}: claims {rows} rows, more than a file of {len(content)} bytes holds; copy it again"
            )
        chosen = _chosen_columns(path, list(schema), sources, required)
        for name in chosen.values():
            if not schema[name].is_numeric():
                raise UserError(f"{path}, column {name!r}: holds {schema[name]}; expected numbers")
        with quietly():
            frame = pl.read_parquet(io.BytesIO(content), columns=list(chosen.values()))
            return {ours: frame[name].cast(pl.Float64).to_numpy() for ours, name in chosen.items()}
    except UserError:
        raise
    # what its readers raise of a damaged file is not of one kind
    except (Exception, pl.exceptions.PanicException) as error:
        raise UserError(f"{path}: is no whole Parquet file ({error}); write or copy it again") from error
