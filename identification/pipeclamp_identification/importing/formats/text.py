"""Delimited text of any kind: exports of MTS, Instron, Zwick, LabVIEW, catman, DIAdem and of spreadsheets."""

from __future__ import annotations

import gzip
import itertools
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.importing.raw import Channel, Damaged, Format, RawTable
from pipeclamp_identification.importing.texts.clock import Clock
from pipeclamp_identification.importing.texts.decoding import text_blocks
from pipeclamp_identification.importing.texts.sniffing import Layout, cells_of, layout_of
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
        del lines
        columns = _Columns(layout)
        columns.add(text[header:])
        for text, own in texts:
            columns.add(text)
            encoding = own
    return columns.tables(f"text in {encoding}, {layout.words()}")


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


class _Columns:
    """The numbers of a text's columns, taken block after block."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.length = 0
        self._values: list[list[Array]] = [[] for _ in range(layout.width)]
        self._present: list[npt.NDArray[np.uint16]] = []
        self._clocks: dict[int, Clock] = {}
        self._between: dict[int, str] = {}

    def add(self, text: str) -> None:
        """Take the rows of a block."""
        if not text.strip():
            return
        found = self._numbers_in(text)
        present = np.zeros(len(found[0]), dtype=np.uint16)
        for values, own in zip(self._values, found, strict=True):
            values.append(own)
            present += np.isfinite(own)
        gaps = np.flatnonzero(present < MOSTLY * self.layout.width)
        if len(gaps):
            lines = text.split("\n")
            self._between |= {self.length + row: lines[row] for row in gaps.tolist() if row < len(lines)}
        self._present.append(present)
        self.length += len(present)

    def _numbers_in(self, text: str) -> list[Array]:
        """Give the numbers of each column of a block, nan where a cell holds none."""
        layout, delimiter = self.layout, self.layout.delimiter
        if delimiter == " ":
            text, delimiter = "\n".join(SEVERAL_BLANKS.sub("\t", line.strip()) for line in text.split("\n")), "\t"
        content, quote = text.encode(), '"' if '"' in text else None
        try:
            # most tables are numbers from end to end
            frame = _frame(content, delimiter, layout, quote, numbers=True)
        except pl.exceptions.PolarsError:
            frame = _frame(content, delimiter, layout, quote, numbers=False)
            return [self._read(place, frame[name]) for place, name in enumerate(frame.columns)]
        # a float column's missing values become nan
        return [frame[name].to_numpy() for name in frame.columns]

    def _read(self, place: int, cells: pl.Series) -> Array:
        """Give a column's numbers, nan where a cell is none; stamps of time become seconds."""
        text = cells.str.strip_chars()
        if self.layout.decimal == ",":
            plain = text.str.replace(",", ".", literal=True, n=1)
            plain = plain.set(text.str.contains(".", literal=True).fill_null(False), None)
        else:
            plain = text
        numbers = plain.cast(pl.Float64, strict=False)
        stamped = numbers.null_count() > MOSTLY * len(numbers) and text.str.contains(":", literal=True).any()
        if place in self._clocks or stamped:
            return self._clocks.setdefault(place, Clock()).seconds(text)
        return numbers.fill_null(float("nan")).to_numpy()

    def tables(self, told: str) -> list[RawTable]:
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
        layout = self.layout
        blocks = _blocks(np.concatenate(self._present) >= MOSTLY * len(numeric))
        self._refuse_other_order(blocks)
        return [
            RawTable(
                f"block {number}" if len(blocks) > 1 else "",
                tuple(
                    Channel(layout.names[place], layout.units[place], values[place][first:last]) for place in numeric
                ),
                layout.first + first + 1,
                (told,),
            )
            for number, (first, last) in enumerate(blocks, 1)
        ]

    def _refuse_other_order(self, blocks: Sequence[tuple[int, int]]) -> None:
        """Refuse a later block whose names stand in another order: its numbers would go for others.

        Raises:
            Damaged: one does.
        """
        names = self.layout.names
        for (_, before), (after, _) in itertools.pairwise(blocks):
            for row in range(before, after):
                cells = cells_of(self._between.get(row, ""), self.layout.delimiter)[: self.layout.width]
                if len(set(cells) & set(names)) >= 2 and tuple(cells) != names[: len(cells)]:
                    raise Damaged(
                        f"has other columns from line {self.layout.first + row + 1} on; expected one order of columns "
                        "in a file"
                    )


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


def _blocks(kept: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Give first row and the one after the last of each block of rows that hold numbers."""
    edges = np.flatnonzero(np.diff(kept.astype(np.int8), prepend=0, append=0))
    found = [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]
    longest = max((last - first for first, last in found), default=0)
    if not longest:
        raise Damaged("holds no table of numbers")
    return [(first, last) for first, last in found if last - first >= min(FEWEST_ROWS, longest)]


FORMAT = Format(
    name="delimited text",
    suffixes=(".csv", ".txt", ".dat", ".asc", ".tsv", ".lvm", ".tab", ".prn", ".gz"),
    begins=lambda head: False,
    read=read,
)
