"""The one error that a user's mistake raises, and what was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class UserError(Exception):
    """Input that can't serve: what was got, where, what was expected, what to do.

    The command line prints it as one message and exits with status 1; everything else that
    is raised is a defect of this program.
    """


class UsageError(UserError):
    """An option's value that no input could make sense of, which the command line exits from with status 2."""


def did_you_mean(name: str, known: Iterable[str], most: int = 1) -> str:
    """Ask whether one of the known names nearest to an unknown one was meant, to stand before what was expected."""
    near = get_close_matches(name, list(known), n=most, cutoff=0.5)
    return f"did you mean {' or '.join(map(repr, near))}? " if near else ""


class InterruptError(UserError):
    """The user stopped what can go on; the message says how."""
