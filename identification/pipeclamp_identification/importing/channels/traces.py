"""A table with its channels known becomes samples in our units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.importing.channels.columns import Column, columns_option
from pipeclamp_identification.importing.channels.naming import EACH_CYCLE, SEGMENT, counts_cycles
from pipeclamp_identification.importing.raw import Channel, LabelColumn, RawTable
from pipeclamp_identification.importing.samples.codes import without_codes
from pipeclamp_identification.importing.samples.each_cycle import cycle_numbers
from pipeclamp_identification.importing.samples.repair import mended_channel
from pipeclamp_identification.signals.sample_noise import sample_noise
from pipeclamp_identification.units.stated import Conversion
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import counted
from pipeclamp_models.base.units import CELSIUS

MOVES, BEYOND_NOISE = 0.5, 8.0
"""Share of its size, and rms of its noise, by more than which a condition moves within a run before that is said."""
FEWEST_WATCHED = 20
"""Samples of it from which on that is told."""


@dataclass(frozen=True)
class Trace:
    """The samples of a table: record, what tells its runs apart, further channels, and their places in the table.

    Attributes:
        record: in our units, as measured; time may go back where a file holds several runs.
        motion: the displacement without blanks and spikes, mm, shape (n,), by which runs are told apart.
        further: conditions that were measured, by column of runs.csv, shape (n,) each.
        places: of each sample in the table, counted from 0, shape (n,).
        done: what was done.
    """

    record: Record
    motion: Array
    further: Mapping[str, Array]
    places: Array
    done: tuple[str, ...]


LOOKED_AT = 1_000_000
"""Samples of a table that tell how long its cycles are."""


def time_of(table: RawTable, columns: Sequence[Column], rate: float | None, begin: int = 0) -> Array:
    """Give a table's time in s; arguments as of `trace_of`.

    Raises:
        UserError: there is neither a channel of time nor a rate.
    """
    for column in columns:
        if column.ours == "time":
            return without_wrong_stamps(turned(table, column))
    if rate is None:
        raise UserError(
            "no channel is the time; expected the samples per second: --rate, or --rate none where time was not "
            "measured"
        )
    return np.arange(begin, begin + table.length) / rate


def without_wrong_stamps(time: Array) -> Array:
    """Take single stamps out that time goes back to or from, though it goes on without them: nan in their place.

    Args:
        time: in any unit, shape (n,).
    """
    back = np.flatnonzero(time[1:] < time[:-1])
    if not len(back):
        return time
    # the wrong one of two stands before the step or behind it
    places = np.unique([back, back + 1])
    places = places[(places > 0) & (places < len(time) - 1)]
    wrong = places[time[places + 1] > time[places - 1]]
    wrong = wrong[(time[wrong] < time[wrong - 1]) | (time[wrong] > time[wrong + 1])]
    if not len(wrong):
        return time
    found = time.copy()
    found[wrong] = np.nan
    return found


def first_motion(table: RawTable, columns: Sequence[Column], timed: IntArray | None) -> Array:
    """Give the first samples of the displacement that have a time, in mm, lines in the place of blanks and spikes.

    `timed`: rows that have a time, (n,); None for all.
    """
    column = next(one for one in columns if one.ours == "displacement")
    first = np.arange(min(LOOKED_AT, table.length)) if timed is None else timed[:LOOKED_AT]
    return mended_channel("displacement_mm", without_codes("displacement_mm", turned(table, column, first))[0])


def segment_of(table: RawTable, columns: Sequence[Column], timed: IntArray | None) -> Array | None:
    """Give what tells the runs of a table apart, of the samples that have a time; None where there is nothing.

    `timed`: as for `first_motion`.
    """
    column = next((one for one in columns if one.ours == SEGMENT), None)
    return None if column is None else turned(table, column, timed)


def with_cycles_numbered(table: RawTable, columns: Sequence[Column]) -> tuple[RawTable, Column]:
    """Give a table with a channel that numbers its cycles, and that as the one that tells its runs apart."""
    column = next(one for one in columns if one.ours == "displacement")
    motion = mended_channel("displacement_mm", without_codes("displacement_mm", turned(table, column))[0])
    finite = np.isfinite(motion)
    numbers = np.full(table.length, np.nan)
    numbers[finite] = cycle_numbers(motion[finite])
    channel = Channel(EACH_CYCLE, "", numbers)
    return replace(table, channels=(*table.channels, channel)), Column(SEGMENT, EACH_CYCLE, "", stated=True)


def counted_before(table: RawTable, columns: Sequence[Column], begins: Sequence[int]) -> Array | None:
    """Give the cycles that a machine had counted before each piece, shape (pieces,); None where nothing counts them.

    Args:
        table: as the file holds it.
        columns: which of its channels is what; the one that parts runs may count cycles, from 1 or from 0 on.
        begins: rows at which pieces begin, and the end.
    """
    column = next((one for one in columns if one.ours == SEGMENT), None)
    # texts are held by their places among each other, which count nothing
    if column is None or not counts_cycles(column.heading) or label_column(table, columns) is not None:
        return None
    count = turned(table, column, None)
    if not np.all(np.isfinite(count)) or np.any(count != np.round(count)) or np.any(count < 0):
        return None
    return np.asarray(count[list(begins[:-1])] - min(float(count.min(initial=1.0)), 1.0), dtype=np.float64)


def label_column(table: RawTable, columns: Sequence[Column]) -> LabelColumn | None:
    """Give the column of texts that tells the runs of a table apart; None where there is none."""
    headings = {one.heading for one in columns if one.ours == SEGMENT}
    return next((label for label in table.labels if label.heading in headings), None)


def turned(table: RawTable, column: Column, rows: IntArray | None = None) -> Array:
    """Give a channel's samples in our unit, of all rows or of chosen ones, shape (n,)."""
    known = (*table.channels, *table.labels)
    values = next(channel.values for channel in known if channel.heading == column.heading)
    chosen = values if rows is None else values[rows]
    factor, offset = column.conversion.factor, column.conversion.offset
    # a large table has no room for copies
    return chosen if (factor, offset) == (1.0, 0.0) else np.asarray(chosen * factor + offset)


def trace_of(where: str, table: RawTable, columns: Sequence[Column], rate: float | None, begin: int = 0) -> Trace:
    """Give a table's samples in our units.

    Args:
        where: names the table in errors.
        table: as the file holds it.
        columns: which channels are ours.
        rate: samples per second, where no channel holds the time.
        begin: samples that were taken before the table's first one.

    Raises:
        UserError: a temperature lies below absolute zero.
    """
    values = {column.ours: turned(table, column) for column in columns} | {"time": time_of(table, columns, rate, begin)}
    kept = np.isfinite(values["time"])
    places = np.flatnonzero(kept)
    if len(places) < len(kept):
        values = {name: samples[kept] for name, samples in values.items()}
    lost = len(kept) - len(places)
    rows = counted(lost, "row")
    left_aside = [f"{rows} without time, or with a stamp that time goes back to or from, left aside"] if lost else []
    _refuse_below_zero(where, columns, values)
    displacement, no_displacement = without_codes("displacement_mm", values["displacement"])
    force, no_force = without_codes("force_N", values["force"])
    record = Record(
        time_s=values["time"],
        displacement_mm=displacement,
        force_N=force,
        temperature_C=values.get("temperature"),
    )
    further = {
        name: samples
        for name, samples in values.items()
        if name not in ("time", "displacement", "force", "temperature", SEGMENT)
    }
    return Trace(
        record,
        mended_channel("displacement_mm", record.displacement_mm),
        further,
        places.astype(np.float64),
        (*left_aside, *no_displacement, *no_force),
    )


def _refuse_below_zero(where: str, columns: Sequence[Column], values: Mapping[str, Array]) -> None:
    if "temperature" not in values:
        return
    lowest = float(np.nanmin(values["temperature"])) if np.any(np.isfinite(values["temperature"])) else math.inf
    if lowest < -CELSIUS:
        column = next(one for one in columns if one.ours == "temperature")
        remedy = f"{column.heading} [°C]" if column.conversion != Conversion() else "none"
        raise UserError(
            f"{where}, channel {column.heading!r}: {lowest:.4g} °C is below absolute zero; expected another unit than "
            f"{column.unit!r}, or none: state it, for example {columns_option([f'temperature={remedy}'])}"
        )


def moved_words(name: str, values: Array) -> str:
    """Say that a further condition isn't one within a run, but moves by more than noise; "" where it stays.

    Args:
        name: its column of runs.csv.
        values: its samples, shape (n,); nan is blank.
    """
    finite = values[np.isfinite(values)]
    if len(finite) < FEWEST_WATCHED:
        return ""
    low, high = np.quantile(finite, (0.05, 0.95)).tolist()
    if high - low <= max(MOVES * max(abs(low), abs(high)), BEYOND_NOISE * sample_noise(finite)):
        return ""
    return f"{name} moves from {low:.3g} to {high:.3g} within it: its mean counts, and no law follows it along a run"
