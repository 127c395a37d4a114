"""What files of records become before their runs have names: drafts of runs, and what is in none, as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.description import ImportedFile
from pipeclamp_identification.campaign.seen import SeenRecord
from pipeclamp_identification.importing.channels.columns import Column, Mapped
from pipeclamp_identification.importing.conditions import Settings
from pipeclamp_identification.importing.raw import Above, Unread
from pipeclamp_models.base.arrays import Array


@dataclass(frozen=True)
class Draft:
    """A run before it has a name.

    Attributes:
        samples: the first and the last, as the file counts them; and their times.
        record: the file that they were written into.
        seen: what they show.
        done: to them.
        further: mean of each further channel, by column of runs.csv.
        temperature: mean, and by how much it moved; None where it wasn't measured.
        label: that the file gives it in a column of texts; "" where it gives none.
        cycles_before: that its specimen had before, where the file shows it.
    """

    samples: tuple[int, int]
    span: tuple[float, float]
    record: Path
    seen: SeenRecord
    done: tuple[str, ...]
    further: Mapping[str, float]
    temperature: tuple[float, float] | None
    label: str = ""
    cycles_before: float = 0.0


@dataclass(frozen=True)
class CutPart:
    """Samples that are in no run, as the file counts them; their times; and why."""

    samples: tuple[int, int]
    span: tuple[float, float]
    why: str


@dataclass(frozen=True)
class TakenPart:
    """What became of a table, or of a part of it.

    Attributes:
        drafts: of its runs.
        runs: into which it was cut, usable or not.
        cut: what is in no run.
        time, displacement: thinned out to stretches, shape (n,), and the least and largest of each, (n, 2).
    """

    drafts: tuple[Draft, ...]
    runs: int
    cut: tuple[CutPart, ...]
    time: Array
    displacement: Array


@dataclass(frozen=True)
class TakenTable:
    """A table that was taken.

    Attributes:
        name: within the file.
        mapped: its channels that are ours.
        unused: headings of the others.
        unread: what isn't numbers in those that are ours.
        joined: what was done to put its channels on one time.
        stated: of its runs, by the file's properties.
        above: what stands above it of the temperature.
        stated_above: other numbers that stand there or in the file's properties, by name and unit.
        taken: what became of it.
    """

    name: str
    mapped: Mapped
    unused: tuple[str, ...]
    unread: tuple[Unread, ...]
    joined: tuple[str, ...]
    stated: Settings
    above: Above | None
    stated_above: Mapping[str, str]
    taken: TakenPart


@dataclass(frozen=True)
class TakenFile:
    """A file that was taken: as campaign.toml states it, its tables, and the names of those that were left aside."""

    file: ImportedFile
    tables: tuple[TakenTable, ...]
    aside: tuple[str, ...]


@dataclass(frozen=True)
class KnownFile:
    """A file that isn't taken, because what it holds is there already."""

    sha256: str


def is_timed(columns: Sequence[Column], rate_is_measured: bool) -> bool:
    """Tell whether the time of a table was measured: by a channel, or by a logger of known rate."""
    return rate_is_measured or any(one.ours == "time" for one in columns)
