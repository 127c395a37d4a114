"""One table with many runs becomes many: by gaps in time, a counter, rests, and steps of amplitude or frequency."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from pipeclamp_identification.signals.half_cycles import turning_points
from pipeclamp_models.base.arrays import Array, IntArray

GAP_STEPS = 20
"""A gap in time is one of so many usual steps at least."""
GAP_CYCLES = 0.25
"""And of so much of a cycle: shorter ones are bridged when the record is read."""
NOISE, SHARE = 8.0, 0.004
"""A turn counts from so many rms of the noise on, and from this share of the whole range."""
SAME_LEVEL = 0.04
"""Cycles whose amplitude and period differ by less from those before them are at one level."""
REMEMBERED = 9
"""Half cycles before, whose median is the level: a control loop that creeps makes no step."""
FEWEST_CYCLES = 3.0
"""Cycles from which on a level is one, and no part of a ramp."""
AT_EDGE = 0.75
"""Cycles at the end of a piece that belong to the level beside them: a record may begin anywhere in a cycle."""
MOSTLY_STEADY = 0.5
"""A piece of which less stands at levels isn't cut by them: its motion is of another kind."""
FEWEST_TURNS = 6
"""Turns of a motion that is looked at."""
STANDING = 10.0
"""Times as long as nearly all ways from turn to turn a motion stands still on which cycles ride: those of the large one
are 7 times as long as those of cycles with 7 times its frequency."""
AT_REST = 0.1
"""Share of the neighbouring amplitude within which the machine rests."""
RESTING = 2.0
"""Cycles without a turn that make a rest."""
LOOKED_AT = 1_000_000
"""Steps of time, evenly chosen, that tell the usual one."""
RIDING = 0.1
"""Share of the amplitude by which the middle of cycles that ride on a larger motion moves from one to the next.
That of the cycles which a next test asks for, a quarter of the large one's amplitude at 7 times its frequency, moves by
1.5 times it and more."""
CREEPS = 0.5
"""Levels that change by more than this share of `SAME_LEVEL` from end to end creep; most of them do in a sweep."""


@dataclass(frozen=True)
class Part:
    """Samples first to last - 1 of a table: a run, or what was cut, and why."""

    first: int
    last: int
    why: str = ""


@dataclass(frozen=True)
class Cut:
    """How a table was cut: its runs, and what is left of it."""

    runs: tuple[Part, ...]
    left: tuple[Part, ...]


def split(time: Array, displacement: Array, segment: Array | None = None) -> Cut:
    """Split a table into runs.

    Args:
        time: s, shape (n,); it may go back where a machine's clock began anew.
        displacement: mm, shape (n,).
        segment: a number that stays the same within a run, shape (n,), where there is one.
    """
    bounds = piece_bounds(time, lambda: displacement, segment)
    runs: list[Part] = []
    left: list[Part] = []
    for first, last in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        found = levels(time[first:last], displacement[first:last])
        runs += [Part(first + part.first, first + part.last, part.why) for part in found.runs]
        left += [Part(first + part.first, first + part.last, part.why) for part in found.left]
    return Cut(tuple(runs), tuple(left))


def piece_bounds(time: Array, motion: Callable[[], Array], segment: Array | None = None) -> IntArray:
    """Give where pieces begin that are different runs, and the end: time goes back or has a gap, the segment changes.

    Args:
        time: s, shape (n,).
        motion: gives the displacement in mm, or the first part of it, which tells how long cycles are.
        segment: shape (n,), where there is one.
    """
    changes = np.empty(0, dtype=np.intp)
    if segment is not None:
        change = np.diff(segment)
        changes = np.flatnonzero((change != 0.0) & ~np.isnan(change)) + 1
        del change
    step = np.diff(time)
    some = step[:: max(1, len(step) // LOOKED_AT)]
    usual = float(np.median(some[some > 0])) if np.any(some > 0) else 0.0
    cuts = np.flatnonzero((step < 0) | (step > GAP_STEPS * usual)) + 1
    if len(cuts) or len(changes):
        y = motion()
        turns = turns_of(y)
        half = float(np.median(np.abs(np.diff(time[turns])))) if len(turns) > 3 else 0.0
        cuts = cuts[(step[cuts - 1] < 0) | (step[cuts - 1] > GAP_CYCLES * 2 * half)]
        # a counter of cycles tells no runs apart
        if np.count_nonzero(changes < len(y)) < max(len(turns) / 6, 1):
            cuts = np.union1d(cuts, changes)
    return np.concatenate([[0], cuts, [len(time)]]).astype(np.intp)


def turns_of(y: Array) -> IntArray:
    """Give the turning points of a motion, noise aside."""
    if len(y) < 5:
        return np.array([0, max(len(y) - 1, 0)], dtype=np.intp)
    noise = float(np.median(np.abs(np.diff(y, 4)))) / 0.6745 / math.sqrt(70)
    least = max(NOISE * noise, SHARE * float(np.ptp(y)))
    return turning_points(y, np.full(len(y), least))


def levels(time: Array, y: Array) -> Cut:
    """Give the levels of a piece as runs, and what lies between them.

    Args:
        time: s, shape (n,); it doesn't go back.
        y: displacement in mm, shape (n,).
    """
    whole = Cut((Part(0, len(y)),), ())
    turns = turns_of(y)
    if len(turns) < FEWEST_TURNS:
        return whole
    ranges = np.abs(np.diff(y[turns]))
    middles = _crossings(time, y, turns)
    amplitude = (ranges[:-2] + 2 * ranges[1:-1] + ranges[2:]) / 8
    period = middles[2:] - middles[:-2]
    stretches = _stretches(np.log(np.maximum(amplitude, 1e-300)), np.log(np.maximum(period, 1e-300)))
    # window k goes from turn k to turn k + 3: three half cycles
    about = (y[turns[:-1]] + y[turns[1:]]) / 2
    long = [(begin, end) for begin, end in stretches if (end - begin + 2) / 2 >= FEWEST_CYCLES]
    kept = [(begin, end) for begin, end in long if not _rides(about[begin : end + 2], amplitude[begin:end])]
    if not kept and long:
        return _at_rests(turns, time, y)
    covered = sum(int(turns[end + 2] - turns[begin]) for begin, end in kept)
    if covered < MOSTLY_STEADY * _moving(turns, ranges) or not kept or _sweeps(amplitude, period, kept):
        return whole
    ends = [[int(turns[begin]), int(turns[end + 2])] for begin, end in kept]
    for before, after in itertools.pairwise(ends):
        if after[0] < before[1]:
            before[1] = after[0] = (after[0] + before[1]) // 2
    found = [
        _Level(first, last, float(np.median(period[begin:end])))
        for (first, last), (begin, end) in zip(ends, kept, strict=True)
    ]
    return _cut_at(found, turns, time, y)


@dataclass(frozen=True)
class _Level:
    first: int
    last: int
    period: float


def _rides(about: Array, amplitude: Array) -> bool:
    """Tell whether cycles ride on a larger motion: what they go about moves with each of them."""
    return float(np.median(np.abs(about[2:] - about[:-2]))) > RIDING * float(np.median(amplitude))


def _at_rests(turns: IntArray, time: Array, y: Array) -> Cut:
    """Cut a motion whose cycles are no levels in the middle of its rests; a part without motion is left."""
    waits = np.diff(time[turns])
    rests = np.flatnonzero(waits > STANDING * np.quantile(waits, 0.9))
    edges = [0, *((turns[rests] + turns[rests + 1]) // 2).tolist(), len(y)]
    parts = [Part(first, last) for first, last in itertools.pairwise(edges)]
    moving = [int(np.count_nonzero((turns > part.first) & (turns < part.last))) >= FEWEST_TURNS for part in parts]
    runs = tuple(part for part, moves in zip(parts, moving, strict=True) if moves)
    left = tuple(replace(part, why="rest") for part, moves in zip(parts, moving, strict=True) if not moves)
    return Cut(runs, left)


def _sweeps(amplitude: Array, period: Array, stretches: Sequence[tuple[int, int]]) -> bool:
    """Tell whether what looks like many levels is one slow change."""
    creeping = 0
    for begin, end in stretches:
        ends = min(3, end - begin)
        for values in (np.log(amplitude[begin:end]), np.log(period[begin:end])):
            if abs(np.median(values[-ends:]) - np.median(values[:ends])) > CREEPS * SAME_LEVEL:
                creeping += 1
                break
    return len(stretches) > 2 and 2 * creeping > len(stretches)


def _moving(turns: IntArray, ranges: Array) -> int:
    """Count the samples of half cycles that are no rest."""
    lengths = np.diff(turns)
    return int(np.sum(lengths[ranges > AT_REST * np.max(ranges)]))


def _crossings(time: Array, y: Array, turns: IntArray) -> Array:
    """Give when each half cycle passes the middle of its way."""
    begin, end = turns[:-1], turns[1:]
    middle, rising = (y[begin] + y[end]) / 2, np.where(y[end] > y[begin], 1.0, -1.0)
    half = np.repeat(np.arange(len(begin)), end - begin)
    passed = np.flatnonzero((y[turns[0] : turns[-1]] - middle[half]) * rising[half] >= 0) + turns[0]
    following = np.searchsorted(passed, begin)
    first = np.append(passed, turns[-1])[following]
    at = np.minimum(first, end)
    before = np.maximum(at - 1, 0)
    step = y[at] - y[before]
    share = np.divide(middle - y[before], step, out=np.zeros(len(at)), where=step != 0)
    return np.asarray(time[before] + share * (time[at] - time[before]))


def _stretches(amplitude: Array, period: Array) -> list[tuple[int, int]]:
    """Give rows of half cycles whose amplitude and period stay, as (first, one after the last)."""
    if _stays(amplitude) and _stays(period):
        return [(0, len(amplitude))]
    found, begin = [], 0
    amplitudes, periods = amplitude.tolist(), period.tolist()
    for place in range(1, len(amplitude) + 1):
        since = max(begin, place - REMEMBERED)
        if place < len(amplitudes) and (
            abs(amplitudes[place] - median(amplitudes[since:place])) < SAME_LEVEL
            and abs(periods[place] - median(periods[since:place])) < SAME_LEVEL
        ):
            continue
        found.append((begin, place))
        begin = place
    return found


def _stays(values: Array) -> bool:
    """Tell whether no value leaves the level of those before it."""
    begun = all(
        abs(value - median(values[:place].tolist())) < SAME_LEVEL
        for place, value in enumerate(values[:REMEMBERED].tolist())
        if place
    )
    if len(values) <= REMEMBERED or not begun:
        return begun
    before = np.median(np.lib.stride_tricks.sliding_window_view(values[:-1], REMEMBERED), axis=1)
    return bool(np.all(np.abs(values[REMEMBERED:] - before) < SAME_LEVEL))


def _cut_at(levels: Sequence[_Level], turns: IntArray, time: Array, y: Array) -> Cut:
    """Give the runs, drawn to the piece's ends where these are near, and the parts between them with what they are."""
    runs: list[Part] = []
    for number, level in enumerate(levels):
        first, last = level.first, level.last
        if number == 0 and time[first] - time[0] <= AT_EDGE * level.period:
            first = 0
        if number == len(levels) - 1 and time[-1] - time[min(last, len(y) - 1)] <= AT_EDGE * level.period:
            last = len(y)
        runs.append(Part(first, last))
    left: list[Part] = []
    edges = [0, *(edge for part in runs for edge in (part.first, part.last)), len(y)]
    for place, (begin, end) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
        if end > begin:
            beside = place - 1 if place else 0
            left.append(Part(begin, end, _what(begin, end, runs[beside], levels[beside].period, turns, time, y)))
    return Cut(tuple(runs), tuple(left))


def _what(begin: int, end: int, beside: Part, period: float, turns: IntArray, time: Array, y: Array) -> str:
    """Say what a part between runs is."""
    inner = turns[(turns > begin) & (turns < end)]
    # at either end it holds a part of the cycles beside it
    within = np.ptp(y[inner] if len(inner) > 1 else np.quantile(y[begin:end], (0.1, 0.9)))
    if within < AT_REST * np.ptp(y[beside.first : beside.last]):
        return "rest"
    inside = np.concatenate([[begin], inner, [end - 1]])
    rests = float(np.max(np.diff(time[inside]))) > RESTING * period
    return "ramps and rest" if rests else "ramp or change of level"
