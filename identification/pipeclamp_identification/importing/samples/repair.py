"""What raw records need before they are cut: even stamps of time, no spikes. Each step says what it did."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.importing.samples.blanks import on_lines
from pipeclamp_identification.importing.samples.split import turns_of
from pipeclamp_identification.signals.sample_noise import scatter_by_median
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.said import counted, few_of

SPIKE = 12.0
"""Standard deviations, by the median of the absolute ones, that a spike lies off the line between its neighbours."""
OF_RANGE = 0.1
"""And the share of the channel's range between its 1st and 99th percent: what is smaller is left to the fit."""
APART = 0.3
"""A spike's neighbours differ by less than this share of it: a step isn't one, the samples behind it stay there."""
FEW_SAMPLES = 8
"""Samples of a half cycle: with fewer, as of a curve that was read off a picture, a peak can be one of them."""
MOST_SPIKES = 0.01
"""Share of the samples; a channel with more of them isn't spiky but noisy, and stays as it is."""
EVEN = 0.25
"""Share of a step by which stamps of time may miss an even grid and be left as they are."""
UNEVEN = 1.6
"""Largest over usual step from which on a record is put on an even grid."""

MOVING = ("displacement_mm", "force_N")
FEWEST_HELD = 8
"""Numbers that tell for how many samples each is held."""
MOSTLY_EVEN = 0.95
"""Share of them that are held for a multiple of the usual length."""
FEWEST_CHANGES = 3
"""Changes of rounded stamps that tell how fast samples were taken: two whole steps of the clock."""


@dataclass(frozen=True)
class Repaired:
    """A record after a repair, and words on what was done."""

    record: Record
    done: tuple[str, ...] = ()


def mended_channel(name: str, values: Array) -> Array:
    """Take blanks and spikes out of one channel of a record, called `name` there; samples (n,), nan where blank."""
    return _despiked(name, on_lines(values, ~np.isfinite(values)))[0]


def without_spikes(record: Record) -> Repaired:
    """Take single samples that stand far off their neighbours out of a record, by Hampel's filter; lines replace them.

    Hampel (J. Am. Stat. Assoc. 69, 1974): a sample lies many times the median absolute deviation off what is usual.
    Usual is here the line between its neighbours, so that the slope of a fast motion counts for nothing. Where a motion
    turns within a few samples, the force's peak there is no spike, nor is one that points the way of any turn: forces
    peak where a triangle turns. Nor is one that the samples on either side lead to.
    """
    changed: dict[str, Array] = {}
    done: list[str] = []
    for name, values in record.channels.items():
        # the displacement comes first, and shows where the motion turns once its own spikes are out
        motion = None if name == MOVING[0] else changed.get(MOVING[0], record.displacement_mm)
        samples, words = _despiked(name, values, motion)
        if words:
            changed[name] = samples
            done.append(words)
    return Repaired(replace(record, **changed) if changed else record, tuple(done))


def _peaks_of_turns(motion: Array, off: Array) -> npt.NDArray[np.bool_]:
    """Give the samples at which a peak comes with a turn of the motion.

    These lie beside a turn whose half cycles, before and after, hold few samples, or beside any whose way the peak
    points.

    Args:
        motion: displacement, shape (n,).
        off: how far each sample stands off the line between those beside it, shape (n,).
    """
    turns = turns_of(motion)
    half = np.diff(turns)
    inner = turns[1:-1]
    quick = np.maximum(half[:-1], half[1:]) < FEW_SAMPLES
    way = motion[inner] - motion[turns[:-2]]
    found = np.zeros(len(motion), dtype=np.bool_)
    for step in (-1, 0, 1):
        beside = (inner + step).clip(0, len(motion) - 1)
        found[beside[quick | (off[beside] * way > 0)]] = True
    return found


def evened(record: Record) -> Repaired:
    """Put samples on an even grid of time, where their stamps aren't.

    Stamps that were rounded (the same one several times over, then a jump of it) are counted out evenly, which changes
    no sample. Samples that were taken unevenly are put on a grid of the usual step by straight lines.

    Args:
        record: one run; its time mustn't go back.

    Raises:
        UnusableRecord: its stamps are rounded so far that they don't tell how fast it was sampled.
    """
    time = record.time_s
    if len(time) < 3:
        return Repaired(record)
    step = np.diff(time)
    positive = step[step > 0]
    if not len(positive):
        return Repaired(record)
    mean = float(time[-1] - time[0]) / (len(time) - 1)
    off = time - np.linspace(time[0], time[-1], len(time))
    if np.max(np.abs(off)) <= EVEN * mean:
        return Repaired(record)
    quantum = float(np.min(positive))
    rounded = np.all(np.abs(step / quantum - np.round(step / quantum)) < 1e-3) and np.max(np.abs(off)) <= 1.5 * quantum
    if rounded and quantum > 1.5 * mean:
        # the first and the last stamp stand for parts of a step of the clock; those between stand for whole ones
        changes = np.flatnonzero(step) + 1
        if len(changes) < FEWEST_CHANGES:
            raise UnusableRecord(
                f"stamps of time rounded to {quantum:.3g} s, {len(changes)} of which begin within {len(time)} samples; "
                "expected finer ones, or the samples per second: --rate"
            )
        apart = float(time[changes[-1]] - time[changes[0]]) / int(changes[-1] - changes[0])
        even = time[changes[0]] + apart * (np.arange(len(time)) - changes[0])
        words = f"stamps of time rounded to {quantum:.3g} s: counted out evenly, {apart:.4g} s apart"
        return Repaired(replace(record, time_s=even), (words,))
    usual = float(np.median(positive))
    if float(np.max(step)) <= UNEVEN * usual:
        return Repaired(record)
    # of samples with one stamp the first counts
    kept = np.concatenate([[True], step > 0])
    count = max(round((time[-1] - time[0]) / usual), 1) + 1
    if count > 4 * len(time):
        return Repaired(record)
    grid = np.linspace(time[0], time[-1], count)
    channels = {
        name: np.interp(grid, time[kept], values[kept]) for name, values in record.channels.items() if name != "time_s"
    }
    words = (
        f"uneven steps of time, {float(np.min(positive)):.3g} to {float(np.max(step)):.3g} s: put on a grid of "
        f"{float(grid[1] - grid[0]):.4g} s by straight lines ({len(time)} samples became {count})"
    )
    return Repaired(Record(time_s=grid, **channels), (words,))


def at_own_rate(record: Record) -> Repaired:
    """Give a record at the rate of its slowest channel, where a logger wrote each number of it several times over."""
    words, keep, of = "", 1, 0
    for name in MOVING:
        times, first = _times_held(record.channels[name])
        if times > keep:
            keep, of, words = times, first % times, f"{name} holds each number for {times} samples: one of them is kept"
    if not words:
        return Repaired(record)
    return Repaired(Record(**{name: values[of::keep] for name, values in record.channels.items()}), (words,))


def _times_held(values: Array) -> tuple[int, int]:
    """Give for how many samples each number is held, 1 where none is, and where the first begins."""
    begins = np.flatnonzero(values[1:] != values[:-1]) + 1
    lengths = np.diff(begins)
    if len(lengths) < FEWEST_HELD:
        return 1, 0
    times = int(np.median(lengths))
    # the last digits of a sensor hold numbers, too, but not for even lengths
    even = times > 1 and np.mean(lengths % times == 0) > MOSTLY_EVEN
    return (times, int(begins[0])) if even else (1, 0)


def _despiked(name: str, values: Array, motion: Array | None = None) -> tuple[Array, str]:
    """Take spikes out of a channel; where it follows a motion, peaks of this are none."""
    found = _spikes(values) if name != "time_s" else np.zeros(len(values), dtype=np.bool_)
    if motion is not None and np.any(found):
        found &= ~_peaks_of_turns(motion, values - on_lines(values, found))
    count = int(np.count_nonzero(found))
    if not count:
        return values, ""
    clean = on_lines(values, found)
    worst = float(np.max(np.abs(values - clean)))
    at = few_of([str(place + 1) for place in np.flatnonzero(found).tolist()], most=3)
    return clean, (
        f"{counted(count, 'spike')} in {name} (sample {at} of it; up to {worst:.3g}): replaced "
        "by straight lines between their neighbours"
    )


def _spikes(values: Array) -> npt.NDArray[np.bool_]:
    none = np.zeros(len(values), dtype=np.bool_)
    if len(values) < 12 or not np.all(np.isfinite(values)):
        return none
    low, high = np.percentile(values, [1, 99])
    bound = OF_RANGE * float(high - low)
    found = none.copy()
    # of one sample, or of two in a row, as a filter leaves it
    for width in (1, 2):
        before, after = values[: -width - 1], values[width + 1 :]
        off = _off_the_line(values, width)
        # most channels have none: what is usual needn't be known then
        if all(np.max(np.abs(one)) <= bound for one in off):
            continue
        least = np.where(np.all(off > 0, axis=0) | np.all(off < 0, axis=0), np.min(np.abs(off), axis=0), 0.0)
        usual = scatter_by_median(off)
        far = max(SPIKE * usual, bound)
        at = np.flatnonzero((least > far) & (np.abs(after - before) < APART * least)) + 1
        at = at[_is_alone(values, at, width, far)]
        for step in range(width):
            found[at + step] = True
    return found if np.count_nonzero(found) <= max(MOST_SPIKES * len(values), 3) else none


def _is_alone(values: Array, at: IntArray, width: int, far: float) -> npt.NDArray[np.bool_]:
    """Tell which samples lie far off either side as it goes on: a peak that is risen to, or falls off again, doesn't.

    So an upper yield point stays: on its way up a steep force passes the level that it drops to behind the peak.

    Args:
        values: of the channel, shape (n,).
        at: places of the first of so many samples in a row, neither end of the channel among them.
        width: samples in a row.
        far: off the line that the last two samples of a side make; at an end of the channel one tells that it stays.
    """
    first, last = at, at + width - 1
    before, after = values[first - 1], values[last + 1]
    way_in = before - values[np.maximum(first - 2, 0)]
    way_out = after - values[np.minimum(last + 2, len(values) - 1)]
    off = np.stack([values[first] - (before + way_in), values[last] - (after + way_out)])
    side = np.sign(values[first] - before)
    return np.asarray(np.all(off * side > far, axis=0))


def _off_the_line(values: Array, width: int) -> Array:
    """Give how far so many samples in a row lie off the line between those beside them, shape (width, n)."""
    before, after = values[: -width - 1], values[width + 1 :]
    off = np.empty((width, len(before)))
    for step in range(width):
        share = (step + 1) / (width + 1)
        off[step] = values[1 + step : len(values) - width + step] - (before + share * (after - before))
    return off
