"""Tables laid out in so many columns of text: what is typed stays whole, numbers stay whole, sentences get the room."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from unicodedata import east_asian_width

RULED, PLAIN = (3, 1), (2, -2)
"""Characters that each column's borders take, and the whole table's: with rules, and with spaces alone."""
SHORTEST_APART = 4
"""Letters of a symbol or word, whose unit stays beside it in a header: "f / Hz"."""
FOLDED = 12
"""Letters, into which a word of a sentence may be cut where nothing else lets a table fit."""
_BOUND = "\0"
"""Stands for a space that no line breaks at."""


@dataclass(frozen=True)
class TableLayout:
    """A table's cells as they are printed, each with its line breaks.

    Attributes:
        ruled: whether there is room for rules between the columns.
        widths: of the columns, in characters.
        header: of each column.
        rows: of each row, each column's text.
    """

    ruled: bool
    widths: Sequence[int]
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def layout(
    header: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool], width: int
) -> TableLayout | None:
    """Lay a table out in at most so many characters; None where it is too wide to be read so.

    Args:
        header: a text for each column.
        rows: each with a text for each column.
        numeric: whether a column holds numbers.
        width: of the screen, in characters, with borders.
    """
    bodies = [[row[index] for row in rows] for index in range(len(header))]
    for ruled, cut in ((True, False), (False, False), (False, True)):
        each, whole = RULED if ruled else PLAIN
        found = _widths(header, bodies, numeric, width - each * len(header) - whole, cut=cut)
        if found is not None:
            heads, widths = found
            lines = [wrapped(head, size).replace(_BOUND, " ") for head, size in zip(heads, widths, strict=True)]
            cells = [[wrapped(text, size) for text, size in zip(row, widths, strict=True)] for row in rows]
            return TableLayout(ruled, widths, lines, cells)
    return None


def hanging(text: str, width: int) -> str:
    """Break lines between words into such of at most so many characters, all as far in as what they go on from."""
    return "\n".join(_hanging(one, width) for one in text.split("\n"))


def _hanging(line: str, width: int) -> str:
    indent = " " * (len(line) - len(line.lstrip()))
    return textwrap.fill(
        line.strip(), width, initial_indent=indent, subsequent_indent=indent, break_long_words=False,
        break_on_hyphens=False,
    )  # fmt: skip


def wrapped(text: str, width: int) -> str:
    """Break text into lines of at most so many characters: at spaces, else after a joint of a name, else anywhere."""
    return "\n".join(line for one in text.split("\n") for line in _lines(one, width))


def _lines(text: str, width: int) -> Iterator[str]:
    line = ""
    for word in text.split(" "):
        joined = f"{line} {word}" if line else word
        if room_of(joined) <= width:
            line = joined
            continue
        if line:
            yield line
        *full, line = _cut(word, width)
        yield from full
    yield line


def _cut(word: str, width: int) -> list[str]:
    """Cut a word into pieces of at most so many characters, after its joints where it has some."""
    pieces = [""]
    for part in _parts(word):
        if room_of(pieces[-1]) + room_of(part) <= width:
            pieces[-1] += part
            continue
        size = width if room_of(part) == len(part) else max(1, width // 2)
        cut = [part[start : start + size] for start in range(0, len(part), size)]
        pieces = [*pieces, *cut] if pieces[-1] else cut
    return pieces


def _parts(word: str) -> list[str]:
    """Give what a long word is made of: names are joined by underscores, paths by slashes."""
    return re.findall(r"[^_:/\\,;.=+-]*[_:/\\,;.=+-]+|[^_:/\\,;.=+-]+", word) or [word]


def _unit_kept(head: str, short: int) -> str:
    """Bind a header's unit together, and to a symbol of at most so many letters."""
    quantity, slash, unit = head.partition(" / ")
    if not slash:
        return head
    between = _BOUND if len(quantity) <= short else " "
    return f"{quantity}{between}/{_BOUND}{unit.replace(' ', _BOUND)}"


def _widths(
    header: Sequence[str], bodies: Sequence[Sequence[str]], numeric: Sequence[bool], room: int, *, cut: bool
) -> tuple[list[str], list[int]] | None:
    """Give the heads, units bound as far as there is room, and the columns' widths; names are cut only where told."""
    bound, loose = [_unit_kept(head, SHORTEST_APART) for head in header], [_unit_kept(head, 0) for head in header]
    columns = range(len(header))
    words = [_longest(word for text in body for word in text.split()) for body in bodies]
    parts = [_longest(part for text in body for word in text.split() for part in _parts(word)) for body in bodies]
    later = [words[one] if one == 0 or numeric[one] else parts[one] for one in columns]
    names = [words[one] if numeric[one] else parts[one] for one in columns]
    pieces = [words[one] if numeric[one] else min(parts[one], FOLDED) for one in columns]
    ways = ((loose, later), (loose, names), (loose, pieces)) if cut else ((bound, words), (loose, words))
    for heads, body in ways:
        least = [max(_longest(head.split()), size) for head, size in zip(heads, body, strict=True)]
        if sum(least) <= room:
            filled = _filled(least, [_longest(column) for column in bodies], room)
            texts = [[head, *column] for head, column in zip(heads, bodies, strict=True)]
            return heads, _filled(filled, [_longest(column) for column in texts], room)
    return None


def _filled(widths: Sequence[int], wanted: Sequence[int], room: int) -> list[int]:
    """Widen columns up to what they want: what is folded into most lines first, of these what lacks least."""
    filled = list(widths)
    for _ in range(room - sum(widths)):
        lacking = [
            (-(-want // have), have - want, one) for one, (want, have) in enumerate(zip(wanted, filled, strict=True))
        ]
        lacking = [entry for entry in lacking if entry[1] < 0]
        if not lacking:
            break
        filled[max(lacking)[-1]] += 1
    return filled


def _longest(texts: Iterable[str]) -> int:
    """Give the length of the longest line; 1 where there is none."""
    return max((room_of(line) for text in texts for line in text.split("\n")), default=1) or 1


def room_of(text: str) -> int:
    """Give the columns of a terminal that a text takes: letters of Chinese, Japanese and Korean take two."""
    return len(text) if text.isascii() else sum(1 + (east_asian_width(one) in "WF") for one in text)


def row_by_row(header: Sequence[str], rows: Sequence[Sequence[str]], caption: str, width: int) -> list[str]:
    """Give a table as lines, row by row, each entry beside its column's head: for a screen too narrow for a table."""
    widest = _longest(header) + 2
    lines = wrapped(caption, width).split("\n") if caption else []
    for row in rows:
        lines.append("")
        for head, text in zip(header, row, strict=True):
            told = wrapped(text, max(width - widest, FOLDED)).split("\n")
            lines += [f"{'' if place else head:<{widest}}{line}" for place, line in enumerate(told) if text]
    return [*lines, ""]
