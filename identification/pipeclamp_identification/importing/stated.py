"""What a user states of an import, checked as a whole."""

from __future__ import annotations

import math
from pathlib import Path

from pipeclamp_identification.importing.columns import parse_columns
from pipeclamp_identification.importing.conditions import Pattern, read_conditions
from pipeclamp_identification.importing.importer import Ask, LeaveOut, Options
from pipeclamp_identification.importing.questions import NONE
from pipeclamp_models.base.errors import UsageError


def stated_options(
    columns: str,
    pattern: str,
    conditions: Path | None,
    rate: float | None,
    *,
    leave_out: LeaveOut,
    ask: Ask | None = None,
) -> Options:
    """Give options of text.

    Args:
        columns: `time=Zeit [ms],force=Last [kN]`.
        pattern: of the files' names.
        conditions: a table of what was set.
        rate: samples per second.
        leave_out: whether files that can't be used may be.
        ask: for what is open.

    Raises:
        UserError: one of them isn't as it should be.
    """
    if rate is not None and not (math.isfinite(rate) and rate > 0):
        raise UsageError(f"--rate: got {rate:g}; expected samples per second, above 0")
    stated = parse_columns(columns)
    if rate is None and any(one.ours == "time" and one.channel.casefold() == NONE for one in stated):
        raise UsageError("--columns: got 'time=none' without --rate; expected the samples per second, too")
    return Options(
        columns=stated,
        pattern=Pattern(pattern) if pattern else None,
        conditions=read_conditions(conditions) if conditions else {},
        rate=rate,
        ask=ask,
        leave_out=leave_out,
    )
