"""What was set in a run, from names of files by a pattern, or from a table."""

from __future__ import annotations

import csv
import io
import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from pipeclamp_identification.campaign.runs_table import NUMBER_COLUMNS, meant_column
from pipeclamp_identification.importing.channels.naming import names_specimen, setting_called
from pipeclamp_identification.importing.raw import Damaged, without_controls
from pipeclamp_identification.importing.texts.above import numbers_above, temperature_above
from pipeclamp_identification.importing.texts.decoding import decoded
from pipeclamp_identification.units.stated import SETTINGS, Conversion, conversion, further_quantity, unit_in_name
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.range import rounded

Settings = dict[str, float | str]
"""Columns of runs.csv and what they hold."""

NOT_SHOWN = {"temperature": -CELSIUS, "density": 0.0}
"""Settings that no record's motion shows, and what they exceed: a file's word on them is taken. "Frequency" may be that
of sampling."""
LONGEST_SPECIMEN = 60
"""Characters of a specimen's name; what is longer is a remark."""
NUMBER = r"[-+]?\d+(?:[.,p]\d+)?"
"""A number in a file's name: 0.5, 0,5 or, where points aren't wanted, 0p5."""
FIELD = re.compile(r"\{([A-Za-z_]\w*)\}")
TEXTS = ("specimen", "run")
GUESSED = {
    "mm": "amplitude_mm", "um": "amplitude_um", "hz": "frequency_Hz", "c": "temperature_C", "degc": "temperature_C",
    "k": "temperature_K", "grad": "temperature_C",
}  # fmt: skip
"""Units behind numbers in names of files, and what was set in them."""
SMALL = ("c", "k")
"""Units in letters that stand for other things, too (2c for two cycles): they count where the number varies."""
LETTERS = {
    "a": "amplitude_mm", "amp": "amplitude_mm", "f": "frequency_Hz", "freq": "frequency_Hz", "t": "temperature_C",
    "temp": "temperature_C",
}  # fmt: skip
"""Letters before numbers in names of files."""
UNIT = re.compile(r"[ _]?(degC|[A-Za-z]+)")
"""What may be the unit of the number before it."""
BEGINS_A_NUMBER = re.compile(r"[ _]+[A-Za-z]+")
"""What stands between two numbers and belongs to the second: the A of 01_A0.5 is no unit of 01."""


class Pattern:
    """How the names of files state what was set: "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}".

    A field's unit is in its name: {temperature_K} and {amplitude_um} are turned into ours. {specimen} is a text, and so
    is any field without a known unit whose text is no number. The pattern may stand anywhere in the name.
    """

    def __init__(self, text: str) -> None:
        fields = FIELD.findall(text)
        if not fields:
            raise UsageError(f"--pattern: got {text!r}; expected fields in braces, for example 'A{{amplitude_mm}}_f'")
        for field in fields:
            if fields.count(field) > 1:
                raise UsageError(f"--pattern: field {field!r} stands there twice; expected it once")
        self.text = text
        self.fields = tuple(fields)
        self.columns = {field: _column_of(field) for field in fields}
        names = [column for column, _, _ in self.columns.values()]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f"--pattern: two fields state {name}; expected one")
        parts = FIELD.split(text)
        expression = "".join(
            re.escape(part) if place % 2 == 0 else f"(?P<{part}>{self._expression(part)})"
            for place, part in enumerate(parts)
        )
        self._expression_of_name = re.compile(expression)

    def _expression(self, field: str) -> str:
        if field in TEXTS:
            return r"[^_\s]+"
        column, _, _ = self.columns[field]
        if column not in NUMBER_COLUMNS:
            return rf"{NUMBER}|[^_\s]+?"
        return NUMBER if column == "temperature_C" else NUMBER.removeprefix("[-+]?")

    def settings(self, stem: str) -> Settings | None:
        """Give what a file's name states; None where it doesn't follow the pattern."""
        found = self._expression_of_name.search(stem)
        if not found:
            return None
        settings: Settings = {}
        for field, text in found.groupdict().items():
            column, factor, offset = self.columns[field]
            number = _number_in(text)
            if field in TEXTS or number is None:
                settings[column] = text
            else:
                settings[column] = rounded(factor * number + offset)
        return settings


def settings_of(path: Path, names: Sequence[str], pattern: Pattern | None) -> Settings:
    """Give what names of a run state: of a column of its file, of the file, or of one of its tables.

    Raises:
        UserError: none follows the pattern.
    """
    if pattern is None:
        return {}
    found = next((settings for name in names if (settings := pattern.settings(name)) is not None), None)
    if found is None:
        raise UserError(
            f"{path}: its name, {' or '.join(map(repr, names))}, doesn't follow --pattern {pattern.text!r}; expected "
            "one that does, or a pattern that all names follow"
        )
    return found


def _column_of(field: str) -> tuple[str, float, float]:
    """Give the column of runs.csv that a field fills, and what turns its numbers into the column's unit."""
    if field in (*NUMBER_COLUMNS, *TEXTS):
        return field, 1.0, 0.0
    quantity, _, unit = field.partition("_")
    if quantity in SETTINGS and unit:
        column = next(name for name in NUMBER_COLUMNS if name.startswith(quantity))
        try:
            found = conversion(quantity, unit.replace("_", "/"), SETTINGS[quantity])
        except UserError as error:
            raise UsageError(f"--pattern, {{{field}}}: {error}") from error
        return column, found.factor, found.offset
    if meant := meant_column(field):
        raise UsageError(
            f"--pattern: field {field!r} is not known; expected {meant!r}, or its quantity in another unit"
        )
    return field, 1.0, 0.0


def _number_in(text: str) -> float | None:
    if not re.fullmatch(NUMBER, text):
        return None
    return float(text.replace(",", ".").replace("p", "."))


def guessed_pattern(
    stems: Sequence[str], contradicted: Callable[[str, Sequence[float]], bool] = lambda column, values: False
) -> str:
    """Propose a pattern that all names of files follow, "" for none.

    Names are compared as far as they are alike: behind it, those of repeats say which one they are. Numbers are looked
    for behind letters (A0.5) and before units (3Hz); those of a further condition (100psi) count where they vary. What
    varies without a meaning parts a name; the part that states most is taken.

    Args:
        stems: the names, without endings.
        contradicted: tells of a column of runs.csv, and of what the names would state there, whether what was measured
            is something else.
    """
    if not stems:
        return ""
    stems = _alike(stems)
    numbers = list(zip(*(re.findall(NUMBER, stem) for stem in stems), strict=False))
    pieces = re.split(NUMBER, stems[0])
    fields: list[str] = []
    for place, texts in enumerate(numbers):
        after = pieces[place + 1]
        begins_the_next = place + 1 < len(numbers) and BEGINS_A_NUMBER.fullmatch(after)
        field = _meant(pieces[place], texts, "" if begins_the_next else after)
        known = field and field not in fields
        fields.append(field if known and not contradicted(*_stated(field, texts)) else "")
    opaque = [place for place, texts in enumerate(numbers) if not fields[place] and len(set(texts)) > 1]
    bounds = [-1, *opaque, len(numbers)]
    parts = [range(low + 1, high) for low, high in itertools.pairwise(bounds)]
    named = [[place for place in part if fields[place]] for part in parts]
    most = max(named, key=len)
    if not most:
        return ""
    first, last = most[0], most[-1]
    begin = re.search(r"[A-Za-z]*[_=]?$", pieces[first])
    middle = "".join(
        (f"{{{fields[place]}}}" if fields[place] else numbers[place][0]) + (pieces[place + 1] if place < last else "")
        for place in range(first, last + 1)
    )
    return (begin[0] if begin else "") + middle + _unit_of(fields[last], pieces[last + 1])


def _alike(stems: Sequence[str]) -> list[str]:
    """Give the beginnings of names that differ in nothing but their numbers."""
    split = [re.split(f"({NUMBER})", stem) for stem in stems]
    between = list(zip(*(parts[::2] for parts in split), strict=False))
    same = next((place for place, texts in enumerate(between) if len(set(texts)) > 1), len(between) - 1)
    alike = itertools.takewhile(lambda letters: len(set(letters)) == 1, zip(*between[same], strict=False))
    tail = "".join(letters[0] for letters in alike)
    return ["".join(parts[: 2 * same]) + tail for parts in split]


def _unit_of(field: str, after: str) -> str:
    """Give a field's unit as it begins what stands behind it; "" where another number's letters do, as in "f3_A0.5"."""
    unit = UNIT.match(after)
    is_its = unit is not None and (GUESSED.get(unit[1].casefold()) == field or field.endswith(f"_{unit[1]}"))
    return unit[0] if unit and is_its else ""


def _meant(before: str, texts: Sequence[str], after: str) -> str:
    """Give the field that numbers in names of files fill, by what stands around them; "" where that tells nothing."""
    letters = re.search(r"([A-Za-z]*)[_=]?$", before)
    unit = UNIT.match(after)
    varies = len(set(texts)) > 1
    if unit and (varies or unit[1] not in SMALL) and (field := GUESSED.get(unit[1].casefold())):
        return field
    if letters and (field := LETTERS.get(letters[1].casefold())):
        return field
    further = further_quantity(unit[1]) if unit and varies else None
    return f"{further}_{unit[1]}" if unit and further else ""


def _stated(field: str, texts: Sequence[str]) -> tuple[str, list[float]]:
    """Give the column of runs.csv that a field fills, and what numbers in names of files state there."""
    column, factor, offset = _column_of(field)
    return column, [factor * (_number_in(text) or 0.0) + offset for text in texts]


def of_properties(properties: Mapping[str, object]) -> Settings:
    """Give what a file's own properties state of its runs: the specimen; temperature and density, where with a unit.

    A temperature may also be called as it is above a table: that of the test, of the specimen or of the oven.
    """
    above = temperature_above([name, without_controls(str(value))] for name, value in properties.items())
    found: Settings = {} if above is None or above.temperature_C is None else {"temperature_C": above.temperature_C}
    for name, value in properties.items():
        plain, unit = unit_in_name(name)
        quantity, text = setting_called(plain), without_controls(str(value))
        if names_specimen(plain) and 0 < len(text) <= LONGEST_SPECIMEN:
            found["specimen"] = text
        elif quantity in NOT_SHOWN and unit:
            column = next(one for one in NUMBER_COLUMNS if one.startswith(quantity))
            # a property is a remark: what can't be read of it isn't asked
            with suppress(UserError, ValueError):
                turned = conversion(quantity, unit, SETTINGS[quantity])
                number = turned.factor * float(text.replace(",", ".")) + turned.offset
                if NOT_SHOWN[quantity] < number < math.inf:
                    found[column] = rounded(number)
    return found


def numbers_of_properties(properties: Mapping[str, object]) -> dict[str, str]:
    """Give numbers with a unit that a file's own properties state, by name and unit."""
    return numbers_above([name, without_controls(str(value))] for name, value in properties.items())


def read_conditions(path: Path) -> dict[str, Settings]:
    """Read a table of what was set: a row a file, its name in column `file` (or a run's, in `run`).

    Returns:
        columns of runs.csv by name of file or run.

    Raises:
        UserError: it can't be read, has no such column, a column of another unit, or a name twice.
    """
    try:
        text, _ = decoded(path.read_bytes())
    except OSError as error:
        raise UserError(f"{path}: can't be read ({error.strerror}); expected a table of what was set") from error
    except Damaged as error:
        raise UserError(f"{path}: {error}; expected a table of what was set") from error
    first = text.split("\n", 1)[0]
    delimiter = max("\t;,", key=first.count)
    read = csv.reader(io.StringIO(text), delimiter=delimiter)
    try:
        rows = [[cell.strip() for cell in row] for row in read if any(row)]
    except csv.Error as error:
        raise UserError(f"{path}, line {read.line_num}: {error}; expected a table of what was set") from error
    if len(rows) < 2:
        raise UserError(f"{path}: has no row below its header; expected a row a file")
    header = rows[0]
    key = next((name for name in header if name.casefold() in ("file", "run")), None)
    if key is None:
        raise UserError(
            f"{path}: has no column 'file'; it has {', '.join(map(repr, header))}; expected the files' names"
        )
    units = dict.fromkeys(header, "")
    body = list(enumerate(rows[1:], 2))
    if len(rows[1]) == len(header) and not rows[1][header.index(key)]:
        units = dict(zip(header, rows[1], strict=True))
        body = body[1:]
    columns = {name: _column_in_table(path, name, units[name]) for name in header if name != key}
    meant = [column for column, _ in columns.values()]
    for name, (column, _) in columns.items():
        if header.count(name) > 1 or meant.count(column) > 1:
            raise UserError(f"{path}: column {name!r} ({column}) stands there twice; expected it once")
    found: dict[str, Settings] = {}
    for number, row in body:
        if len(row) != len(header):
            raise UserError(f"{path}, row {number}: has {len(row)} cells; expected {len(header)} as in the header")
        named = dict(zip(header, row, strict=True))
        name = Path(named.pop(key)).name
        if name in found:
            raise UserError(f"{path}, row {number}: {name!r} stands there twice; expected each {key} once")
        found[name] = {
            columns[own][0]: _cell(f"{path}, row {number}, column {own!r}", *columns[own], cell, delimiter)
            for own, cell in named.items()
            if cell
        }
    return found


def _column_in_table(path: Path, name: str, unit: str) -> tuple[str, Conversion]:
    """Give the column of runs.csv that one of a table fills, and what turns its numbers into that column's unit.

    Raises:
        UserError: its unit is none of what it is called, or isn't stated.
    """
    if name in (*NUMBER_COLUMNS, *TEXTS):
        return name, Conversion()
    plain, own = unit_in_name(name)
    quantity = setting_called(plain)
    unit = own or unit.strip("[]() ")
    if quantity and unit:
        column = next(one for one in NUMBER_COLUMNS if one.startswith(quantity))
        try:
            return column, conversion(quantity, unit, SETTINGS[quantity])
        except UserError as error:
            raise UserError(f"{path}, column {name!r}: {error}") from error
    if meant := meant_column(name):
        raise UserError(f"{path}: column {name!r} is not known; expected {meant!r}, or its unit behind it in brackets")
    return name, Conversion()


def _cell(where: str, column: str, turned: Conversion, cell: str, delimiter: str) -> float | str:
    plain = cell.replace(",", ".") if delimiter != "," else cell
    try:
        value = float(plain)
    except ValueError:
        if column in NUMBER_COLUMNS:
            raise UserError(f"{where}: got {cell!r}; expected a number") from None
        return cell
    if not math.isfinite(value):
        raise UserError(f"{where}: got {cell!r}; expected a finite number")
    return value if turned == Conversion() else rounded(turned.factor * value + turned.offset)


def is_free(stated: Settings) -> bool:
    """Tell whether a motion is stated to be no sine."""
    return stated.get("motion") == "free"


def name_in(table: Mapping[str, Settings], names: Sequence[str]) -> str:
    """Give the first of a run's names by which a table knows it; "" for none."""
    return next((name for name in names if name and name in table), "")
