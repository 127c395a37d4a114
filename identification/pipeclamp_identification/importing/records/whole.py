"""Files of records become a campaign, or join one: planned, written beside it, read back, put in its place."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

from pipeclamp_identification.campaign.description import CampaignDescription, Imported, read_description
from pipeclamp_identification.campaign.judging import judge_runs
from pipeclamp_identification.campaign.reading import seen_in
from pipeclamp_identification.campaign.runs_table import RunRow, read_runs_table
from pipeclamp_identification.campaign.seen import LeftOut, SeenFree, SeenRecord
from pipeclamp_identification.importing.plan import ImportPlan
from pipeclamp_identification.importing.reading import files_in
from pipeclamp_identification.importing.records.imported import ImportedRecords
from pipeclamp_identification.importing.records.looked_at import looked_at
from pipeclamp_identification.importing.records.planner import plan_import
from pipeclamp_identification.importing.request import ImportRequest
from pipeclamp_identification.importing.writing import (
    existing_campaign,
    head_of,
    is_left_out_anew,
    refuse_other_time,
    write_campaign,
    write_description,
)
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import cores, spread
from pipeclamp_models.base.progress import Progress

MANY = 100
"""Runs from which on records that were there already are read by several processes."""


def import_records(request: ImportRequest) -> ImportedRecords:
    """Import files of records into a campaign, whole or not at all; files that it holds already change nothing.

    Raises:
        UserError: a file, or what the campaign would be, can't serve; or it wasn't confirmed.
    """
    files, folder, tell = files_in(request.paths), request.folder, request.tell
    restored = request.restored_words()
    existing = existing_campaign(folder)
    taken = [row["run"] for row in existing.rows] if existing else []
    with request.staged() as work:
        drafts = work / "drafts"
        drafts.mkdir()
        before = existing.imported if existing else Imported()
        plan = plan_import(
            files, request.options, drafts, format=request.format, known=existing.known if existing else {},
            left_out=before.left_out, taken=taken, progress=tell,
        )  # fmt: skip
        plan = replace(plan, notes=(*restored, *plan.notes, *request.passed_over_words()))
        if not plan.files and existing is None:
            raise UserError("no file was named; expected test machines' files")
        if existing and not plan.files and not is_left_out_anew(plan.left_out, existing):
            return _found(folder, folder, plan, existing.imported, tell, written=False)
        refuse_other_time(existing, plan)
        tell("the campaign as a whole")
        head = head_of(existing, plan, request.campaign_name, request.notes)
        imported = write_campaign(work, plan, existing, head=head, software=request.software, format=request.format)
        shutil.rmtree(drafts)
        found = _found(work, folder, plan, imported, tell, written=not request.dry_run)
        if request.dry_run:
            return found
        if found.imported.delay:
            write_description(work, head, found.imported)
        request.put_in_place(work, found, existing)
    return found


def _found(
    work: Path, folder: Path, plan: ImportPlan, imported: Imported, tell: Progress, *, written: bool
) -> ImportedRecords:
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
    return ImportedRecords(folder, description.name, plan, rows, judged, looked, imported, written)


def _seen(work: Path, description: CampaignDescription, row: RunRow) -> SeenRecord | LeftOut | UserError:
    """Look at a record that was there; a mistake is given, not raised, so that the first one is told first."""
    try:
        return seen_in(work, description, row)
    except UserError as error:
        return error
