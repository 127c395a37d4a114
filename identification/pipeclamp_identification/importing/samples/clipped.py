"""Clipped stretches taken out of a record, down to its longest row of whole cycles within the sensor's range."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.campaign.clipping import CHANNEL_COLUMNS
from pipeclamp_identification.campaign.cycles import Cycles
from pipeclamp_identification.campaign.faults import SensorFailure
from pipeclamp_identification.campaign.records import Record

FEWEST_CYCLES = 3
"""Fewer whole cycles aren't worth a run."""


def without_clipped_cycles(record: Record, cycles: Cycles, failure: SensorFailure) -> tuple[Record, str]:
    """Give the longest row of cycles that never reach the value at which a sensor stands, and words on it.

    Args:
        record: in which a sensor stands at an extreme value.
        cycles: its steady cycles.
        failure: of the sensor.

    Raises:
        SensorFailure: the same, where fewer than three cycles in a row are left.
    """
    if failure.fault != "clipped" or failure.size is None:
        raise failure
    samples = getattr(record, CHANNEL_COLUMNS[failure.channel])
    at = samples == failure.size
    clipped = [bool(np.any(at[begin:end])) for begin, end in zip(cycles.bounds[:-1], cycles.bounds[1:], strict=True)]
    rows = np.split(np.arange(cycles.count), np.flatnonzero(np.diff(np.array(clipped, dtype=np.int8)) != 0) + 1)
    whole = [row for row in rows if not clipped[int(row[0])]]
    best = max(whole, key=len, default=np.array([], dtype=np.intp))
    if len(best) < FEWEST_CYCLES:
        raise failure
    first, last = int(cycles.bounds[best[0]]), int(cycles.bounds[best[-1] + 1])
    return record.part(first, last), (
        f"{failure}; {sum(clipped)} of {cycles.count} cycles are clipped and cut off, the longest row of "
        f"{len(best)} others is kept"
    )
