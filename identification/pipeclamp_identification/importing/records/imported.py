"""What files of records became, as it is told."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.description import Imported, ImportedFile
from pipeclamp_identification.campaign.judging import JudgedRuns
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.importing.answer import (
    ImportAnswer,
    ImportedRunAnswer,
    Thing,
    import_answer,
    specimen_words,
)
from pipeclamp_identification.importing.plan import ImportPlan
from pipeclamp_identification.importing.records.looked_at import LookedAt


@dataclass(frozen=True)
class ImportedRecords:
    """A campaign of records that an import wrote, or would write, as a reader finds it.

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
    plan: ImportPlan
    rows: tuple[RunRow, ...]
    judged: JudgedRuns
    looked: LookedAt
    imported: Imported
    written: bool
    thing: Thing = "run"

    @property
    def files(self) -> tuple[ImportedFile, ...]:
        """Files that are new."""
        return self.plan.files

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """Runs that can't be used."""
        return self.judged.left_out

    @property
    def serves(self) -> bool:
        """Whether a law can be identified from it: it has runs with steady cycles."""
        return bool(self.judged.sines)

    def notes(self) -> tuple[str, ...]:
        """Give what to know of the campaign, of its channels and units first."""
        delay = (self.imported.delay.words,) if self.imported.delay else ()
        smoothing = filter(None, (self.looked.smoothing.words(),))
        specimens = specimen_words(self.rows, self.folder, self.thing)
        return (*self.plan.notes, *delay, *self.judged.remarks, *smoothing, *specimens)

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
        return import_answer(self, rows, known=self.plan.known, pattern=self.plan.pattern)
