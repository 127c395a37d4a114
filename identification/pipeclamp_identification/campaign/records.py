"""Records: the samples of one run, read from CSV, gzipped CSV or Parquet."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.description import ColumnSource, RecordColumn
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.tables import pl

NEEDED: tuple[RecordColumn, ...] = ("time_s", "displacement_mm", "force_N")
OPTIONAL: tuple[RecordColumn, ...] = ("temperature_C",)
LARGEST = 1e12
"""No test lasts longer (s), moves further (mm) or pushes harder (N); a time may count milliseconds from 1970."""


@dataclass(frozen=True)
class Record:
    """The samples of one run, all arrays of one length; blank cells are nan."""

    time_s: Array
    displacement_mm: Array
    force_N: Array
    temperature_C: Array | None = None


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
    sources = {ours: columns.get(ours, ColumnSource.model_validate({"from": ours})) for ours in (*NEEDED, *OPTIONAL)}
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
    sources = {name: ColumnSource.model_validate({"from": name}) for name in names}
    read = _parquet_channels if path.name.lower().endswith(".parquet") else _csv_channels
    return read(path, content, sources, required=tuple(names))


class UnusableRecord(Exception):  # noqa: N818 - it says what the record is, and is no defect of the program
    """A record that can't be used, with the reason: its run is left out."""


def check_samples(record: Record) -> None:
    """Check what holds for the samples of any usable record.

    Args:
        record: the samples.

    Raises:
        UnusableRecord: with the row of the file where the fault shows first (the header is row 1).
    """
    if len(record.time_s) == 0:
        raise UnusableRecord("no full cycle: the record has no samples")
    for name in NEEDED:
        bad = np.flatnonzero(~np.isfinite(getattr(record, name)))
        if len(bad):
            raise UnusableRecord(f"non-finite samples: {len(bad)} in {name}, the first in row {bad[0] + 2}")
        huge = np.flatnonzero(np.abs(getattr(record, name)) > LARGEST)
        if len(huge):
            raise UnusableRecord(
                f"impossible samples: {len(huge)} in {name} beyond {LARGEST:g}, the first in row {huge[0] + 2}"
            )
    back = np.flatnonzero(np.diff(record.time_s) < 0.0)
    if len(back):
        before, after = record.time_s[back[0]], record.time_s[back[0] + 1]
        raise UnusableRecord(f"time goes back in row {back[0] + 3}, from {before:g} s to {after:g} s")
    if np.ptp(record.displacement_mm) == 0.0:
        raise UnusableRecord(f"constant displacement: {record.displacement_mm[0]:g} mm in every row")


def _chosen_columns(
    path: Path, present: list[str], sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, str]:
    """Find which of the file's columns are ours, by their names without surrounding blanks."""
    chosen = {}
    for ours, source in sources.items():
        matches = [name for name in present if name.strip() == source.name.strip()]
        if len(matches) > 1:
            raise UserError(f"{path}: has {len(matches)} columns {source.name!r}; expected one; rename the others")
        if matches:
            chosen[ours] = matches[0]
        elif ours in required:
            raise UserError(
                f"{path}: has no column {source.name!r} (for {ours}); it has {', '.join(map(repr, present))}; "
                "expected comma-separated columns with these names in row 1, or a table [columns] in campaign.toml "
                "that says which columns they are"
            )
    return chosen


def _csv_channels(
    path: Path, content: bytes, sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, Array]:
    if path.name.lower().endswith(".gz"):
        try:
            content = gzip.decompress(content)
        except (OSError, EOFError, zlib.error) as error:
            raise UserError(f"{path}: is no whole gzip file ({error}); write or copy it again") from error
    # blank rows at the end are how some programs finish a file; in the middle they are missing samples
    if content[-2:].isspace():
        content = content.rstrip()
    first = content.split(b"\n", 1)[0]
    try:
        header = next(csv.reader([first.decode("utf-8-sig")]), [])
    except UnicodeDecodeError as error:
        raise UserError(f"{path}, row 1: is not UTF-8 text (byte {error.start}); save the file as UTF-8") from error
    chosen = _chosen_columns(path, header, sources, required)
    theirs = list(chosen.values())
    try:
        frame = pl.read_csv(content, columns=theirs, schema_overrides=dict.fromkeys(theirs, pl.Float64))
    except pl.exceptions.PolarsError as error:
        raise UserError(_first_bad_cell(path, content, header, theirs) or f"{path}: can't be read: {error}") from error
    # a float column's missing values become nan
    return {ours: frame[name].to_numpy() for ours, name in chosen.items()}


def _first_bad_cell(path: Path, content: bytes, header: list[str], theirs: list[str]) -> str | None:
    """Look once more, slowly, for the cell that the fast reader stumbled over."""
    reader = csv.reader(io.StringIO(content.decode("utf-8-sig", errors="replace"), newline=""))
    next(reader)
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


def _parquet_channels(
    path: Path, content: bytes, sources: Mapping[RecordColumn, ColumnSource], required: tuple[RecordColumn, ...]
) -> dict[RecordColumn, Array]:
    try:
        schema = pl.read_parquet_schema(io.BytesIO(content))
        chosen = _chosen_columns(path, list(schema), sources, required)
        for name in chosen.values():
            if not schema[name].is_numeric():
                raise UserError(f"{path}, column {name!r}: holds {schema[name]}; expected numbers")
        frame = pl.read_parquet(io.BytesIO(content), columns=list(chosen.values()))
    except pl.exceptions.PolarsError as error:
        raise UserError(f"{path}: is no whole Parquet file ({error}); write or copy it again") from error
    return {ours: frame[name].cast(pl.Float64).to_numpy() for ours, name in chosen.items()}
