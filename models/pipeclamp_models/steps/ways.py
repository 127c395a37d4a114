"""Records between their samples, as an FMU walks its steps: in ways on which the motion doesn't turn round."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.steps.within_step import part_of, turn_within


@dataclass(frozen=True)
class Ways:
    """Ways along records of n samples, m of them in each row.

    A row that doesn't turn round in a step in which another does has a way without length there.

    Attributes:
        step: the sample that each way leads to, or whose step it begins, shape (m,).
        last: the way that ends at each sample, shape (n,).
        y, v: displacement mm and velocity mm/s at their ends, shape (R, m).
        y_previous: displacement at their beginnings, mm, same shape.
        h: their durations, s, same shape.
    """

    step: IntArray
    last: IntArray
    y: Array
    v: Array
    y_previous: Array
    h: Array

    @property
    def length(self) -> Array:
        """How far each sample's ways go, mm, shape (R, n)."""
        return np.asarray(np.add.reduceat(np.abs(self.y - self.y_previous), np.append(0, self.last[:-1] + 1), axis=1))

    def spread(self, values: Array) -> Array:
        """Give values of the samples, (R, n), along the ways, (R, m); what keeps still, (R, 1), as it is."""
        return values[:, self.step] if values.shape[1] > 1 else values

    def rows(self, chosen: IntArray) -> Ways:
        """Give those of some of the rows."""
        y, v, y_previous, h = (each[chosen] for each in (self.y, self.v, self.y_previous, self.h))
        return replace(self, y=y, v=v, y_previous=y_previous, h=h)


def ways_along(y: Array, v: Array, h: Array, rest: Array | float, parts: int) -> Ways:
    """Walk records from sample to sample by the equations of an FMU's own step (`within_step`).

    Args:
        y, v: displacement mm and velocity mm/s at the samples, shape (R, n).
        h: time between samples in s, shape (R, 1).
        rest: where the rows lie before their first sample, mm, shape (R, 1) or ().
        parts: in which each step is walked.
    """
    samples = y.shape[1]
    y_end, v_end, took = _in_parts(y, v, h, parts)
    step = np.repeat(np.arange(1, samples), parts)
    y_begin, v_begin = (np.concatenate([first[:, :1], end[:, :-1]], axis=1) for first, end in ((y, y_end), (v, v_end)))
    share, place = _turns(y_begin, v_begin, y_end, v_end, took)
    speed = np.where(share > 0.0, 0.0, v_begin)
    turned = np.flatnonzero(share.any(axis=0))

    def whole(first: Array, end: Array, turn: Array) -> Array:
        """Put the first sample before all, and the way to a turn before the way from there."""
        ways = np.insert(end, turned, turn[:, turned], axis=1)
        return np.concatenate([first[:, :1], ways], axis=1)

    y_end, v_end = whole(y, y_end, place), whole(v, v_end, speed)
    took = whole(h, took * (1.0 - share), took * share)
    step = np.append(0, np.insert(step, turned, step[turned]))
    y_before = np.roll(y_end, 1, axis=1)
    y_before[:, :1] = rest
    return Ways(step, np.flatnonzero(np.diff(step, append=samples)), y_end, v_end, y_before, took)


def _in_parts(y: Array, v: Array, h: Array, parts: int) -> tuple[Array, Array, Array]:
    """Give displacement and velocity at the ends of all parts, and their durations, shape (R, (n - 1) parts) each."""
    shares = np.arange(1, parts + 1) / parts
    motion = y[:, :-1, None], v[:, :-1, None], y[:, 1:, None], v[:, 1:, None]
    # what isn't told its velocity goes straight to its end, in the last part
    share = np.where((motion[1] == 0.0) & (motion[3] == 0.0), shares == 1.0, shares)
    place, speed = part_of(motion, h[:, :, None], share)
    place[:, :, -1:], speed[:, :, -1:] = motion[2:]
    took = h[:, :, None] * np.diff(share, axis=2, prepend=0.0)
    return place.reshape(len(y), -1), speed.reshape(len(y), -1), took.reshape(len(y), -1)


def _turns(y_begin: Array, v_begin: Array, y_end: Array, v_end: Array, took: Array) -> tuple[Array, Array]:
    """Give where ways turn round: the share of each, and the displacement; 0 and the beginning where they don't."""
    share, place = np.zeros_like(y_end), y_begin.copy()
    for row, way in np.argwhere(v_begin * v_end < 0.0):
        begin = float(y_begin[row, way]), float(v_begin[row, way])
        turned = turn_within((*begin, float(y_end[row, way]), float(v_end[row, way])), float(took[row, way]))
        if turned:
            share[row, way], place[row, way] = turned
    return share, place
