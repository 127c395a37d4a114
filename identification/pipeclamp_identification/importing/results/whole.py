"""Files of results become a campaign of metrics, or join one: whole or not at all."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pipeclamp_identification.campaign.description import (
    CampaignDescription,
    Imported,
    LeftOutFile,
    description_text,
    read_description,
)
from pipeclamp_identification.campaign.runs_table import FILE_NAME, read_runs_table
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.answer import Found
from pipeclamp_identification.importing.columns import listed
from pipeclamp_identification.importing.conditions import guessed_pattern
from pipeclamp_identification.importing.importer import left_out_files
from pipeclamp_identification.importing.reading import Contents, digest_of, files_in, read_file
from pipeclamp_identification.importing.results.taking import TakenResults, taken_results
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import ResultsFileError, UnusableFileError, listed_why
from pipeclamp_identification.importing.whole import RESTORED, import_whole, passed_over_words
from pipeclamp_identification.importing.writing import (
    Existing,
    existing_campaign,
    is_left_out_anew,
    put_in_place,
    still_left_out,
    table_text,
    write_description,
)
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import restored, set_aside, staged_folder

if TYPE_CHECKING:
    from pipeclamp_identification.importing.results.found import FoundResults


def import_any(
    paths: Sequence[Path],
    folder: Path,
    options: Options,
    *,
    page: Callable[[Found | FoundResults], str],
    confirm: Callable[[Found | FoundResults], bool] | None = None,
    dry_run: bool = False,
    name: str = "",
    notes: str = "",
    software: str = "",
    format: Format = "parquet",
    progress: Callable[[str], None] | None = None,
) -> Found | FoundResults:
    """Import files: of records, as `import_whole` does, whose arguments these are; or of results.

    Raises:
        UserError: a file, or what the campaign would be, can't serve.
    """

    def of_results() -> FoundResults:
        return import_results(
            paths, folder, options, page=page, confirm=confirm, dry_run=dry_run, name=name, notes=notes,
            software=software, progress=progress,
        )  # fmt: skip

    if _holds_results(folder if folder.exists() else set_aside(folder)):
        return of_results()
    try:
        return import_whole(
            paths, folder, options, page=page, confirm=confirm, dry_run=dry_run, name=name, notes=notes,
            software=software, format=format, progress=progress,
        )  # fmt: skip
    except ResultsFileError:
        return of_results()


def _holds_results(folder: Path) -> bool:
    """Tell whether a campaign that was imported lies there, of tests without records."""
    existing = existing_campaign(folder) if folder.is_dir() else None
    return existing is not None and not existing.holds_records


def import_results(
    paths: Sequence[Path],
    folder: Path,
    options: Options,
    *,
    page: Callable[[FoundResults], str],
    confirm: Callable[[FoundResults], bool] | None = None,
    dry_run: bool = False,
    name: str = "",
    notes: str = "",
    software: str = "",
    progress: Callable[[str], None] | None = None,
) -> FoundResults:
    """Make a campaign of metrics of files of results, or add files to one; arguments as for `import_whole`.

    Raises:
        UserError: a file can't serve, no row does, or the campaign holds records.
    """
    tell = progress or (lambda what: None)
    files = files_in(paths)
    back = restored(folder)
    existing = existing_campaign(folder)
    if existing and existing.holds_records:
        raise UserError(
            f"{folder}: holds records of tests, which results don't join; expected another campaign for them (-o)"
        )
    before = existing.imported if existing else Imported()
    taken = _taken(files, options, existing, tell)
    told = [*([RESTORED] if back else []), *taken.told, *passed_over_words(paths)]
    made = _Made(folder, taken, before, tuple(told), options)
    if existing and not taken.files and not is_left_out_anew(taken.left_out, existing):
        return made.found(folder, written=False)
    with staged_folder(Path(tempfile.gettempdir()) / folder.name if dry_run else folder) as work:
        tell("the campaign as a whole")
        made = replace(made, imported=_imported(before, taken, software))
        head = existing.head if existing else description_text(name or file_name(folder.resolve()), notes)
        rows = table_text(existing.rows if existing else (), [row for one in taken.files for row, _ in one.rows])
        (work / FILE_NAME).write_text(rows, encoding="utf-8", newline="\n")
        write_description(work, head, made.imported)
        found = made.found(work, written=not dry_run)
        if dry_run:
            return found
        tell("its page")
        put_in_place(work, folder, page(found), partial(confirm, found) if confirm else None)
    return found


@dataclass(frozen=True)
class _Taken:
    """Files that are new, names of those that the campaign holds, those that can't be used, and what is told."""

    files: tuple[TakenResults, ...]
    known: tuple[str, ...]
    left_out: tuple[LeftOutFile, ...]
    told: tuple[str, ...]


def _taken(files: Sequence[Path], options: Options, existing: Existing | None, tell: Callable[[str], None]) -> _Taken:
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
        for words in one.told:
            alike.setdefault(words, []).append(one.file.file)
    told = [f"{listed(files_told, most=1)}: {words}" for words, files_told in alike.items()]
    if taken and not any(one.rows for one in taken):
        raise UserError("\n  ".join(["no row of results can be used", *told]))
    told = [*listed_why([(one.file, one.why) for one in left_out]), *contents.notes, *told]
    return _Taken(tuple(taken), tuple(contents.again), left_out, tuple(told))


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
        told: what to know of it.
        options: what the user states.
    """

    folder: Path
    taken: _Taken
    imported: Imported
    told: tuple[str, ...]
    options: Options

    def found(self, work: Path, *, written: bool) -> FoundResults:
        """Read the campaign in a folder as any reader does.

        Raises:
            UserError: it can't be used.
        """
        from pipeclamp_identification.importing.results.found import FoundResults
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
        return FoundResults(
            folder=self.folder,
            files=tuple(one.file for one in files),
            known=self.taken.known,
            new=new,
            rows=table.rows,
            campaign=campaign,
            imported=self.imported,
            pattern=guessed_pattern([one.stem for one in files]) if asked else "",
            told=self.told,
            written=written,
        )
