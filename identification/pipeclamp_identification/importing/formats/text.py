"""Delimited text of any kind: exports of MTS, Instron, Zwick, LabVIEW, catman, DIAdem and of spreadsheets."""

from __future__ import annotations

import gzip
import itertools
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeclamp_identification.importing.decoding import decoded
from pipeclamp_identification.importing.raw import Channel, Damaged, Format, RawTable
from pipeclamp_identification.importing.sniffing import Layout, cells_of, layout_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

GZIP = b"\x1f\x8b"
LARGEST = 8 << 30
"""Bytes of text that a packed file may hold."""
SEVERAL_BLANKS = re.compile(r"[ \t]+")
FEWEST_ROWS = 8
"""Rows from which on a block of numbers is one of samples, where there are longer ones."""
MOSTLY = 0.5
"""A row without so many of its numbers parts blocks."""
STAMP_FORMATS = ("%Y-%m-%d", "%d.%m.%Y", "%Y/%m/%d", "%m/%d/%Y", "%d/%m/%Y", "%d-%m-%Y")


def read(path: Path) -> Sequence[RawTable]:
    """Read the tables of a text: one, or a block each where lines without numbers part them."""
    text, encoding = decoded(_content(path))
    lines = text.split("\n")
    layout = layout_of(lines)
    if layout.delimiter == " ":
        table = "\n".join(SEVERAL_BLANKS.sub("\t", line.strip()) for line in lines[layout.first :])
        columns = _columns(table, "\t", layout)
    else:
        columns = _columns("\n".join(lines[layout.first :]), layout.delimiter, layout)
    numeric = [place for place, values in enumerate(columns) if np.any(np.isfinite(values))]
    if len(numeric) < 2:
        raise Damaged("holds no table of numbers")
    matrix = np.stack([columns[place] for place in numeric])
    told = (f"text in {encoding}, {layout.words()}",)
    blocks = _blocks(matrix)
    _refuse_other_order(lines, layout, blocks)
    return [
        RawTable(
            f"block {number}" if len(blocks) > 1 else "",
            tuple(
                Channel(layout.names[place], layout.units[place], matrix[row, first:last])
                for row, place in enumerate(numeric)
            ),
            layout.first + first + 1,
            told,
        )
        for number, (first, last) in enumerate(blocks, 1)
    ]


def _content(path: Path) -> bytes:
    with path.open("rb") as stream:
        if stream.read(2) != GZIP:
            stream.seek(0)
            return stream.read()
    with gzip.open(path) as unpacked:
        content = unpacked.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise Damaged(f"holds more than {LARGEST >> 30} GiB of text")
    return content


def _columns(text: str, delimiter: str, layout: Layout) -> list[Array]:
    """Give the numbers of each column, nan where a cell holds none."""
    content = text.encode()
    quote = '"' if '"' in text else None
    try:
        # most tables are numbers from end to end
        frame = _frame(content, delimiter, layout, quote, numbers=True)
    except pl.exceptions.PolarsError:
        frame = _frame(content, delimiter, layout, quote, numbers=False)
        return [_numbers(frame[name], layout.decimal) for name in frame.columns]
    return [frame[name].fill_null(float("nan")).to_numpy() for name in frame.columns]


def _frame(content: bytes, delimiter: str, layout: Layout, quote: str | None, *, numbers: bool) -> pl.DataFrame:
    """Give the cells; rows that are shorter are filled up, what is beyond the width is left aside."""
    return pl.read_csv(
        content,
        separator=delimiter,
        has_header=False,
        schema={str(place): pl.Float64 if numbers else pl.String for place in range(layout.width)},
        quote_char=quote,
        truncate_ragged_lines=True,
        decimal_comma=numbers and layout.decimal == "," and delimiter != ",",
    )


def _numbers(cells: pl.Series, decimal: str) -> Array:
    """Give a column's numbers, nan where a cell is none; stamps of time become seconds."""
    text = cells.str.strip_chars()
    if decimal == ",":
        plain = text.str.replace(",", ".", literal=True, n=1)
        plain = plain.set(text.str.contains(".", literal=True).fill_null(False), None)
    else:
        plain = text
    numbers = plain.cast(pl.Float64, strict=False)
    if numbers.null_count() > MOSTLY * len(numbers) and text.str.contains(":", literal=True).any():
        return _stamps(text)
    return numbers.fill_null(float("nan")).to_numpy()


def _stamps(text: pl.Series) -> Array:
    """Give stamps of time in seconds: of the day, or since the first of them where they have a date."""
    clock = text.str.extract(r"(\d{1,3}):(\d{2})(?::(\d{2}(?:[.,]\d+)?))?", 1).cast(pl.Float64, strict=False) * 3600.0
    clock += text.str.extract(r"\d{1,3}:(\d{2})", 1).cast(pl.Float64, strict=False) * 60.0
    seconds = text.str.extract(r"\d{1,3}:\d{2}:(\d{2}(?:[.,]\d+)?)", 1).str.replace(",", ".", literal=True)
    clock += seconds.cast(pl.Float64, strict=False).fill_null(0.0)
    values: Array = clock.fill_null(float("nan")).to_numpy()
    date = text.str.extract(r"^(\d{1,4}[-./]\d{1,2}[-./]\d{1,4})[ T]", 1)
    if date.null_count() < len(date):
        for pattern in STAMP_FORMATS:
            days = date.str.to_date(pattern, strict=False)
            if days.null_count() == date.null_count():
                number = days.cast(pl.Int32).cast(pl.Float64).fill_null(float("nan")).to_numpy()
                return np.asarray(values + 86400.0 * (number - np.nanmin(number)))
    # over midnight the clock begins anew
    steps = np.flatnonzero(np.diff(values) < -43200.0)
    for step in steps:
        values = np.concatenate([values[: step + 1], values[step + 1 :] + 86400.0])
    return values


def _blocks(matrix: Array) -> list[tuple[int, int]]:
    """Give first row and the one after the last of each block of numbers."""
    present = np.isfinite(matrix)
    kept = np.mean(present, axis=0) >= MOSTLY
    edges = np.flatnonzero(np.diff(np.concatenate([[0], kept.astype(np.int8), [0]])))
    found = [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]
    longest = max((last - first for first, last in found), default=0)
    if not longest:
        raise Damaged("holds no table of numbers")
    return [(first, last) for first, last in found if last - first >= min(FEWEST_ROWS, longest)]


def _refuse_other_order(lines: Sequence[str], layout: Layout, blocks: Sequence[tuple[int, int]]) -> None:
    """Refuse a later block whose names stand in another order: its numbers would go for others.

    Raises:
        Damaged: one does.
    """
    for (_, before), (after, _) in itertools.pairwise(blocks):
        for index in range(layout.first + before, layout.first + after):
            cells = cells_of(lines[index], layout.delimiter)[: layout.width]
            alike = set(cells) & set(layout.names)
            if len(alike) >= 2 and tuple(cells) != layout.names[: len(cells)]:
                raise Damaged(f"has other columns from line {index + 1} on; expected one order of columns in a file")


FORMAT = Format(
    name="delimited text",
    suffixes=(".csv", ".txt", ".dat", ".asc", ".tsv", ".lvm", ".tab", ".prn", ".gz"),
    begins=lambda head: False,
    read=read,
)
