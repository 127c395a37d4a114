"""What a test machine's file holds, before anybody knows which channel is what."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pipeclamp_models.base.arrays import Array, IntArray

MOST_SAMPLES = 250_000_000
"""Numbers that a channel may claim to hold: 2 GB; what claims more is damaged."""
FEW_SAMPLES = 1_000_000
"""So many may be claimed by any file."""
FEWEST_ROWS, MANY_CHANNELS = 8, 100
"""Fewer rows than these of more columns than those are channels that stand in rows."""
COMPRESSED = 20.0
"""Samples for each byte of a file that compresses: channels that stand still shrink far more, but hardly all do."""


@dataclass(frozen=True)
class Channel:
    """One channel: its name and unit as the file states them (no unit: ""), and its samples, nan where blank."""

    name: str
    unit: str
    values: Array

    @property
    def heading(self) -> str:
        """Name and unit in one, as a user states the channel."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class LabelColumn(Channel):
    """A column of texts, as a channel: number k stands for `texts[k]`, nan for rows above the first of them."""

    texts: tuple[str, ...]

    def of(self, rows: IntArray) -> str:
        """Give the text that rows have, by their places, shape (n,), and not all others; "" where there is none."""
        numbers = np.unique(self.values[rows])
        one = len(numbers) == 1 and len(self.texts) > 1 and np.isfinite(numbers[0])
        return self.texts[int(numbers[0])] if one else ""


@dataclass(frozen=True)
class Unread:
    """Cells of a column that hold text where numbers were expected; they are blank to whoever reads its samples.

    Attributes:
        name, unit: of the column, as of a channel.
        count: of such cells.
        row: of the file that holds the first one.
        text: that stands there; "" where all cells are blank.
        is_whole: whether the column holds no number at all, and is no channel.
    """

    name: str
    unit: str
    count: int
    row: int
    text: str
    is_whole: bool

    @property
    def channel(self) -> Channel:
        """The column as a channel without samples."""
        return Channel(self.name, self.unit, np.empty(0))

    def words(self) -> str:
        """Say what stands where."""
        if not self.text:
            return f"column {self.channel.heading!r} holds no number in any row"
        what = "no numbers" if self.is_whole else f"text for a number in {self.count} cells"
        if self.count == 1 and not self.is_whole:
            what = "text for a number"
        first = "first " if self.count > 1 else ""
        return f"column {self.channel.heading!r} holds {what}, {first}{self.text!r} in row {self.row}"


@dataclass(frozen=True)
class Above:
    """What is stated of the temperature above a table.

    Attributes:
        temperature_C: that of the test; None where that isn't clear.
        words: how it is stated, or why it isn't clear, for people.
    """

    temperature_C: float | None
    words: str


@dataclass(frozen=True)
class RawTable:
    """Channels of one length.

    Attributes:
        name: of the table within its file: a sheet, a group, a block; "" where there is but one.
        group: that it shares with tables of other lengths; "" where it shares none.
        channels: in the file's order.
        first_row: row of the file that holds the first samples, where it has rows; 1 elsewhere.
        read_as: how it was read, for people.
        unread: columns with text where numbers were expected.
        titles: what stands above the channels' names, "" where nothing does; none where a format has no such thing.
        joined: what was done to put channels of other rates on one time, for people.
        labels: columns that hold nothing but text: they may tell runs apart, and name them.
        properties: that the file states of the table beside its channels, by name.
        above: what lines above it state of the temperature.
        stated_above: other numbers that they state, by name and unit.
    """

    name: str
    channels: tuple[Channel, ...]
    first_row: int = 1
    read_as: tuple[str, ...] = ()
    unread: tuple[Unread, ...] = ()
    labels: tuple[LabelColumn, ...] = ()
    titles: tuple[str, ...] = ()
    joined: tuple[str, ...] = ()
    properties: Mapping[str, object] = field(default_factory=dict)
    above: Above | None = None
    stated_above: Mapping[str, str] = field(default_factory=dict)
    group: str = ""

    @property
    def length(self) -> int:
        """Samples of each channel."""
        return len(self.channels[0].values) if self.channels else 0


class Damaged(Exception):  # noqa: N818 - it says what the file is
    """A file that isn't what its format says, with the reason and what was expected."""


@dataclass(frozen=True)
class Format:
    """A format of files.

    Attributes:
        name: for people.
        suffixes: of its files, in lower case, with the dot.
        begins: tells by the first bytes of a file whether it is of this format.
        read: gives the tables of a file; it may raise anything, which is told as damage.
        module: that must be installed, and the package that brings it, where it is an extra.
        is_also_notes: whether such files as often describe others: of a folder they are read where it holds no others.
    """

    name: str
    suffixes: tuple[str, ...]
    begins: Callable[[bytes], bool]
    read: Callable[[Path], Sequence[RawTable]]
    module: str = ""
    package: str = ""
    is_also_notes: bool = False


def without_controls(text: str) -> str:
    """Give a text without control characters, which a terminal would obey."""
    return "".join(one if one.isprintable() else " " for one in text).strip()


def refuse_size(what: str, count: float, holds: int, times: float = 1.0) -> None:
    """Refuse a count of samples that a file of so many bytes can't hold.

    Args:
        what: holds them.
        count: claimed.
        holds: bytes of the file.
        times: how many samples a byte may hold, more than one where the format compresses.

    Raises:
        Damaged: it claims more.
    """
    if not 0 <= count <= min(MOST_SAMPLES, FEW_SAMPLES + holds * times):
        raise Damaged(f"{what} claims {count:g} samples, more than a file of {holds} bytes holds")


def refuse_rows(length: int, channels: int) -> None:
    """Refuse a table whose channels seem to stand in rows.

    Args:
        length: rows.
        channels: columns.

    Raises:
        Damaged: they do.
    """
    if length < FEWEST_ROWS and channels > MANY_CHANNELS:
        raise Damaged(
            f"has {channels} columns of {length} numbers: its channels seem to stand in rows; expected a column each: "
            "transpose it"
        )


def side_by_side(table: RawTable) -> list[RawTable]:
    """Give the tables of one whose names come again in the same order: runs that stand beside each other."""
    headings = [channel.heading for channel in table.channels]
    width = next(
        (
            width
            for width in range(2, len(headings) // 2 + 1)
            if len(headings) % width == 0 and headings == headings[:width] * (len(headings) // width)
        ),
        0,
    )
    if not width:
        return [table]
    titles = [set(table.titles[first : first + width]) - {""} for first in range(0, len(headings), width)]
    titled = all(len(own) == 1 for own in titles) and len(set.union(*titles)) == len(titles)
    parts = []
    for first in range(0, len(headings), width):
        channels = table.channels[first : first + width]
        filled = np.flatnonzero(np.any([np.isfinite(channel.values) for channel in channels], axis=0))
        end = int(filled[-1]) + 1 if len(filled) else 0
        if end:
            own = next(iter(titles[first // width])) if titled else f"columns {first + 1} to {first + width}"
            name = f"{table.name} {own}".strip()
            cut = tuple(replace(channel, values=channel.values[:end]) for channel in channels)
            parts.append(replace(table, name=name, channels=cut, labels=(), titles=()))
    return parts


def table_of(name: str, columns: Sequence[tuple[str, str, object]], read_as: Sequence[str] = ()) -> list[RawTable]:
    """Give a table for each length that channels have, longest first; what isn't numbers in one row is left aside.

    Args:
        name: of the table.
        columns: name, unit and samples of each channel.
        read_as: how it was read.
    """
    by_length: dict[int, list[Channel]] = {}
    for column, unit, values in columns:
        samples = np.squeeze(np.asarray(values))
        if samples.ndim == 0:
            samples = samples.reshape(1)
        if samples.ndim == 1 and samples.dtype.kind in "fiub" and len(samples):
            by_length.setdefault(len(samples), []).append(Channel(column, unit, samples.astype(np.float64)))
    lengths = sorted(by_length, reverse=True)
    return [
        RawTable(
            name if len(lengths) == 1 else f"{name} {length} samples".strip(),
            tuple(by_length[length]),
            1,
            tuple(read_as),
            group=name if len(lengths) > 1 else "",
        )
        for length in lengths
    ]
