"""Which channel of a file is what, and in which unit: by names and units, or as it was stated."""

from __future__ import annotations

import difflib
import itertools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from pipeclamp_identification.importing.channels.naming import SEGMENT, condition_name, is_measured, unit_of
from pipeclamp_identification.importing.channels.questions import NONE, Choice, Question, find
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.unusable import UnusableFileError
from pipeclamp_identification.units.stated import (
    OURS,
    QUANTITY_OF,
    Conversion,
    conversion,
    conversion_of_rate,
    unit_in_name,
)
from pipeclamp_models.base.errors import UsageError, UserError, did_you_mean
from pipeclamp_models.base.said import few_of
from pipeclamp_models.base.shell import quoted
from pipeclamp_models.base.units import unit_shown

OF_RUNS = ("run", "file", "motion")
"""Columns of runs.csv that no channel fills."""
OR_UNTIMED = "or --rate none where time was not measured, as in a quasi-static test"
ODD = re.compile(r"^[-#]|^none$|,\s*[A-Za-z_]\w*\s*=|,$", re.IGNORECASE)
"""Names of channels that would be read as something else."""
ALIKE = 0.75
"""Likeness of a condition's name to a quantity that is missing from which on it may be that, misspelled."""
LONGEST_OPTION = 250
"""Characters of an option that a message can hold whole."""
PLACE = re.compile(r"#(\d{1,6})(?:\s*\[(.+)\])?")
"""A channel by its place, and the unit that the file states of it."""
UNIT_BEHIND = re.compile(r"(.*\S)\s*\[([^\[\]]+)\]")
"""A channel, and the unit that is stated behind it."""
MOST_UNUSED = 4
"""Channels that aren't used, of which one line names so many."""


@dataclass(frozen=True)
class Column:
    """A channel that is one of ours.

    Attributes:
        ours: time, displacement, force, temperature, segment, or the name of a further condition.
        heading: the channel's name and unit, as the file has them.
        unit: that counts; "" where none is needed.
        conversion: into our unit.
        stated: whether the user said so, not names and units.
        overrides: the unit that the file states, where the user stated another one.
    """

    ours: str
    heading: str
    unit: str
    conversion: Conversion = field(default_factory=Conversion)
    stated: bool = False
    overrides: str = ""


@dataclass(frozen=True)
class Stated:
    """What --columns says of one quantity: the channel as it was named, and whether its sign turns."""

    ours: str
    channel: str
    reversed: bool = False


def parse_columns(text: str) -> tuple[Stated, ...]:
    """Read what --columns states: `time=Zeit [ms],force=-Last [kN],current_A=Strom`.

    Args:
        text: OURS=CHANNEL, separated by commas; a channel's name may hold commas and brackets.

    Raises:
        UsageError: an entry isn't so, or one of ours or a channel stands there twice.
    """
    entries = re.split(r",\s*(?=[A-Za-z_]\w*\s*=)", text.strip()) if text.strip() else []
    found: dict[str, Stated] = {}
    for entry in entries:
        ours, equals, channel = entry.partition("=")
        ours, channel = ours.strip(), channel.strip().rstrip(",").strip()
        if not equals or not re.fullmatch(r"[A-Za-z_]\w*", ours) or not channel:
            raise UsageError(f"--columns: got {entry!r}; expected OURS=CHANNEL, for example 'force=Last [kN]'")
        ours = QUANTITY_OF.get(ours, ours)
        if ours in ("displacement", "force") and channel.casefold() == NONE:
            raise UsageError(f"--columns: got {entry!r}; expected a channel: a loop has displacement and force")
        if ours in OF_RUNS:
            raise UsageError(
                f"--columns: got {entry!r}; expected one of {', '.join(OURS)}, {SEGMENT}, or a further condition: "
                f"{ours} is what an import gives each run"
            )
        if ours in found:
            raise UsageError(f"--columns: {ours} stands there twice; expected it once")
        sign = channel.startswith("-") and len(channel) > 1
        found[ours] = Stated(ours, channel[1:].strip() if sign else channel, sign)
    channels = [one.channel for one in found.values() if one.channel.casefold() != NONE]
    for channel in channels:
        if channels.count(channel) > 1:
            raise UsageError(f"--columns: channel {channel!r} stands there twice; expected each for one quantity")
    return tuple(found.values())


class ContradictedUnitError(UserError):
    """A unit was stated, and a file states another one: it isn't the file that can't serve."""


class OpenChannelsError(UserError):
    """A table has all that it needs, but names and units don't tell it: it must not be left out for a unit.

    Attributes:
        where: the table.
        mapped: what is told, and what is open.
        words: what is open, and the option that would state it.
    """

    def __init__(self, where: str, mapped: Mapped, words: str) -> None:
        super().__init__(f"{where}: {words}")
        self.where, self.mapped, self.words = where, mapped, words

    def __reduce__(self) -> tuple[type[OpenChannelsError], tuple[str, Mapped, str]]:
        """Let it come out of another process."""
        return OpenChannelsError, (self.where, self.mapped, self.words)


@dataclass(frozen=True)
class Mapped:
    """Which channels of a table are ours, and what is still to be asked; `units` of all its channels, by heading."""

    columns: tuple[Column, ...]
    questions: tuple[Question, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)

    def option(self) -> str:
        """Give --columns as it would state these, with the first choice for what is open that no other one takes."""
        entries = [(_entry(column), column.heading) for column in self.columns]
        entries += [(choice.text, choice.channel) for choice in self._chosen() if choice]
        return self.option_of(entries)

    def as_others(self, units: Mapping[str, str]) -> Mapped:
        """Give the same, with the unit first that other files state of a channel, by its name without a unit."""
        return replace(self, questions=tuple(one.as_others(units) for one in self.questions))

    def option_of(self, entries: Sequence[tuple[str, str]]) -> str:
        """Give --columns with entries, each with its channel's heading; places stand for names that are too long."""
        option = columns_option(
            [self._by_place(text, heading) if ODD.search(heading) else text for text, heading in entries]
        )
        if len(option) <= LONGEST_OPTION:
            return option
        return columns_option([self._by_place(*entry) for entry in entries])

    def _by_place(self, text: str, heading: str) -> str:
        if heading not in self.units:
            return text
        before, _, behind = text.partition(heading)
        own = f" [{self.units[heading]}]" if behind and self.units[heading] else ""
        return f"{before}#{list(self.units).index(heading) + 1}{own}{behind}"

    def is_answerable(self) -> bool:
        """Tell whether the option would state all that is open, but for a time that no channel is."""
        open_yet = zip(self.questions, self._chosen(), strict=True)
        return all(choice or question in self.without_time for question, choice in open_yet)

    @property
    def without_time(self) -> tuple[Question, ...]:
        """The question for the time, where no channel may be it: samples per second answer it."""
        return tuple(one for one in self.questions if one.ours == "time" and not one.choices)

    def _chosen(self) -> list[Choice | None]:
        """Give a choice for each question, of another channel each; None where there is none left."""
        taken = {column.heading for column in self.columns}
        chosen: dict[str, Choice | None] = {}
        # what has the fewest channels to choose from goes first, lest another one take its only one
        for question in sorted(self.questions, key=lambda one: len({choice.channel for choice in one.choices})):
            choice = next((one for one in question.choices if one.channel not in taken), None)
            taken |= {choice.channel} - {""} if choice else set()
            chosen[question.ours] = choice
        return [chosen[question.ours] for question in self.questions]


def unused_words(files: Sequence[str], headings: Sequence[str], mapped: Mapped) -> str:
    """Say which channels of files aren't used, and how one that is measured becomes a condition.

    Args:
        files: their names, at least one.
        headings: of these channels, at least one.
        mapped: those that are used.
    """
    words = f"{few_of(files, most=1)}: not used: {few_of([*map(repr, headings)], most=MOST_UNUSED)}"
    likely = next((one for one in headings if is_measured(one)), None)
    if likely is None:
        return words
    stated = [(_entry(column), column.heading) for column in mapped.columns if column.stated]
    return f"{words}; to keep one as a condition, its mean over each run: " + mapped.option_of(
        [*stated, (f"{condition_name(likely)}={likely}", likely)]
    )


def columns_option(entries: Sequence[str]) -> str:
    """Give --columns with these entries, as a shell takes it."""
    return f"--columns {quoted(','.join(entries), always=True)}"


def _entry(column: Column) -> str:
    """Give a column as --columns states it."""
    return f"{column.ours}={'-' if column.conversion.factor < 0 else ''}{_stated_heading(column)}"


def _stated_heading(column: Column) -> str:
    if column.overrides or (column.unit and not unit_in_name(column.heading)[1]):
        return f"{column.heading} [{column.unit}]"
    return column.heading


def map_columns(table: RawTable, stated: Sequence[Stated] = ()) -> Mapped:
    """Find which channels of a table are ours.

    Args:
        table: as a file holds it.
        stated: what the user says; it counts before what names tell.

    Raises:
        UserError: a stated channel isn't there, or its unit is none of that quantity, or contradicts the file's.
    """
    said = {one.ours: one for one in stated}
    columns = [_stated_column(table, one) for one in stated if one.channel.casefold() != NONE]
    as_stated = {column.heading: column.ours for column in columns}
    taken = set(as_stated)
    headings = [column.heading for column in columns]
    for heading in headings:
        if headings.count(heading) > 1:
            raise UserError(f"--columns: channel {heading!r} stands there twice; expected each for one quantity")
    questions = []
    for quantity in (*OURS, SEGMENT):
        if quantity in said:
            continue
        found = find(quantity, table, taken, as_stated)
        if found is None and quantity == SEGMENT:
            found = find(quantity, replace(table, channels=table.labels), taken, as_stated)
        if isinstance(found, Question):
            questions.append(found)
        elif found is not None:
            unit = "" if quantity == SEGMENT else unit_of(found)
            columns.append(Column(quantity, found.heading, unit, conversion(quantity, unit) if unit else Conversion()))
            taken.add(found.heading)
    order = [*OURS, SEGMENT]
    columns.sort(key=lambda column: order.index(column.ours) if column.ours in order else len(order))
    return Mapped(tuple(columns), tuple(questions), {one.heading: unit_of(one) for one in table.channels})


def _stated_column(table: RawTable, stated: Stated) -> Column:
    channel, unit = channel_named(table, stated)
    own = unit_of(channel)
    counts = unit or own
    overrides = own if unit and own and unit != own else ""
    if stated.ours in OURS:
        if not counts:
            raise UserError(
                f"--columns: no unit is stated of {channel.heading!r}, neither in the file nor in the option; expected "
                f"for example '{stated.ours}={channel.heading} [{unit_shown(OURS[stated.ours])}]'"
            )
        rate = conversion_of_rate(counts) if stated.ours == "displacement" else None
        try:
            found = rate or conversion(stated.ours, counts)
        except UserError as error:
            raise UserError(f"--columns, {stated.ours}={stated.channel}: {error}") from error
    else:
        found = Conversion()
    sign = -1.0 if stated.reversed else 1.0
    turned = replace(found, factor=sign * found.factor, offset=sign * found.offset)
    return Column(stated.ours, channel.heading, counts, turned, True, overrides)


@dataclass(frozen=True)
class _Called:
    """Channels of a name, and whether that holds the unit that the file states of them."""

    channels: Sequence[Channel] = ()
    with_own_unit: bool = False


def channel_named(table: RawTable, stated: Stated) -> tuple[Channel, str]:
    """Find a channel by its heading, its name, or either with a unit in brackets behind it, or by its place.

    Returns:
        the channel, and the unit that is stated behind it; "" for none.

    Raises:
        UserError: there is none, or there are several.
        ContradictedUnitError: the file states another unit.
    """
    if stated.ours == SEGMENT:
        # names of runs serve as well as their numbers
        table = replace(table, channels=(*table.channels, *table.labels))
    name, unit = _one_blank(stated.channel), ""
    found = _called(table, name)
    if not found.channels and (parts := UNIT_BEHIND.fullmatch(name)):
        name, unit = parts[1], parts[2].strip()
        found = _called(table, name)
    if not found.channels:
        found = _at_place(table, name) if PLACE.fullmatch(name) else _called_in(table, name)
    channel = _only_one(table, stated, name, found.channels)
    own = unit_of(channel)
    if unit and own and unit != own and not found.with_own_unit:
        raise ContradictedUnitError(
            f"--columns: got {stated.channel!r} (for {stated.ours}), but the file says {channel.heading!r}; "
            f"expected its own unit, or {channel.heading} [{unit}] where the file is wrong"
        )
    return channel, unit


def _one_blank(text: str) -> str:
    """Give a text with one blank where there are several."""
    return " ".join(text.split())


def channels_called(table: RawTable, name: str) -> Sequence[Channel]:
    """Give the channels that a name alone tells, with or without the unit that the file states."""
    return _called(table, _one_blank(name)).channels


def _called(table: RawTable, name: str) -> _Called:
    """Give the channels whose heading a name is, else those whose name it is, with a unit in it or without."""
    exact = [channel for channel in table.channels if _one_blank(channel.heading) == name]
    if exact:
        return _Called(exact, with_own_unit=True)
    return _Called(
        [one for one in table.channels if name in (_one_blank(one.name), _one_blank(unit_in_name(one.name)[0]))]
    )


def _called_in(table: RawTable, name: str) -> _Called:
    """Give the channels of which the file states no unit, and whose unit the user says before the one that counts."""
    parts = UNIT_BEHIND.fullmatch(name)
    return _Called([one for one in _called(table, parts[1]).channels if not unit_of(one)] if parts else [])


def _at_place(table: RawTable, name: str) -> _Called:
    """Give the channel whose place a name is (`#3`); its own unit stands before the one that counts."""
    number = PLACE.fullmatch(name)
    if not number or not 0 < int(number[1]) <= len(table.channels):
        return _Called()
    channel = table.channels[int(number[1]) - 1]
    return _Called([channel], with_own_unit=bool(number[2]) and number[2] == unit_of(channel))


def _only_one(table: RawTable, stated: Stated, name: str, channels: Sequence[Channel]) -> Channel:
    """Give the one channel that is called so.

    Raises:
        UserError: there is none, it holds texts, or there are several.
    """
    text = next((one for one in table.unread if one.is_whole and name in (one.name, one.channel.heading)), None)
    if not channels and text:
        raise UserError(f"--columns: {text.words()}; expected numbers (for {stated.ours})")
    if not channels:
        headings = [channel.heading for channel in table.channels]
        raise UserError(
            f"--columns: there is no channel {stated.channel!r} (for {stated.ours}); {did_you_mean(name, headings)}"
            f"there are {few_of([*map(repr, headings)])}"
        )
    if len(channels) > 1:
        raise UserError(
            f"--columns: {len(channels)} channels are called {stated.channel!r} (for {stated.ours}): "
            f"{few_of([repr(channel.heading) for channel in channels])}; expected one of them, whole, or by its place "
            f"(#{table.channels.index(channels[0]) + 1})"
        )
    return channels[0]


def refuse_open_questions(where: str, mapped: Mapped) -> None:
    """Refuse a table of which names and units don't tell all that is needed.

    Raises:
        UnusableFileError: a channel seems to be missing; as the next,
        OpenChannelsError: with the ready option that states the first of each choice.
    """
    if not mapped.questions:
        return
    problems = "; ".join(question.why for question in mapped.questions)
    own = [column.ours for column in mapped.columns if column.ours not in (*OURS, SEGMENT)]
    for question in mapped.questions:
        if question.is_missing and (near := difflib.get_close_matches(question.ours, own, n=1, cutoff=ALIKE)):
            problems += f" (--columns states {near[0]!r}: did you mean {question.ours!r}?)"
    rate = " --rate 1000" if mapped.without_time else ""
    if rate and len(mapped.questions) == 1:
        raise UnusableFileError(
            where,
            problems,
            f"; expected its samples per second, for example{rate}, or the channel that is it; {OR_UNTIMED}",
        )
    if not mapped.is_answerable():
        there = few_of([repr(heading) for heading in mapped.units])
        raise UnusableFileError(
            where,
            problems,
            f"\n  there are {there}"
            "\n  expected a channel of numbers for time, displacement and force; where one is, but its name or unit "
            "says something else, --columns OURS=CHANNEL states it (see --help)",
        )
    option = mapped.option()
    lines = ["; expected it to be stated, for example (check it):", f"  {option}{rate}"]
    for question in mapped.questions:
        if len(question.choices) > 1:
            lines.append(f"  {question.ours}: {few_of(_short([one.text for one in question.choices]), between=' or ')}")
        if question.ours == "time" and question.is_missing and question.choices:
            lines.append(f"  or --rate 1000, samples per second, where no channel is the time; {OR_UNTIMED}")
    if rate:
        lines.append(f"  --rate: samples per second, for no channel is the time; {OR_UNTIMED}")
    if re.search(r" \[1 [^\]]+\]", option):
        lines.append("  [1 N], [1 mm]: of what one of the channel's own unit is; put its number there")
    remedy = "\n".join(lines)
    if any(question.is_missing for question in mapped.questions):
        raise UnusableFileError(where, problems, remedy)
    raise OpenChannelsError(where, mapped, f"{problems}{remedy}")


def _short(texts: Sequence[str]) -> Sequence[str]:
    """Give the first texts, as many as a line holds, at least two."""
    lengths = list(itertools.accumulate(len(text) + 4 for text in texts))
    count = max(2, sum(length <= LONGEST_OPTION for length in lengths))
    return texts if count >= len(texts) else [*texts[:count], f"{len(texts) - count} more"]
