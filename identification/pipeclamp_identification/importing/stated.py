"""What a user states of an import, checked as a whole."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeclamp_identification.importing.columns import Mapped, Stated, parse_columns
from pipeclamp_identification.importing.conditions import Pattern, Settings, read_conditions
from pipeclamp_identification.importing.questions import NONE
from pipeclamp_identification.importing.unusable import UnusableFiles
from pipeclamp_models.base.errors import UsageError

Ask = Callable[[str, Mapped], Sequence[Stated]]
"""Asks a person what names and units leave open, and gives what the answers state."""
LeaveOut = Callable[[UnusableFiles], bool]
"""Says, or asks a person, whether files that can't be used may be left out."""


@dataclass(frozen=True)
class Options:
    """What a user states.

    Attributes:
        columns: which channels are ours.
        pattern: of the files' names.
        conditions: settings by name of file or run.
        rate: samples per second, where no channel holds the time.
        ask: for what is open; None where nobody can answer.
        leave_out: whether files that can't be used may be left out, and the others imported.
    """

    columns: tuple[Stated, ...] = ()
    pattern: Pattern | None = None
    conditions: Mapping[str, Settings] = field(default_factory=dict)
    rate: float | None = None
    ask: Ask | None = None
    leave_out: LeaveOut = lambda unusable: False


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
