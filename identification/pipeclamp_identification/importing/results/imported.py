"""What files of results became, as it is told."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp_identification.campaign.description import Imported, ImportedFile
from pipeclamp_identification.campaign.runs_table import RunRow
from pipeclamp_identification.campaign.seen import LeftOut
from pipeclamp_identification.importing.answer import (
    ImportAnswer,
    ImportedRunAnswer,
    Thing,
    import_answer,
    specimen_words,
)
from pipeclamp_models.base.digits import newtons
from pipeclamp_models.base.said import counted

if TYPE_CHECKING:
    from pipeclamp_identification.metrics_only.campaign import MetricCampaign

METRICS = "stiffness and loss of a test, without a record"
WEAK = 0.01
"""Share of the largest force amplitude below which that of a test is told."""


@dataclass(frozen=True)
class ImportedResults:
    """A campaign of results that an import wrote, or would write, as a reader finds it.

    Attributes:
        folder: of the campaign.
        files: that are new, as campaign.toml states them.
        known: names of files that the campaign held already.
        new: names of the tests that came in.
        rows: of runs.csv, with what it held before.
        campaign: all its tests.
        imported: campaign.toml's table of that name.
        pattern: that the names of files seem to follow, where they state what nothing else does.
        of_files: what to know of the files.
        written: whether anything was.
    """

    folder: Path
    files: tuple[ImportedFile, ...]
    known: tuple[str, ...]
    new: frozenset[str]
    rows: tuple[RunRow, ...]
    campaign: MetricCampaign
    imported: Imported
    pattern: str
    of_files: tuple[str, ...]
    written: bool
    thing: Thing = "test"

    @property
    def name(self) -> str:
        """The campaign's."""
        return self.campaign.name

    @property
    def left_out(self) -> tuple[LeftOut, ...]:
        """Tests that can't be used."""
        return self.campaign.left_out

    @property
    def serves(self) -> bool:
        """Whether a law can be identified from it: it has tests that can be used."""
        return bool(self.campaign.runs)

    def notes(self) -> tuple[str, ...]:
        """Give what to know of the campaign, of its columns and units first."""
        specimens = specimen_words(self.rows, self.folder, self.thing)
        return (*self.of_files, *_weak_words(self.campaign), *specimens)

    def answer(self) -> ImportAnswer:
        """Give it as data."""
        stated = {row.run: row for row in self.rows}
        lost = {one.run for one in self.left_out}
        runs = [
            ImportedRunAnswer(
                run=source.run,
                file=source.file,
                amplitude_mm=row.amplitude_mm,
                frequency_Hz=row.frequency_Hz,
                temperature_C=row.setup.temperature_C if source.run not in lost else None,
                cycles=None,
                new=source.run in self.new,
                done=(METRICS,),
            )
            for source in self.imported.runs
            if (row := stated.get(source.run))
        ]
        return import_answer(self, runs, known=self.known, pattern=self.pattern)


def _weak_words(campaign: MetricCampaign) -> list[str]:
    """Say which tests had forces so small beside others that a load cell may hardly tell them."""
    forces = [run.stiffness * run.amplitude_mm for run in campaign.runs]
    largest = max(forces, default=0.0)
    weak = sum(force < WEAK * largest for force in forces)
    if not weak:
        return []
    return [
        f"the force's amplitude of {weak} of {counted(len(forces), 'test')} is below {WEAK:.0%} of the largest, "
        f"{newtons(largest)}: each test counts alike, however little its load cell tells; where these scatter, take "
        "their rows out of runs.csv"
    ]
