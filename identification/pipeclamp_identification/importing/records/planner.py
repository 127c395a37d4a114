"""From files to a plan: each becomes drafts of runs, which get their names and rows in the files' order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from pipeclamp_identification.campaign.description import ImportedCut, ImportedFile, LeftOutFile
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.channels.columns import Mapped, unused_words
from pipeclamp_identification.importing.conditions import guessed_pattern
from pipeclamp_identification.importing.left_out import left_out_files
from pipeclamp_identification.importing.plan import ImportPlan, Overview
from pipeclamp_identification.importing.raw import without_controls
from pipeclamp_identification.importing.reading import Contents, stem_of
from pipeclamp_identification.importing.records.all_runs import (
    conditions_words,
    contradicted,
    refuse_none,
    refuse_reversed,
    reversed_words,
    without_doubtful_temperatures,
)
from pipeclamp_identification.importing.records.drafts import KnownFile, TakenFile, TakenTable, is_timed
from pipeclamp_identification.importing.records.named_run import Called, NamedRun, name_part, named_run
from pipeclamp_identification.importing.records.settings_above import StatedAbove, settings_above_words
from pipeclamp_identification.importing.records.taking import OURS, Way, taken_files
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError, are_no_strays, foremost, listed_why
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import few_of

MOST_ASIDE = 4
"""Tables that are left aside, of which one line names so many."""


def plan_import(
    paths: Sequence[Path],
    options: Options,
    records: Path,
    *,
    format: Format = "parquet",
    known: Mapping[str, str] | None = None,
    left_out: Sequence[LeftOutFile] = (),
    taken: Sequence[str] = (),
    progress: Progress = silent,
) -> ImportPlan:
    """Plan what files become; their runs' records are written, and none is held.

    Args:
        paths: of the files.
        options: what the user states.
        records: an empty folder for the records, and
        format: theirs.
        known: SHA-256 of files that the campaign holds already, by name.
        left_out: files that were left out before, and still are as long as they can't be used.
        taken: names of its runs.
        progress: hears which file is being read.

    Raises:
        UserError: files can't be used and mustn't be left out; what a channel is, is open and there is nobody to ask; a
            name doesn't follow the pattern; no run can be used.
    """
    contents = Contents(known or {})
    digests = frozenset((known or {}).values())
    unusable: dict[Path, UnusableFileError] = {}
    planner = _Planner(options, set(taken))
    way = Way(
        options.columns,
        options.rate,
        options.timed,
        options.ask is not None,
        records,
        format,
        digests,
        options.called_free,
    )
    for path, file in zip(paths, taken_files(paths, way, options.ask, progress), strict=True):
        if isinstance(file, UnusableFileError):
            unusable[path] = file
            if not contents and are_no_strays([*unusable.values()]):
                raise foremost([*unusable.values()])
            continue
        if contents.is_new(path, file.sha256 if isinstance(file, KnownFile) else file.file.sha256):
            assert isinstance(file, TakenFile)
            planner.add(path, file)
    for words in contents.notes:
        planner.note(words)
    again = tuple(contents.again)
    return planner.plan(again, left_out_files(unusable, len(paths), left_out, options.leave_out))


def _stem_of(path: Path, table: TakenTable, several: bool) -> str:
    """Give what a table's runs are named by: its file, and where that has several the sheet or group too."""
    stem = without_controls(stem_of(path)) or "run"
    own = name_part(table.name)
    return f"{stem}_{own}" if several and own else stem


class _Planner:
    """Takes drafts file after file, names them, and gives the plan."""

    def __init__(self, options: Options, taken: set[str]) -> None:
        self._options, self._taken = options, taken
        self._files: list[ImportedFile] = []
        self._runs: list[NamedRun] = []
        self._cut: list[ImportedCut] = []
        self._overviews: list[Overview] = []
        self._notes: list[str] = []
        self._alike: dict[str, list[str]] = {}
        self._unused: dict[tuple[str, ...], tuple[Mapped, list[str]]] = {}
        self._above: list[StatedAbove] = []
        self._untimed: list[str] = []

    def add(self, path: Path, file: TakenFile) -> None:
        """Take a file's drafts.

        Raises:
            UserError: a name doesn't follow the pattern.
        """
        called = file_name(path)
        if file.aside:
            names = few_of([*map(repr, file.aside)], most=MOST_ASIDE)
            self.note(f"{called}: left aside, without time, displacement and force: {names}")
        stems = [_stem_of(path, table, len(file.tables) > 1) for table in file.tables]
        count = Counter(stems)
        labels = Counter(name_part(draft.label) for table in file.tables for draft in table.taken.drafts)
        for table, stem in zip(file.tables, stems, strict=True):
            self._note_table(called, table)
            single = table.taken.runs == 1 and count[stem] == 1
            runs = []
            for draft in table.taken.drafts:
                label = name_part(draft.label)
                by = Called(path, label or stem, stem, labels[label] == 1 if label else single)
                run = named_run(draft, table, by, self._taken, self._options)
                self._taken.add(run.planned.name)
                for words in run.notes:
                    self.note(words)
                runs.append(run)
            self._runs += runs
            self._above.append(StatedAbove(table.stated_above, tuple(run.planned.row for run in runs)))
            self._cut += [
                ImportedCut(file=called, table=table.name, samples=one.samples, why=one.why) for one in table.taken.cut
            ]
            if len(table.taken.time):
                self._overviews.append(_overview(path, table, [run.planned.name for run in runs]))
        self._files.append(file.file)

    def note(self, words: str) -> None:
        """Keep what the user is told, once."""
        if words not in self._notes:
            self._notes.append(words)

    def _note_table(self, called: str, table: TakenTable) -> None:
        """Keep what is to be known of a table, of a file that is called so."""
        for column in table.mapped.columns:
            if column.overrides:
                self.note(
                    f"{column.heading!r} is taken in {column.unit}, as --columns states, though the file says "
                    f"{column.overrides}"
                )
            if how := column.conversion.integrated_words:
                self.note(
                    f"the displacement is {column.heading!r}, {how}: its mean isn't known, and what moves slower than "
                    "the test is taken off"
                )
        time = next((column.heading for column in table.mapped.columns if column.ours == "time"), None)
        if self._options.rate and time:
            self.note(f"--rate isn't used where {time!r} is the time; to use it instead: --columns time=none")
        if not is_timed(table.mapped.columns, self._options.timed) and called not in self._untimed:
            self._untimed.append(called)
        for words in table.joined:
            self._alike.setdefault(words, []).append(called)
        measured = {OURS.get(column.ours, column.ours) for column in table.mapped.columns}
        if stated := sorted(set(table.stated) - measured):
            words = f"{few_of(stated)} taken from the file's own properties"
            self._alike.setdefault(words, []).append(called)
        for unread in table.unread:
            self.note(f"{called}: {unread.words()}; such cells count as blank")
        _, files = self._unused.setdefault(table.unused, (table.mapped, []))
        files += [] if called in files else [called]

    def plan(self, again: tuple[str, ...], left_out: tuple[LeftOutFile, ...] = ()) -> ImportPlan:
        """Give all that was taken; `again` names files that are known, `left_out` those that can't be used.

        Raises:
            UserError: no run can be used, or the force of all has the wrong sign.
        """
        if self._files and not self._runs:
            refuse_none(len(self._files), self._cut, self._notes)
        refuse_reversed(self._runs)
        options = self._options
        stems = () if options.pattern or options.conditions else [run.own for run in self._runs]
        guess = guessed_pattern(stems, partial(contradicted, self._runs, options.timed))
        runs, words_above = without_doubtful_temperatures(self._runs, guess)
        for words in (*words_above, *filter(None, [reversed_words(runs)])):
            self.note(words)
        for words, files in self._alike.items():
            self.note(f"{few_of(list(dict.fromkeys(files)), most=1)}: {words}")
        for headings, (mapped, files) in self._unused.items():
            if headings:
                self._notes.append(unused_words(files, headings, mapped))
        for words in settings_above_words([one for one in self._above if one.runs]):
            self.note(words)
        for words in conditions_words(options.conditions, runs, {*again, *(Path(name).stem for name in again)}):
            self.note(words)
        notes = (*listed_why([(one.file, one.why) for one in left_out]), *self._notes)
        return ImportPlan(
            tuple(self._files), tuple(run.planned for run in runs), tuple(self._cut), tuple(self._overviews), guess,
            notes, again, left_out, tuple(self._untimed),
        )  # fmt: skip


def _overview(path: Path, table: TakenTable, names: Sequence[str]) -> Overview:
    taken = table.taken
    return Overview(
        title=f"{file_name(path)}, {table.name}" if table.name else file_name(path),
        time=taken.time,
        displacement=taken.displacement,
        runs=tuple((name, *draft.span) for draft, name in zip(taken.drafts, names, strict=True)),
        cut=tuple((one.why, *one.span) for one in taken.cut),
    )
