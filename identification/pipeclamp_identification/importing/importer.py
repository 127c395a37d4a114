"""From files to a plan: each is read, its channels found, its runs cut, repaired and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import Cycles, find_cycles
from pipeclamp_identification.campaign.description import ImportedColumn, ImportedCut, ImportedFile, ImportedRun
from pipeclamp_identification.campaign.faults import SensorFailure
from pipeclamp_identification.campaign.free_motion import free_motion
from pipeclamp_identification.campaign.plausibility import STATED_APART, fundamental_of, reversed_sign
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_identification.importing.clipped import without_clipped_cycles
from pipeclamp_identification.importing.columns import Column, Mapped, Stated, map_columns, refuse_open_questions
from pipeclamp_identification.importing.conditions import Pattern, Settings, guessed_pattern, settings_for
from pipeclamp_identification.importing.plan import Overview, Plan, PlannedRun
from pipeclamp_identification.importing.rates import joined_rates
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.reading import SourceFile, read_file, without_controls
from pipeclamp_identification.importing.repair import evened, mended
from pipeclamp_identification.importing.split import Part, split
from pipeclamp_identification.importing.traces import Trace, trace_of
from pipeclamp_identification.units.stated import conversion, is_unit
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError

OURS = {"time": "time_s", "displacement": "displacement_mm", "force": "force_N", "temperature": "temperature_C"}
STEADY_TEMPERATURE = 5.0
"""K by which a temperature may move within a run before that is said."""
WIDEST_OVERVIEW = 600
"""Stretches that a picture of a whole table is thinned out to."""
Ask = Callable[[str, Mapped], Sequence[Stated]]
"""Asks a person what names and units leave open, and gives what the answers state."""


@dataclass(frozen=True)
class Options:
    """What a user states.

    Attributes:
        columns: which channels are ours.
        pattern: of the files' names.
        conditions: settings by name of file or run.
        rate: samples per second, where no channel holds the time.
        ask: for what is open; None where nobody can answer.
    """

    columns: tuple[Stated, ...] = ()
    pattern: Pattern | None = None
    conditions: Mapping[str, Settings] = field(default_factory=dict)
    rate: float | None = None
    ask: Ask | None = None


def plan_import(
    paths: Sequence[Path],
    options: Options,
    known: Mapping[str, str] | None = None,
    taken: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Plan:
    """Plan what files become; nothing is written.

    Args:
        paths: of the files.
        options: what the user states.
        known: SHA-256 of files that the campaign holds already, by name.
        taken: names of its runs.
        progress: hears which file is being read.

    Raises:
        UserError: a file can't be read; what a channel is, is open and there is nobody to ask; a name doesn't follow
            the pattern; no run can be used.
    """
    known = known or {}
    maker = _Maker(options, set(taken))
    digests = {digest: name for name, digest in known.items()}
    again: list[str] = []
    new: list[str] = []
    for path in paths:
        if progress:
            progress(path.name)
        source = read_file(path)
        if (other := digests.get(source.sha256)) is not None:
            if other in new:
                raise UserError(f"{path}: has the same content as {other}; one measurement counts once: leave one out")
            again.append(source.name)
            continue
        if source.name in known:
            raise UserError(
                f"{path}: the campaign holds a file of this name with other content; expected another name, or a new "
                "campaign"
            )
        if source.name in new:
            raise UserError(f"{path}: another file has this name; expected a name of its own for each")
        digests[source.sha256] = source.name
        new.append(source.name)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of numbers that a check refuses
            maker.add(source)
    return maker.plan(tuple(again))


class _Maker:
    """Takes file after file, and gives the plan."""

    def __init__(self, options: Options, taken: set[str]) -> None:
        self.options, self.taken = options, taken
        self.files: list[ImportedFile] = []
        self.runs: list[PlannedRun] = []
        self.cut: list[ImportedCut] = []
        self.overviews: list[Overview] = []
        self.stems: list[str] = []
        self.notes: list[str] = []
        self.reversed: list[tuple[str, Mapped]] = []
        self.columns = options.columns

    def add(self, source: SourceFile) -> None:
        """Take a file."""
        settings: Settings = {}
        if self.options.pattern:
            found = self.options.pattern.settings(source.stem)
            if found is None:
                raise UserError(
                    f"{source.path}: its name doesn't follow --pattern {self.options.pattern.text!r}; expected one "
                    "that does, or a pattern that all names follow"
                )
            settings = found
        self.stems.append(source.stem)
        if len(source.tables) > 1 and not any(self._is_whole(table) for table in source.tables):
            joined = joined_rates(source.tables)
            if joined and self._is_whole(joined):
                source = replace(source, tables=(joined,))
        used = [one for one in (self._mapped(source, table) for table in source.tables) if one]
        if not used:
            table = max(source.tables, key=lambda one: len(one.channels))
            refuse_open_questions(_where(source, table), map_columns(table, self.columns))
        pieces = [
            (table, mapped, *_pieces(_where(source, table), table, mapped, self.options.rate)) for table, mapped in used
        ]
        single = sum(len(parts) for _, _, _, parts, _ in pieces) == 1
        for table, mapped, trace, parts, left in pieces:
            planned = [self._run(source, table, mapped, trace, part, settings, single) for part in parts]
            gone = [part for part, one in zip(parts, planned, strict=True) if isinstance(one, str)]
            reasons = [one for one in planned if isinstance(one, str)]
            left = [*left, *(replace(part, why=why) for part, why in zip(gone, reasons, strict=True))]
            kept = [(part, one) for part, one in zip(parts, planned, strict=True) if isinstance(one, PlannedRun)]
            self.runs += [one for _, one in kept]
            self.cut += [
                ImportedCut(file=source.name, table=table.name, samples=_samples(table, trace, part), why=part.why)
                for part in sorted(left, key=lambda part: part.first)
            ]
            self.overviews.append(_overview(source, table, trace, kept, left))
        self.files.append(
            ImportedFile(
                file=source.name,
                sha256=source.sha256,
                format=source.format,
                read_as="; ".join(used[0][0].told),
                columns={OURS.get(one.ours, one.ours): _imported(one) for one in used[0][1].columns},
            )
        )

    def _is_whole(self, table: RawTable) -> bool:
        """Tell whether a table has both displacement and force."""
        try:
            found = map_columns(table, self.columns)
        except UserError:
            return False
        open_yet = {one.ours for one in found.questions if not one.is_missing}
        return {"displacement", "force"} <= {one.ours for one in found.columns} | open_yet

    def _mapped(self, source: SourceFile, table: RawTable) -> tuple[RawTable, Mapped] | None:
        """Give a table with its channels known; None for one that holds no test, beside others that do."""
        several = len(source.tables) > 1
        try:
            mapped = map_columns(table, self.columns)
        except UserError:
            if several:
                return None
            raise
        if self.options.rate:
            mapped = replace(mapped, questions=tuple(one for one in mapped.questions if one.ours != "time"))
        if mapped.questions and several and not {"displacement", "force"} & {one.ours for one in mapped.columns}:
            return None
        if mapped.questions and self.options.ask:
            self.columns = (*self.columns, *self.options.ask(_where(source, table), mapped))
            mapped = map_columns(table, self.columns)
        refuse_open_questions(_where(source, table), mapped)
        for column in mapped.columns:
            if column.overrides:
                self._note(
                    f"{column.heading!r} is taken in {column.unit}, as --columns states, though the file says "
                    f"{column.overrides}"
                )
        return table, mapped

    def _note(self, words: str) -> None:
        if words not in self.notes:
            self.notes.append(words)

    def _run(
        self,
        source: SourceFile,
        table: RawTable,
        mapped: Mapped,
        trace: Trace,
        part: Part,
        settings: Settings,
        single: bool,
    ) -> PlannedRun | str:
        """Give a part as a run, or why it can't be one."""
        clean = mended(trace.record.part(part.first, part.last))
        repaired = evened(clean.record)
        done = [*trace.told, *clean.told, *repaired.told]
        try:
            record, cycles, words = _usable(repaired.record)
        except UnusableRecord as fault:
            return str(fault)
        done += words
        name = self._name(source.stem, single)
        further = {
            column: float(np.nanmean(values[part.first : part.last])) for column, values in trace.further.items()
        }
        measured: Settings = {column: _digits(_in_its_unit(mapped, column, value)) for column, value in further.items()}
        if record.temperature_C is not None:
            measured["temperature_C"] = round(float(np.mean(record.temperature_C)), 2)
            moved = float(np.ptp(record.temperature_C))
            if moved > STEADY_TEMPERATURE:
                self._note(f"run {name}: its temperature moves by {moved:.3g} K; its mean counts")
        sine: tuple[float, float] | None = None
        if cycles is None:
            measured["motion"] = "free"
        else:
            shown = fundamental_of(record, cycles)
            sine = (shown.amplitude_mm, cycles.frequency_Hz)
            measured |= {"amplitude_mm": _digits(sine[0]), "frequency_Hz": _digits(sine[1])}
            if reversed_sign(shown):
                self.reversed.append((name, mapped))
        row: dict[str, float | str | None] = dict(measured)
        stated = dict(settings) | settings_for(self.options.conditions, source.name, name)
        for column, value in stated.items():
            if column in ("amplitude_mm", "frequency_Hz") and not single and isinstance(value, float):
                own = measured.get(column)
                # a file with several runs has one name
                if isinstance(own, float) and abs(own - value) > STATED_APART * value:
                    continue
            if column in ("run", "file"):
                continue
            row[column] = value
        source_of = ImportedRun(
            run=name,
            file=source.name,
            table=table.name,
            samples=_samples(table, trace, part),
            measured=tuple(column for column in measured if column not in stated and column != "motion"),
            done=tuple(done),
        )
        return PlannedRun(row, record, source_of, sine)

    def _name(self, stem: str, single: bool) -> str:
        """Give a run's name: its file's, with a number where there are several."""
        candidates = _names(without_controls(stem) or "run", single)
        name = next(one for one in candidates if one not in self.taken)
        self.taken.add(name)
        return name

    def plan(self, again: tuple[str, ...]) -> Plan:
        """Give all that was taken.

        Raises:
            UserError: no run can be used, or the force of all has the wrong sign.
        """
        if self.files and not self.runs:
            reasons = "\n".join(
                f"  {one.file}, {one.samples[0]} to {one.samples[1]}: {one.why}" for one in self.cut[:10]
            )
            raise UserError(
                f"no run can be used, in {len(self.files)} files; expected loops of force and displacement\n{reasons}"
            )
        if self.runs and len(self.reversed) == len(self.runs):
            mapped = self.reversed[0][1]
            turned = [
                replace(one, conversion=replace(one.conversion, factor=-one.conversion.factor))
                if one.ours == "force"
                else one
                for one in mapped.columns
            ]
            raise UserError(
                "the force of all runs has the wrong sign: stiffness and dissipated energy are both negative; force is "
                f"what the rig applies, positive with positive displacement; expected it turned, for example\n  "
                f"{Mapped(tuple(turned)).option()}"
            )
        guess = "" if self.options.pattern or self.options.conditions else guessed_pattern(self.stems)
        return Plan(
            tuple(self.files), tuple(self.runs), tuple(self.cut), tuple(self.overviews), guess, tuple(self.notes), again
        )


def _names(stem: str, single: bool) -> Iterator[str]:
    if single:
        yield stem
    number = 1 if not single else 2
    while True:
        yield f"{stem}_{number:02d}"
        number += 1


def _where(source: SourceFile, table: RawTable) -> str:
    return f"{source.path}, {table.name}" if table.name else str(source.path)


def _pieces(where: str, table: RawTable, mapped: Mapped, rate: float | None) -> tuple[Trace, list[Part], list[Part]]:
    trace = trace_of(where, table, mapped.columns, rate)
    finite = np.isfinite(trace.motion)
    if np.count_nonzero(finite) < 2:
        return trace, [], [Part(0, len(finite), "no samples of displacement")]
    y = np.interp(np.arange(len(finite)), np.flatnonzero(finite), trace.motion[finite])
    cut = split(trace.record.time_s, y, trace.segment)
    return trace, list(cut.runs), list(cut.left)


def _usable(record: Record) -> tuple[Record, Cycles | None, list[str]]:
    """Give a record that can be used, its cycles (None for a free motion), and what was cut out of it.

    Raises:
        UnusableRecord: it can't be.
    """
    check_samples(record)
    words: list[str] = []
    try:
        cycles = find_cycles(record)
    except UnusableRecord:
        if not free_motion(record):
            raise
        return record, None, ["its motion is no sine: it is free"]
    try:
        check_clipping(record, cycles)
    except SensorFailure as failure:
        record, told = without_clipped_cycles(record, cycles, failure)
        words.append(told)
        cycles = find_cycles(record)
        check_clipping(record, cycles)
    return record, cycles, words


def _digits(value: float) -> float:
    """Give a measured setting with the digits that it has."""
    return float(f"{value:.4g}")


def _in_its_unit(mapped: Mapped, column: str, value: float) -> float:
    """Turn a further condition into the unit that its column's name states, where the channel has one, too."""
    source = next(one for one in mapped.columns if one.ours == column)
    quantity, _, target = column.rpartition("_")
    if not (quantity and source.unit and is_unit(target)):
        return value
    try:
        found = conversion(quantity, source.unit, target)
    except UserError as error:
        raise UserError(f"--columns, {column}={source.heading}: {error}") from error
    return found.factor * value + found.offset


def _imported(column: Column) -> ImportedColumn:
    return ImportedColumn(
        channel=column.heading,
        unit=column.unit,
        factor=column.conversion.factor,
        offset=column.conversion.offset,
        stated=column.stated,
    )


def _samples(table: RawTable, trace: Trace, part: Part) -> tuple[int, int]:
    """Give the first and the last sample of a part as the file counts them."""
    return (
        int(trace.places[part.first]) + table.first_row,
        int(trace.places[part.last - 1]) + table.first_row,
    )


def _overview(
    source: SourceFile, table: RawTable, trace: Trace, kept: Sequence[tuple[Part, PlannedRun]], left: Sequence[Part]
) -> Overview:
    time, y = trace.record.time_s, trace.motion
    edges = np.unique(np.linspace(0, len(y), min(WIDEST_OVERVIEW, len(y)) + 1).astype(np.intp))
    begins = edges[:-1]
    thinned: Array = np.stack([np.minimum.reduceat(y, begins), np.maximum.reduceat(y, begins)], axis=1)

    def span(part: Part) -> tuple[float, float]:
        return float(time[part.first]), float(time[part.last - 1])

    return Overview(
        title=f"{source.name}, {table.name}" if table.name else source.name,
        time=time[begins],
        displacement=thinned,
        runs=tuple((run.name, *span(part)) for part, run in kept),
        cut=tuple((part.why, *span(part)) for part in left),
    )
