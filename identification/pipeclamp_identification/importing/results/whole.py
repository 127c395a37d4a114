"""Files of results become a campaign of metrics, or join one: whole or not at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pipeclamp_identification.campaign.description import (
    CampaignDescription,
    Imported,
    LeftOutFile,
    description_text,
    read_description,
)
from pipeclamp_identification.campaign.runs_table import FILE_NAME, read_runs_table
from pipeclamp_identification.importing.conditions import guessed_pattern
from pipeclamp_identification.importing.left_out import left_out_files
from pipeclamp_identification.importing.reading import Contents, digest_of, files_in, read_file
from pipeclamp_identification.importing.request import ImportRequest
from pipeclamp_identification.importing.results.imported import ImportedResults
from pipeclamp_identification.importing.results.taking import TakenResults, taken_results
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError, listed_why
from pipeclamp_identification.importing.writing import (
    Existing,
    existing_campaign,
    is_left_out_anew,
    still_left_out,
    table_text,
    write_description,
)
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.base.said import few_of


def import_results(request: ImportRequest) -> ImportedResults:
    """Make a campaign of metrics of files of results, or add files to one.

    Raises:
        UserError: a file can't serve, no row does, the campaign holds records; or it wasn't confirmed.
    """
    files, folder, tell = files_in(request.paths), request.folder, request.tell
    restored = request.restored_words()
    existing = existing_campaign(folder)
    if existing and existing.holds_records:
        raise UserError(
            f"{folder}: holds records of tests, which results don't join; expected another campaign for them (-o)"
        )
    before = existing.imported if existing else Imported()
    taken = _taken(files, request.options, existing, tell)
    notes = (*restored, *taken.notes, *request.passed_over_words())
    made = _Made(folder, taken, before, notes, request.options)
    if existing and not taken.files and not is_left_out_anew(taken.left_out, existing):
        return made.found(folder, written=False)
    with request.staged() as work:
        tell("the campaign as a whole")
        made = replace(made, imported=_imported(before, taken, request.software))
        head = existing.head if existing else description_text(request.campaign_name, request.notes)
        rows = table_text(existing.rows if existing else (), [row for one in taken.files for row, _ in one.rows])
        (work / FILE_NAME).write_text(rows, encoding="utf-8", newline="\n")
        write_description(work, head, made.imported)
        found = made.found(work, written=not request.dry_run)
        if not request.dry_run:
            request.put_in_place(work, found, existing)
    return found


@dataclass(frozen=True)
class _Taken:
    """Files that are new, names of those that the campaign holds, those that can't be used, and what is told."""

    files: tuple[TakenResults, ...]
    known: tuple[str, ...]
    left_out: tuple[LeftOutFile, ...]
    notes: tuple[str, ...]


def _taken(files: Sequence[Path], options: Options, existing: Existing | None, tell: Progress) -> _Taken:
    """Take files of results.

    Raises:
        UserError: files can't be used and mustn't be left out, or no row of any can.
    """
    contents = Contents(existing.known if existing else {})
    names = {row["run"] for row in existing.rows} if existing else set()
    taken: list[TakenResults] = []
    unusable: dict[Path, UnusableFileError] = {}
    for number, path in enumerate(files, 1):
        tell(f"{number} of {len(files)}: {file_name(path)}")
        try:
            digest = digest_of(path)
            if contents.is_new(path, digest):
                taken.append(taken_results(read_file(path), digest, options, names))
                names |= {source.run for _, source in taken[-1].rows}
        except UnusableFileError as error:
            unusable[path] = error
    before = existing.imported.left_out if existing else ()
    left_out = left_out_files(unusable, len(files), before, options.leave_out)
    alike: dict[str, list[str]] = {}
    for one in taken:
        for words in one.notes:
            alike.setdefault(words, []).append(one.file.file)
    notes = [f"{few_of(own_files, most=1)}: {words}" for words, own_files in alike.items()]
    if taken and not any(one.rows for one in taken):
        raise UserError("\n  ".join(["no row of results can be used", *notes]))
    notes = [*listed_why([(one.file, one.why) for one in left_out]), *contents.notes, *notes]
    return _Taken(tuple(taken), tuple(contents.again), left_out, tuple(notes))


def _imported(before: Imported, taken: _Taken, software: str) -> Imported:
    """Give what campaign.toml says of an import, and of those before it."""
    files = tuple(one.file for one in taken.files)
    return Imported(
        software=software,
        files=(*before.files, *files),
        runs=(*before.runs, *(source for one in taken.files for _, source in one.rows)),
        cut=(*before.cut, *(cut for one in taken.files for cut in one.cut)),
        left_out=still_left_out(before, files, taken.left_out),
    )


@dataclass(frozen=True)
class _Made:
    """What is known of an import before the campaign is read.

    Attributes:
        folder: where it will lie.
        taken: its files.
        imported: campaign.toml's table of that name.
        notes: what to know of it.
        options: what the user states.
    """

    folder: Path
    taken: _Taken
    imported: Imported
    notes: tuple[str, ...]
    options: Options

    def found(self, work: Path, *, written: bool) -> ImportedResults:
        """Read the campaign in a folder as any reader does.

        Raises:
            UserError: it can't be used.
        """
        from pipeclamp_identification.metrics_only.campaign import metric_campaign_of

        try:
            description: CampaignDescription = read_description(work)
            table = read_runs_table(work, description)
            campaign = metric_campaign_of(work, description, table, strict=False)
        except UserError as error:
            raise UserError(str(error).replace(str(work), str(self.folder))) from error
        files = self.taken.files
        new = frozenset(source.run for one in files for _, source in one.rows)
        unknown = any(row.setup.temperature_C is None for row in table.rows if row.run in new)
        asked = unknown and not self.options.pattern and not self.options.conditions
        return ImportedResults(
            folder=self.folder,
            files=tuple(one.file for one in files),
            known=self.taken.known,
            new=new,
            rows=table.rows,
            campaign=campaign,
            imported=self.imported,
            pattern=guessed_pattern([one.stem for one in files]) if asked else "",
            of_files=self.notes,
            written=written,
        )
