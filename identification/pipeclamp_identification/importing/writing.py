"""A plan becomes a campaign's folder, whole or not at all; files that come later join one that was imported before."""

from __future__ import annotations

import csv
import io
import json
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeclamp_identification.campaign import description as campaign_file
from pipeclamp_identification.campaign import runs_table
from pipeclamp_identification.campaign.description import (
    CampaignDescription,
    Imported,
    ImportedFile,
    LeftOutFile,
    description_text,
    read_description,
)
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.plan import ImportPlan
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import PLAIN_FILE_NAME, read_text, refuse_folder, untaken

OURS = "# Below this line stands what `pipeclamp import` did; it is written anew when files are added."
"""Parts what a user may change from what is ours, in campaign.toml."""
FIRST_COLUMNS = ("run", "file", "motion", "amplitude_mm", "frequency_Hz", "temperature_C", "specimen")


@dataclass(frozen=True)
class Existing:
    """A campaign that was imported before.

    Attributes:
        folder: where it lies.
        description: its campaign.toml, and the text of what is the user's in it.
        rows: of its runs.csv, as they stand there.
        stands: both files as they were read.
    """

    folder: Path
    description: CampaignDescription
    head: str
    rows: tuple[dict[str, str], ...]
    stands: tuple[bytes, ...]

    @property
    def imported(self) -> Imported:
        """What campaign.toml says of earlier imports."""
        return self.description.imported or Imported()

    @property
    def holds_records(self) -> bool:
        """Whether its tests have records: results of tests have none, and no campaign holds both."""
        return bool(self.rows[0].get("file"))

    @property
    def known(self) -> dict[str, str]:
        """SHA-256 of each of its files, by name."""
        return {one.file: one.sha256 for one in self.imported.files}


def existing_campaign(folder: Path) -> Existing | None:
    """Give the campaign that a folder holds already; None where there is no such folder.

    Raises:
        UserError: something else is there.
    """
    if not folder.exists():
        refuse_folder(folder)
        return None
    if not (folder / campaign_file.FILE_NAME).is_file():
        raise UserError(f"{folder}: exists already; expected a new folder, or a campaign that `pipeclamp import` wrote")
    stands = _as_it_stands(folder)
    description = read_description(folder)
    text = read_text(folder / campaign_file.FILE_NAME, "the campaign's description, a TOML file")
    if description.imported is None or OURS not in text:
        raise UserError(
            f"{folder}: holds a campaign that wasn't imported; expected a new folder (`pipeclamp join` makes "
            "one of two)"
        )
    runs_table.read_runs_table(folder, description)
    with (folder / runs_table.FILE_NAME).open(encoding="utf-8-sig", newline="") as stream:
        rows = tuple(csv.DictReader(stream))
    return Existing(folder, description, text.partition(OURS)[0], rows, stands)


def refuse_changed(folder: Path, existing: Existing | None) -> None:
    """Refuse to put a campaign in the place of one that isn't what was read before, or that wasn't there.

    Raises:
        UserError: another import, or an editor, changed it meanwhile; what they did would be lost.
    """
    if _as_it_stands(folder) != (existing.stands if existing else ()):
        raise UserError(
            f"{folder}: changed while this import ran, by another import or in an editor; nothing was written; the "
            "same command again joins these files to what is there now"
        )


def _as_it_stands(folder: Path) -> tuple[bytes, ...]:
    """Give what a campaign's two files hold, those that are there."""
    paths = (folder / campaign_file.FILE_NAME, folder / runs_table.FILE_NAME)
    return tuple(path.read_bytes() for path in paths if path.is_file())


def table_text(before: Sequence[Mapping[str, str]], new: Sequence[Mapping[str, float | str | None]]) -> str:
    """Give runs.csv: rows that were there, as they were, and new ones."""
    rows: list[dict[str, str]] = [dict(row) for row in before]
    rows += [{name: _cell(value) for name, value in row.items()} for row in new]
    names = dict.fromkeys(name for row in rows for name in row)
    header = [
        *(name for name in FIRST_COLUMNS if name in names),
        *(name for name in names if name not in FIRST_COLUMNS),
    ]
    stream = io.StringIO()
    writer = csv.DictWriter(stream, header, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue()


def _cell(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.10g}"


def imported_text(imported: Imported) -> str:
    """Give the table [imported] of campaign.toml.

    By hand, a line a fact: tomli-w gives each entry of an array a line of its own, 12 lines for a run instead of 6.
    """
    lines = [OURS, "[imported]", f"software = {_text(imported.software)}"]
    if imported.delay:
        lines += ["[imported.delay]", *_pairs(imported.delay.model_dump())]
    parts = {"files": imported.files, "runs": imported.runs, "cut": imported.cut, "left_out": imported.left_out}
    for kind, entries in parts.items():
        for entry in entries:
            lines += ["", f"[[imported.{kind}]]", *_pairs(entry.model_dump(exclude_defaults=True))]
    return "\n".join(lines) + "\n"


def _pairs(values: Mapping[str, Any]) -> list[str]:
    return [f"{_key(name)} = {_value(value)}" for name, value in values.items() if value is not None]


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_pairs(value)) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(one) for one in value) + "]"
    return repr(value)


def _text(text: str) -> str:
    """Give a TOML basic string: a JSON string, but for one control character that JSON lets pass."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def write_campaign(
    work: Path, plan: ImportPlan, existing: Existing | None, *, head: str, software: str, format: Format
) -> Imported:
    """Write a plan into a working folder; its records are moved there.

    Args:
        work: an empty folder.
        plan: what to write.
        existing: what is there already.
        head: what stands in campaign.toml before what an import did, as `head_of` gives it.
        software: that did it.
        format: of records.

    Returns:
        what campaign.toml says of this import and those before.
    """
    (work / "runs").mkdir()
    taken: set[str] = set()
    if existing:
        shutil.copytree(existing.folder / "runs", work / "runs", dirs_exist_ok=True)
        taken = {Path(row["file"]).name.casefold() for row in existing.rows}
    files: dict[str, str] = {}
    for number, run in enumerate(plan.runs, len(existing.rows) + 1 if existing else 1):
        stem = run.name if PLAIN_FILE_NAME.fullmatch(run.name.replace(".", "_")) else f"{number:04d}"
        files[run.name] = f"runs/{untaken(stem, taken, f'.{format}')}.{format}"
        run.record.rename(work / files[run.name])
    rows = existing.rows if existing else ()
    new = [{"run": run.name, "file": files[run.name], **run.row} for run in plan.runs]
    (work / runs_table.FILE_NAME).write_text(table_text(rows, new), encoding="utf-8", newline="\n")
    before = existing.imported if existing else Imported()
    imported = Imported(
        software=software,
        files=(*before.files, *plan.files),
        runs=(*before.runs, *(run.source for run in plan.runs)),
        cut=(*before.cut, *plan.cut),
        left_out=still_left_out(before, plan.files, plan.left_out),
    )
    write_description(work, head, imported)
    return imported


def head_of(existing: Existing | None, plan: ImportPlan, name: str, notes: str) -> str:
    """Give what stands in campaign.toml before what an import did: what is there, or the name of a new campaign."""
    return existing.head if existing else description_text(name, notes, time_measured=not plan.untimed)


def refuse_other_time(existing: Existing | None, plan: ImportPlan) -> None:
    """Refuse files without a time beside tests whose time was measured.

    Raises:
        UserError: there are such.
    """
    if existing and existing.description.time_measured and plan.untimed:
        raise UserError(
            f"{plan.untimed[0]}: its time was not measured, that of the tests in {existing.folder} was, and a law of "
            "both would take cycles for seconds; expected another campaign (-o)"
        )


def is_left_out_anew(left_out: Sequence[LeftOutFile], existing: Existing) -> bool:
    """Tell whether files are left out that the campaign doesn't name yet."""
    return any(one not in existing.imported.left_out for one in left_out)


def still_left_out(
    before: Imported, files: Sequence[ImportedFile], left_out: Sequence[LeftOutFile]
) -> tuple[LeftOutFile, ...]:
    """Give the files that are left out: those of earlier imports as long as no file of their name came in."""
    anew = {one.file for one in files} | {one.file for one in left_out}
    return (*(one for one in before.left_out if one.file not in anew), *left_out)


def write_description(work: Path, head: str, imported: Imported) -> None:
    """Write campaign.toml: what is the user's, and below it what an import did."""
    (work / campaign_file.FILE_NAME).write_text(head + imported_text(imported), encoding="utf-8", newline="\n")
