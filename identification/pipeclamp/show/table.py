"""Tables of text and numbers, as terminals and pages show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SINGLE_CYCLES = "each run holds one cycle, so that no scatter from cycle to cycle can be known"
"""What stands where a scatter would."""


@dataclass(frozen=True)
class Table:
    """A table: a header and rows of text or numbers; numbers are shown with four significant digits."""

    header: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]
    caption: str = ""


def cell(value: str | float | None) -> str:
    """Give a table cell's text."""
    if value is None:
        return "–"
    return value if isinstance(value, str) else f"{value:.4g}"
