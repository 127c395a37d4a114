"""The one error that a user's mistake raises."""

from __future__ import annotations


class UserError(Exception):
    """Input that can't serve: what was got, where, what was expected, what to do.

    The command line prints it as one message and exits with status 1; everything else that
    is raised is a defect of this program.
    """
