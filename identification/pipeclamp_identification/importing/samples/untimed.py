"""Records whose time was not measured: each way from turn to turn is laid out as half a sine of half a second."""

from __future__ import annotations

import itertools
import math

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


def laid_out(record: Record) -> Repaired:
    """Give a record with cycles of one second, in which the displacement goes from turn to turn as a sine does.

    Without a time, only the curve of force over displacement is known: in it samples are joined by straight lines. How
    close they lie along it says nothing, and would be taken for a motion. A single cycle that lacks its last step goes
    on to where it began. One that hardly turns stays as it is.
    """
    turns = _turns_of(record.displacement_mm)
    if len(turns) < FEWEST_TURNS:
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
    for place, (first, last) in enumerate(itertools.pairwise(turns.tolist())):
        is_first, is_last = place == 0, place == len(ranges) - 1
        whole = max(ranges[place], ranges[1] if is_first else ranges[-2] if is_last else 0.0)
        # of the first way its end is a turn, of the others their beginning
        missing = whole - ranges[place]
        shares = np.abs(y[first : last + 1] - y[first]) / whole
        shares = np.maximum.accumulate(np.clip(shares, 0.0, ranges[place] / whole)) + (
            missing / whole if is_first else 0.0
        )
        low, high = _phase(shares[0]), _phase(shares[-1])
        count = max(math.ceil((high - low) / math.pi * FEWEST_PER_HALF), last - first)
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


def _turns_of(y: Array) -> IntArray:
    """Give the turns of a motion; of a few samples, whose steps look like noise, those of large ways."""
    turns = turns_of(y)
    return turns if len(turns) >= FEWEST_TURNS else turning_points(y, np.full(len(y), TURN * float(np.ptp(y))))


def _phase(share: float) -> float:
    """Give the phase of a sine from turn to turn, 0 to pi, that has a share of its way behind it."""
    return math.acos(1 - 2 * min(max(share, 0.0), 1.0))
