"""Delimited text of any kind: exports of MTS, Instron, Zwick, LabVIEW, catman, DIAdem and of spreadsheets."""

from __future__ import annotations

import gzip
import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.importing.raw import Above, Channel, Damaged, Format, RawTable, Unread, refuse_rows
from pipeclamp_identification.importing.texts.above import numbers_above, temperature_above
from pipeclamp_identification.importing.texts.clock import Clock
from pipeclamp_identification.importing.texts.decoding import text_blocks
from pipeclamp_identification.importing.texts.labels import Labels
from pipeclamp_identification.importing.texts.sniffing import (
    FEWEST_COLUMNS,
    OTHER,
    OTHER_COLUMNS,
    Layout,
    cells_of,
    decimals_change,
    has_other_decimals,
    is_header,
    is_number,
    is_other_header,
    layout_of,
)
from pipeclamp_identification.importing.texts.titles import names_of_blocks
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.tables import pl

GZIP = b"\x1f\x8b"
LARGEST = 8 << 30
"""Bytes of text that a packed file may hold."""
BLOCK = 64 << 20
"""Bytes of text that are turned into numbers at once; the first of them tell how the table is held."""
SEVERAL_BLANKS = re.compile(r"[ \t]+")
FEWEST_ROWS = 8
"""Rows from which on a block of numbers is one of samples, where there are longer ones."""
LOST = 200
"""Steps, beyond the rows without samples, that a clock may have gone on by where these part no tables."""
RISING = 0.05
"""Share of steps up that make a column that never falls a clock, its stamps rounded perhaps, and no count of cycles."""
NOT_A_NUMBER = ("nan", "inf", "+inf", "-inf", "na", "n/a", "null", "none", "#n/a", "-", "--", "---")
"""What stands for a blank cell, in lower case."""
GROUPED = {
    ".": r"^[-+]?[1-9]\d{0,2}(?:(?:,\d{3})+\.\d+|(?:['\x{2019}\x{a0}\x{202f} ]\d{3})+(?:\.\d+)?)$",
    ",": r"^[-+]?[1-9]\d{0,2}(?:(?:\.\d{3})+,\d+|(?:['\x{2019}\x{a0}\x{202f} ]\d{3})+(?:,\d+)?)$",
}
"""Numbers whose thousands are parted, by the decimal sign: 1,017.21 and 1'017, but not 1,017, which may be 1.017."""
FORTRAN = r"^([-+]?[\d.,]+)[dD]([-+]?\d+)$"
"""A number in Fortran's double precision: 1.234D+03."""
GROUPS = {".": r"[,'\x{2019}\x{a0}\x{202f} ]", ",": r"[.'\x{2019}\x{a0}\x{202f} ]"}
MOSTLY = 0.5
"""A row without so many of its numbers parts blocks."""


def read(path: Path) -> Sequence[RawTable]:
    """Read the tables of a text: one, or a block each where lines without numbers part them.

    The text is never held whole.
    """
    with _opened(path) as stream:
        texts = text_blocks(stream, BLOCK, LARGEST)
        text, encoding = next(texts)
        lines = text.split("\n")
        layout = layout_of(lines)
        header = sum(len(line) + 1 for line in lines[: layout.first])
        columns = _Columns(layout, lines[: layout.first])
        del lines
        columns.add(text[header:])
        for text, own in texts:
            columns.add(text)
            encoding = own
    grouped = ", thousands parted" if columns.grouped else ""
    return columns.tables(f"text in {encoding}, {layout.words()}{grouped}")


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open a file's text, unpacked."""
    with path.open("rb") as stream:
        packed = stream.read(len(GZIP)) == GZIP
        stream.seek(0)
        if not packed:
            yield stream
            return
        with gzip.open(stream) as unpacked:
            yield cast(BinaryIO, unpacked)


@dataclass(frozen=True)
class _Texts:
    """Cells of a column that hold text: how many, the row of the first, and what stands there."""

    count: int
    row: int
    text: str


class _Columns:
    """The numbers of a text's columns, taken block after block."""

    def __init__(self, layout: Layout, header: Sequence[str]) -> None:
        self.layout, self._header = layout, header
        self.length = 0
        self._values: list[list[Array]] = [[] for _ in range(layout.width)]
        self._present: list[npt.NDArray[np.uint16]] = []
        self._clocks: dict[int, Clock] = {}
        self._between: dict[int, str] = {}
        self._lost: list[Array] = []
        self._texts: dict[int, _Texts] = {}
        self._labels: dict[int, Labels] = {}
        self.grouped = False

    def add(self, text: str) -> None:
        """Take the rows of a block.

        Raises:
            Damaged: the decimal sign changes.
        """
        if not text.strip():
            return
        found, cells = self._numbers_in(text)
        present = np.zeros(len(found[0]), dtype=np.uint16)
        for values, own in zip(self._values, found, strict=True):
            values.append(own)
            present += np.isfinite(own)
        gaps = np.flatnonzero(present < MOSTLY * self.layout.width)
        if len(gaps):
            lines = text.split("\n")
            own_lines = {row: lines[row] for row in gaps.tolist() if row < len(lines)}
            for row, line in own_lines.items():
                if has_other_decimals(line, self.layout):
                    number = self.layout.first + self.length + row + 1
                    raise decimals_change(number, line, OTHER[self.layout.decimal])
            self._between |= {self.length + row: line for row, line in own_lines.items()}
            lost = [self.length + row for row, line in own_lines.items() if self._is_lost(line)]
            self._lost.append(np.array(lost, dtype=np.float64))
        for place, column in cells.items():
            # what stands between blocks is no sample
            self._note_texts(place, column, np.isnan(found[place]) & (present >= FEWEST_COLUMNS))
            if np.all(np.isnan(found[place])):
                self._labels.setdefault(place, Labels()).add(column)
        self._present.append(present)
        self.length += len(present)

    def _is_lost(self, line: str) -> bool:
        """Tell whether a line is a sample that was lost: cells that say so, or are blank, and no text."""
        cells = [cell for cell in cells_of(line, self.layout.delimiter) if cell]
        return bool(cells) and all(is_number(cell, self.layout.decimal) for cell in cells)

    def _note_texts(self, place: int, cells: pl.Series, none: npt.NDArray[np.bool_]) -> None:
        """Keep how many cells of a column hold text for a number, and the first of them."""
        text = cells.str.strip_chars()
        said = text.str.to_lowercase().is_in(NOT_A_NUMBER).fill_null(True)
        rows = np.flatnonzero(none & ~said.to_numpy() & (text != "").fill_null(False).to_numpy())
        if len(rows):
            before = self._texts.get(place)
            row = int(rows[0])
            first = before or _Texts(0, self.layout.first + self.length + row + 1, str(text[row]))
            self._texts[place] = replace(first, count=first.count + len(rows))

    def _numbers_in(self, text: str) -> tuple[list[Array], dict[int, pl.Series]]:
        """Give the numbers of each column of a block, nan where a cell holds none; and cells that may be text."""
        layout, delimiter = self.layout, self.layout.delimiter
        if delimiter == " ":
            text, delimiter = "\n".join(SEVERAL_BLANKS.sub("\t", line.strip()) for line in text.split("\n")), "\t"
        content, quote = text.encode(), '"' if '"' in text else None
        try:
            # most tables are numbers from end to end; beside commas polars takes points for them too, even of thousands
            plain = layout.decimal == "." or "." not in text
            frame = _frame(content, delimiter, layout, quote, numbers=plain)
        except pl.exceptions.PolarsError:
            plain = False
            frame = _frame(content, delimiter, layout, quote, numbers=False)
        if not plain:
            found = [self._read(place, frame[name]) for place, name in enumerate(frame.columns)]
            texts = {place: frame[name] for place, name in enumerate(frame.columns) if np.any(np.isnan(found[place]))}
            return found, texts
        # a float column's missing values become nan
        return [frame[name].to_numpy() for name in frame.columns], {}

    def _read(self, place: int, cells: pl.Series) -> Array:
        """Give a column's numbers, nan where a cell is none; stamps of time become seconds."""
        text = cells.str.strip_chars()
        numbers = self._plain(text).cast(pl.Float64, strict=False)
        grouped = text.str.contains(GROUPED[self.layout.decimal]).fill_null(False)
        if grouped.any():
            parted = self._plain(text.filter(grouped).str.replace_all(GROUPS[self.layout.decimal], ""))
            numbers = numbers.scatter(grouped.arg_true(), parted.cast(pl.Float64, strict=False))
            self.grouped = True
        stamped = numbers.null_count() > MOSTLY * len(numbers) and text.str.contains(":", literal=True).any()
        if place in self._clocks or stamped:
            return self._clocks.setdefault(place, Clock()).seconds(text)
        return numbers.fill_null(float("nan")).to_numpy()

    def _plain(self, text: pl.Series) -> pl.Series:
        """Give texts of numbers with decimal points, and exponents as polars reads them."""
        text = text.str.replace(FORTRAN, "${1}e${2}")
        if self.layout.decimal == ".":
            return text
        plain = text.str.replace(",", ".", literal=True, n=1)
        return plain.set(text.str.contains(".", literal=True).fill_null(False), None)

    def tables(self, read_as: str) -> list[RawTable]:
        """Give the tables.

        Raises:
            Damaged: there is none, or a later one has its columns in another order.
        """
        values = []
        for place, pieces in enumerate(self._values):
            samples = np.concatenate(pieces) if len(pieces) != 1 else pieces[0]
            pieces.clear()
            values.append(self._clocks[place].continued(samples) if place in self._clocks else samples)
        numeric = [place for place, samples in enumerate(values) if np.any(np.isfinite(samples))]
        if len(numeric) < 2:
            raise Damaged("holds no table of numbers")
        refuse_rows(self.length, len(numeric))
        layout = self.layout
        kept = np.concatenate(self._present) >= MOSTLY * len(numeric)
        for rows in self._lost:
            kept[rows.astype(np.intp)] = True
        blocks = _blocks(kept)
        self._refuse_other_order(blocks)
        blocks = _long_ones(_that_go_on([values[place] for place in numeric], blocks))
        # stamps of the clock became seconds, whatever stands above them
        units = ["s" if place in self._clocks else unit for place, unit in enumerate(layout.units)]
        if layout.step and 0 not in numeric:
            # rows whose time the header states
            numeric = [0, *numeric]
            values[0] = np.arange(self.length, dtype=np.float64) * layout.step
        labels = {
            place: column
            for place, one in self._labels.items()
            if place not in numeric and (column := one.column(layout.names[place], units[place], self.length))
        }
        unread = [
            Unread(layout.names[place], units[place], one.count, one.row, one.text, is_whole=place not in numeric)
            for place, one in self._texts.items()
        ]
        blank = set(range(layout.width)) - {*numeric, *self._texts, *labels}
        unread += [
            Unread(layout.names[place], units[place], self.length, layout.first + 1, "", is_whole=True)
            for place in sorted(blank)
        ]
        above = self._above(blocks)
        # of several tables below each other nobody knows whether the header's numbers hold for all
        numbers = numbers_above(self._cells(self._header)) if len(blocks) == 1 else {}
        return [
            RawTable(
                name,
                tuple(Channel(layout.names[place], units[place], values[place][first:last]) for place in numeric),
                layout.first + first + 1,
                (read_as,),
                tuple(unread),
                tuple(replace(column, values=column.values[first:last]) for column in labels.values()),
                tuple(layout.titles[place] for place in numeric),
                above=own,
                stated_above=numbers,
            )
            for name, own, (first, last) in zip(self._names(blocks), above, blocks, strict=True)
        ]

    def _above(self, blocks: Sequence[tuple[int, int]]) -> list[Above | None]:
        """Give what stands above each block of the temperature: right above it, or else in the file's header."""
        header = temperature_above(self._cells(self._header))
        between = [
            temperature_above(self._cells(self._between.get(row, "") for row in range(before, after)))
            for (_, before), (after, _) in itertools.pairwise(blocks)
        ]
        return [header, *(own or header for own in between)]

    def _cells(self, lines: Iterable[str]) -> Iterator[list[str]]:
        """Give the cells of lines, but of those that name the columns; a whole line where blanks part the numbers."""
        for line in lines:
            cells = cells_of(line, self.layout.delimiter)
            if not is_header(cells, self.layout.names):
                yield [line] if self.layout.delimiter == " " else cells

    def _names(self, blocks: Sequence[tuple[int, int]]) -> list[str]:
        """Give the blocks' names, "" for a single one."""
        if len(blocks) == 1:
            return [""]
        layout = self.layout
        between = [
            [self._between.get(row, "") for row in range(before, after)]
            for (_, before), (after, _) in itertools.pairwise(blocks)
        ]
        above = [
            [line for line in lines if line.strip() and not is_header(cells_of(line, layout.delimiter), layout.names)]
            for lines in (self._header, *between)
        ]
        return names_of_blocks(above, layout.delimiter)

    def _refuse_other_order(self, blocks: Sequence[tuple[int, int]]) -> None:
        """Refuse a later block whose names or units are others, or in another order: its numbers would go for them.

        Raises:
            Damaged: one does.
        """
        layout = self.layout
        for (_, before), (after, _) in itertools.pairwise(blocks):
            for row in range(before, after):
                cells = cells_of(self._between.get(row, ""), layout.delimiter)[: layout.width]
                if is_other_header(cells, layout.names, layout.units):
                    raise Damaged(f"has {OTHER_COLUMNS.format(layout.first + row + 1)}")


def _frame(content: bytes, delimiter: str, layout: Layout, quote: str | None, *, numbers: bool) -> pl.DataFrame:
    """Give the cells; rows that are shorter are filled up, what is beyond the width is left aside."""
    # polars takes the first row's width for that of all
    first = delimiter.join("0" * layout.width) + "\n"
    frame = pl.read_csv(
        first.encode() + content,
        separator=delimiter,
        has_header=False,
        schema={str(place): pl.Float64 if numbers else pl.String for place in range(layout.width)},
        quote_char=quote,
        truncate_ragged_lines=True,
        decimal_comma=numbers and layout.decimal == "," and delimiter != ",",
    )
    return frame.slice(1)


def _blocks(kept: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Give first row and the one after the last of each block of rows that hold numbers."""
    edges = np.flatnonzero(np.diff(kept.astype(np.int8), prepend=0, append=0))
    if not len(edges):
        raise Damaged("holds no table of numbers")
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def _that_go_on(columns: Sequence[Array], blocks: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Join blocks over which a clock or counter goes on: what parts them is lost samples or a remark, no new table."""
    if len(blocks) < 2:
        return list(blocks)
    first, last = (np.array(ends, dtype=np.intp) for ends in zip(*blocks, strict=True))
    going = np.zeros(len(blocks) - 1, dtype=np.bool_)
    inside = np.ones(last[-1] - first[0] - 1, dtype=np.bool_)
    for end, begin in zip(last[:-1], first[1:], strict=True):
        inside[end - 1 - first[0] : begin - first[0]] = False
    for values in columns:
        steps = np.diff(values[first[0] : last[-1]])[inside]
        steps = steps[np.isfinite(steps)]
        if len(steps) and np.all(steps >= 0) and np.mean(steps > 0) > RISING:
            step = values[first[1:]] - values[last[:-1] - 1]
            going |= (step > 0) & (step <= (first[1:] - last[:-1] + LOST) * np.median(steps[steps > 0]))
    begins = np.concatenate([[True], ~going])
    return list(zip(first[begins].tolist(), last[np.append(begins[1:], True)].tolist(), strict=True))


def _long_ones(blocks: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Give the blocks that are long enough to be samples."""
    longest = max(last - first for first, last in blocks)
    return [(first, last) for first, last in blocks if last - first >= min(FEWEST_ROWS, longest)]


FORMAT = Format(
    name="delimited text",
    suffixes=(".csv", ".txt", ".dat", ".asc", ".tsv", ".lvm", ".tab", ".prn", ".tra", ".gz"),
    begins=lambda head: False,
    read=read,
)
