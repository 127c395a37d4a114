"""Texts of users and of files, as they may stand in a message: without control characters, in lines of some length."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

LONGEST_LINE = 289
"""Characters of a line of a message, at most: 300 with the program's name before it."""
MOST_LINES = 40
"""Lines of a message, at most: one, and what it lists."""
ENDING = 120
"""Characters that stay of the end of a line that is cut: there it says what was expected."""
A_COMMAND = "  pipeclamp "
"""What a line of a list begins with that is a command."""
CUT = " [...] "
END_OF_PLACE = 40
"""Characters that stay of a path at the beginning of a line that is too long, at least: upper folders say least."""
MOST_NAMED = 8
"""Texts that are named of many, unless another number is asked: some files have hundreds of channels."""
HIDDEN = frozenset(("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"))
"""Categories of Unicode that a terminal obeys, hides or can't show."""


def printable(text: str, keep: str = "") -> str:
    """Give a text with its blanks as spaces and what a terminal would obey, or can't show, as Python would escape it.

    Args:
        text: any.
        keep: control characters that stay.
    """
    if text.isprintable():
        return text
    shown = (character if character in keep else _shown(character) for character in text)
    return "".join(shown)


def _shown(character: str) -> str:
    if character.isspace() and character.isascii():
        return " "
    return ascii(character)[1:-1] if unicodedata.category(character) in HIDDEN else character


def counted(count: int, what: str) -> str:
    """Give how many there are of what has an s in the plural: "1 run", "2 runs"."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def few_of(texts: Sequence[str], most: int = MOST_NAMED, between: str = ", ") -> str:
    """Name the first of many: "a, b and 3 more".

    >>> few_of(["a", "b", "c"], most=2)
    'a, b and 1 more'
    """
    more = f" and {len(texts) - most} more" if len(texts) > most else ""
    return between.join(texts[:most]) + more


def message(text: str) -> str:
    """Give a text as a message: one line, or that and lines that two spaces begin.

    A line that is too long goes without its file's upper folders, and, if that isn't enough, without its middle; one
    that is a command stays whole, for it is copied.
    """
    told = [printable(line) for line in re.split(r"\n(?=  \S)", text.strip())]
    lines = [line if line.startswith(A_COMMAND) else _fitted(line) for line in told]
    further = len(lines) - MOST_LINES
    return "\n".join(lines if further <= 0 else [*lines[:MOST_LINES], f"  and {further} more"])


def _fitted(line: str) -> str:
    place, colon, rest = line.partition(": ")
    if len(line) > LONGEST_LINE and colon and ("/" in place or "\\" in place) and len(place) > END_OF_PLACE:
        # a line of a list stays one
        cut = line[: len(line) - len(line.lstrip())] + CUT.lstrip()
        left = max(LONGEST_LINE - len(cut) - len(colon + rest), END_OF_PLACE)
        line = cut + place[-left:] + colon + rest
    if len(line) <= LONGEST_LINE:
        return line
    return line[: LONGEST_LINE - ENDING - len(CUT)] + CUT + line[-ENDING:]
