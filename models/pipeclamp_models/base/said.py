"""Texts of users and of files, as they may stand in a message: without control characters, in lines of some length."""

from __future__ import annotations

import re
import unicodedata

LONGEST = 300
"""Characters of a line of a message, at most."""
MOST_LINES = 40
"""Lines of a message, at most: one, and what it lists."""
ENDING = 120
"""Characters that stay of the end of a line that is cut: there it says what was expected."""
CUT = " [...] "
PLACE = re.compile(r"[^\n]*?[/\\][^\n]*?(?=: )")
"""A file's path at the beginning of a line."""
END_OF_PLACE = 40
"""Characters that stay of its end, at least, where a line is too long: folders above say least."""
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


def message(text: str) -> str:
    """Give a text as a message: one line, or that and lines that two spaces begin.

    A line that is too long goes without its file's upper folders, and, if that isn't enough, without its middle.
    """
    lines = [_fitted(printable(line)) for line in re.split(r"\n(?=  \S)", text.strip())]
    further = len(lines) - MOST_LINES
    return "\n".join(lines if further <= 0 else [*lines[:MOST_LINES], f"  and {further} more"])


def _fitted(line: str) -> str:
    place = PLACE.match(line)
    if len(line) > LONGEST and place and len(place[0]) > END_OF_PLACE:
        left = max(len(place[0]) - (len(line) - LONGEST) - len(CUT.lstrip()), END_OF_PLACE)
        line = CUT.lstrip() + place[0][-left:] + line[place.end() :]
    if len(line) <= LONGEST:
        return line
    return line[: LONGEST - ENDING - len(CUT)] + CUT + line[-ENDING:]
