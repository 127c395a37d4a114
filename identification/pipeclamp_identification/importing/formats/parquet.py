"""Parquet, by polars."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeclamp_identification.importing.raw import COMPRESSED, Damaged, Format, RawTable, refuse_size, table_of
from pipeclamp_models.base.tables import pl


def read(path: Path) -> Sequence[RawTable]:
    """Read the columns of numbers, and stamps of time as seconds since the first."""
    rows = int(pl.scan_parquet(path).select(pl.len()).collect().item())
    refuse_size("the file", rows, path.stat().st_size, COMPRESSED)
    columns: list[tuple[str, str, object]] = []
    for column in pl.read_parquet(path).iter_columns():
        kind = column.dtype
        if kind.is_numeric() or kind == pl.Boolean:
            columns.append((column.name, "", column.cast(pl.Float64).fill_null(float("nan")).to_numpy()))
        elif kind.is_temporal():
            ticks = column.cast(pl.Datetime("ns") if kind in (pl.Date, pl.Datetime) else pl.Duration("ns"))
            known = ticks.to_physical()
            first = known.drop_nulls().head(1).to_list() or [0]
            seconds = (known - first[0]).cast(pl.Float64) * 1e-9
            columns.append((column.name, "s", seconds.fill_null(float("nan")).to_numpy()))
    if not columns:
        raise Damaged("has no column of numbers")
    return table_of("", columns)


FORMAT = Format(name="Parquet", suffixes=(".parquet", ".pq"), begins=lambda head: head[:4] == b"PAR1", read=read)
