"""Which channel of a file is what, and in which unit: by names and units, or as it was stated."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.units.stated import (
    OURS,
    QUANTITY_OF,
    Conversion,
    Quantity,
    conversion,
    quantity_of_unit,
    unit_in_name,
)
from pipeclamp_models.base.errors import UsageError, UserError, did_you_mean

NEEDED = ("time", "displacement", "force")
NONE = "none"
"""States that a quantity isn't there."""
SEGMENT = "segment"
"""A channel that tells one run of a file from the next."""

WORDS: Mapping[Quantity, tuple[str, ...]] = {
    "time": ("time", "timestamp", "zeit", "zeitstempel", "uhrzeit", "temps", "tempo", "tiempo", "elapsed", "t"),
    "displacement": (
        "displacement", "displ", "disp", "stroke", "travel", "position", "pos", "lvdt", "deflection", "extension",
        "crosshead", "weg", "kolbenweg", "hub", "verschiebung", "auslenkung", "traverse", "deplacement", "course",
        "spostamento", "corsa", "desplazamiento", "y",
    ),
    "force": (
        "force", "load", "loadcell", "kraft", "last", "kraftmessdose", "effort", "forza", "carico", "fuerza", "f",
    ),
    "temperature": ("temperature", "temperatur", "temp", "thermocouple", "thermoelement", "temperatura", "tc", "t"),
    SEGMENT: ("segment", "block", "sequence", "sequenz", "abschnitt", "schritt", "teilversuch", "step", "run", "lauf"),
}  # fmt: skip
"""Words that name a quantity, folded; a compound may end with one that is long enough (Kolbenweg, Axialkraft)."""
ENDINGS = 3
"""Letters from which on a compound's last word counts."""
OTHERS = frozenset(
    (
        *("command", "cmd", "setpoint", "soll", "sollwert", "target", "demand", "reference", "fuehrung"),
        *("error", "abweichung", "velocity", "speed", "geschwindigkeit", "rate", "accel", "acceleration"),
        *("beschleunigung", "peak", "valley", "max", "maximum", "min", "minimum", "mean", "mittelwert", "strain"),
        *("dehnung", "stress", "spannung", "pressure", "druck", "limit", "date", "datum", "bewegung", "energy"),
    )
)
"""Words of what is derived from a channel, asked of the machine, or something else."""
LETTERS = 1
"""Words of so few letters count only beside a unit."""


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
        if ours in found:
            raise UsageError(f"--columns: {ours} stands there twice; expected it once")
        sign = channel.startswith("-") and len(channel) > 1
        found[ours] = Stated(ours, channel[1:].strip() if sign else channel, sign)
    channels = [one.channel for one in found.values() if one.channel.casefold() != NONE]
    for channel in channels:
        if channels.count(channel) > 1:
            raise UsageError(f"--columns: channel {channel!r} stands there twice; expected each for one quantity")
    return tuple(found.values())


@dataclass(frozen=True)
class Question:
    """What names and units don't tell: of which quantity, why, and the entries of --columns that would.

    `is_missing`: nothing in the table looks like it.
    """

    ours: str
    why: str
    choices: tuple[str, ...]
    is_missing: bool = False


@dataclass(frozen=True)
class Mapped:
    """Which channels of a table are ours, and what is still to be asked."""

    columns: tuple[Column, ...]
    questions: tuple[Question, ...] = ()

    def option(self) -> str:
        """Give --columns as it would state these, with the first choice for what is open."""
        entries = [f"{column.ours}={_turned(column)}{_stated_heading(column)}" for column in self.columns]
        entries += [question.choices[0] for question in self.questions if question.choices]
        return f'--columns "{",".join(entries)}"'


def _turned(column: Column) -> str:
    return "-" if column.conversion.factor < 0 else ""


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
    taken = {column.heading for column in columns}
    headings = [column.heading for column in columns]
    for heading in headings:
        if headings.count(heading) > 1:
            raise UserError(f"--columns: channel {heading!r} stands there twice; expected each for one quantity")
    questions = []
    for quantity in (*OURS, SEGMENT):
        if quantity in said:
            continue
        found, question = _find(quantity, [one for one in table.channels if one.heading not in taken])
        if found:
            columns.append(found)
            taken.add(found.heading)
        elif question:
            questions.append(question)
    order = [*OURS, SEGMENT]
    columns.sort(key=lambda column: order.index(column.ours) if column.ours in order else len(order))
    return Mapped(tuple(columns), tuple(questions))


def _stated_column(table: RawTable, stated: Stated) -> Column:
    channel, unit = _channel_named(table, stated)
    own = _unit_of(channel)
    counts = unit or own
    overrides = own if unit and own and unit != own else ""
    if stated.ours in OURS:
        if not counts:
            raise UserError(
                f"--columns: no unit is stated of {channel.heading!r}, neither in the file nor in the option; expected "
                f"for example '{stated.ours}={channel.heading} [{OURS[stated.ours].replace('degC', '°C')}]'"
            )
        try:
            found = conversion(stated.ours, counts)
        except UserError as error:
            raise UserError(f"--columns, {stated.ours}={stated.channel}: {error}") from error
    else:
        found = Conversion()
    sign = -1.0 if stated.reversed else 1.0
    return Column(
        stated.ours, channel.heading, counts, Conversion(sign * found.factor, sign * found.offset), True, overrides
    )


def _channel_named(table: RawTable, stated: Stated) -> tuple[Channel, str]:
    """Find a channel by its heading, its name, or either with a unit in brackets behind it."""
    name = " ".join(stated.channel.split())

    def called(channel: Channel) -> set[str]:
        return {" ".join(text.split()) for text in (channel.heading, channel.name, unit_in_name(channel.name)[0])}

    exact = [channel for channel in table.channels if " ".join(channel.heading.split()) == name]
    matches = exact or [channel for channel in table.channels if name in called(channel)]
    unit = ""
    if not matches and (parts := re.fullmatch(r"(.*\S)\s*\[([^\[\]]+)\]", name)):
        name, unit = parts[1], parts[2].strip()
        exact = [channel for channel in table.channels if " ".join(channel.heading.split()) == name]
        matches = exact or [channel for channel in table.channels if name in called(channel)]
    if not matches and (number := re.fullmatch(r"#(\d+)", name)) and 0 < int(number[1]) <= len(table.channels):
        matches = [table.channels[int(number[1]) - 1]]
    headings = [channel.heading for channel in table.channels]
    if not matches:
        raise UserError(
            f"--columns: there is no channel {stated.channel!r} (for {stated.ours}); {did_you_mean(name, headings)}"
            f"there are {', '.join(map(repr, headings))}"
        )
    if len(matches) > 1:
        raise UserError(
            f"--columns: {len(matches)} channels are called {stated.channel!r} (for {stated.ours}): "
            f"{', '.join(repr(channel.heading) for channel in matches)}; expected one of them, whole, or by its place "
            f"(#{table.channels.index(matches[0]) + 1})"
        )
    if unit and (own := _unit_of(matches[0])) and exact == [] and unit != own:
        raise UserError(
            f"--columns: got {stated.channel!r} (for {stated.ours}), but the file says {matches[0].heading!r}; "
            f"expected its own unit, or {matches[0].heading} [{unit}] where the file is wrong"
        )
    return matches[0], unit


def _unit_of(channel: Channel) -> str:
    """Give the unit that a file states of a channel: beside its name, or in it."""
    return channel.unit or unit_in_name(channel.name)[1]


def _find(quantity: Quantity, channels: Sequence[Channel]) -> tuple[Column | None, Question | None]:
    """Find the channel of a quantity; a question where several may be it, or its unit isn't stated."""
    ranked: dict[int, list[Channel]] = {}
    for channel in channels:
        if rank := _rank(quantity, channel):
            ranked.setdefault(rank, []).append(channel)
    if not ranked:
        if quantity not in NEEDED:
            return None, None
        choices = tuple(f"{quantity}={channel.heading}" for channel in channels)
        return None, Question(
            quantity, f"no channel is called a {quantity} or is in a unit of one", choices, is_missing=True
        )
    best = ranked[max(ranked)]
    if len(best) > 1:
        if quantity == SEGMENT:
            return None, None
        choices = (
            *(f"{quantity}={_with_unit(quantity, channel)}" for channel in best),
            *(() if quantity in NEEDED else (f"{quantity}={NONE}",)),
        )
        names = ", ".join(repr(channel.heading) for channel in best)
        return None, Question(quantity, f"{len(best)} channels may be the {quantity}: {names}", choices)
    (channel,) = best
    if quantity == SEGMENT:
        return Column(SEGMENT, channel.heading, ""), None
    unit = _unit_of(channel)
    if not unit:
        units = {"time": ("s", "ms"), "displacement": ("mm", "m"), "force": ("N", "kN"), "temperature": ("°C", "K")}
        choices = tuple(f"{quantity}={channel.heading} [{one}]" for one in units[quantity])
        return None, Question(quantity, f"no unit is stated of {channel.heading!r}", choices)
    return Column(quantity, channel.heading, unit, conversion(quantity, unit)), None


def _with_unit(quantity: Quantity, channel: Channel) -> str:
    return channel.heading if _unit_of(channel) else f"{channel.heading} [{OURS[quantity].replace('degC', '°C')}]"


def _rank(quantity: Quantity, channel: Channel) -> int:
    """Give how well a channel's name and unit fit a quantity: 0 not at all, 4 our own name."""
    unit = _unit_of(channel)
    name = unit_in_name(channel.name)[0] if not channel.unit else channel.name
    if QUANTITY_OF.get(channel.name) == quantity:
        return 4
    words = _words(name)
    if any(word in OTHERS or word.endswith(("geschwindigkeit", "beschleunigung")) for word in words):
        return 0
    of_unit = _fits_unit(quantity, unit)
    if unit and not of_unit:
        return 0
    if _is_named(quantity, words, beside_unit=bool(unit)):
        # a name and a unit: sure; a name alone: its unit must be asked
        return 3 if unit or quantity == SEGMENT else 2
    if unit and quantity != SEGMENT and not any(_is_named(other, words, True) for other in WORDS if other != quantity):
        return 1
    return 0


def _fits_unit(quantity: Quantity, unit: str) -> bool:
    if quantity == SEGMENT:
        return unit in ("", "-", "1")
    if not unit:
        return False
    if quantity_of_unit(unit) == quantity:
        return True
    try:
        conversion(quantity, unit)
    except UserError:
        return False
    return True


def _is_named(quantity: Quantity, words: Sequence[str], beside_unit: bool) -> bool:
    for known in WORDS[quantity]:
        for word in words:
            if len(known) <= LETTERS and not beside_unit:
                continue
            if word == known or (len(known) >= ENDINGS and len(word) > len(known) and word.endswith(known)):
                return True
    return False


def _words(name: str) -> list[str]:
    """Give a name's words, folded: no capitals, accents or digits."""
    text = name.replace("ß", "ss").replace("ü", "ue").replace("ä", "ae").replace("ö", "oe")
    plain = unicodedata.normalize("NFKD", re.sub(r"([a-z])([A-Z])", r"\1 \2", text))
    return re.findall(r"[a-z]+", "".join(one for one in plain if not unicodedata.combining(one)).casefold())


def refuse_open_questions(where: str, mapped: Mapped) -> None:
    """Refuse a table of which names and units don't tell all that is needed.

    Raises:
        UserError: with the ready option that states the first of each choice.
    """
    if not mapped.questions:
        return
    problems = [f"{question.why}" for question in mapped.questions]
    choices = [
        f"  {question.ours}: {' or '.join(question.choices)}"
        for question in mapped.questions
        if len(question.choices) > 1
    ]
    raise UserError(
        "\n".join(
            [
                f"{where}: {'; '.join(problems)}; expected it to be stated, for example (check it):",
                f"  {mapped.option()}",
                *choices,
            ]
        )
    )
