"""Channels that were sampled at different rates, in tables of their own, put on one time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeclamp_identification.importing.columns import Column, map_columns
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_models.base.arrays import Array


def joined_rates(tables: Sequence[RawTable]) -> RawTable | None:
    """Give the tables of a file as one, on the times of the longest; None where fewer than two have times.

    Others are put there by straight lines, and only where all of them were sampled.

    Args:
        tables: each with a channel of time.
    """
    timed = [(table, time, column) for table in tables for time, column in _time(table)]
    if len(timed) < 2:
        return None
    base, time, _ = max(timed, key=lambda one: one[0].length)
    first, last = max(float(one[0]) for _, one, _ in timed), min(float(one[-1]) for _, one, _ in timed)
    within = (time >= first) & (time <= last)
    if np.count_nonzero(within) < 2:
        return None
    channels = [replace(channel, values=channel.values[within]) for channel in base.channels]
    taken = {channel.heading for channel in channels}
    for table, own, column in timed:
        if table is base:
            continue
        for channel in table.channels:
            if channel.heading != column.heading and channel.heading not in taken:
                taken.add(channel.heading)
                channels.append(Channel(channel.name, channel.unit, np.interp(time[within], own, channel.values)))
    told = f"channels of {len(timed)} rates, on the times of the fastest by straight lines"
    return RawTable("", tuple(channels), base.first_row, (*base.told, told))


def _time(table: RawTable) -> list[tuple[Array, Column]]:
    """Give a table's time in s, and its channel; nothing where there is none that rises."""
    column = next((one for one in map_columns(table).columns if one.ours == "time"), None)
    if column is None:
        return []
    values = next(channel.values for channel in table.channels if channel.heading == column.heading)
    time = np.asarray(values * column.conversion.factor + column.conversion.offset)
    return [(time, column)] if np.all(np.isfinite(time)) and np.all(np.diff(time) > 0) else []
