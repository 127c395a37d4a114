"""What an import will write, as data: runs whose records lie in files already, what was cut, and where all of it is
from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.description import ImportedCut, ImportedFile, ImportedRun, LeftOutFile
from pipeclamp_identification.campaign.seen import SeenRecord
from pipeclamp_models.base.arrays import Array


@dataclass(frozen=True)
class PlannedRun:
    """A run as it will be: its row of runs.csv, where its record lies, and where it comes from."""

    row: Mapping[str, float | str | None]
    record: Path
    seen: SeenRecord
    source: ImportedRun
    measured: tuple[float, float] | None
    """Amplitude in mm and frequency in Hz; None for a free motion."""

    @property
    def name(self) -> str:
        """The run's name."""
        return self.source.run


@dataclass(frozen=True)
class Overview:
    """A table of a file, thinned out to be looked at: where its runs lie.

    Attributes:
        title: file, and table where it has several.
        time: s, shape (n,).
        displacement: mm, least and largest value of each of the n stretches, shape (n, 2).
        runs: name, first and last time of each.
        cut: why, first and last time of each part that is in no run.
    """

    title: str
    time: Array
    displacement: Array
    runs: tuple[tuple[str, float, float], ...]
    cut: tuple[tuple[str, float, float], ...]


@dataclass(frozen=True)
class ImportPlan:
    """All that files become.

    Attributes:
        files, cut: as campaign.toml states them.
        runs: in the order of the files and their samples.
        overviews: of tables of which not all is one run.
        pattern: that the names of files seem to follow; "" where none was found, or one was stated.
        notes: what to know, for people.
    """

    files: tuple[ImportedFile, ...]
    runs: tuple[PlannedRun, ...]
    cut: tuple[ImportedCut, ...]
    overviews: tuple[Overview, ...] = ()
    pattern: str = ""
    notes: tuple[str, ...] = ()
    known: tuple[str, ...] = ()
    """Names of files that the campaign holds already."""
    left_out: tuple[LeftOutFile, ...] = ()
    """Files that can't be used, which the user lets be left out."""
    untimed: tuple[str, ...] = ()
    """Names of files in which no time was measured."""
