"""How a long computation tells what it is doing."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]


def silent(what: str) -> None:
    """Tell nobody what is being done."""
