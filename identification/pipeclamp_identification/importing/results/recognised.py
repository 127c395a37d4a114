"""Tables whose rows are results of tests, and no samples of a motion."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pipeclamp_identification.importing.channels.columns import Stated, channel_named
from pipeclamp_identification.importing.channels.naming import rank, unit_of
from pipeclamp_identification.importing.channels.questions import NONE
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.results.quantities import LOSSES, STIFFNESSES, TARGETS, quantity_of, turned
from pipeclamp_identification.units.stated import conversion
from pipeclamp_models.base.errors import UserError

CYCLES_A_ROW = 2.0
"""Cycles that pass from row to row, beyond which rows are no samples of them: records have many rows a cycle, and a
column of the samples per second has one."""


def holds_results(table: RawTable, stated: Sequence[Stated] = ()) -> bool:
    """Tell whether a table's rows are tests of their own.

    They are by its frequency or, where it has neither that nor a time, as a sweep of the amplitude has none, by columns
    of what each test's stiffness is and what it lost.

    Args:
        table: as a file holds it.
        stated: what the user says of its channels.
    """
    if frequency_of_results(table, stated) is not None:
        return True
    said = {one.ours for one in stated if one.channel.casefold() != NONE}
    if said & {"time", "displacement", "force"} or any(rank("time", channel) > 2 for channel in table.channels):
        return False
    return _are_known({*said, *map(quantity_of, table.channels)})


def frequency_of_results(table: RawTable, stated: Sequence[Stated] = ()) -> Channel | None:
    """Give the frequency of a table whose rows are tests of their own, None of any other table.

    They are told by what the user states, by the cycles that pass between two rows or, where no motion stands beside a
    time, by columns of stiffness and loss; without a time, names alone of these tell.

    Args:
        table: as a file holds it.
        stated: what the user says of its channels.
    """
    said = {one.ours: one for one in stated}
    if "frequency" in said and said.keys() & {*STIFFNESSES, *LOSSES}:
        with suppress(UserError):
            return channel_named(table, said["frequency"])[0]
    found = {quantity: channel for channel in table.channels if (quantity := quantity_of(channel))}
    frequency = found.get("frequency")
    if frequency is None:
        return None if said.keys() & {"time", "displacement", "force"} else without_units(table).get("frequency")
    times = [channel for channel in table.channels if rank("time", channel) > 2]
    if times:
        apart = min(_cycles_a_row(frequency, time) for time in times) > CYCLES_A_ROW
        return frequency if apart or (_are_known(found) and not _holds_a_loop(table)) else None
    if {"displacement", "force"} <= said.keys():
        return None
    return frequency if any(quantity in found for quantity in (*STIFFNESSES, *LOSSES)) else None


def _are_known(quantities: Collection[str]) -> bool:
    """Tell whether quantities of a result say how stiff a test was and what it lost."""
    have = set(quantities)
    return {"storage_stiffness", "loss_stiffness"} <= have or bool(have & set(LOSSES) and have & set(STIFFNESSES))


def _holds_a_loop(table: RawTable) -> bool:
    """Tell whether names and units of a table tell a displacement and a force that move."""
    return all(
        any(rank(moved, one) > 2 and len(np.unique(one.values[np.isfinite(one.values)])) > 1 for one in table.channels)
        for moved in ("displacement", "force")
    )


def _cycles_a_row(frequency: Channel, time: Channel) -> float:
    """Give how many cycles pass from one row to the next, the median of all."""
    step = conversion("time", unit_of(time)).factor * np.diff(time.values)
    per_second = turned("frequency", unit_of(frequency), frequency.name)
    assert per_second is not None
    cycles = per_second.factor * frequency.values[1:] * step
    cycles = cycles[np.isfinite(cycles) & (step > 0)]
    return float(np.median(cycles)) if len(cycles) else 0.0


def without_units(table: RawTable) -> dict[str, Channel]:
    """Give the channels of a table that names alone tell to hold results, by quantity; none where there is a time."""
    if any(rank("time", channel) > 2 for channel in table.channels):
        return {}
    found: dict[str, Channel] = {}
    for channel in table.channels:
        named = [one for one, unit in TARGETS.items() if quantity_of(replace(channel, unit=unit or "-")) == one]
        if not unit_of(channel) and named:
            found.setdefault(named[0], channel)
    return found if "frequency" in found and _are_known(found) else {}


def results_words(table: RawTable, stated: Sequence[Stated] = ()) -> str:
    """Say of a table of results what it is."""
    frequency = frequency_of_results(table, stated)
    values = np.empty(0) if frequency is None else frequency.values[np.isfinite(frequency.values)]
    of = (
        f" ({frequency.heading!r} from {np.min(values):.4g} to {np.max(values):.4g})"
        if frequency and len(values)
        else ""
    )
    return (
        f"holds results, a row a test{of}, and no samples of a motion; such files are imported by themselves, as a "
        "campaign of metrics"
    )
