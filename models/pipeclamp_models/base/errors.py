"""The one error that a user's mistake raises, and what was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from pipeclamp_models.base.said import message

LONGEST_NAME_SOUGHT = 100
"""Characters of a name by which a known one is found: the search takes the square of their number."""
SPELLED_ALIKE_SHARE, SPELLED_ALIKE_SHARE_OF_SHORT = 0.66, 0.5
"""Of the letters of two names that are spelled much alike; of short ones one letter is another, as of "c3" and "c1"."""
LONGEST_SHORT = 2
"""Letters of a short name; a longer one may abbreviate others."""


class UserError(Exception):
    """Input that can't serve: what was got, where, what was expected, what to do.

    The command line prints it as one message and exits with status 1; everything else that
    is raised is a defect of this program. Its lines have up to 300 characters, and none that a terminal obeys, whatever
    names and values they hold.
    """

    def __init__(self, text: str = "") -> None:
        """Take what is wrong."""
        super().__init__(message(text))


class UsageError(UserError):
    """An option's value that no input could make sense of, which the command line exits from with status 2."""


def did_you_mean(name: str, known: Iterable[str], most: int = 1) -> str:
    """Ask whether one of the known names nearest to an unknown one was meant, to stand before what was expected.

    Near are names that are spelled much alike, and where none is, those that the unknown one abbreviates.

    Args:
        name: the unknown name.
        known: those that it might be, the likeliest first.
        most: how many are asked about at most.

    Returns:
        the question with a blank behind it; empty where no name is near.
    """
    sought, names = name[:LONGEST_NAME_SOUGHT], list(known)
    is_short = len(sought) <= LONGEST_SHORT
    near = get_close_matches(
        sought, names, n=most, cutoff=SPELLED_ALIKE_SHARE_OF_SHORT if is_short else SPELLED_ALIKE_SHARE
    )
    if not near and not is_short:
        near = [one for one in names if sought.casefold() in one.casefold()][:most]
    return f"did you mean {' or '.join(map(repr, near))}? " if near else ""


class InterruptError(UserError):
    """The user stopped what can go on; the message says how."""
