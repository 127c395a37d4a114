"""Tables whose rows are results of tests, and no samples of a motion."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from pipeclamp_identification.importing.naming import rank, unit_of
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import LOSSES, STIFFNESSES, quantity_of, turned
from pipeclamp_identification.units.stated import conversion

CYCLES_A_ROW = 2.0
"""Cycles that pass from row to row, beyond which rows are no samples of them: records have many rows a cycle, and a
column of the samples per second has one."""


def frequency_of_results(table: RawTable, stated: Collection[str] = ()) -> Channel | None:
    """Give the frequency of a table whose rows are tests of their own, None of any other table.

    They are told by the cycles that pass between two rows or, without a time, by columns of stiffness and loss.

    Args:
        table: as a file holds it.
        stated: quantities of a record that the user says are there.
    """
    found = {quantity: channel for channel in table.channels if (quantity := quantity_of(channel))}
    frequency = found.get("frequency")
    if frequency is None:
        return None
    times = [channel for channel in table.channels if rank("time", channel) > 2]
    if times:
        return frequency if min(_cycles_a_row(frequency, time) for time in times) > CYCLES_A_ROW else None
    if {"displacement", "force"} <= set(stated):
        return None
    return frequency if any(quantity in found for quantity in (*STIFFNESSES, *LOSSES)) else None


def _cycles_a_row(frequency: Channel, time: Channel) -> float:
    """Give how many cycles pass from one row to the next, the median of all."""
    step = conversion("time", unit_of(time)).factor * np.diff(time.values)
    per_second = turned("frequency", unit_of(frequency))
    assert per_second is not None
    cycles = per_second.factor * frequency.values[1:] * step
    cycles = cycles[np.isfinite(cycles) & (step > 0)]
    return float(np.median(cycles)) if len(cycles) else 0.0


def results_words(table: RawTable, stated: Collection[str] = ()) -> str:
    """Say of a table of results what it is."""
    frequency = frequency_of_results(table, stated)
    assert frequency is not None
    values = frequency.values[np.isfinite(frequency.values)]
    return (
        f"holds results, a row a test ({frequency.heading!r} from {np.min(values):.4g} to {np.max(values):.4g}), and "
        "no samples of a motion; such files are imported by themselves, as a campaign of metrics"
    )
