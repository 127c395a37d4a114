"""A table with its channels known becomes samples in our units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.importing.columns import SEGMENT, Column
from pipeclamp_identification.importing.raw import RawTable
from pipeclamp_identification.importing.repair import mended_channel
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.units import CELSIUS


@dataclass(frozen=True)
class Trace:
    """The samples of a table: record, what tells its runs apart, further channels, and their places in the table.

    Attributes:
        record: in our units, as measured; time may go back where a file holds several runs.
        motion: the displacement without blanks and spikes, mm, shape (n,), by which runs are told apart.
        segment: shape (n,), None where there is no such channel.
        further: conditions that were measured, by column of runs.csv, shape (n,) each.
        places: of each sample in the table, counted from 0, shape (n,).
        told: what was done.
    """

    record: Record
    motion: Array
    segment: Array | None
    further: Mapping[str, Array]
    places: Array
    told: tuple[str, ...]


def trace_of(where: str, table: RawTable, columns: Sequence[Column], rate: float | None) -> Trace:
    """Give a table's samples in our units.

    Args:
        where: names the table in errors.
        table: as the file holds it.
        columns: which channels are ours.
        rate: samples per second, where no channel holds the time.

    Raises:
        UserError: a temperature lies below absolute zero.
    """
    by_heading = {channel.heading: channel.values for channel in table.channels}
    values: dict[str, Array] = {
        column.ours: np.asarray(by_heading[column.heading] * column.conversion.factor + column.conversion.offset)
        for column in columns
    }
    if "time" not in values and rate:
        values["time"] = np.arange(table.length) / rate
    kept = np.isfinite(values["time"])
    places = np.flatnonzero(kept)
    if len(places) < len(kept):
        values = {name: samples[kept] for name, samples in values.items()}
    told = [] if len(places) == len(kept) else [f"{len(kept) - len(places)} rows without time are left aside"]
    _refuse_below_zero(where, columns, values)
    record = Record(
        time_s=values["time"],
        displacement_mm=values["displacement"],
        force_N=values["force"],
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
        values.get(SEGMENT),
        further,
        places.astype(np.float64),
        tuple(told),
    )


def _refuse_below_zero(where: str, columns: Sequence[Column], values: Mapping[str, Array]) -> None:
    if "temperature" not in values:
        return
    lowest = float(np.nanmin(values["temperature"])) if np.any(np.isfinite(values["temperature"])) else math.inf
    if lowest < -CELSIUS:
        column = next(one for one in columns if one.ours == "temperature")
        raise UserError(
            f"{where}, channel {column.heading!r}: {lowest:.4g} °C is below absolute zero; expected another unit than "
            f"{column.unit!r}: state it, for example --columns 'temperature={column.heading} [°C]'"
        )
