"""What an import is asked for, and what imports of records and of results have in common: their beginning and end."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import ImportedCampaign
from pipeclamp_identification.importing.raw import without_controls
from pipeclamp_identification.importing.reading import passed_over_in
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.writing import Existing, refuse_changed
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import replace_folder, restored, staged_folder
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import few_of

PAGE = "import.html"
RESTORED = "an earlier import was ended while it replaced the campaign; the campaign was put back as it was before"


@dataclass(frozen=True)
class ImportRequest:
    """What is to be imported, where to, and how.

    Attributes:
        paths: of files, or of folders with them.
        folder: of the campaign: new, or one that was imported before.
        options: what the user states.
        page: draws the page that stands in the campaign's folder.
        confirm: asks before anything is put in place; a no leaves all as it was.
        dry_run: write nothing.
        name, notes: of a new campaign; its folder's name by default.
        software: name and version of this program.
        format: of the records.
        tell: hears what is being done.
    """

    paths: Sequence[Path]
    folder: Path
    options: Options
    page: Callable[[ImportedCampaign], str]
    confirm: Callable[[ImportedCampaign], bool] | None = None
    dry_run: bool = False
    name: str = ""
    notes: str = ""
    software: str = ""
    format: Format = "parquet"
    tell: Progress = silent

    @property
    def campaign_name(self) -> str:
        """Name of a new campaign."""
        return self.name or file_name(self.folder.resolve())

    def restored_words(self) -> list[str]:
        """Put back what an import that was ended left aside, and say so; empty where there was nothing."""
        return [RESTORED] if restored(self.folder) else []

    def passed_over_words(self) -> list[str]:
        """Say which files of folders aren't read: no format has their ending, or they may describe the others."""
        unknown, notes = (few_of(list(map(without_controls, names))) for names in passed_over_in(self.paths))
        words = [f"not read, for no known format has such an ending: {unknown}"] if unknown else []
        beside = f"not read beside files of other formats, which they may describe: {notes}; where they hold tests, "
        return [*words, *([f"{beside}name the files themselves"] if notes else [])]

    def staged(self) -> AbstractContextManager[Path]:
        """Give a folder to write the campaign into; what is only looked at needs no place beside the campaign."""
        looked_at = Path(tempfile.gettempdir()) / (self.folder.resolve().name or "campaign")
        return staged_folder(looked_at if self.dry_run else self.folder)

    def put_in_place(self, work: Path, found: ImportedCampaign, existing: Existing | None) -> None:
        """Put a campaign and its page in place, once that is confirmed.

        Args:
            work: where it lies.
            found: what it is.
            existing: the campaign that it takes the place of, as it was read.

        Raises:
            UserError: it wasn't confirmed, or the place has changed meanwhile.
        """
        self.tell("its page")
        (work / PAGE).write_text(self.page(found), encoding="utf-8", newline="\n")
        if self.confirm and not self.confirm(found):
            raise UserError("nothing was written: the import wasn't confirmed")
        refuse_changed(self.folder, existing)
        replace_folder(work, self.folder)
