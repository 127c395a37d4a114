"""A command as a shell takes it: sh, bash, zsh and fish, on Windows PowerShell and cmd."""

from __future__ import annotations

import os
import re
import shlex

PLAIN_WORD = re.compile(r"[\w./:+\udc80-\udcff-][\w./:+=@,\udc80-\udcff-]*(?<!,)")
"""A word that no shell changes; bytes of names that are no text are as good as letters."""
PLAIN_ON_WINDOWS = re.compile(r"[\w./\\:+-][\w./\\:+=@,-]*(?<!,)")
"""The same there, where a backslash parts folders; elsewhere it takes the next sign's meaning away."""
IS_WINDOWS = os.name == "nt"


def quoted(word: str, *, always: bool = False, windows: bool = IS_WINDOWS) -> str:
    """Give a word as a shell takes it: as it is, or in double quotes where these keep all of it, else in single ones.

    Double quotes are what cmd knows too. What they don't keep from PowerShell, `$` and the grave accent, cmd takes as
    it is: such a word can be written for one of them alone, which is PowerShell.

    Args:
        word: of a command.
        always: in quotes even where it needs none.
        windows: for its shells.
    """
    if not always and (PLAIN_ON_WINDOWS if windows else PLAIN_WORD).fullmatch(word):
        return word
    if not windows:
        return shlex.quote(word) if re.search(r'["$`\\!]', word) else f'"{word}"'
    if re.search(r"[$`]", word):
        return "'" + word.replace("'", "''") + "'"
    # a program takes \" for a quote, and \\" for the end of a path in quotes
    plain = re.sub(r'(\\*)"', r'\1\1\\"', word)
    return f'"{plain}{(len(plain) - len(plain.rstrip(chr(92)))) * chr(92)}"'


def shell_line(*words: str, windows: bool = IS_WINDOWS) -> str:
    """Join the words of a pipeclamp command to a line that can be run as it stands."""
    return " ".join(["pipeclamp", *(quoted(word, windows=windows) for word in words)])
