"""Half cycles of any motion: its turning points, small ones within larger motions left aside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray


@dataclass(frozen=True)
class HalfCycles:
    """Where each sample lies between the turning points before and after it; all of shape (n,).

    Attributes:
        degrees: phase after the last turning point, 0 to 180, of the sine that has the same share of its way behind it.
        rising: whether the displacement rises to the next turning point.
    """

    degrees: Array
    rising: BoolArray


def half_cycles(y: Array, least: Array) -> HalfCycles:
    """Split a motion into half cycles.

    Args:
        y: displacement, shape (n,).
        least: way back, in its unit, from which on a turn counts at each sample, above 0, same shape.
    """
    turns = turning_points(y, least)
    half = np.searchsorted(turns, np.arange(len(y)), side="right").clip(1, len(turns) - 1)
    begin, end = y[turns[half - 1]], y[turns[half]]
    way = np.where(end == begin, 1.0, end - begin)
    share = np.clip((y - begin) / way, 0.0, 1.0)
    return HalfCycles(np.degrees(np.arccos(1 - 2 * share)), end > begin)


def turning_points(y: Array, least: Array) -> IntArray:
    """Give the samples at which the motion turns, the first and the last one among them."""
    places = _extremes(y) if np.ptp(least) == 0.0 else np.arange(len(y))
    values = y[places].tolist()
    found, extreme, direction = [0], 0, 0
    for index, (value, way) in enumerate(zip(values, least[places].tolist(), strict=True)):
        beyond = value - values[extreme]
        if direction == 0:
            if abs(beyond) > way:
                extreme, direction = index, 1 if beyond > 0 else -1
        elif beyond * direction >= 0:
            extreme = index
        elif -beyond * direction > way:
            found.append(extreme)
            extreme, direction = index, -direction
    last = len(values) - 1
    found += [point for point in dict.fromkeys((extreme, last)) if point > found[-1]]
    return np.asarray(places[found if len(found) > 1 else [0, last]], dtype=np.intp)


def _extremes(y: Array) -> IntArray:
    """Give the samples at which a motion can turn, of samples alike the last, with the first and the last sample.

    Where one way back counts everywhere, those between are passed over: the motion goes on there.
    """
    slope = np.sign(np.diff(y))
    moving = np.flatnonzero(slope)
    turns = moving[1:][slope[moving[1:]] != slope[moving[:-1]]]
    return np.unique(np.concatenate([[0], turns, [len(y) - 1]])).astype(np.intp)
