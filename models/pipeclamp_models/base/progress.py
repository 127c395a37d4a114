"""How a long computation tells what it is doing, and who does it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Progress = Callable[[str], None]


def silent(what: str) -> None:
    """Tell nobody what is being done."""


@dataclass(frozen=True)
class Workers:
    """Who does a long computation.

    Attributes:
        processes: that share it; -1 for as many as there are cores.
        tell: is told what is being done.
    """

    processes: int = 1
    tell: Progress = silent


ALONE = Workers()
"""This process, which tells nobody."""
