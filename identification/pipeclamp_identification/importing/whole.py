"""An import from its files to the campaign in its place: planned, written beside it, read back, put there."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from pipeclamp_identification.campaign.description import (
    CampaignDescription,
    Imported,
    read_description,
)
from pipeclamp_identification.campaign.judging import judge_runs
from pipeclamp_identification.campaign.reading import seen_in
from pipeclamp_identification.campaign.runs_table import RunRow, read_runs_table
from pipeclamp_identification.campaign.seen import LeftOut, SeenFree, SeenRecord
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import Found
from pipeclamp_identification.importing.columns import listed
from pipeclamp_identification.importing.importer import plan_import
from pipeclamp_identification.importing.looked_at import looked_at
from pipeclamp_identification.importing.plan import Plan
from pipeclamp_identification.importing.raw import without_controls
from pipeclamp_identification.importing.reading import files_in, passed_over_in
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.writing import (
    existing_campaign,
    head_of,
    is_left_out_anew,
    put_in_place,
    refuse_other_time,
    write_campaign,
    write_description,
)
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import restored, staged_folder
from pipeclamp_models.base.processes import cores, spread

RESTORED = "an earlier import was ended while it replaced the campaign; the campaign was put back as it was before"
MANY = 100
"""Runs from which on records that were there already are read by several processes."""


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
    tell = progress or (lambda what: None)
    back = restored(folder)
    existing = existing_campaign(folder)
    name = name or file_name(folder.resolve())
    taken = [row["run"] for row in existing.rows] if existing else []
    # what is only looked at needs no place beside the campaign
    with staged_folder(Path(tempfile.gettempdir()) / folder.name if dry_run else folder) as work:
        drafts = work / "drafts"
        drafts.mkdir()
        before = existing.imported if existing else Imported()
        plan = plan_import(
            files, options, drafts, format=format, known=existing.known if existing else {}, left_out=before.left_out,
            taken=taken, progress=tell,
        )  # fmt: skip
        plan = replace(plan, notes=(*([RESTORED] if back else []), *plan.notes, *passed_over_words(paths)))
        if not plan.files and existing is None:
            raise UserError("no file was named; expected test machines' files")
        if existing and not plan.files and not is_left_out_anew(plan.left_out, existing):
            return _found(folder, folder, plan, existing.imported, tell, written=False)
        refuse_other_time(existing, plan)
        tell("the campaign as a whole")
        imported = write_campaign(work, plan, existing, name=name, notes=notes, software=software, format=format)
        shutil.rmtree(drafts)
        found = _found(work, folder, plan, imported, tell, written=not dry_run)
        if dry_run:
            return found
        if found.imported.delay:
            write_description(work, head_of(existing, plan, name, notes), found.imported)
        tell("its page")
        put_in_place(work, folder, page(found), partial(confirm, found) if confirm else None)
    return found


def passed_over_words(paths: Sequence[Path]) -> list[str]:
    """Say which files of folders aren't read, for no format has their ending."""
    names = list(map(without_controls, passed_over_in(paths)))
    return [f"not read, for no known format has such an ending: {listed(names)}"] if names else []


def _found(
    work: Path, folder: Path, plan: Plan, imported: Imported, tell: Callable[[str], None], *, written: bool
) -> Found:
    """Judge a campaign as any reader does, by what is known of its new records, and by reading the others.

    Args:
        work: where it lies.
        folder: where it will lie, for errors.
        plan: of what is new.
        imported: what campaign.toml says of it.
        tell: hears what is being done.
        written: whether it stays.

    Raises:
        UserError: it can't be used.
    """
    try:
        description = read_description(work)
        rows = read_runs_table(work, description).rows
        seen: dict[str, SeenRecord | LeftOut] = {run.name: run.seen for run in plan.runs}
        # a table of conditions may call a motion free that looks like a sine, and the other way round
        others = [row for row in rows if row.run not in seen or row.free is not isinstance(seen[row.run], SeenFree)]
        processes = cores() if len(others) > MANY else 1
        for row, one in zip(others, spread(partial(_seen, work, description), others, processes), strict=True):
            if isinstance(one, UserError):
                raise one
            tell(row.run)
            seen[row.run] = one
        judged = judge_runs(work, rows, seen, time_measured=description.time_measured)
        looked = looked_at(work, description, rows, judged)
    except UserError as error:
        raise UserError(str(error).replace(str(work), str(folder))) from error
    if plan.files:
        imported = imported.model_copy(update={"delay": looked.delay})
    return Found(folder, description.name, plan, rows, judged, looked, imported, written)


def _seen(work: Path, description: CampaignDescription, row: RunRow) -> SeenRecord | LeftOut | UserError:
    """Look at a record that was there; a mistake is given, not raised, so that the first one is told first."""
    try:
        return seen_in(work, description, row)
    except UserError as error:
        return error
