"""Excel (.xlsx, .xlsb, .xls) and OpenDocument (.ods) sheets, by calamine."""

from __future__ import annotations

import datetime
import re
import zipfile
from collections import deque
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import Damaged, Format, RawTable, table_of
from pipeclamp_identification.importing.texts.sniffing import names_above
from pipeclamp_models.base.archive import opened_archive

OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
MOST_CELLS = 300_000_000
PLACE = re.compile(rb'<c[^>]*? r="([A-Z]{1,3})(\d{1,7})"|<(?:\w+:)?row[^>]*? r="(\d{1,7})"')
REPEATED = re.compile(rb'number-(?:rows|columns)-repeated="(\d+)"[^>]*?(?:office:value|office:string)')
HEADER_ROWS = 200
FEWEST_NUMBERS = 2


def read(path: Path) -> Sequence[RawTable]:
    """Read every sheet that holds a table of numbers."""
    from python_calamine import CalamineWorkbook

    if zipfile.is_zipfile(path):
        _refuse_sizes(path)
    workbook = CalamineWorkbook.from_path(str(path))
    sheets = [(name, workbook.get_sheet_by_name(name).to_python()) for name in workbook.sheet_names]
    tables = [table for name, rows in sheets for table in _tables(name, rows)]
    if not tables:
        raise Damaged("holds no sheet with a table of numbers")
    return tables


def _refuse_sizes(path: Path) -> None:
    """Refuse workbooks that aren't fit to be unpacked, or whose cells lie too far apart to be held.

    Each part is unpacked here once, by zipfile, which stops where a part holds more than the archive says: calamine
    would go on.
    """
    with opened_archive(path, "a spreadsheet") as packed:
        for member in packed.infolist():
            with packed.open(member) as stream:
                chunks = iter(partial(stream.read, 1 << 20), b"")
                if re.search(r"worksheets/.*\.xml$|^content\.xml$", member.filename):
                    _refuse_far_cells(member.filename, chunks)
                else:
                    deque(chunks, maxlen=0)


def _refuse_far_cells(name: str, chunks: Iterator[bytes]) -> None:
    columns, rows, rest = 1, 1, b""
    repeats = 1
    for chunk in chunks:
        text = rest + chunk
        for letters, row, other in PLACE.findall(text):
            if letters:
                column = 0
                for letter in letters:
                    column = 26 * column + letter - 64
                columns = max(columns, column)
            rows = max(rows, int(row or other))
        repeats = max([repeats, *(int(count) for count in REPEATED.findall(text))])
        rest = text[-300:]
    if columns * rows > MOST_CELLS or repeats > 10_000_000:
        raise Damaged(f"claims {max(columns * rows, repeats):g} cells in {name}; expected a table of numbers")


def _tables(name: str, rows: list[list[Any]]) -> list[RawTable]:
    """Give the table of a sheet: where numbers begin, with names and units above."""
    first = next((place for place, row in enumerate(rows) if _count(row) >= FEWEST_NUMBERS), None)
    if first is None:
        return []
    # a header may hold numbers: the table is as wide as most of its rows
    widths = [_count(row) for row in rows[first:]]
    usual = max(set(widths), key=widths.count)
    first = next((place for place, row in enumerate(rows) if _count(row) == usual and usual >= FEWEST_NUMBERS), first)
    places = [place for place, cell in enumerate(rows[first]) if _number(cell) is not None]
    header = [
        [_text(row[place]) if place < len(row) else "" for place in places] for row in rows[:first][-HEADER_ROWS:]
    ]
    names, units = names_above(header, len(places))
    last = max(place for place, row in enumerate(rows) if _count(row) >= FEWEST_NUMBERS)
    body = [[_number(row[place]) if place < len(row) else None for place in places] for row in rows[first : last + 1]]
    values = np.array([[np.nan if cell is None else cell for cell in row] for row in body], dtype=np.float64)
    kept = np.any(np.isfinite(values), axis=1)
    (table,) = table_of(name, [(names[place], units[place], values[kept, place]) for place in range(len(places))])
    return [RawTable(name, table.channels, first + 1, (f"sheet {name!r}",))]


def _count(row: Sequence[Any]) -> int:
    return sum(_number(cell) is not None for cell in row)


def _number(cell: Any) -> float | None:
    """Give a cell's number; times in seconds. None where it is no number."""
    if isinstance(cell, bool) or cell is None:
        return None
    if isinstance(cell, int | float):
        return float(cell)
    if isinstance(cell, datetime.timedelta):
        return cell.total_seconds()
    if isinstance(cell, datetime.datetime):
        return cell.replace(tzinfo=datetime.UTC).timestamp()
    if isinstance(cell, datetime.time):
        return cell.hour * 3600.0 + cell.minute * 60.0 + cell.second + cell.microsecond * 1e-6
    return None


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell).strip()


def _begins(head: bytes) -> bool:
    """Tell a workbook by its first bytes: an OLE file, or a zip that begins as one."""
    return head[:8] == OLE or head[:4] == b"PK\x03\x04"


FORMAT = Format(
    name="spreadsheet",
    suffixes=(".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"),
    begins=_begins,
    read=read,
    module="python_calamine",
    package="python-calamine",
)
