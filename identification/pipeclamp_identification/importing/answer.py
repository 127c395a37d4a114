"""What `import` answers: runs with what was measured, what was cut, and what to know of the campaign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from pipeclamp_identification.campaign.description import Imported, ImportedCut, ImportedFile, LeftOutFile
from pipeclamp_identification.campaign.judging import JudgedRuns
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.importing.looked_at import LookedAt
from pipeclamp_identification.importing.plan import Plan
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_models.base.answer import AnswerModel, LeftOutRun, left_out_runs


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


def taken_columns(files: Sequence[ImportedFile]) -> dict[str, dict[str, str]]:
    """Give channel and factor of each column, by file."""
    return {
        one.file: {
            name: f"{column.channel} {Conversion(column.factor, column.offset).words()}"
            for name, column in one.columns.items()
        }
        for one in files
    }


def cut_answers(cut: Sequence[ImportedCut]) -> tuple[ImportedCutAnswer, ...]:
    """Give what is in no run."""
    return tuple(
        ImportedCutAnswer(file=one.file, table=one.table, first=one.samples[0], last=one.samples[1], why=one.why)
        for one in cut
    )


@dataclass(frozen=True)
class Found:
    """What an import found: the plan, the campaign as a reader finds it, and what campaign.toml says of it.

    Attributes:
        folder, name: of the campaign.
        plan: of what was new.
        rows: of runs.csv, with what it held before.
        judged: all its runs.
        looked: some of them more closely.
        imported: campaign.toml's table of that name.
        written: whether anything was.
    """

    folder: Path
    name: str
    plan: Plan
    rows: tuple[RunRow, ...]
    judged: JudgedRuns
    looked: LookedAt
    imported: Imported
    written: bool

    @property
    def files(self) -> tuple[ImportedFile, ...]:
        """Files that are new."""
        return self.plan.files

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """Runs that can't be used."""
        return self.judged.left_out

    def notes(self) -> tuple[str, ...]:
        """Give what to know of the campaign, of its channels and units first."""
        delay = (self.imported.delay.words,) if self.imported.delay else ()
        smoothing = filter(None, (self.looked.smoothing.words(),))
        return (*self.plan.notes, *delay, *self.judged.remarks, *smoothing)

    def answer(self) -> ImportAnswer:
        """Give it as data."""
        new = {run.name: run for run in self.plan.runs}
        stated = {row.run: row for row in self.rows}
        lost = {one.run for one in self.judged.left_out}
        rows = []
        for source in self.imported.runs:
            sine, row = self.judged.sines.get(source.run), stated.get(source.run)
            measured = new[source.run].measured if source.run in new else None
            rows.append(
                ImportedRunAnswer(
                    run=source.run,
                    file=source.file,
                    amplitude_mm=measured[0] if measured else self.judged.settings[source.run][0] if sine else None,
                    frequency_Hz=sine.cycles.frequency_Hz if sine else measured[1] if measured else None,
                    temperature_C=row.setup.temperature_C if row and source.run not in lost else None,
                    cycles=sine.cycles.count if sine else None,
                    new=source.run in new,
                    done=source.done,
                )
            )
        return ImportAnswer(
            campaign=str(self.folder),
            written=self.written,
            new_files=tuple(one.file for one in self.plan.files),
            known_files=self.plan.known,
            columns=taken_columns(self.imported.files),
            runs=tuple(rows),
            cut=cut_answers(self.imported.cut),
            left_out=left_out_runs(self.judged.left_out),
            left_out_files=self.imported.left_out,
            pattern=self.plan.pattern,
            notes=self.notes(),
        )
