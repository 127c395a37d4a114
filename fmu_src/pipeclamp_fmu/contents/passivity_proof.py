"""Whether a law without memory dissipates at any displacement and velocity in its range: proved, or disproved.

At given A, f and T what a force is at rest depends on the displacement alone and gives back over a closed motion what
it took. The rest must act against the velocity:

    (F(y, v) - F(y, 0)) v >= 0.

Its bounds over a box are computed by interval arithmetic; where they don't tell, the box is halved, the worst first, so
that no place between points of a grid is missed.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import sympy as sp

from pipeclamp_fmu.contents.intervals import bounds
from pipeclamp_fmu.contents.passivity import CYCLES_ACCOUNTED, Cycle, Interval
from pipeclamp_models.equations import symbols
from pipeclamp_models.realise.stepping import Stepping, conditions_of, parameter_symbols

FASTEST_LOOKED_AT = 2.0
"""Largest velocity that is looked at, of that of a sinusoid of the largest amplitude at the highest frequency."""

MOST_BOXES = 3000
"""After so many it is left undecided."""

SHARPENED = 200
"""Boxes that are halved beyond the first place found, towards the one that feeds in most."""

NOTHING, SMALLEST = 1e-9, 1e-200
"""A negative power that is less than this share of that in the middle of the range, or than this in N mm/s, is
rounding."""


@dataclass(frozen=True)
class Proof:
    """What was found.

    Attributes:
        proved: whether the law is proved to dissipate everywhere.
        against: where its force pushes along, by signal: the slow ones (A mm, f Hz, T K, ...), y (mm) and v (mm/s);
            None where no such place was met.
    """

    proved: bool
    against: Mapping[str, float] | None = None

    def words(self) -> str:
        """Say of a law that was taken why it is held to create no energy."""
        if self.proved:
            return "creates no energy: proved for any motion in its range at held A, f and T (by interval arithmetic)"
        searched = (
            "creates no energy as far as was searched: an optimiser, free in A, f, T and the shape of the cycle, found "
            "none that feeds energy in; it isn't proved"
        )
        if self.against is None:
            return searched
        *_, y, v = self.against.values()
        return f"{searched}: at y = {y:.3g} mm and v = {v:.3g} mm/s, say, its force pushes along instead of braking"


def prove(law: Stepping, values: Sequence[float], ranges: Sequence[Interval], about: float = 0.0) -> Proof:
    """Prove that a law dissipates, or find where it doesn't.

    Args:
        law: the law; one with states is left undecided.
        values: of its parameters, in the order of `parameter_symbols`.
        ranges: of A (mm), f (Hz), T (K) and further conditions, as `conditions_of` names them.
        about: mm, about which the law's tests moved.
    """
    if law.equations.states:
        return Proof(proved=False)
    given = dict(zip(parameter_symbols(law.equations), map(sp.Float, values), strict=True))
    held = [(symbol, sp.sympify(value)) for symbol, value in (*law.coefficients, *law.held)]
    slow = {symbol: value.xreplace(given) for symbol, value in held if symbol != value}
    terms = [term for term in sp.Add.make_args(sp.expand_mul(law.force, deep=False)) if term.has(symbols.v)]
    against = [(term - term.subs(symbols.v, 0)).xreplace(given) for term in terms]
    names = [*conditions_of(law.equations), "y", "v"]
    (_, A), (_, f) = ranges[0], ranges[1]
    fastest = FASTEST_LOOKED_AT * 2 * math.pi * f * A
    by_name = {str(symbol): symbol for expression in (*against, *slow.values()) for symbol in expression.free_symbols}
    matters = [name == "v" or name in by_name for name in names]
    by_name |= {"y": symbols.y, "v": symbols.v}

    def power(box: Sequence[Interval]) -> Interval:
        """Give bounds of what is dissipated over a box, N mm/s."""
        in_order = zip(names, box, strict=True)
        known: dict[sp.Basic, Interval] = {by_name[name]: one for name, one in in_order if name in by_name}
        for symbol, expression in slow.items():
            known[symbol] = bounds(expression, known)
        parts = [bounds(symbols.v * part, known) for part in against]
        return math.fsum(low for low, _ in parts), math.fsum(high for _, high in parts)

    places, ways = (about - A, about + A), ((0.0, fastest), (-fastest, 0.0))
    return _searched(power, names, matters, [(*ranges, places, way) for way in ways])


def cycles_through(proof: Proof, about: float = 0.0) -> list[tuple[Cycle, tuple[float, ...]]]:
    """Give cycles that pass a place where a law feeds energy, with the conditions there; displacements from `about`."""
    if proof.against is None:
        return []
    *where, y, v = proof.against.values()
    A, f = where[0], where[1]
    size = min(1.0, abs(v) / (2 * math.pi * f * A))
    middle = max(-(1 - size), min(1 - size, (y - about) / A))
    shapes = (((1, size, 0.0),), ((1, 0.6 * size, 0.0), (3, 0.4 * size, 1.0)))
    through = [Cycle("a motion", shape, middle) for shape in shapes]
    return [(cycle, tuple(where)) for cycle in (*CYCLES_ACCOUNTED, *through)]


def _searched(
    power: Callable[[Sequence[Interval]], Interval],
    names: Sequence[str],
    matters: Sequence[bool],
    boxes: Sequence[tuple[Interval, ...]],
) -> Proof:
    """Halve boxes until none is left in which the power may be negative, or it is at a middle.

    Args:
        power: gives bounds of the power over a box.
        names: of a box's sides; matters: whether the power depends on them.
        boxes: to begin with.
    """
    centres = [power([((low + high) / 2,) * 2 for low, high in box])[1] for box in boxes]
    rounding = max(SMALLEST, NOTHING * max((abs(one) for one in centres if math.isfinite(one)), default=0.0))
    number = count()
    waiting: list[tuple[float, int, tuple[Interval, ...]]] = []
    whole = boxes[0]

    def add(box: tuple[Interval, ...]) -> None:
        low, _ = power(box)
        if low < -rounding:
            heapq.heappush(waiting, (low, next(number), box))

    for box in boxes:
        add(box)
    worst, against, left = -rounding, None, MOST_BOXES
    while waiting and left:
        left -= 1
        _, _, box = heapq.heappop(waiting)
        middle = [(low + high) / 2 for low, high in box]
        _, there = power([(value, value) for value in middle])
        if there < worst:
            left = min(left, SHARPENED) if against is None else left
            worst, against = there, dict(zip(names, middle, strict=True))
        widths = [
            (high - low) / (end - begin) if end > begin and told else 0.0
            for (low, high), (begin, end), told in zip(box, whole, matters, strict=True)
        ]
        widest = widths.index(max(widths))
        for half in ((box[widest][0], middle[widest]), (middle[widest], box[widest][1])):
            add((*box[:widest], half, *box[widest + 1 :]))
    return Proof(proved=not waiting and against is None, against=against)
