"""What `import` answers: runs with what was measured, what was cut, and what to know of the campaign."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Protocol

from pydantic import Field

from pipeclamp_identification.campaign.description import Imported, ImportedFile, LeftOutFile
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs
from pipeclamp_models.base.shell import shell_line

Thing = Literal["run", "test"]
"""A test with a record, and one without."""


class ImportedRunAnswer(AnswerModel):
    """A run of the campaign, and what of it was measured."""

    run: str
    file: str = Field(description="that it comes from")
    amplitude_mm: float | None = Field(description="of the displacement's fundamental; null for a free motion")
    frequency_Hz: float | None
    temperature_C: float | None
    cycles: int | None = Field(description="whole ones that are steady")
    new: bool = Field(description="whether this call imported it")
    done: tuple[str, ...] = Field(description="to its samples")


class ImportedCutAnswer(AnswerModel):
    """Samples of a file that are in no run."""

    file: str
    table: str
    first: int
    last: int
    why: str


class ImportAnswer(AnswerModel):
    """What files became."""

    campaign: str = Field(description="its folder")
    written: bool
    new_files: tuple[str, ...]
    known_files: tuple[str, ...] = Field(description="that the campaign held already")
    columns: dict[str, dict[str, str]] = Field(description="channel and factor of each column, by file")
    runs: tuple[ImportedRunAnswer, ...]
    cut: tuple[ImportedCutAnswer, ...]
    left_out: tuple[LeftOutRun, ...]
    left_out_files: tuple[LeftOutFile, ...] = Field(description="that couldn't be used, by this import or one before")
    pattern: str = Field(description="that the names of files seem to follow; empty where none was found")
    notes: tuple[str, ...]


class ImportedCampaign(Protocol):
    """A campaign that an import wrote, or would write: of records or of results, each of which answers for itself."""

    @property
    def folder(self) -> Path:
        """Where it lies, or would lie."""

    @property
    def name(self) -> str:
        """The campaign's."""

    @property
    def thing(self) -> Thing:
        """What a test of it is called."""

    @property
    def files(self) -> tuple[ImportedFile, ...]:
        """Files that are new, as campaign.toml states them."""

    @property
    def imported(self) -> Imported:
        """The table of that name in campaign.toml."""

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """Tests that can't be used."""

    @property
    def written(self) -> bool:
        """Whether anything was."""

    @property
    def serves(self) -> bool:
        """Whether a law can be identified from it."""

    def notes(self) -> tuple[str, ...]:
        """Give what to know of the campaign, of its channels and units first."""

    def answer(self) -> ImportAnswer:
        """Give it as data."""


def import_answer(
    found: ImportedCampaign, runs: Sequence[ImportedRunAnswer], *, known: tuple[str, ...], pattern: str
) -> ImportAnswer:
    """Give a campaign as data.

    Args:
        found: the campaign.
        runs: of it, with what was measured of each.
        known: names of files that it held already.
        pattern: that the names of files seem to follow; empty where none was found.
    """
    cut = (
        ImportedCutAnswer(file=one.file, table=one.table, first=one.samples[0], last=one.samples[1], why=one.why)
        for one in found.imported.cut
    )
    return ImportAnswer(
        campaign=str(found.folder),
        written=found.written,
        new_files=tuple(one.file for one in found.files),
        known_files=known,
        columns=_taken_columns(found.imported.files),
        runs=tuple(runs),
        cut=tuple(cut),
        left_out=left_out_runs(found.left_out),
        left_out_files=found.imported.left_out,
        pattern=pattern,
        notes=found.notes(),
    )


def specimen_words(rows: Sequence[RunRow], folder: Path, thing: Thing) -> tuple[str, ...]:
    """Say of how many specimens the tests are, where they are of several, and how each has a law of its own."""
    named = {row.setup.specimen for row in rows if row.setup.specimen}
    if len(named) < 2:
        return ()
    alone = shell_line("identify", str(folder), "-o", "laws", "--per", "specimen")
    return (
        f"its {thing}s are of {len(named)} specimens, and one law is fitted to all of them; a law of each: {alone}",
    )


def _taken_columns(files: Sequence[ImportedFile]) -> dict[str, dict[str, str]]:
    """Give channel and factor of each column, by file."""
    return {
        one.file: {
            name: f"{column.channel} {Conversion(column.factor, column.offset).words()}"
            for name, column in one.columns.items()
        }
        for one in files
    }
