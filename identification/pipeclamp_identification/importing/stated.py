"""What a user states of an import, checked as a whole."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeclamp_identification.importing.channels.columns import Mapped, Stated, parse_columns
from pipeclamp_identification.importing.channels.questions import NONE
from pipeclamp_identification.importing.conditions import Pattern, Settings, is_free, read_conditions
from pipeclamp_identification.importing.unusable import UnusableFiles
from pipeclamp_models.base.errors import UsageError

Ask = Callable[[str, Mapped], Sequence[Stated]]
"""Asks a person what names and units leave open, and gives what the answers state."""
LeaveOut = Callable[[UnusableFiles], bool]
"""Says, or asks a person, whether files that can't be used may be left out."""
NOMINAL_RATE = 100.0
"""Samples per second by which runs are told apart where time was not measured."""


@dataclass(frozen=True)
class Options:
    """What a user states.

    Attributes:
        columns: which channels are ours.
        pattern: of the files' names.
        conditions: settings by name of file or run.
        rate: samples per second, where no channel holds the time.
        timed: whether that is the logger's; otherwise time was not measured, and the rate is nominal.
        ask: for what is open; None where nobody can answer.
        leave_out: whether files that can't be used may be left out, and the others imported.
    """

    columns: tuple[Stated, ...] = ()
    pattern: Pattern | None = None
    conditions: Mapping[str, Settings] = field(default_factory=dict)
    rate: float | None = None
    timed: bool = True
    ask: Ask | None = None
    leave_out: LeaveOut = lambda unusable: False

    @property
    def called_free(self) -> frozenset[str]:
        """Names of files and runs whose motion is stated to be free; without a time every motion is laid out."""
        return frozenset(name for name, stated in self.conditions.items() if self.timed and is_free(stated))


def stated_options(
    columns: str,
    pattern: str,
    conditions: Path | None,
    rate: float | str | None,
    *,
    leave_out: LeaveOut,
    ask: Ask | None = None,
) -> Options:
    """Give options of text.

    Args:
        columns: `time=Zeit [ms],force=Last [kN]`.
        pattern: of the files' names.
        conditions: a table of what was set.
        rate: samples per second; "none" where time was not measured, and no channel holds it.
        leave_out: whether files that can't be used may be.
        ask: for what is open.

    Raises:
        UserError: one of them isn't as it should be.
    """
    samples, timed = _rate_of(rate)
    stated = parse_columns(columns)
    if samples is None and any(one.ours == "time" and one.channel.casefold() == NONE for one in stated):
        raise UsageError(
            "--columns: got 'time=none' without --rate; expected the samples per second, too, or --rate none where "
            "time was not measured"
        )
    return Options(
        columns=stated,
        pattern=Pattern(pattern) if pattern else None,
        conditions=read_conditions(conditions) if conditions else {},
        rate=samples,
        timed=timed,
        ask=ask,
        leave_out=leave_out,
    )


def _rate_of(stated: float | str | None) -> tuple[float | None, bool]:
    """Give the samples per second, and whether they are a logger's: nominal ones where time was not measured.

    Raises:
        UsageError: it is neither a number above 0 nor "none".
    """
    if stated is None:
        return None, True
    if isinstance(stated, str) and stated.strip().casefold() == NONE:
        return NOMINAL_RATE, False
    try:
        rate = float(stated)
    except (TypeError, ValueError):
        rate = math.nan
    if math.isfinite(rate) and rate > 0:
        return rate, True
    raise UsageError(f"--rate: got {stated}; expected samples per second, above 0, or none where time was not measured")
