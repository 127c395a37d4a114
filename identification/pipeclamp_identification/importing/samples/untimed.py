"""Records whose time was not measured: each way from turn to turn is laid out as half a sine of half a second.

What a column parts of such a curve goes on from piece to piece: the step between two is a part of one or both of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.campaign.cycles import lacks_a_step
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.importing.samples.repair import Repaired
from pipeclamp_identification.importing.samples.split import turns_of
from pipeclamp_identification.signals.half_cycles import turning_points
from pipeclamp_models.base.arrays import Array, IntArray

FEWEST_PER_HALF = 32
"""Samples of half a cycle at least: of a curve that was read off a picture there are but a few."""
HALF = 0.5
"""s that half a cycle takes."""
TURN = 0.1
"""Share of the whole way from which on a way back is a turn of such a curve."""
FEWEST_TURNS = 4
"""The first sample, two turns and the last one: the way between two turns tells how far the others went."""
CLOSED = 0.02
"""Share of the way up within which the way back ends where that began: then both are a cycle, from turn to turn."""
SHARE_DIGITS = 6
"""Of a share of a step."""
HARDLY_TURNS = "without a time, it takes two turns within it to tell a cycle, or one way up and back"
"""Why a record whose time wasn't measured is no sine."""
UNLOADED = 0.01
"""Share of the largest displacement, and of the largest force, within which a piece begins unloaded."""


def laid_out(record: Record) -> Repaired:
    """Give a record with cycles of one second, in which the displacement goes from turn to turn as a sine does.

    Without a time, only the curve of force over displacement is known: in it samples are joined by straight lines. How
    close they lie along it says nothing, and would be taken for a motion. A single cycle that lacks its last step goes
    on to where it began. One that hardly turns stays as it is, unless it goes up and back once, as loading and
    unloading do.
    """
    turns = turns_of_curve(record.displacement_mm)
    if len(turns) < FEWEST_TURNS and not _goes_up_and_back(record.displacement_mm, turns):
        return Repaired(record)
    if len(turns) == FEWEST_TURNS and lacks_a_step(record.displacement_mm):
        record = Record(**{name: np.append(values, values[0]) for name, values in record.channels.items()})
        turns = np.append(turns[:-1], turns[-1] + 1)
    y = record.displacement_mm
    ranges = np.abs(np.diff(y[turns]))
    channels = {name: values for name, values in record.channels.items() if name not in ("time_s", "displacement_mm")}
    times: list[Array] = []
    laid: dict[str, list[Array]] = {name: [] for name in ("displacement_mm", *channels)}
    begun = 0.0
    ways = zip(itertools.pairwise(turns.tolist()), _spans(ranges), strict=True)
    for place, ((first, last), (whole, low, high)) in enumerate(ways):
        # of the first way its end is a turn, of the others their beginning
        begins = 1.0 - ranges[place] / whole if place == 0 else 0.0
        shares = np.abs(y[first : last + 1] - y[first]) / whole
        shares = np.maximum.accumulate(np.clip(shares, 0.0, ranges[place] / whole)) + begins
        count = max(math.ceil((high - low) / math.pi * FEWEST_PER_HALF), last - first)
        is_last = place == len(ranges) - 1
        phase = low + (high - low) * np.arange(count + is_last) / count
        share = (1 - np.cos(phase)) / 2
        way = math.copysign(whole, y[last] - y[first])
        times.append(begun + (phase - low) / math.pi * HALF)
        laid["displacement_mm"].append(y[first] + way * (share - shares[0]))
        for name, values in channels.items():
            laid[name].append(np.interp(share, shares, values[first : last + 1]))
        begun += (high - low) / math.pi * HALF
    found = Record(time_s=np.concatenate(times), **{name: np.concatenate(parts) for name, parts in laid.items()})
    return Repaired(found, (f"laid out over sines of 1 Hz ({len(y)} samples became {len(found.time_s)})",))


def _goes_up_and_back(y: Array, turns: IntArray) -> bool:
    """Tell whether a motion turns once and ends where it began, so that both its ends are turns."""
    closes = abs(y[-1] - y[0]) <= CLOSED * float(np.ptp(y))
    return bool(len(turns) == FEWEST_TURNS - 1 and closes)


def hardly_turns_words(y: Array) -> str:
    """Say why a curve isn't laid out, and how far it comes back from its one turn; displacement (n,) in mm, finite."""
    turns = turns_of_curve(y)
    if len(turns) != FEWEST_TURNS - 1:
        return HARDLY_TURNS
    out, back = np.abs(np.diff(y[turns]))
    shorter = min(out, back) / max(out, back)
    return f"{HARDLY_TURNS}, within {CLOSED:.0%}: of its two ways one is {shorter:.0%} of the other"


def cycles_of(y: Array) -> float:
    """Give through how many cycles a curve goes, counted as they are laid out; displacement (n,) in mm, finite."""
    ranges = np.abs(np.diff(y[turns_of_curve(y)])) if len(y) > 1 else np.empty(0)
    if not np.any(ranges):
        return 0.0
    return sum(high - low for _, low, high in _spans(ranges)) / (2 * math.pi)


def shares_before(y: Array, force: Array, bounds: Sequence[int]) -> Array:
    """Give the share of the step to each piece that belongs to the piece before it, nan where a piece begins anew.

    A piece goes on towards where it began, for there its loop closes, but no farther; the rest of the step leads to the
    next one. What begins unloaded may be another specimen.

    Args:
        y, force: of the whole curve, shape (n,), blanks nan.
        bounds: where pieces begin, and the end.

    Returns:
        a share for each piece but the first, 0 to 1, shape (pieces - 1,).
    """
    found = np.full(len(bounds) - 2, np.nan)
    unloaded = [UNLOADED * np.max(np.abs(one), initial=0.0, where=np.isfinite(one)) for one in (y, force)]
    began = y[0]
    for place, first in enumerate(bounds[1:-1]):
        step, lacking = y[first] - y[first - 1], began - y[first - 1]
        is_known = bool(np.all(np.isfinite([step, lacking, force[first] - force[first - 1]])))
        began = y[first]
        if is_known and (abs(y[first]) > unloaded[0] or abs(force[first]) > unloaded[1]):
            # a trifle of the step would be a sample in the place of another
            found[place] = round(min(max(lacking / step, 0.0), 1.0), SHARE_DIGITS) if step else 0.0
            began = y[first - 1] + found[place] * step
    return found


def _spans(ranges: Array) -> list[tuple[float, float, float]]:
    """Give of each way from turn to turn the whole one in mm, and where on a sine along that it begins and ends, rad.

    The first way and the last one are parts of ways as long as those beside them.

    Args:
        ranges: of the ways, mm, shape (ways,).
    """
    spans = []
    last = len(ranges) - 1
    for place, own in enumerate(ranges.tolist()):
        beside = [*(ranges[1:2] if place == 0 else ()), *(ranges[-2:-1] if place == last else ())]
        whole = float(max(own, *beside)) if beside else own
        low = _phase(1.0 - own / whole) if place == 0 else 0.0
        spans.append((whole, low, _phase(own / whole) if 0 < place == last else math.pi))
    return spans


def turns_of_curve(y: Array) -> IntArray:
    """Give the turns of a motion; of a few samples, whose steps look like noise, those of large ways."""
    turns = turns_of(y)
    return turns if len(turns) >= FEWEST_TURNS else turning_points(y, np.full(len(y), TURN * float(np.ptp(y))))


def _phase(share: float) -> float:
    """Give the phase of a sine from turn to turn, 0 to pi, that has a share of its way behind it."""
    return math.acos(1 - 2 * min(max(share, 0.0), 1.0))
