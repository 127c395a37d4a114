"""An import from its files to the campaign in its place: planned, written beside it, read back, put there."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import Found
from pipeclamp_identification.importing.delay import common_delay
from pipeclamp_identification.importing.importer import Options, plan_import
from pipeclamp_identification.importing.reading import files_in
from pipeclamp_identification.importing.writing import PAGE, existing_campaign, put_in_place, stage
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import staged_folder


def import_whole(
    paths: Sequence[Path],
    folder: Path,
    options: Options,
    *,
    page: Callable[[Found], str],
    confirm: Callable[[Found], bool] | None = None,
    dry_run: bool = False,
    name: str = "",
    notes: str = "",
    software: str = "",
    format: Format = "parquet",
    progress: Callable[[str], None] | None = None,
) -> Found:
    """Import files into a campaign, whole or not at all; files that it holds already change nothing.

    Args:
        paths: of files, or of folders with them.
        folder: of the campaign: new, or one that was imported before.
        options: what the user states.
        page: draws the page that stands in the campaign's folder.
        confirm: asks before anything is put in place; a no leaves all as it was.
        dry_run: write nothing.
        name, notes: of a new campaign; its folder's name by default.
        software: name and version of this program.
        format: of the records.
        progress: is told what is being done.

    Raises:
        UserError: a file, or what the campaign would be, can't serve.
    """
    files = files_in(paths)
    existing = existing_campaign(folder)
    taken = [row["run"] for row in existing.rows] if existing else []
    plan = plan_import(files, options, existing.known if existing else {}, taken, progress)
    if not plan.files:
        if existing is None:
            raise UserError("no file was named; expected test machines' files")
        return Found(folder, plan, read_campaign(folder), existing.imported, written=False)
    # what is only looked at needs no place beside the campaign
    with staged_folder(Path(tempfile.gettempdir()) / folder.name if dry_run else folder) as work:
        if progress:
            progress("read back")
        staged = stage(
            work, folder, plan, existing, name=name or folder.resolve().name, notes=notes, software=software,
            format=format, delay_of=common_delay,
        )  # fmt: skip
        found = Found(folder, plan, staged.campaign, staged.imported, written=not dry_run)
        if dry_run:
            return found
        (work / PAGE).write_text(page(found), encoding="utf-8", newline="\n")
        if confirm and not confirm(found):
            raise UserError("nothing was written: the import wasn't confirmed")
        put_in_place(work, folder)
    return found
