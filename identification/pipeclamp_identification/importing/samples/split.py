"""One table with many runs becomes many: by gaps in time, a counter, rests, and steps of amplitude or frequency."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from pipeclamp_identification.signals.half_cycles import turning_points
from pipeclamp_identification.signals.sample_noise import sample_noise
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
FEWEST_CYCLES = 2.5
"""Cycles from its first turn to its last from which on a level is one, and no part of a ramp: a program of three cycles
a step has half a cycle less between them, for it comes from the step before and goes on to the next one."""
FEWEST_RIDING = 3.0
"""Cycles from which on those of a large motion, on which they ride, are told from an earthquake's."""
FEWEST_HALVES = 3
"""Half cycles of a level of two cycles between its first turn and its last: one whole cycle and a half."""
CLEAR_STEP = 2 * SAME_LEVEL
"""Change of amplitude from which on a step of such a program is told from half cycles that scatter."""
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
WELL_WITHIN = 0.45
"""Share of a way from turn to turn, either side of its middle, in which it is moving for certain."""
WELL_WITHIN_OF_SINE = 2 / np.pi * np.arcsin(2 * WELL_WITHIN)
"""Share of a sine's half cycle that it is."""
RESTING = 2.0
"""Cycles without a turn that make a rest."""
LOOKED_AT = 1_000_000
"""Steps of time, evenly chosen, that tell the usual one."""
RIDING = 0.1
"""Share of the amplitude by which the middle of cycles that ride on a larger motion moves from one to the next.
That of the cycles which a next test asks for, a quarter of the large one's amplitude at 7 times its frequency, moves by
1.5 times it and more."""
WITHOUT_ORDER = 0.4
"""Change of a half cycle's way to the next one's, as a logarithm and in the median, from which on a motion is no
program: noise of several bands changes it by 0.44 to 1.3, a program whose each cycle is half as large again by 0.22."""
CREEPS = 0.5
"""Levels that change by more than this share of `SAME_LEVEL` from end to end creep."""
GOES_ON = 3.0
"""Times the usual change from one half cycle to the next within a row: where the step to one beside it is no larger,
and goes the same way, the row is a piece of a ramp or a sweep; a change of level is a larger one."""


_Row = tuple[int, int, float]
"""Half cycles of one level: the first, the one after the last, and their period in s."""


@dataclass(frozen=True)
class SampleRange:
    """Samples first to last - 1 of a table: a run, or what was cut, and why."""

    first: int
    last: int
    why: str = ""


@dataclass(frozen=True)
class Cut:
    """How a table was cut: its runs, and what is left of it."""

    runs: tuple[SampleRange, ...]
    left: tuple[SampleRange, ...]


def split(time: Array, displacement: Array, segment: Array | None = None) -> Cut:
    """Split a table into runs.

    Args:
        time: s, shape (n,); it may go back where a machine's clock began anew.
        displacement: mm, shape (n,).
        segment: a number that stays the same within a run, shape (n,), where there is one.
    """
    bounds = piece_bounds(time, lambda: displacement, segment)
    runs: list[SampleRange] = []
    left: list[SampleRange] = []
    for first, last in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        found = levels(time[first:last], displacement[first:last])
        runs += [SampleRange(first + part.first, first + part.last, part.why) for part in found.runs]
        left += [SampleRange(first + part.first, first + part.last, part.why) for part in found.left]
    return Cut(tuple(runs), tuple(left))


def piece_bounds(
    time: Array, motion: Callable[[], Array], segment: Array | None = None, *, surely: bool = False
) -> IntArray:
    """Give where pieces begin that are different runs, and the end: time goes back or has a gap, the segment changes.

    Args:
        time: s, shape (n,).
        motion: gives the displacement in mm, or the first part of it, which tells how long cycles are.
        segment: shape (n,), where there is one.
        surely: whether it was stated to tell runs apart: else one that changes with each cycle only counts these.
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
        if surely or np.count_nonzero(changes < len(y)) < max(len(turns) / 6, 1):
            cuts = np.union1d(cuts, changes)
    return np.concatenate([[0], cuts, [len(time)]]).astype(np.intp)


def turns_of(y: Array) -> IntArray:
    """Give the turning points of a motion, noise aside: places in it, both ends among them; displacement (n,) in mm."""
    if len(y) < 5:
        return np.array([0, max(len(y) - 1, 0)], dtype=np.intp)
    least = max(NOISE * sample_noise(y), SHARE * float(np.ptp(y)))
    return turning_points(y, np.full(len(y), least))


def unsteady(time: Array, y: Array, steady: slice, cycles: int) -> str:
    """Say that a run changes along it so far that most of its motion isn't used; "" where it doesn't.

    Args:
        time: s, shape (n,).
        y: displacement in mm, shape (n,).
        steady: samples of it that are used.
        cycles: in these.
    """
    turns = turns_of(y)
    ranges = np.abs(np.diff(y[turns]))
    moving = _moving(y, turns, ranges)
    used = steady.stop - steady.start
    if used >= MOSTLY_STEADY * moving:
        return ""
    halves = ranges > AT_REST * np.max(ranges)
    least, most = np.quantile(ranges[halves], (0.1, 0.9)) / 2
    low, high = np.quantile(0.5 / np.maximum(np.diff(time[turns])[halves], 1e-12), (0.1, 0.9))
    are = "is steady, and alone is used" if cycles == 1 else "are steady, and alone are used"
    return (
        f"amplitude or frequency changes along it (half cycles of {least:.3g} to {most:.3g} mm, {low:.3g} to "
        f"{high:.3g} Hz): {cycles} of some {np.count_nonzero(halves) / 2:.0f} cycles {are} (--columns "
        "segment=each-cycle makes each a run; where a column 'motion' of --conditions says free, it stays one motion)"
    )


def irregular(y: Array) -> str:
    """Say that half cycles of a run follow each other without order, as where noise drives it; "" where they don't.

    Args:
        y: displacement in mm, shape (n,).
    """
    ranges = np.abs(np.diff(y[turns_of(y)]))
    ranges = ranges[ranges > 0]
    if len(ranges) < FEWEST_TURNS or np.median(np.abs(np.diff(np.log(ranges)))) < WITHOUT_ORDER:
        return ""
    least, most = np.quantile(ranges, (0.1, 0.9)) / 2
    return f"half cycles of {least:.3g} to {most:.3g} mm follow each other without order"


def levels(time: Array, y: Array) -> Cut:
    """Give the levels of a piece as runs, and what lies between them.

    Args:
        time: s, shape (n,); it doesn't go back.
        y: displacement in mm, shape (n,).
    """
    whole = Cut((SampleRange(0, len(y)),), ())
    turns = turns_of(y)
    if len(turns) < FEWEST_TURNS:
        return whole
    ranges = np.abs(np.diff(y[turns]))
    middles = _crossings(time, y, turns)
    amplitude = (ranges[:-2] + 2 * ranges[1:-1] + ranges[2:]) / 8
    period = middles[2:] - middles[:-2]
    logarithms = np.log(np.maximum(amplitude, 1e-300)), np.log(np.maximum(period, 1e-300))
    stretches = _stretches(*logarithms)
    # window k goes from turn k to turn k + 3: three half cycles
    about = (y[turns[:-1]] + y[turns[1:]]) / 2
    long = [(begin, end) for begin, end in stretches if (end - begin + 2) / 2 >= FEWEST_CYCLES]
    kept = [(begin, end) for begin, end in long if not _rides(about[begin : end + 2], amplitude[begin:end])]
    if not kept and any((end - begin + 2) / 2 >= FEWEST_RIDING for begin, end in long):
        return _at_rests(turns, time, y)
    kept = [(begin, end) for begin, end in kept if not any(_is_ramp(values, begin, end) for values in logarithms)]
    rows = [(begin, end + 2, float(np.median(period[begin:end]))) for begin, end in kept]
    short = _short_levels(turns, ranges, time)
    enough = MOSTLY_STEADY * _moving(y, turns, ranges)
    if _covered(rows, turns) < enough:
        rows = short
    else:
        rows = sorted([*rows, *(one for one in short if all(one[1] <= row[0] or row[1] <= one[0] for row in rows))])
    if _covered(rows, turns) < enough or not rows:
        return whole
    ends = [[int(turns[begin]), int(turns[end])] for begin, end, _ in rows]
    for before, after in itertools.pairwise(ends):
        if after[0] < before[1]:
            before[1] = after[0] = (after[0] + before[1]) // 2
    found = [_Level(first, last, period) for (first, last), (_, _, period) in zip(ends, rows, strict=True)]
    return _cut_at(found, turns, time, y)


def _covered(rows: Sequence[_Row], turns: IntArray) -> int:
    """Count the samples in rows of half cycles."""
    return sum(int(turns[end] - turns[begin]) for begin, end, _ in rows)


def _short_levels(turns: IntArray, ranges: Array, time: Array) -> list[_Row]:
    """Give the levels of a program of steps of amplitude, those of two cycles too; none where it is no such program.

    They are told by their amplitude alone, in which those beside each other differ clearly: a period needs more cycles.
    """
    ways = np.log(np.maximum(ranges, 1e-300))
    stretches = [
        (begin, end)
        for begin, end in _stretches(ways, np.zeros_like(ways), CLEAR_STEP)
        if end - begin >= FEWEST_HALVES and not _is_ramp(ways, begin, end)
    ]
    steps = np.abs(np.diff([np.median(ways[begin:end]) for begin, end in stretches]))
    if len(stretches) < 2 or np.min(steps) <= CLEAR_STEP:
        return []
    return [(begin, end, 2 * float(time[turns[end]] - time[turns[begin]]) / (end - begin)) for begin, end in stretches]


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
    parts = [SampleRange(first, last) for first, last in itertools.pairwise(edges)]
    moving = [int(np.count_nonzero((turns > part.first) & (turns < part.last))) >= FEWEST_TURNS for part in parts]
    runs = tuple(part for part, moves in zip(parts, moving, strict=True) if moves)
    left = tuple(replace(part, why="rest") for part, moves in zip(parts, moving, strict=True) if not moves)
    return Cut(runs, left)


def _is_ramp(values: Array, begin: int, end: int) -> bool:
    """Tell whether a row of half cycles is a piece of a slow change, a ramp or a sweep, that goes on beside it.

    Args:
        values: logarithm of the amplitude, or of the period, of each half cycle, shape (n,).
        begin: first one of the row.
        end: and the one after its last.
    """
    row = values[begin:end]
    # ends of a short row don't overlap
    ends = max(1, min(3, len(row) // 2))
    creep = float(np.median(row[-ends:]) - np.median(row[:ends]))
    if abs(creep) <= CREEPS * SAME_LEVEL:
        return False
    steps = np.sign(creep) * np.diff(values)
    # the last step before the row, and the first one after it, beside those next to them
    sides = [(begin - 1, steps[begin : end - 1][:REMEMBERED]), (end - 1, steps[begin : end - 1][-REMEMBERED:])]
    return any(
        0.0 < float(steps[place]) <= GOES_ON * float(np.median(inner))
        for place, inner in sides
        if 0 <= place < len(steps)
    )


def _moving(y: Array, turns: IntArray, ranges: Array) -> float:
    """Count the samples of half cycles that are no rest, without those of a rest before or behind one.

    Args:
        y: displacement in mm, shape (n,).
        turns: its turns, as places, shape (t,).
        ranges: from turn to turn, shape (t - 1,).
    """
    lengths = np.diff(turns)
    half = np.repeat(np.arange(len(lengths)), lengths)
    beyond = np.abs(y[turns[0] : turns[-1]] - y[turns[:-1]][half])
    inside = np.bincount(half[np.abs(beyond - ranges[half] / 2) < WELL_WITHIN * ranges[half]], minlength=len(lengths))
    moving = np.minimum(lengths, inside / WELL_WITHIN_OF_SINE)
    return float(np.sum(moving[ranges > AT_REST * np.max(ranges)]))


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


def _stretches(amplitude: Array, period: Array, same: float = SAME_LEVEL) -> list[tuple[int, int]]:
    """Give rows of half cycles whose amplitude and period stay, as (first, one after the last).

    Args:
        amplitude, period: logarithms of each half cycle, shape (n,).
        same: change from those before within which one stays.
    """
    if _stays(amplitude, same) and _stays(period, same):
        return [(0, len(amplitude))]
    found, begin = [], 0
    amplitudes, periods = amplitude.tolist(), period.tolist()
    for place in range(1, len(amplitude) + 1):
        since = max(begin, place - REMEMBERED)
        if place < len(amplitudes) and (
            abs(amplitudes[place] - median(amplitudes[since:place])) < same
            and abs(periods[place] - median(periods[since:place])) < same
        ):
            continue
        found.append((begin, place))
        begin = place
    return found


def _stays(values: Array, same: float) -> bool:
    """Tell whether no value leaves the level of those before it."""
    begun = all(
        abs(value - median(values[:place].tolist())) < same
        for place, value in enumerate(values[:REMEMBERED].tolist())
        if place
    )
    if len(values) <= REMEMBERED or not begun:
        return begun
    before = np.median(np.lib.stride_tricks.sliding_window_view(values[:-1], REMEMBERED), axis=1)
    return bool(np.all(np.abs(values[REMEMBERED:] - before) < same))


def _cut_at(levels: Sequence[_Level], turns: IntArray, time: Array, y: Array) -> Cut:
    """Give the runs, drawn to the piece's ends where these are near, and the parts between them with what they are."""
    runs: list[SampleRange] = []
    for number, level in enumerate(levels):
        first, last = level.first, level.last
        if number == 0 and time[first] - time[0] <= AT_EDGE * level.period:
            first = 0
        if number == len(levels) - 1 and time[-1] - time[min(last, len(y) - 1)] <= AT_EDGE * level.period:
            last = len(y)
        runs.append(SampleRange(first, last))
    left: list[SampleRange] = []
    edges = [0, *(edge for part in runs for edge in (part.first, part.last)), len(y)]
    for place, (begin, end) in enumerate(zip(edges[::2], edges[1::2], strict=True)):
        if end > begin:
            beside = place - 1 if place else 0
            left.append(SampleRange(begin, end, _what(begin, end, runs[beside], levels[beside].period, turns, time, y)))
    return Cut(tuple(runs), tuple(left))


def _what(begin: int, end: int, beside: SampleRange, period: float, turns: IntArray, time: Array, y: Array) -> str:
    """Say what a part between runs is."""
    inner = turns[(turns > begin) & (turns < end)]
    # at either end it holds a part of the cycles beside it
    within = np.ptp(y[inner] if len(inner) > 1 else np.quantile(y[begin:end], (0.1, 0.9)))
    lasts = float(time[end - 1] - time[begin]) > period
    if lasts and within < AT_REST * np.ptp(y[beside.first : beside.last]):
        return "rest"
    inside = np.concatenate([[begin], inner, [end - 1]])
    rests = float(np.max(np.diff(time[inside]))) > RESTING * period
    return "ramps and rest" if rests else "ramp or change of level"
