"""A draft of a run gets its name and its row of runs.csv: what was measured, and what was stated of it."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeclamp_identification.campaign.description import ImportedRun
from pipeclamp_identification.campaign.plausibility import STATED_APART, reversed_sign
from pipeclamp_identification.campaign.seen import SeenSine
from pipeclamp_identification.importing.channels.columns import Mapped
from pipeclamp_identification.importing.conditions import Settings, is_free, name_in, settings_of
from pipeclamp_identification.importing.plan import PlannedRun
from pipeclamp_identification.importing.raw import Above
from pipeclamp_identification.importing.records.drafts import Draft, TakenTable, is_timed
from pipeclamp_identification.importing.stated import Options
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.units.stated import conversion, is_unit
from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.errors import UserError

STEADY_TEMPERATURE = 5.0
"""K by which a temperature may move within a run before that is said."""
UNTIMED_FREQUENCY = (
    "the frequency that is stated isn't used, for time was not measured; where it is known, state the samples per "
    "second in place of --rate none: those of a cycle times the frequency"
)
LONGEST_NAME = 60
"""Characters of a sheet's, group's or label's name that become part of a run's."""


@dataclass(frozen=True)
class Called:
    """What a draft is named by.

    Attributes:
        path: of its file.
        own: its label or, without one, the stem.
        stem: what its table's runs are named by.
        single: whether no other run is named by the same.
    """

    path: Path
    own: str
    stem: str
    single: bool

    def free_name(self, taken: Container[str]) -> str:
        """Give its own name, behind its table's where that is taken; with a number where there are several."""
        return next(one for one in self._names() if one not in taken)

    def _names(self) -> Iterator[str]:
        if self.single:
            yield self.own
            if self.own != self.stem:
                yield f"{self.stem}_{self.own}"
        number = 1 if not self.single else 2
        while True:
            yield f"{self.own}_{number:02d}"
            number += 1


@dataclass(frozen=True)
class NamedRun:
    """A run with its name and its row.

    Attributes:
        planned: as it will be.
        own: what it was named by.
        known_as: what it is called in the table of conditions; "" where that says nothing of it.
        above: what stands above its table of its temperature, where nothing else states one.
        mapped: channels of its table.
        reversed: whether its force has the wrong sign.
        notes: what to know of it.
    """

    planned: PlannedRun
    own: str
    known_as: str
    above: Above | None
    mapped: Mapped
    reversed: bool
    notes: tuple[str, ...]


def named_run(draft: Draft, table: TakenTable, called: Called, taken: Container[str], options: Options) -> NamedRun:
    """Give a draft its name and its row.

    Args:
        draft: the run.
        table: it is cut from.
        called: what it is named by.
        taken: names of other runs.
        options: what the user states.

    Raises:
        UserError: neither of its names follows the pattern, or a further condition has another unit than its column.
    """
    settings = settings_of(called.path, tuple(dict.fromkeys((called.own, called.stem))), options.pattern)
    name, file = called.free_name(taken), file_name(called.path)
    timed = is_timed(table.mapped.columns, options.timed)
    sine = (draft.seen.shown.amplitude_mm, draft.seen.cycles.frequency_Hz) if isinstance(draft.seen, SeenSine) else None
    known_as = name_in(options.conditions, (name, draft.label, called.own, file, Path(file).stem))
    stated = settings | options.conditions.get(known_as, {})
    # who calls a motion free that looks like a sine states neither amplitude nor frequency
    measured = _measured(draft, table.mapped, None if is_free(stated) else sine, timed=timed)
    row: dict[str, float | str | None] = {**table.stated, **measured}
    above = table.above if "temperature_C" not in row else None
    if above and above.temperature_C is not None:
        row["temperature_C"] = above.temperature_C
    row |= _counting(stated, measured, single=called.single, timed=timed)
    notes = []
    if draft.temperature and draft.temperature[1] > STEADY_TEMPERATURE:
        notes.append(f"run {name}: its temperature moves by {draft.temperature[1]:.3g} K; its mean counts")
    if "frequency_Hz" in stated and not timed:
        notes.append(UNTIMED_FREQUENCY)
    source = ImportedRun(
        run=name,
        file=file,
        table=table.name,
        samples=draft.samples,
        measured=tuple(column for column in measured if column not in stated and column != "motion"),
        done=draft.done,
    )
    return NamedRun(
        PlannedRun(row, draft.record, draft.seen, source, sine), called.own, known_as,
        above if "temperature_C" not in stated else None, table.mapped,
        isinstance(draft.seen, SeenSine) and bool(reversed_sign(draft.seen.shown)), tuple(notes),
    )  # fmt: skip


def name_part(text: str) -> str:
    """Give a text as a part of a run's name, which files may be called by."""
    return re.sub(r"[^\w.,+-]+", "_", text)[:LONGEST_NAME].strip("_.")


def _measured(draft: Draft, mapped: Mapped, sine: tuple[float, float] | None, *, timed: bool) -> Settings:
    """Give what was measured of a run, by column of runs.csv; `sine` is its amplitude (mm) and frequency (Hz)."""
    measured: Settings = {
        column: _digits(_in_its_unit(mapped, column, value))
        for column, value in draft.further.items()
        if not math.isnan(value)
    }
    if draft.temperature:
        measured["temperature_C"] = round(draft.temperature[0], 2)
    if draft.cycles_before:
        measured["first_cycle"] = _digits(draft.cycles_before)
    if sine is None:
        return measured | {"motion": "free"}
    measured["amplitude_mm"] = _digits(sine[0])
    return measured | ({"frequency_Hz": _digits(sine[1])} if timed else {})


def _counting(stated: Settings, measured: Settings, *, single: bool, timed: bool) -> Settings:
    """Give what counts of the settings that were stated of a run.

    A table with several runs has one name: an amplitude or frequency that it states is that of some of them.
    """

    def is_of_others(column: str) -> bool:
        value, found = stated[column], measured.get(column)
        if not (isinstance(value, float) and isinstance(found, float)):
            return False
        return abs(found - value) > STATED_APART * value

    out = {"run", "file"} | (set() if timed else {"frequency_Hz"})
    if not single:
        out |= {column for column in ("amplitude_mm", "frequency_Hz") if column in stated and is_of_others(column)}
    return {column: value for column, value in stated.items() if column not in out}


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
