"""Tables of text and numbers, as terminals and pages show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pipeclamp_models.base.digits import plain

SINGLE_CYCLES = "each run holds one cycle, so that no scatter from cycle to cycle can be known"
"""What stands where a scatter would."""


@dataclass(frozen=True)
class Table:
    """A table: a header and rows of text or numbers; numbers are shown with four significant digits."""

    header: Sequence[str]
    rows: Sequence[Sequence[str | float | None]]
    caption: str = ""


def cell(value: str | float | None) -> str:
    """Give a table cell's text: of a number four digits, without a power of ten where figures do (28000 N/mm)."""
    if value is None:
        return "–"
    return value if isinstance(value, str) else plain(value, 4)


def outside_head(outside: Mapping[str, str]) -> tuple[str, ...]:
    """Give the head of a column for what lies outside a law's range, by run, where something does."""
    return ("outside the law's range",) if outside else ()


def outside_cell(outside: Mapping[str, str], run: str) -> tuple[str, ...]:
    """Give a run's entry in that column."""
    return (outside.get(run, ""),) if outside else ()
