"""Pieces of a table without a time are parts of one curve: each gets what is its of the steps to those beside it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.importing.channels.columns import Column
from pipeclamp_identification.importing.channels.naming import names_specimen
from pipeclamp_identification.importing.channels.traces import counted_before, first_motion, turned
from pipeclamp_identification.importing.raw import Channel, RawTable
from pipeclamp_identification.importing.samples.untimed import cycles_of, shares_before
from pipeclamp_models.base.arrays import Array

MOVING = ("displacement", "force")
"""Of which the point between two samples is known: all else is that of the samples themselves."""


@dataclass(frozen=True)
class PieceRows:
    """Rows of a piece of a table, with the points that it shares with those beside it.

    Attributes:
        channels: with a sample more at either end where there is such a point.
        begin: rows of the table before the first of them, or before the one that its first point lies behind.
        cycles_before: that the specimen surely had before; nan where nothing tells.
        places: of each sample in the table, between two where it is such a point; None where all are the table's own.
    """

    channels: tuple[Channel, ...]
    begin: int
    cycles_before: float = math.nan
    places: Array | None = None


def rows_apart(
    table: RawTable, channels: Sequence[Channel], columns: Sequence[Column], begins: Sequence[int]
) -> Iterator[PieceRows]:
    """Give the pieces of a table as they are; arguments as of `joined_rows`."""
    counted = counted_before(table, columns, begins)
    for number, (first, last) in enumerate(itertools.pairwise(begins)):
        before = math.nan if counted is None else float(counted[number])
        yield PieceRows(tuple(replace(one, values=one.values[first:last]) for one in channels), first, before)


def joined_rows(
    table: RawTable, channels: Sequence[Channel], columns: Sequence[Column], begins: Sequence[int]
) -> Iterator[PieceRows]:
    """Give the pieces of a table whose time was not measured; what a machine caught cycles apart is no curve.

    Args:
        table: as the file holds it.
        channels: those of it that are ours, and the texts that tell runs apart.
        columns: which of them is what.
        begins: rows at which pieces begin, and the end.
    """
    y, force = (turned(table, next(one for one in columns if one.ours == ours)) for ours in MOVING)
    shares = [np.nan, *_of_one_specimen(table, shares_before(y, force, begins), begins), np.nan]
    counted = counted_before(table, columns, begins)
    if counted is not None:
        shares[1:-1] = np.where(np.diff(counted) > 1, np.nan, shares[1:-1]).tolist()
    moving = {one.heading for one in columns if one.ours in MOVING}
    cycles = 0.0
    parts = zip(itertools.pairwise(begins), itertools.pairwise(shares), strict=True)
    for number, ((first, last), (own, following)) in enumerate(parts):
        rows = tuple(
            replace(one, values=_with_ends(one.values, first, last, own, following, one.heading in moving))
            for one in channels
        )
        if np.isnan(own):
            cycles = 0.0
        places = _with_ends(np.arange(len(y), dtype=np.float64), first, last, own, following, True)
        before = cycles if counted is None else float(counted[number])
        yield PieceRows(rows, first - int(own < 1), before, places)
        motion = first_motion(RawTable(table.name, rows), columns, None)
        cycles += cycles_of(motion[np.isfinite(motion)])


def _of_one_specimen(table: RawTable, shares: Array, begins: Sequence[int]) -> list[float]:
    """Give the shares, nan where the piece is of another specimen than the one before it."""
    named = [one.values for one in (*table.channels, *table.labels) if names_specimen(one.name)]
    return [
        float(share) if all(_is_same(*values[first - 1 : first + 1]) for values in named) else np.nan
        for first, share in zip(begins[1:-1], shares, strict=True)
    ]


def _is_same(before: float, after: float) -> bool:
    """Tell whether two cells are the same; blanks are."""
    return before == after or bool(np.isnan(before) and np.isnan(after))


def _with_ends(values: Array, first: int, last: int, own: float, following: float, moves: bool) -> Array:
    """Give samples first to last - 1 with the points on the steps to either side where these belong to them, too."""
    parts = [values[first:last]]
    if own < 1:
        parts.insert(0, np.array([_between(values, first, own) if moves else values[first]]))
    if following > 0:
        parts.append(np.array([_between(values, last, following) if moves else values[last - 1]]))
    return np.concatenate(parts)


def _between(values: Array, place: int, share: float) -> float:
    """Give the value on the step to a sample, behind a share of it."""
    return float(values[place - 1] + share * (values[place] - values[place - 1]))
