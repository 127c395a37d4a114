"""Numbers that stand for none: what a logger writes where a sensor is off, or beyond its range (32767, -9999, 1e38)."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.campaign.records import LARGEST_VALUE
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.said import counted

MOST_CODES = 0.1
"""Share of the samples; a number that more of them hold is a place at which the channel stays."""
MOST_KINDS = 3
"""Different ones in a channel: off, above and below the range."""


def without_codes(name: str, values: Array) -> tuple[Array, tuple[str, ...]]:
    """Take out of a channel what is no measurement: nan in its place, with words on what was done.

    It is one and the same number, several times over, and lies farther off all others than these lie apart: no motion
    and no force gets there within a sample, and stands still there. One that lies beyond all that is measured counts
    once, too; a single other one is a spike.

    Args:
        name: of the channel.
        values: its samples, shape (n,); nan is blank.
    """
    done: list[str] = []
    kept = values
    for _ in range(MOST_KINDS):
        code = _code_of(kept[np.isfinite(kept)])
        if code is None:
            break
        gone = kept == code
        count = int(np.count_nonzero(gone))
        kept = np.where(gone, np.nan, kept)
        done.append(f"{name} is {code:g} in {counted(count, 'sample')}, far off all others: taken as blank")
    return kept, tuple(done)


def _code_of(values: Array) -> float | None:
    """Give the number that stands for none; None where there is none. `values` are finite, (n,)."""
    if len(values) < 2:
        return None
    for code in (float(np.max(values)), float(np.min(values))):
        others = values[values != code]
        count = len(values) - len(others)
        if not len(others) or count > MOST_CODES * len(values) or (count < 2 and abs(code) <= LARGEST_VALUE):
            continue
        low, high = float(np.min(others)), float(np.max(others))
        if high > low and max(code - high, low - code) > high - low:
            return code
    return None
