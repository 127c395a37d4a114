"""What stands above a table: "Prüftemperatur;23;°C", whether it is that of the test, by its name; other numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pipeclamp_identification.importing.channels.naming import ENDINGS, OTHERS, WORDS, words_of
from pipeclamp_identification.importing.raw import Above
from pipeclamp_identification.units.stated import conversion, quantity_of_unit, unit_in_name
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.range import rounded

STATEMENT = re.compile(
    r"(?P<name>(?:[^\d:=]+ : )?[^\d:=]*[^\W\d_][^\d:=]*?(?<=[\w\])}.%°]))\s*[:=]?\s*"
    r"(?P<number>[-+\N{MINUS SIGN}]?\d+(?:[.,]\d+)?)\s*"
    r"(?:(?:±|\+/?-)\s*\d+(?:[.,]\d+)?\s*)?(?P<unit>[^\d\s].*)?"
)
"""A name, that of a group before it perhaps ("Environment : Temperature"); a number, its tolerance, and a unit."""
LONGEST, LONGEST_WORD = 120, 40
"""Characters of a line that may state one, and of a word in it."""
LETTER = "t"
ASKED = frozenset(("setpoint", "soll", "sollwert", "target"))
"""Words of what the machine is asked for, as an oven is for the temperature of a test."""
OF_THE_TEST = re.compile(
    r"(?:pruef|test|versuch|proben?|specimen|sample|koerper|bauteil|teil|kammer|chamber|ofen|oven|furnace|klima|"
    r"schrank|cabinet|solln?|wert|set|point|target|nominal|nenn|essai|eprouvette|enceinte|four|prova|provino|camera|forno|"
    r"ensayo|probeta|camara|horno|actual|ist|during|of|the|at|for|der|des|die|im|in|du|de|del|della|di|d|l|s|n)*"
)
"""What may stand beside the word for temperature, or before it in a compound, where it is that of the test."""


@dataclass(frozen=True)
class _Statement:
    """A temperature in °C, None where its unit isn't stated; whether it is that of the test; and the line."""

    value: float | None
    is_of_test: bool
    line: str


@dataclass(frozen=True)
class _Number:
    """A number as a line states it, with its name, its unit ("" for none), and the line."""

    name: str
    number: str
    unit: str
    line: str


def temperature_above(rows: Iterable[Sequence[str]]) -> Above | None:
    """Give what rows above a table state of the test's temperature; None where they don't.

    Args:
        rows: of cells, or of a whole line each.
    """
    found = [one for row in rows if (one := _statement(row))]
    sure = [one for one in found if one.is_of_test and one.value is not None]
    if len({one.value for one in sure}) == 1:
        return Above(sure[0].value, f"temperature {sure[0].value:g} °C, as {sure[0].line!r} above the table states")
    if sure:
        lines = " and ".join(dict.fromkeys(repr(one.line) for one in sure))
        return Above(None, f"no temperature taken from above the table, where {lines} don't agree")
    if found:
        why = "states no unit" if found[0].is_of_test else "may be another than the test's"
        return Above(None, f"no temperature taken from above the table, where {found[0].line!r} {why}")
    return None


def numbers_above(rows: Iterable[Sequence[str]]) -> dict[str, str]:
    """Give numbers with a unit that rows above a table state, by name and unit, "Schraubenmoment [Nm]".

    Args:
        rows: of cells, or of a whole line each.
    """
    found = [_number(row) for row in rows]
    return {f"{one.name} [{one.unit}]": one.number for one in found if one and one.unit}


def _number(row: Sequence[str]) -> _Number | None:
    # a header's cells may be parted otherwise than the table's
    text = " ".join(re.split(r"[;\t|\s]+", " ".join(row).strip("#%!*;,|\t ")))
    if len(text) > LONGEST or not (found := STATEMENT.fullmatch(text)):
        return None
    name, own = unit_in_name(found["name"].rstrip(". "))
    return _Number(name, found["number"], (found["unit"] or own).strip("[]()<>; "), text)


def _statement(row: Sequence[str]) -> _Statement | None:
    if not (found := _number(row)):
        return None
    stated, text = found.unit, found.line
    words = words_of(found.name)
    if not _is_temperature(words, stated) or not OTHERS.isdisjoint(set(words) - ASKED):
        return None
    others = [other for other in map(_beside, words) if other]
    is_of_test = all(len(other) <= LONGEST_WORD and OF_THE_TEST.fullmatch(other) for other in others)
    if not stated:
        return _Statement(None, True, text) if is_of_test else None
    if quantity_of_unit(stated) != "temperature":
        return None
    turned = conversion("temperature", stated)
    number = float(found.number.replace(",", ".").replace("\N{MINUS SIGN}", "-"))
    value = rounded(turned.factor * number + turned.offset)
    return _Statement(value, is_of_test, text) if -CELSIUS < value < math.inf else None


def _is_temperature(words: Sequence[str], unit: str) -> bool:
    """Tell whether words name a temperature: one letter does only beside a unit that is nothing else."""
    return any(_beside(word) != word for word in words if word != LETTER) or (words == [LETTER] and len(unit) > 1)


def _beside(word: str) -> str:
    """Give what of a word isn't the one for temperature."""
    for known in sorted(WORDS["temperature"], key=len, reverse=True):
        if len(known) >= ENDINGS and word.endswith(known):
            return word.removesuffix(known)
    return "" if word == LETTER else word
