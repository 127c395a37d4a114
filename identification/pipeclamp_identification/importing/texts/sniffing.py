"""How a text holds its table: what parts its cells, its decimals, where the numbers begin, what names and units are."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

from pipeclamp_identification.importing.raw import Damaged
from pipeclamp_identification.units.stated import is_unit, quantity_of_unit, unit_in_name
from pipeclamp_models.base.said import counted

DELIMITERS = ("\t", ";", ",", "|", " ")
"""The blank, any number of them, comes last: it stands beside others, too."""
WORDS = {"\t": "tabs", ";": "semicolons", ",": "commas", "|": "bars", " ": "blanks"}
PLACES = 40
"""Parts of the file that lines are looked at in."""
LINES_A_PLACE = 2
MANY_LINES = 300
"""Lines up to which all are looked at."""
FEWEST_COLUMNS = 2
CLEAR = 0.6
"""Share of the lines that a way to part cells must make rows of numbers of."""
LONGEST_HEADER = 20_000
LEFT_ALIGNED = ("\t", ";", "|")
"""What parts names that stand above their columns though there may be more of them."""
REMARKS = frozenset(
    ("comment", "comments", "event", "events", "marker", "markers", "note", "notes", "remark", "remarks")
)
"""Names of columns of text that are blank in most rows, or left off there."""
MOST_SHOWN = 40
"""Characters of a line that an error shows."""
LINES_OF_NAMES = 4
"""Lines that a row of names may take, at most."""
HEADER_ROWS = 4
"""Rows above the numbers that may name columns or state units."""
LABELLED_ROWS = 100
"""Rows above the numbers that may state units behind a label."""
UNIT_LABEL = re.compile(r"unit|einheit|unidad", re.IGNORECASE)
POINT = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?$|[-+]?(?:nan|inf)$", re.IGNORECASE)
COMMA = re.compile(r"[-+]?(?:\d+,?\d*|,\d+)(?:[eEdD][-+]?\d+)?$|[-+]?(?:nan|inf)$", re.IGNORECASE)
LONGEST_NUMBER = 100
"""Characters; looking for a number in a longer cell takes the square of its length."""
STAMP = re.compile(
    r"(?:\d{1,4}[-./]\d{1,2}[-./]\d{1,4}[ T]+)?\d{1,3}:\d{2}(?:[.,]\d+)?(?::\d{2}(?:[.,:]\d+)?)?"
    r"(?:\s*[ap]\.?m\.?|Z|[-+]\d\d:?\d\d)?$",
    re.IGNORECASE,
)
OUTSIDE_BRACKETS = re.compile(r",(?![^()]*\))")
COMMENT = re.compile(r"^\s*[#%!*]+\s+")
"""What some programs put before a line of names or units."""
BRACKETED = re.compile(r"[\[(<]\s*(.*?)\s*[\])>]")
MOST_UNITS = 0.5
"""Share of a row's cells above which, as known units, they make it one of units."""
NEEDED = {"time", "displacement", "force"}
OTHER_COLUMNS = "other columns or units from line {} on; expected one order of columns in a file, and one unit of each"
NUMBERS_ALONE = ("1", "%")
ANGLES = ("rad", "deg", "°")
NAME_LETTERS = ("t", "x", "y", "F", "T", "f")
"""Letters that name columns, though they are units of something, too: tonnes, farads, teslas."""


DECIMALS = {".": "decimal point", ",": "decimal comma"}
OTHER = {".": ",", ",": "."}

Names = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]
"""Names and units of columns, and titles above the names."""


@dataclass(frozen=True)
class Layout:
    """How a text holds its table.

    Attributes:
        delimiter: between cells; " " stands for any number of blanks.
        decimal: "." or ",".
        width: cells in a row.
        first: index of the first line of numbers.
        names, units: of the columns; units "" where none is stated in a row of their own.
        titles: what stands in the row above the names, "" where nothing does.
        step: of time between rows in s, where the header states it: for a first column that is blank. Else 0.
    """

    delimiter: str
    decimal: str
    width: int
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    titles: tuple[str, ...]
    step: float = 0.0

    def words(self) -> str:
        """Say how the table is held."""
        header = f", {counted(self.first, 'line')} before the numbers" if self.first else ", no header"
        return f"cells parted by {WORDS[self.delimiter]}, {DECIMALS[self.decimal]}{header}"


def cells_of(line: str, delimiter: str) -> list[str]:
    """Give the cells of a line, without blanks and quotes around them."""
    if delimiter == " ":
        return line.split()
    if '"' in line:
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
        except csv.Error:
            cells = line.split(delimiter)
    else:
        cells = line.split(delimiter)
    return [cell.strip() for cell in cells]


def is_number(cell: str, decimal: str) -> bool:
    """Tell whether a cell is a number, or a stamp of time."""
    if len(cell) > LONGEST_NUMBER:
        return False
    return bool((COMMA if decimal == "," else POINT).match(cell) or STAMP.match(cell))


def has_other_decimals(line: str, layout: Layout) -> bool:
    """Tell whether a row's numbers have the other decimal sign: all of them may, and two at least have none else."""
    other = OTHER[layout.decimal]
    cells = [cell for cell in cells_of(line, layout.delimiter)[: layout.width] if cell]
    sure = sum(is_number(cell, other) and not is_number(cell, layout.decimal) for cell in cells)
    return sure >= FEWEST_COLUMNS and all(is_number(cell, other) for cell in cells)


def decimals_change(number: int, line: str, to: str) -> Damaged:
    """Give the error of a text whose decimal sign changes `to` another in a line, whose number is given."""
    return Damaged(
        f"changes its decimal sign in line {number}: got {line.strip()[:MOST_SHOWN]!r} with {DECIMALS[to]}s; expected "
        f"{DECIMALS[OTHER[to]]}s as in the lines above: export it again with one sign throughout"
    )


def layout_of(lines: Sequence[str]) -> Layout:
    """Find how lines hold a table.

    Raises:
        Damaged: no way to part them makes a table of numbers.
    """
    places = _places(lines)
    sample = [lines[index] for index in places]
    if not sample:
        raise Damaged("is empty; expected a table of numbers")
    parting = [one for one in DELIMITERS if any(len(cells_of(line, one)) >= FEWEST_COLUMNS for line in sample)]
    ways = [(delimiter, decimal) for delimiter in parting for decimal in (".", ",")]
    quoted = any('"' in line for line in sample)
    scored = [(*_score(sample, *way), way) for way in ways if way != (",", ",") or quoted]
    share, width, ended, (delimiter, decimal) = max(
        scored, key=lambda one: (round(one[0], 2), -DELIMITERS.index(one[3][0])), default=(0.0, 0, False, ("", ""))
    )
    if share == 0.0:
        if 2 * sum(any(is_number(line.strip(), decimal) for decimal in DECIMALS) for line in sample) > len(sample):
            raise Damaged(
                "holds one column of numbers alone; expected displacement and force of a test side by side in one table"
            )
        line = sample[len(sample) // 2][:MOST_SHOWN]
        raise Damaged(
            f"holds no table of numbers: no two columns of them are parted by tabs, ; , | or blanks; got {line!r} in it"
        )
    first = _first_line(lines, sample, delimiter, decimal, width, ended)
    header = _whole_lines(lines[:first], delimiter)
    if ended and header and len(named := cells_of(header[-1], delimiter)) == width + 1 and named[-1]:
        # a column that is blank in most rows has a name
        width += 1
    names, units, titles = _names_and_units(header, delimiter, width)
    if not any(units):
        units = _labelled_units(header, delimiter, width)
    layout = Layout(delimiter, decimal, width, first, names, units, titles, _step(header, delimiter, decimal))
    above = next((place for place in reversed(range(first)) if lines[place].strip()), None)
    if above is not None and has_other_decimals(lines[above], layout):
        # the larger part of the file made the layout
        raise decimals_change(first + 1, lines[first], decimal)
    return layout


def _whole_lines(lines: Sequence[str], delimiter: str) -> list[str]:
    """Give lines of a header; those that quotes hold together, as names with a line end are, become one.

    A quote opens where a cell begins: the loss modulus G" and a stroke of 2" open none.
    """
    begins = rf"(?:^|{re.escape(delimiter)})\s*\""
    whole, begun = re.compile(begins + r'(?:[^"]|"")*"'), re.compile(begins)
    found: list[str] = []
    for line in lines:
        if found and found[-1].count("\n") < LINES_OF_NAMES and begun.search(whole.sub("", found[-1])):
            found[-1] += "\n" + line
        else:
            found.append(line)
    return found


def _places(lines: Sequence[str]) -> list[int]:
    """Give the lines that are looked at, blank ones aside: of a long file some at many places.

    Short rows at the end of a file that was cut, and the header, are few among them.
    """
    if len(lines) > MANY_LINES:
        begins = [len(lines) * place // PLACES for place in range(PLACES)]
        found = [index for begin in begins for index in range(begin, begin + LINES_A_PLACE) if lines[index].strip()]
        if len(found) > len(begins):
            return found
    return [index for index, line in enumerate(lines) if line.strip()]


def _trimmed(cells: list[str], ended: bool) -> list[str]:
    """Give cells without the blank one that a delimiter at the line's end makes, where all rows are `ended` so."""
    return cells[:-1] if ended and len(cells) > 1 and not cells[-1] else cells


def _score(sample: Sequence[str], delimiter: str, decimal: str) -> tuple[float, int, bool]:
    """Give the share of cells that are numbers where a line has at least two, over all lines; the usual width; and
    whether a delimiter ends each row: a last column may be blank now and then."""
    cells = [cells_of(line, delimiter) for line in sample]
    counted = [(row, sum(is_number(cell, decimal) for cell in row)) for row in cells]
    rows = [(row, numbers) for row, numbers in counted if numbers >= FEWEST_COLUMNS]
    if not rows:
        return 0.0, 0, False
    ended = all(not row[-1] for row, _ in rows)
    widths = [len(_trimmed(row, ended)) for row, _ in rows]
    width = max(set(widths), key=widths.count)
    kept = [
        numbers / len([cell for cell in row if cell])
        for (row, numbers), own in zip(rows, widths, strict=True)
        if own == width
    ]
    # a header may be longer than a short table; what must be clear is which way makes the best rows
    return sum(kept) / len(kept) * (0.5 + 0.5 * len(kept) / len(counted)), width, ended


def _first_line(
    lines: Sequence[str], sample: Sequence[str], delimiter: str, decimal: str, width: int, ended: bool
) -> int:
    """Find the first line of the table: as wide as most, with numbers where most have them.

    Lines right above it that hold text for one of these numbers belong to it, others ("Samples;2500;2500") don't.
    """
    rows = [row for row in (_trimmed(cells_of(line, delimiter), ended) for line in sample) if len(row) == width]
    # a column that mostly is blank holds no labels either: "X0;0;0" is no row of it
    expected = [
        place
        for place in range(width)
        if 2 * sum(not row[place] or is_number(row[place], decimal) for row in rows) >= len(rows)
    ]

    def numbers_in(line: str) -> tuple[bool, bool]:
        row = _trimmed(cells_of(line, delimiter), ended)
        if len(row) == width + 1 and ended == is_number(row[width], decimal):
            # its last column is blank in most rows, or a remark that most rows don't have
            row = row[:width]
        numbers = sum(is_number(cell, decimal) for cell in row)
        enough = len(row) == width and numbers >= max(FEWEST_COLUMNS, CLEAR * len([cell for cell in row if cell]))
        return enough, enough and all(is_number(row[place], decimal) for place in expected if row[place])

    enough: list[bool] = []
    for line in itertools.islice(lines, LONGEST_HEADER):
        some, whole = numbers_in(line)
        enough.append(some)
        if whole:
            break
    else:
        if not any(enough):
            raise Damaged(f"has no line of {width} cells with numbers among its first {LONGEST_HEADER}")
        return enough.index(True)
    first = len(enough) - 1
    while first and enough[first - 1]:
        first -= 1
    return first


def _names_and_units(header: Sequence[str], delimiter: str, width: int) -> Names:
    """Find the rows of names and of units right above the numbers."""
    blank = ("",) * width
    numbered = tuple(f"column {place}" for place in range(1, width + 1))
    above = [line for line in header if line.strip()][-HEADER_ROWS:]
    if not above:
        return numbered, blank, blank
    rows = [row for row in (_header_row(line, delimiter, width) for line in above) if row]
    last = cells_of(above[-1], delimiter)
    beyond = [cell for cell in last[width:] if cell]
    if beyond and (delimiter in LEFT_ALIGNED or REMARKS.issuperset(map(str.casefold, beyond))):
        # the last columns may be blank in each row: LabVIEW's "Comment", a logger's "Events"
        rows = [*rows, last[:width]]
    if not rows:
        if delimiter == "," and len(last) > 1:
            why = (
                "a name that holds a comma must stand in quotes: export it so"
                if len(last) > width
                else "decimal commas between commas can't be told from them: export with points"
            )
            raise Damaged(
                f"has {len(last)} names above {width} columns of numbers; expected as many; {why}, or with semicolons "
                "between columns"
            )
        return numbered, blank, blank
    return names_above(rows, width)


def names_above(rows: Sequence[Sequence[str]], width: int) -> Names:
    """Give names and units of columns, units "" where none are stated, and what stands above the names.

    A row of units stands below the names, or above them where nothing else does; alone, it leaves them without names.
    Without one, names that state units go before what stands below them, catman's rates and slots.

    Args:
        rows: of cells above the numbers, each so wide.
        width: columns.
    """
    filled = [row for row in rows if any(row)]
    blank = ("",) * width
    place = next((place for place in reversed(range(len(filled))) if _are_units(filled[place])), None)
    if place is None or (len(filled) == 1 and not _are_ours(filled[0])):
        last = len(filled) - 1
        named = next((row for row in range(last, -1, -1) if _name_ours(filled[row])), last)
        return _unique(filled[named] if filled else blank), blank, tuple(filled[named - 1] if named > 0 else blank)
    others = filled[place - 1 : place] or filled[place + 1 : place + 2] or [blank]
    titles = filled[place - 2] if place > 1 else blank
    return _unique(others[0]), tuple(_bare(cell) for cell in filled[place]), tuple(titles)


def _labelled_units(header: Sequence[str], delimiter: str, width: int) -> tuple[str, ...]:
    """Give units of columns from rows that say so in the first column, LabVIEW's "Y_Unit_Label"; "" without them."""
    units = [""] * width
    for line in header[-LABELLED_ROWS:]:
        label, *cells = [_bare(cell) for cell in cells_of(line, delimiter)[:width]]
        of_time = label == "X_Dimension" and cells[:1] == ["Time"]
        if of_time or (UNIT_LABEL.search(label) and label[:1] in "xX" and any(map(_is_plain_unit, cells[:1]))):
            units[0] = "s" if of_time else cells[0]
        elif UNIT_LABEL.search(label) and any(map(_is_plain_unit, cells)):
            units[1 : 1 + len(cells)] = cells
    return tuple(units)


def _step(header: Sequence[str], delimiter: str, decimal: str) -> float:
    """Give the step of time that all channels of LabVIEW's header have, 0 where there is no such one."""
    rows = {cells[0]: cells[1:] for cells in (cells_of(line, delimiter) for line in header[-LABELLED_ROWS:]) if cells}
    steps = {cell for cell in rows.get("Delta_X", []) if cell}
    of_time = rows.get("X_Dimension", [])[:1] == ["Time"]
    if not of_time or len(steps) != 1 or not (COMMA if decimal == "," else POINT).match(step := steps.pop()):
        return 0.0
    return float(step.replace(decimal, "."))


def _header_row(line: str, delimiter: str, width: int) -> list[str] | None:
    """Give the cells of a row of names; None where there aren't as many as columns."""
    row = cells_of(COMMENT.sub("", line), delimiter)
    if len(row) > width and not any(row[width:]):
        row = row[:width]
    if len(row) > width and delimiter == ",":
        # commas in brackets part no names: Position(8800 (0,1):Position) (mm)
        row = [cell.strip() for cell in OUTSIDE_BRACKETS.split(line)]
    if len(row) != width and delimiter == " ":
        # names of several words, two blanks or a tab between them; or a comment's sign before them
        row = [cell.strip() for cell in re.split(r"\t|\s{2,}|;", line.strip())]
        if len(row) != width:
            row = line.lstrip("#%!* \t").split()
    return row if len(row) == width and any(row) else None


def _bare(cell: str) -> str:
    """Give a unit without brackets around it."""
    inside = BRACKETED.fullmatch(cell)
    return inside[1] if inside else cell


def _are_units(row: Sequence[str]) -> bool:
    """Tell whether a row's cells are units, not all dashes: all of them; or most, two of ours or one twice among them.

    Names differ from each other, as Pa and Pa don't.

    A row with one that nobody knows is still one: which unit that is must be asked, not which column.
    """
    filled = [cell for cell in row if cell and cell not in ("-", "--", "[]", "()", "[-]", "(-)")]
    known = sum(_is_plain_unit(_bare(cell)) for cell in filled)
    if known == len(filled) or not known:
        return bool(known)
    if all(map(BRACKETED.fullmatch, filled)):
        return True
    measured = [cell for cell in filled if cell not in NUMBERS_ALONE and _is_plain_unit(_bare(cell))]
    return known > MOST_UNITS * len(filled) and (_are_ours(row) or len(set(measured)) < len(measured))


def _are_ours(row: Sequence[str]) -> bool:
    """Tell whether a row holds units of two different channels that a record needs."""
    plain = [_bare(cell) for cell in row]
    return len({quantity_of_unit(cell) for cell in plain if cell and _is_plain_unit(cell)} & NEEDED) > 1


def _name_ours(row: Sequence[str]) -> bool:
    """Tell whether a row's names state units of two different channels that a record needs."""
    return len({quantity_of_unit(unit_in_name(cell)[1]) for cell in row if cell} & NEEDED) > 1


def is_header(row: Sequence[str], names: Sequence[str]) -> bool:
    """Tell whether a row is one of a table's names, or of units."""
    return len(set(row) & set(names)) >= FEWEST_COLUMNS or _are_units(row)


def is_other_header(row: Sequence[str], names: Sequence[str], units: Sequence[str]) -> bool:
    """Tell whether a row below a table's header is one of names or units that stand in another order, or are others."""
    cells = [_bare(cell) for cell in row]
    if len(set(row) & set(names)) >= FEWEST_COLUMNS:
        return _unique(row) != tuple(names[: len(row)])
    # a label stands before units, not a unit of the first column
    skipped = 1 if cells and UNIT_LABEL.search(cells[0]) else 0
    return any(units) and _are_units(row) and _are_ours(row) and cells[skipped:] != list(units[skipped : len(cells)])


def _is_plain_unit(cell: str) -> bool:
    """Tell whether a cell is a unit and nothing more: "kN", not "Load [kN]", nor the letter that a column is called.

    "N/mm", "mm/s" and "rad/s" are; of "s/mm" nobody knows whether it is a displacement.
    """
    name, own = unit_in_name(cell)
    compound = not own or name in ANGLES or quantity_of_unit(name) in ("displacement", "force")
    return cell not in NAME_LETTERS and compound and is_unit(cell)


def _unique(names: Sequence[str]) -> tuple[str, ...]:
    """Give names of which none is blank."""
    return tuple(name.lstrip("#%").strip() or f"column {place}" for place, name in enumerate(names, 1))
