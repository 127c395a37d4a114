"""Channels that were sampled at different rates, in tables of their own, put on one time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeclamp_identification.importing.channels.columns import Column, map_columns
from pipeclamp_identification.importing.channels.naming import rank
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.said import few_of


def joined_rates(tables: Sequence[RawTable], base: RawTable | None = None) -> RawTable | None:
    """Give the tables of a file as one, on the times of one of them; None where fewer than two have times.

    Others are put there by straight lines. Where one is a whole test, others stand still before and behind their own
    samples, as a temperature does; else only what lies where all were sampled is taken.

    Args:
        tables: each with a channel of time.
        base: which is a whole test, if any; else the longest gives the times.
    """
    timed = [(table, time, column) for table in tables for time, column in _time(table)]
    whole = next((one for one in timed if one[0] is base), None)
    if base is not None:
        ends = (float(whole[1][0]), float(whole[1][-1])) if whole else (math.inf, -math.inf)
        timed = [one for one in timed if one[1][0] < ends[1] and one[1][-1] > ends[0]]
    if len(timed) < 2:
        return None
    chosen, time, _ = whole or max(timed, key=lambda one: one[0].length)
    first, last = max(float(one[0]) for _, one, _ in timed), min(float(one[-1]) for _, one, _ in timed)
    within = np.ones(len(time), dtype=np.bool_) if whole else (time >= first) & (time <= last)
    if np.count_nonzero(within) < 2:
        return None
    channels = [replace(channel, values=channel.values[within]) for channel in chosen.channels]
    taken = {channel.heading for channel in channels}
    for table, own, column in timed:
        if table is chosen:
            continue
        for channel in table.channels:
            if channel.heading != column.heading and channel.heading not in taken:
                taken.add(channel.heading)
                channels.append(Channel(channel.name, channel.unit, np.interp(time[within], own, channel.values)))
    moved = [repr(channel.heading) for channel in channels[len(chosen.channels) :]]
    words = f"put on the times of the {'test' if whole else 'fastest channel'} by straight lines: {few_of(moved)}"
    joined = (*chosen.joined, words)
    return replace(chosen, name="", channels=tuple(channels), labels=(), titles=(), joined=joined)


def by_own_times(table: RawTable) -> list[RawTable]:
    """Give a table for each channel of one in which a time stands before each, not all the same; nothing for others."""
    times, channels = table.channels[::2], table.channels[1::2]
    alternate = len(times) == len(channels) > 1 and all(
        rank("time", time) and not rank("time", channel) for time, channel in zip(times, channels, strict=True)
    )
    if not alternate or all(np.array_equal(times[0].values, one.values, equal_nan=True) for one in times):
        return []
    tables = []
    for pair in zip(times, channels, strict=True):
        filled = np.isfinite(pair[0].values)
        own = tuple(replace(channel, values=channel.values[filled]) for channel in pair)
        tables.append(replace(table, name=pair[1].name, channels=own, labels=(), titles=()))
    return tables


def _time(table: RawTable) -> list[tuple[Array, Column]]:
    """Give a table's time in s, and its channel; nothing where there is none that rises."""
    column = next((one for one in map_columns(table).columns if one.ours == "time"), None)
    if column is None:
        return []
    values = next(channel.values for channel in table.channels if channel.heading == column.heading)
    time = np.asarray(values * column.conversion.factor + column.conversion.offset)
    return [(time, column)] if np.all(np.isfinite(time)) and np.all(np.diff(time) > 0) else []
