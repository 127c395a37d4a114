"""Levels of a test condition: the set points that measured values scatter about, or classes where there are none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray, IntArray

MOST_SET_POINTS = 10
"""More set points than this are shown as classes."""
CLASSES_OF_MANY = 6
SPREAD = 3.0
"""Values that reach farther than this many steps without a gap are no set point that they scatter about."""
MOST_DIGITS = 7
SAME_SHARE, SAME_KELVIN = 0.05, 5.0
"""Conditions closer than this share of each other, and temperatures closer than this, count as the same where tests are
counted or grouped by them: drives never hit their set points."""

ABOUT_ZERO = 0.002
"""Share of the largest value within which measured ones may scatter about a set point of zero, of which no share of
their own means anything: a coil without current shows -0.1 and 0.2 mA beside 3000."""
SET_POINT_WIDTH = 0.02
"""Share of the step within which values are at one set point, to which it is told: 0.1 °C of 5, no -0.076."""

VARIED_SHARES = {"A": 0.05}
VARIED_SHARE = 0.02
"""A condition counts as varied when its values spread by more than this share of the largest: drives miss an amplitude
by a few percent."""
LEVELS_APART = 0.04
"""Values of a condition further apart than this share of its range are different levels."""


@dataclass(frozen=True)
class Level:
    """The runs at one level of a condition.

    Attributes:
        label: the set point, "low to high" for a class, or a name.
        low, high: the ends in words.
        rows: of the runs.
        known: whether the condition is known for them.
        at_zero: whether they scatter about a set point of zero.
    """

    label: str
    low: str
    high: str
    rows: IntArray
    known: bool = True
    at_zero: bool = False


def number_levels(values: Array, *, relative: float | None = None, absolute: float = math.inf) -> tuple[Level, ...]:
    """Give the levels of a numeric condition, rising; those runs last for which it isn't known.

    Args:
        values: of each run, nan where not known, shape (R,).
        relative, absolute: neighbouring values that differ by no more than this share, and by no more than this,
            belong to one set point.
    """
    told = SET_POINT_WIDTH * absolute if math.isfinite(absolute) else 0.0
    known = np.flatnonzero(np.isfinite(values))
    order = known[np.argsort(values[known], kind="stable")]
    rising = values[order]
    step = np.full(len(rising), absolute)
    zero = np.zeros(len(rising), dtype=np.bool_)
    if relative is not None:
        step = np.minimum(step, relative * np.abs(rising))
        zero = _at_zero(rising)
        step[zero] = np.ptp(rising[zero]) if np.any(zero) else 0.0
    groups = np.split(np.arange(len(order)), np.flatnonzero(np.diff(rising) > step[1:]) + 1) if len(order) else []
    if any(np.ptp(rising[group]) > SPREAD * np.mean(step[group]) for group in groups):
        groups = _quantiles(rising)
        ends = np.array([(rising[group[0]], rising[group[-1]]) for group in groups])
    else:
        points = np.array([0.0 if np.all(zero[group]) else np.mean(rising[group]) for group in groups])
        classes = _classes([len(group) for group in groups])
        ends = np.array([(points[places[0]], points[places[-1]]) for places in classes])
        groups = [np.concatenate([groups[place] for place in places]) for places in classes]
    texts = distinct_texts(_rounded(ends.ravel(), told))
    found = [
        Level(low if low == high else f"{low} to {high}", low, high, order[group], at_zero=bool(np.all(zero[group])))
        for group, low, high in zip(groups, texts[::2], texts[1::2], strict=True)
    ]
    return (*found, *_unknown(np.flatnonzero(~np.isfinite(values))))


def _at_zero(values: Array) -> BoolArray:
    """Tell which values scatter about a set point of zero: of either sign, or mostly unlike beside others that repeat.

    Small ones that repeat, as the low end of a row of decades does, are set points of their own.

    Args:
        values: all known, shape (n,).
    """
    small = np.abs(values) <= ABOUT_ZERO * np.max(np.abs(values), initial=0.0)
    few, others = np.sort(values[small]), np.sort(np.abs(values[~small]))
    if len(few) < 2 or not len(others):
        return np.zeros(len(values), dtype=np.bool_)
    mostly_unlike = np.mean(np.diff(few) > SAME_SHARE * np.abs(few[1:])) > 0.5
    repeated = 2 * (1 + np.count_nonzero(np.diff(others) > SAME_SHARE * others[1:])) <= len(others)
    scatter = bool(few[0] < 0.0 < few[-1]) or bool(mostly_unlike and repeated)
    return small if scatter else np.zeros(len(values), dtype=np.bool_)


def _quantiles(rising: Array) -> list[IntArray]:
    """Give the places of rising values in classes of about as many, where no gaps part them."""
    edges = np.unique(np.quantile(rising, np.arange(1, CLASSES_OF_MANY) / CLASSES_OF_MANY))
    parts = np.split(np.arange(len(rising), dtype=np.intp), np.searchsorted(rising, edges))
    return [places for places in parts if len(places)]


def _classes(counts: Sequence[int]) -> list[IntArray]:
    """Put many set points into classes of about as many runs: whole ones, for runs at one setting belong together.

    Args:
        counts: runs of each set point, rising.

    Returns:
        places of the set points of each class; each is one of its own where they are few.
    """
    numbers = np.arange(len(counts), dtype=np.intp)
    if len(counts) > MOST_SET_POINTS:
        middles = np.cumsum(counts) - np.array(counts) / 2
        numbers = (middles * CLASSES_OF_MANY / np.sum(counts)).astype(np.intp)
    parts = np.split(np.arange(len(counts), dtype=np.intp), np.flatnonzero(np.diff(numbers)) + 1)
    return [places for places in parts if len(places)]


def known_levels(values: Array) -> list[Level]:
    """Give the levels of a numeric condition by which tests are grouped, rising, without those of unknown ones."""
    return [level for level in number_levels(values, relative=SAME_SHARE) if level.known]


def set_points(values: Array, absolute: float = np.inf) -> IntArray:
    """Number the set points that values scatter about, shape (n,); a value that belongs to none is alone.

    Args:
        values: of each run, nan where not known, which is one of its own, shape (n,).
        absolute: by how much those of one set point differ at most, where they don't by `SAME_SHARE`.
    """
    numbers = np.arange(len(values), dtype=np.intp)
    for level in number_levels(values, relative=SAME_SHARE, absolute=absolute):
        together = values[level.rows]
        if (
            not level.known
            or level.at_zero
            or np.ptp(together) <= min(absolute, SAME_SHARE * float(np.max(np.abs(together))))
        ):
            numbers[level.rows] = level.rows[0]
    return numbers


def name_levels(names: Sequence[str | None]) -> tuple[Level, ...]:
    """Give the levels of a condition that is a name, in alphabetical order; nameless runs last."""
    found = sorted({name for name in names if name})
    rows = {name: np.flatnonzero([entry == name for entry in names]) for name in found}
    levels = [Level(name, name, name, rows[name]) for name in found]
    return (*levels, *_unknown(np.flatnonzero([not name for name in names])))


def group_names(labels: Sequence[str]) -> list[str]:
    """Give the groups that labels make, in alphabetical order; blanks are of none.

    Labels that hardly repeat are remarks: none, unless two groups at least have two runs each.
    """
    counts = {name: labels.count(name) for name in sorted(set(labels) - {""})}
    return list(counts) if sum(count > 1 for count in counts.values()) > 1 else []


def _unknown(rows: IntArray) -> tuple[Level, ...]:
    return (Level("not known", "", "", rows, known=False),) if len(rows) else ()


def distinct_texts(values: Array) -> list[str]:
    """Give numbers as text, with as few digits (two at least) as keep different ones apart."""
    different = len(np.unique(values))
    for digits in range(2, MOST_DIGITS):
        texts = [f"{float(f'{value:.{digits}g}'):g}" for value in values]
        if len(set(texts)) >= different:
            break
    return texts


def _rounded(values: Array, step: float) -> Array:
    return np.round(values / step) * step + 0.0 if step else values  # + 0.0: no -0


def varies(signal: str, values: Array) -> bool:
    """Tell whether a condition varies by more than tests scatter that were meant to be alike."""
    share = VARIED_SHARES.get(signal, VARIED_SHARE)
    return bool(np.ptp(values) > share * np.max(np.abs(values)))


def count_levels(signal: str, values: Array) -> int:
    """Count the levels of a condition: clusters of values; one where it doesn't vary."""
    if not varies(signal, values):
        return 1
    ordered = np.sort(values, axis=None)
    apart = LEVELS_APART * (ordered[-1] - ordered[0])
    count, begin = 1, ordered[0]
    for value in ordered:
        # From the level's own beginning, so that a condition that varies finely has many levels, not one.
        if value > begin + apart:
            count, begin = count + 1, value
    return count
