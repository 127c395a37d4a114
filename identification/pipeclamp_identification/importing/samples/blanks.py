"""Blank samples, as a logger leaves them where it lost some: short rows of them are bridged, longer ones cut off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.clipping import FEWEST_ON_A_PLATEAU
from pipeclamp_identification.campaign.records import NEEDED, Record, UnusableRecord
from pipeclamp_identification.importing.samples.split import GAP_CYCLES, turns_of
from pipeclamp_models.base.arrays import Array, BoolArray
from pipeclamp_models.base.said import counted

MOST_BLANK = 0.01
"""Share of a channel's samples that may be blank in rows as long as a gap in time may be."""
FINE_CYCLES = 0.02
"""Rows so short are bridged however many there are: a channel may be sampled at a part of another's rate."""
HELD_CYCLES = 0.05
"""A number that a channel holds for longer, while the other moves, may be none that was measured."""
MOVES = 0.1
"""Share of its range by which the other channel moves meanwhile."""
JUMPS = 0.05
"""Share of its own range by which it goes there or back at once: a sensor's last digit that stands doesn't."""
MOST_HELD = 0.5
"""Of the cycles have such a stretch, or it is the clamp's own."""
MOVING = ("displacement_mm", "force_N")
FEWEST_CYCLES = 3
"""Fewer cycles between blanks aren't worth a run."""


@dataclass(frozen=True)
class Whole:
    """A record without blanks: samples first to last - 1 of those that there were, and words on what was done."""

    record: Record
    first: int
    last: int
    done: tuple[str, ...] = ()


def without_blanks(record: Record, row: Callable[[int], int]) -> Whole:
    """Put short rows of blanks on straight lines; keep the longest stretch without long ones.

    Args:
        record: one run; nan is blank.
        row: gives the row of the file that a sample stands in.

    Raises:
        UnusableRecord: no three cycles in a row are left.
    """
    blank = {name: ~np.isfinite(values) for name, values in record.channels.items()}
    still = {name: _longest_plateau(record.channels[name]) for name in MOVING}
    if not any(np.any(gone) for gone in blank.values()) and max(still.values()) < FEWEST_ON_A_PLATEAU:
        return Whole(record, 0, len(record.time_s))
    cycle = _samples_of_cycle(on_lines(record.displacement_mm, blank["displacement_mm"]))
    done: tuple[str, ...] = ()
    for name, other in (MOVING, MOVING[::-1]):
        held = _held(record.channels[name], record.channels[other], cycle)
        for begin, end in held:
            blank[name][begin:end] = True
        if held:
            begin, end = held[0]
            more = f", and {len(held) - 1} times more" if len(held) > 1 else ""
            done += (
                f"{name} stands at {record.channels[name][begin]:g} for {end - begin} samples from row {row(begin)} "
                f"on, while {other} moves{more}: taken as blank",
            )
    if not any(np.any(gone) for gone in blank.values()):
        return Whole(record, 0, len(record.time_s))
    long = {name: _long_rows(blank[name], cycle) for name in NEEDED}
    cut = np.logical_or.reduce([*long.values()])
    first, last = _longest(~cut)
    if last - first < len(cut):
        where = ", ".join(name for name, rows in long.items() if np.any(rows))
        count = int(np.count_nonzero(cut))
        words = f"{count} sample{'s are' if count > 1 else ' is'} blank in {where}, the first in row "
        words += str(row(int(np.argmax(cut))))
        if last - first < max(FEWEST_CYCLES * cycle, 2):
            raise UnusableRecord(f"{words}; no {FEWEST_CYCLES} cycles in a row are without")
        done += (f"{words}: cut off, the longest stretch without them is kept",)
    kept = {}
    for name, gone in blank.items():
        count = int(np.count_nonzero(gone[first:last]))
        if count == last - first:
            continue  # a temperature that this stretch doesn't have
        kept[name] = on_lines(record.channels[name], gone)[first:last]
        if count:
            done += (f"{counted(count, 'blank sample')} in {name}: replaced by straight lines",)
    return Whole(Record(**kept), first, last, done)


def _longest_plateau(values: Array) -> int:
    """Give how many samples in a row are one number, at most."""
    changes = np.flatnonzero(values[1:] != values[:-1])
    return int(np.max(np.diff(changes, prepend=-1, append=len(values) - 1)))


def _held(values: Array, other: Array, cycle: float) -> list[tuple[int, int]]:
    """Give stretches, as (first, one after the last), in which a channel holds one number while the other moves.

    A logger that misses a channel repeats its last number, or writes zero. Play holds the force in every cycle, and the
    end of a sensor's range is looked for elsewhere: neither counts.
    """
    if not cycle or not np.any(np.isfinite(values)) or not np.any(np.isfinite(other)):
        return []
    edges = np.concatenate([[0], np.flatnonzero(values[1:] != values[:-1]) + 1, [len(values)]])
    begins, ends = edges[:-1], edges[1:]
    long = np.flatnonzero(ends - begins >= max(HELD_CYCLES * cycle, FEWEST_ON_A_PLATEAU))
    if len(long) * cycle > MOST_HELD * len(values):
        return []
    if not len(long):
        return []
    extremes, steps = (np.nanmin(values), np.nanmax(values)), np.abs(np.diff(values))
    jump = max(JUMPS * float(extremes[1] - extremes[0]), 2 * float(np.nanpercentile(steps, 95)))
    least = MOVES * float(np.nanmax(other) - np.nanmin(other))
    found = []
    for begin, end in zip(begins[long].tolist(), ends[long].tolist(), strict=True):
        moved = other[begin:end][np.isfinite(other[begin:end])]
        beside = [steps[place] for place in (begin - 1, end - 1) if 0 <= place < len(steps)]
        if values[begin] not in extremes and len(moved) and np.ptp(moved) > least and max(beside, default=0) > jump:
            found.append((begin, end))
    return found


def on_lines(values: Array, gone: BoolArray) -> Array:
    """Put samples on straight lines between the others, those before the first and behind the last on these.

    Args:
        values: of a channel, shape (n,).
        gone: which of them, shape (n,); where all or none are, nothing is done.
    """
    if np.all(gone) or not np.any(gone):
        return values
    places = np.arange(len(values))
    return np.where(gone, np.interp(places, places[~gone], values[~gone]), values)


def _samples_of_cycle(y: Array) -> float:
    """Give how many samples a cycle has, about; 0 where there is none."""
    turns = turns_of(y)
    return 2 * float(np.median(np.diff(turns))) if len(turns) > 3 else 0.0


def _long_rows(blank: BoolArray, cycle: float) -> BoolArray:
    """Give which blanks can't be bridged: those at either end, and rows that are too long for how many there are."""
    edges = np.flatnonzero(np.diff(blank.astype(np.int8), prepend=0, append=0))
    begins, ends = edges[::2], edges[1::2]
    few = np.count_nonzero(blank) <= MOST_BLANK * len(blank)
    longest = max((GAP_CYCLES if few else FINE_CYCLES) * cycle, 1 if few else 0)
    long = (ends - begins > longest) | (begins == 0) | (ends == len(blank))
    found = np.zeros(len(blank), dtype=np.bool_)
    for begin, end in zip(begins[long].tolist(), ends[long].tolist(), strict=True):
        found[begin:end] = True
    return found


def _longest(kept: BoolArray) -> tuple[int, int]:
    """Give the longest row of samples that are kept, as (first, one after the last)."""
    edges = np.flatnonzero(np.diff(kept.astype(np.int8), prepend=0, append=0))
    if not len(edges):
        return 0, 0
    best = int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[2 * best]), int(edges[2 * best + 1])
