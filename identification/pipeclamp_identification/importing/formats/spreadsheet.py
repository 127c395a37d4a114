"""Excel (.xlsx, .xlsb, .xls) and OpenDocument (.ods) sheets, by calamine."""

from __future__ import annotations

import datetime
import math
import re
import zipfile
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from pipeclamp_identification.importing.raw import (
    Channel,
    Damaged,
    Format,
    LabelColumn,
    RawTable,
    Unread,
    refuse_rows,
)
from pipeclamp_identification.importing.texts.above import numbers_above, temperature_above
from pipeclamp_identification.importing.texts.labels import Labels
from pipeclamp_identification.importing.texts.sniffing import (
    CLEAR,
    OTHER_COLUMNS,
    is_header,
    is_number,
    is_other_header,
    names_above,
)
from pipeclamp_models.base.archive import opened_archive
from pipeclamp_models.base.tables import pl

OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
MOST_CELLS = 300_000_000
PLACE = re.compile(rb'<c[^>]*? r="([A-Z]{1,3})(\d{1,7})"|<(?:\w+:)?row[^>]*? r="(\d{1,7})"')
REPEATED = re.compile(rb'number-(?:rows|columns)-repeated="(\d+)"[^>]*?(?:office:value|office:string)')
HEADER_ROWS = 200
FEWEST_NUMBERS = 2
CLOCK = (datetime.timedelta, datetime.datetime, datetime.time)
PARTS = ("[Content_Types].xml", "content.xml", "mimetype")
"""Of a workbook, one of which every one holds."""


def read(path: Path) -> Sequence[RawTable]:
    """Read every sheet that holds a table of numbers."""
    from python_calamine import CalamineWorkbook

    if zipfile.is_zipfile(path):
        _refuse_sizes(path)
    workbook = CalamineWorkbook.from_path(str(path))
    sheets = [(name, workbook.get_sheet_by_name(name).to_python()) for name in workbook.sheet_names]
    tables = [table for name, rows in sheets for table in _tables(name, rows)]
    if not tables:
        for name, rows in sheets:
            _refuse_texts(name, rows)
        raise Damaged("holds no sheet with a table of numbers")
    return tables


def _refuse_sizes(path: Path) -> None:
    """Refuse workbooks that aren't fit to be unpacked, or whose cells lie too far apart to be held.

    Each part is unpacked here once, by zipfile, which stops where a part holds more than the archive says: calamine
    would go on.
    """
    with opened_archive(path, "a spreadsheet") as packed:
        names = packed.namelist()
        if not any(part in names for part in PARTS):
            inside = (
                f"of {len(names)} files ({names[0]!r}, ...)"
                if len(names) > 1
                else f"of {str(names)[1:-1] or 'nothing'}"
            )
            raise Damaged(f"is a ZIP archive {inside}, no spreadsheet; expected the files that are in it: unpack it")
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


@dataclass(frozen=True)
class _Body:
    """The rows of a sheet that hold its numbers.

    Attributes:
        rows: the cells; rows may be of unequal lengths.
        above: how many rows stand above.
        names: of each column.
        units: of each column; seconds of stamps of time.
        places: the columns with numbers.
    """

    rows: list[list[Any]]
    above: int
    names: Sequence[str]
    units: Sequence[str]
    places: Sequence[int]

    def channels(self) -> tuple[Channel, ...]:
        """Give the columns with numbers."""
        return tuple(
            Channel(
                self.names[place],
                self.units[place],
                np.array([_nan(_cell(row, place)) for row in self.rows], dtype=np.float64),
            )
            for place in self.places
        )

    @cached_property
    def texts(self) -> dict[int, list[tuple[int, str]]]:
        """Give what of each column is text, each with its row, from 0."""
        found = {place: _texts(self.rows, place) for place in range(len(self.names))}
        return {place: texts for place, texts in found.items() if texts}

    def unread(self) -> tuple[Unread, ...]:
        """Give the columns that hold texts, or some."""
        return tuple(
            Unread(
                self.names[place],
                self.units[place],
                len(texts),
                self.above + texts[0][0] + 1,
                texts[0][1],
                is_whole=place not in self.places,
            )
            for place, texts in self.texts.items()
        )

    def labels(self) -> tuple[LabelColumn, ...]:
        """Give the columns of texts alone that may tell runs apart."""
        columns = [
            _labels(self.rows, place, self.names[place], self.units[place])
            for place in self.texts
            if place not in self.places
        ]
        return tuple(column for column in columns if column)


def _tables(name: str, rows: list[list[Any]]) -> list[RawTable]:
    """Give the table of a sheet: where numbers begin, with names and units above."""
    first, end = _extent(rows)
    if first == end:
        return []
    cells = rows[first:end]
    places = sorted({place for row in cells for place, cell in enumerate(row) if _is_number(cell)})
    refuse_rows(len(cells), len(places))
    wide = max(map(len, cells))
    header = [[_text(row[place]) if place < len(row) else "" for place in range(wide)] for row in rows[:first]]
    names, units, titles = names_above(header[-HEADER_ROWS:], wide)
    _refuse_other_columns(name, cells, first, names, units)
    above = [row for row in header if not is_header(row, names)]
    body = _Body(cells, first, names, _with_seconds(units, cells, places), places)
    return [
        RawTable(
            name,
            body.channels(),
            first + 1,
            (f"sheet {name!r}",),
            body.unread(),
            body.labels(),
            tuple(titles[place] for place in places),
            above=temperature_above(above),
            stated_above=numbers_above(above),
        )
    ]


def _extent(rows: list[list[Any]]) -> tuple[int, int]:
    """Give the rows of a sheet's table, as (first, one after the last); both 0 where it has none.

    A header may hold numbers: rows are as most, with numbers in the columns that mostly have them.
    """
    counts = [_count(row) for row in rows]
    some = [place for place, count in enumerate(counts) if count >= FEWEST_NUMBERS]
    if not some:
        return 0, 0
    among: Counter[int] = Counter(place for row in some for place, cell in enumerate(rows[row]) if _is_number(cell))
    usual = [place for place, count in among.items() if 2 * count >= len(some)]
    first = next((row for row in some if all(_cell(rows[row], place) is not None for place in usual)), some[0])
    while first and counts[first - 1] >= max(FEWEST_NUMBERS, CLEAR * len(usual)):
        first -= 1
    return first, some[-1] + 1


def _refuse_other_columns(
    sheet: str, body: list[list[Any]], above: int, names: Sequence[str], units: Sequence[str]
) -> None:
    """Refuse a sheet with another header within its table, `above` rows of the sheet standing above that.

    Raises:
        Damaged: it has one.
    """
    for number, row in enumerate(body, above + 1):
        some_text = any(isinstance(cell, str) and cell for cell in row)
        if some_text and is_other_header([_text(cell) for cell in row], names, units):
            raise Damaged(f"sheet {sheet!r} has {OTHER_COLUMNS.format(number)}")


def _with_seconds(units: Sequence[str], body: list[list[Any]], places: Sequence[int]) -> list[str]:
    """Give the columns' units, seconds for those of stamps of time, which are read so."""
    timed = {place for place in places if isinstance(_filled(body, place), CLOCK)}
    return ["s" if place in timed else unit for place, unit in enumerate(units)]


def _labels(body: list[list[Any]], place: int, name: str, unit: str) -> LabelColumn | None:
    """Give a column of text that may tell runs apart."""
    labels = Labels()
    labels.add(pl.Series([_text(row[place]) if place < len(row) else "" for row in body], dtype=pl.String))
    return labels.column(name, unit, len(body))


def _texts(body: list[list[Any]], place: int) -> list[tuple[int, str]]:
    """Give what of a column is text, each with its row."""
    cells = [(row, line[place]) for row, line in enumerate(body) if place < len(line)]
    return [(row, text) for row, cell in cells if isinstance(cell, str) and (text := _text(cell))]


def _refuse_texts(name: str, rows: list[list[Any]]) -> None:
    """Refuse a sheet whose numbers are texts.

    Raises:
        Damaged: it is one.
    """
    for number, row in enumerate(rows, 1):
        texts = [cell for cell in row if isinstance(cell, str) and (is_number(cell, ",") or is_number(cell, "."))]
        if len(texts) >= FEWEST_NUMBERS:
            raise Damaged(
                f"holds its numbers as text ({texts[0][:20]!r} in row {number} of sheet {name!r}); turn the columns "
                "into numbers in the spreadsheet, or save the sheet as text (.csv)"
            )


def _count(row: Sequence[Any]) -> int:
    return sum(map(_is_number, row))


def _is_number(cell: Any) -> bool:
    return _number(cell) is not None


def _cell(row: Sequence[Any], place: int) -> float | None:
    return _number(row[place]) if place < len(row) else None


def _nan(number: float | None) -> float:
    return math.nan if number is None else number


def _filled(body: list[list[Any]], place: int) -> Any:
    """Give the first number or time in a column."""
    return next(row[place] for row in body if _cell(row, place) is not None)


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
