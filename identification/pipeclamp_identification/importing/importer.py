"""From files to a plan: each becomes drafts of runs, which get their names and rows in the files' order."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pipeclamp_identification.campaign.description import ImportedCut, ImportedFile, ImportedRun, LeftOutFile
from pipeclamp_identification.campaign.plausibility import PEAK_TO_PEAK, STATED_APART, reversed_sign
from pipeclamp_identification.campaign.seen import SeenSine
from pipeclamp_identification.campaign.writing import Format
from pipeclamp_identification.importing.channels.columns import Mapped, listed, unused_words
from pipeclamp_identification.importing.conditions import Pattern, Settings, guessed_pattern, name_in, settings_of
from pipeclamp_identification.importing.plan import ImportPlan, Overview, PlannedRun
from pipeclamp_identification.importing.raw import Above, without_controls
from pipeclamp_identification.importing.reading import Contents, digest_of, stem_of
from pipeclamp_identification.importing.stated import LeaveOut, Options
from pipeclamp_identification.importing.taking import (
    Draft,
    KnownFile,
    TakenFile,
    TakenTable,
    Way,
    is_timed,
    taken_files,
)
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import (
    UnusableFileError,
    UnusableFiles,
    are_no_strays,
    foremost,
    listed_why,
)
from pipeclamp_identification.signals.digits import rounded_to
from pipeclamp_identification.units.stated import conversion, is_unit
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.said import counted

STEADY_TEMPERATURE = 5.0
"""K by which a temperature may move within a run before that is said."""
TEMPERATURE_APART = 15.0
"""K by which an oven may miss what was set in it: a name's number that is farther off is no temperature."""
MOST_ASIDE = 4
"""Tables that are left aside, of which one line names so many."""
UNTIMED_FREQUENCY = (
    "the frequency that is stated isn't used, for time was not measured; where it is known, state the samples per "
    "second in place of --rate none: those of a cycle times the frequency"
)
LONGEST_NAME = 60
"""Characters of a sheet's, group's or label's name that become part of a run's."""


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
    way = Way(options.columns, options.rate, options.timed, options.ask is not None, records, format, digests)
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


def left_out_files(
    unusable: Mapping[Path, UnusableFileError], files: int, before: Sequence[LeftOutFile], leave_out: LeaveOut
) -> tuple[LeftOutFile, ...]:
    """Give the files that are left out, where they may be.

    Args:
        unusable: the error of each.
        files: of the import in all.
        before: that were left out by an earlier import.
        leave_out: says whether.

    Raises:
        UserError: they mustn't be, or there is no other.
    """
    found = {path: _of_unusable(path, error) for path, error in unusable.items()}
    anew = {path: unusable[path] for path, one in found.items() if not _is_among(one, before)}
    new = UnusableFiles(anew, files)
    if anew and not (new.others and leave_out(new)):
        raise new.refusal()
    return tuple(found.values())


def _of_unusable(path: Path, error: UnusableFileError) -> LeftOutFile:
    try:
        digest = digest_of(path)
    except UnusableFileError:
        digest = None
    return LeftOutFile(file=file_name(path), sha256=digest, why=error.why)


def _is_among(file: LeftOutFile, before: Sequence[LeftOutFile]) -> bool:
    """Tell whether a file, with this content, was left out before."""
    return file.sha256 is not None and (file.file, file.sha256) in {(one.file, one.sha256) for one in before}


def _stem_of(path: Path, table: TakenTable, several: bool) -> str:
    """Give what a table's runs are named by: its file, and where that has several the sheet or group too."""
    stem = without_controls(stem_of(path)) or "run"
    own = _plain(table.name)
    return f"{stem}_{own}" if several and own else stem


def _plain(text: str) -> str:
    """Give a text as a part of a run's name, which files may be called by."""
    return re.sub(r"[^\w.,+-]+", "_", text)[:LONGEST_NAME].strip("_.")


class _Planner:
    """Takes drafts file after file, names them, and gives the plan."""

    def __init__(self, options: Options, taken: set[str]) -> None:
        self.options, self.taken = options, taken
        self.files: list[ImportedFile] = []
        self.runs: list[PlannedRun] = []
        self.cut: list[ImportedCut] = []
        self.overviews: list[Overview] = []
        self.notes: list[str] = []
        self.reversed: list[Mapped] = []
        self.own: dict[str, str] = {}
        self.known_as: dict[str, str] = {}
        self.alike: dict[str, list[str]] = {}
        self.above: dict[str, Above] = {}
        self.unused: dict[tuple[str, ...], tuple[Mapped, list[str]]] = {}
        self.untimed: list[str] = []

    def add(self, path: Path, file: TakenFile) -> None:
        """Take a file's drafts.

        Raises:
            UserError: a name doesn't follow the pattern.
        """
        called = file_name(path)
        if file.aside:
            names = listed([*map(repr, file.aside)], most=MOST_ASIDE)
            self.note(f"{called}: left aside, without time, displacement and force: {names}")
        stems = [_stem_of(path, table, len(file.tables) > 1) for table in file.tables]
        count = Counter(stems)
        labels = Counter(_plain(draft.label) for table in file.tables for draft in table.taken.drafts)
        for table, stem in zip(file.tables, stems, strict=True):
            single = table.taken.runs == 1 and count[stem] == 1
            for column in table.mapped.columns:
                if column.overrides:
                    self.note(
                        f"{column.heading!r} is taken in {column.unit}, as --columns states, though the file says "
                        f"{column.overrides}"
                    )
            time = next((column.heading for column in table.mapped.columns if column.ours == "time"), None)
            if self.options.rate and time:
                self.note(f"--rate isn't used where {time!r} is the time; to use it instead: --columns time=none")
            if not is_timed(table.mapped.columns, self.options.timed) and called not in self.untimed:
                self.untimed.append(called)
            for words in table.joined:
                self.alike.setdefault(words, []).append(called)
            if table.stated:
                words = f"{listed(sorted(table.stated))} taken from the file's own properties"
                self.alike.setdefault(words, []).append(called)
            for unread in table.unread:
                self.note(f"{called}: {unread.words()}; such cells count as blank")
            _, files = self.unused.setdefault(table.unused, (table.mapped, []))
            files += [] if called in files else [called]
            runs = []
            for draft in table.taken.drafts:
                label = _plain(draft.label)
                runs.append(self._run(path, label or stem, stem, table, draft, labels[label] == 1 if label else single))
            self.runs += runs
            self.cut += [
                ImportedCut(file=called, table=table.name, samples=one.samples, why=one.why) for one in table.taken.cut
            ]
            if len(table.taken.time):
                self.overviews.append(_overview(path, table, runs))
        self.files.append(file.file)

    def note(self, words: str) -> None:
        """Keep what the user is told, once."""
        if words not in self.notes:
            self.notes.append(words)

    def _run(self, path: Path, own: str, stem: str, table: TakenTable, draft: Draft, single: bool) -> PlannedRun:
        """Give a draft its name and its row.

        Args:
            path: of its file.
            own: what it is named by: its label or, without one, the stem.
            stem: what its table's runs are named by.
            table: it is cut from.
            draft: the run.
            single: whether no other run is named by the same.

        Raises:
            UserError: neither name follows the pattern.
        """
        settings = settings_of(path, tuple(dict.fromkeys((own, stem))), self.options.pattern)
        name = self._name(own, stem, single)
        self.own[name] = own
        measured: Settings = {
            column: _digits(_in_its_unit(table.mapped, column, value))
            for column, value in draft.further.items()
            if not math.isnan(value)
        }
        if draft.temperature:
            mean, moved = draft.temperature
            measured["temperature_C"] = round(mean, 2)
            if moved > STEADY_TEMPERATURE:
                self.note(f"run {name}: its temperature moves by {moved:.3g} K; its mean counts")
        sine: tuple[float, float] | None = None
        if isinstance(draft.seen, SeenSine):
            sine = (draft.seen.shown.amplitude_mm, draft.seen.cycles.frequency_Hz)
            measured["amplitude_mm"] = _digits(sine[0])
            if is_timed(table.mapped.columns, self.options.timed):
                measured["frequency_Hz"] = _digits(sine[1])
            if reversed_sign(draft.seen.shown):
                self.reversed.append(table.mapped)
        else:
            measured["motion"] = "free"
        row: dict[str, float | str | None] = {**table.stated, **measured}
        if table.above and "temperature_C" not in row:
            self.above[name] = table.above
            if table.above.temperature_C is not None:
                row["temperature_C"] = table.above.temperature_C
        called = file_name(path)
        known_as = name_in(self.options.conditions, (name, draft.label, own, called, Path(called).stem))
        self.known_as[name] = known_as
        stated = settings | self.options.conditions.get(known_as, {})
        for column, value in stated.items():
            if column in ("amplitude_mm", "frequency_Hz") and not single and isinstance(value, float):
                found = measured.get(column)
                # a table with several runs has one name
                if isinstance(found, float) and abs(found - value) > STATED_APART * value:
                    continue
            if column in ("run", "file"):
                continue
            if column == "frequency_Hz" and not is_timed(table.mapped.columns, self.options.timed):
                self.note(UNTIMED_FREQUENCY)
                continue
            row[column] = value
        if "temperature_C" in stated:
            self.above.pop(name, None)
        source = ImportedRun(
            run=name,
            file=called,
            table=table.name,
            samples=draft.samples,
            measured=tuple(column for column in measured if column not in stated and column != "motion"),
            done=draft.done,
        )
        return PlannedRun(row, draft.record, draft.seen, source, sine)

    def _name(self, own: str, stem: str, single: bool) -> str:
        """Give a run's name: its own, behind its table's where that is taken; with a number where there are several."""
        candidates = _names(own, stem, single)
        name = next(one for one in candidates if one not in self.taken)
        self.taken.add(name)
        return name

    def plan(self, again: tuple[str, ...], left_out: tuple[LeftOutFile, ...] = ()) -> ImportPlan:
        """Give all that was taken; `again` names files that are known, `left_out` those that can't be used.

        Raises:
            UserError: no run can be used, or the force of all has the wrong sign.
        """
        if self.files and not self.runs:
            reasons = "\n".join(
                f"  {one.file}, {one.samples[0]} to {one.samples[1]}: {one.why}" for one in self.cut[:10]
            )
            raise UserError(
                f"no run can be used, in {counted(len(self.files), 'file')}; expected loops of force and displacement\n"
                + "\n".join([reasons, *(f"  {note}" for note in self.notes)])
            )
        if self.runs and len(self.reversed) == len(self.runs):
            turned = [
                replace(one, conversion=replace(one.conversion, factor=-one.conversion.factor))
                if one.ours == "force"
                else one
                for one in self.reversed[0].columns
            ]
            raise UserError(
                "the force of all runs has the wrong sign: stiffness and dissipated energy are both negative; force is "
                f"what the rig applies, positive with positive displacement; expected it turned, for example\n  "
                f"{replace(self.reversed[0], columns=tuple(turned), questions=()).option()}"
            )
        stems = () if self.options.pattern or self.options.conditions else [self.own[run.name] for run in self.runs]
        guess = guessed_pattern(stems, self._contradicted)
        self._note_above(guess)
        for words, files in self.alike.items():
            self.note(f"{listed(list(dict.fromkeys(files)), most=1)}: {words}")
        for headings, (mapped, files) in self.unused.items():
            if headings:
                self.notes.append(unused_words(files, headings, mapped))
        self._note_conditions({Path(name).stem for name in again} | set(again))
        notes = (*listed_why([(one.file, one.why) for one in left_out]), *self.notes)
        return ImportPlan(
            tuple(self.files), tuple(self.runs), tuple(self.cut), tuple(self.overviews), guess, notes, again, left_out,
            tuple(self.untimed),
        )  # fmt: skip

    def _contradicted(self, column: str, values: Sequence[float]) -> bool:
        """Tell whether most runs were measured otherwise than the files' names would state, a value a run."""
        if column == "temperature_C":
            # what stands above a table may be that of another test: names may contradict it, not the other way round
            shown = [None if run.name in self.above else run.row.get(column) for run in self.runs]
            pairs = [(own, value) for own, value in zip(shown, values, strict=True) if isinstance(own, float)]
            apart = [abs(own - value) > TEMPERATURE_APART for own, value in pairs]
        elif column in ("amplitude_mm", "frequency_Hz"):
            measured = [run.measured and run.measured[column == "frequency_Hz"] for run in self.runs]
            pairs = [(own, value) for own, value in zip(measured, values, strict=True) if own is not None]
            apart = [not _twice(own, value) and abs(own - value) > STATED_APART * value for own, value in pairs]
        else:
            return False
        return 2 * sum(apart) > len(apart)

    def _note_above(self, guess: str) -> None:
        """Say which temperatures stand above tables; where the files' names state others, none is taken.

        Args:
            guess: the pattern that the names seem to follow.
        """
        named = Pattern(guess).settings if guess else lambda stem: None
        apart = [
            run
            for run in self.runs
            if run.name in self.above
            and isinstance(value := (named(self.own[run.name]) or {}).get("temperature_C"), float)
            and abs(value - (self.above[run.name].temperature_C or value)) > TEMPERATURE_APART
        ]
        files: dict[str, list[str]] = {}
        for run in self.runs:
            if run.name in self.above:
                files.setdefault(self.above[run.name].words, []).append(run.source.file)
        if apart:
            self.runs = [
                replace(run, row={**run.row, "temperature_C": None}) if run in apart else run for run in self.runs
            ]
        for words, own in files.items():
            self.note(f"{listed(list(dict.fromkeys(own)), most=1)}: {words}")
        if apart:
            self.note(
                f"the names of {len(apart)} of these files state another temperature: neither is taken; import again "
                "with --pattern, or state it in runs.csv"
            )

    def _note_conditions(self, again: set[str]) -> None:
        """Say which rows of the table of conditions met no run, and which runs no row; `again` are known files."""
        met = again | set(self.known_as.values())
        idle = [repr(name) for name in self.options.conditions if name not in met]
        bare = [run for run, name in self.known_as.items() if not name]
        if idle:
            self.note(f"--conditions: no run here is called, nor from a file that is called, {listed(idle)}")
        if bare and self.options.conditions:
            self.note(f"--conditions: says nothing of {len(bare)} of {len(self.runs)} runs: {listed(bare)}")


def _twice(amplitude: float, stated: float) -> bool:
    """Tell whether an amplitude is that of a stroke from peak to peak that was stated."""
    return PEAK_TO_PEAK[0] * stated < amplitude < PEAK_TO_PEAK[1] * stated


def _names(own: str, stem: str, single: bool) -> Iterator[str]:
    if single:
        yield own
        if own != stem:
            yield f"{stem}_{own}"
    number = 1 if not single else 2
    while True:
        yield f"{own}_{number:02d}"
        number += 1


def _digits(value: float) -> float:
    """Give a measured setting with the digits that it has."""
    return rounded_to(value, 4)


def _in_its_unit(mapped: Mapped, column: str, value: float) -> float:
    """Turn a further condition into the unit that its column's name states, where the channel has one, too."""
    source = next(one for one in mapped.columns if one.ours == column)
    quantity, _, target = column.rpartition("_")
    if not (quantity and source.unit and is_unit(target)):
        return value
    try:
        found = conversion(quantity, source.unit, target)
    except UserError as error:
        raise UserError(
            f"--columns, {column}={source.heading}: {error}; or what counts behind it, for example "
            f"{column}={source.heading} [2 {target}] where 1 {source.unit} is 2 {target}"
        ) from error
    return found.factor * value + found.offset


def _overview(path: Path, table: TakenTable, runs: Sequence[PlannedRun]) -> Overview:
    taken = table.taken
    return Overview(
        title=f"{file_name(path)}, {table.name}" if table.name else file_name(path),
        time=taken.time,
        displacement=taken.displacement,
        runs=tuple((run.name, *draft.span) for draft, run in zip(taken.drafts, runs, strict=True)),
        cut=tuple((one.why, *one.span) for one in taken.cut),
    )
