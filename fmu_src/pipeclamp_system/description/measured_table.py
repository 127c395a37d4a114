"""Tables of measurements on a pipe: the excitation's column, columns of numbers, time."""

from __future__ import annotations

import csv
import math
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.files import read_content
from pipeclamp_models.base.tables import pl

Drive = Literal["acceleration_m_s2", "displacement_mm", "force_N"]


@dataclass(frozen=True)
class DriveKind:
    """What an excitation's column holds: what of the pipe it shakes, the unit's size in SI, the unit."""

    shakes: Literal["base", "force"]
    scale: float
    unit: str


DRIVES: dict[Drive, DriveKind] = {
    "acceleration_m_s2": DriveKind("base", 1.0, "m/s²"),
    "displacement_mm": DriveKind("base", 1e-3, "mm"),
    "force_N": DriveKind("force", 1.0, "N"),
}
"""Columns that the excitation may stand in."""


def csv_frame(path: Path) -> pl.DataFrame:
    """Read a table.

    Raises:
        UserError: it can't be read, two columns have one name, or it has no rows.
    """
    # Not by its path, in which polars would take brackets for patterns.
    content = read_content(path, "CSV with names in row 1")
    names = next(csv.reader(content.partition(b"\n")[0].decode("utf-8-sig", "replace").splitlines()[:1]), [])
    twice = next((name for name, count in Counter(names).items() if name and count > 1), None)
    if twice is not None:
        raise UserError(f"{path}, row 1: column {twice!r} is there twice; expected a name for each column")
    try:
        frame = pl.read_csv(content, infer_schema_length=None)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise UserError(f"{path}: can't read this file ({error}); expected CSV with names in row 1") from error
    if frame.height == 0:
        raise UserError(f"{path}: has no rows below its names; expected numbers")
    return frame


def drive_column(frame: pl.DataFrame, path: Path) -> Drive:
    """Give the name of the excitation's column.

    Raises:
        UserError: there is none, or more than one.
    """
    found = [name for name in DRIVES if name in frame.columns]
    if len(found) != 1:
        got = " and ".join(found) or f"none of them in {', '.join(frame.columns)}"
        raise UserError(
            f"{path}: got {got}; expected one column of the excitation: {', '.join(DRIVES)} (of the base, or a force)"
        )
    return found[0]


def numbers(frame: pl.DataFrame, name: str, path: Path, *, blank: bool = False) -> Array:
    """Give a column of finite numbers; blank cells are nan where they are allowed.

    Raises:
        UserError: there is no such column, or a cell holds something else; the message names its row.
    """
    if name not in frame.columns:
        raise UserError(
            f"{path}: there is no column {name!r}; {did_you_mean(name, frame.columns)}expected it beside "
            f"{', '.join(frame.columns)}, separated by commas"
        )
    column = frame[name]
    if not column.dtype.is_numeric() and not (blank and column.null_count() == column.len()):
        bad = next((row for row, cell in enumerate(column.to_list()) if not _is_finite(cell)), 0)
        raise UserError(f"{path}, row {bad + 2}, column {name!r}: got {column[bad]!r}; expected a finite number")
    values = column.cast(pl.Float64).to_numpy().astype(np.float64)
    missing = np.zeros(values.size, dtype=np.bool_) if not blank else column.is_null().to_numpy()
    bad_rows = np.flatnonzero(~np.isfinite(values) & ~missing)
    if bad_rows.size:
        cell = column[int(bad_rows[0])]
        raise UserError(f"{path}, row {bad_rows[0] + 2}, column {name!r}: got {cell}; expected a finite number")
    return values


def _is_finite(cell: object) -> bool:
    try:
        return math.isfinite(float(str(cell)))
    except ValueError:
        return False


def ascending_time(frame: pl.DataFrame, path: Path) -> Array:
    """Give time_s.

    Raises:
        UserError: it isn't there, or doesn't ascend.
    """
    time = numbers(frame, "time_s", path)
    for row, (before, after) in enumerate(pairwise(time.tolist())):
        if after <= before:
            raise UserError(f"{path}, row {row + 3}: time_s goes from {before:g} to {after:g}; expected it to ascend")
    return time
