"""Where a fit starts: the starts that effects state, in combination, or the most promising of these."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.law.law import Equations
from pipeclamp_models.law.outline import Sizes, number_in

SINGULAR_SHARE = 1e-7
"""Directions of the scaled Jacobian with a smaller share of its largest singular value are undetermined."""
SMALLEST_FORCE_SCALE = 1e-3
"""Of a start's force; where the data ask for less, or for the opposite, its shape is none of theirs."""
MOST_STARTS = 8
"""A fit starts from all combinations of its effects' starts, but from so many at most: those that promise most."""

Values = Mapping[str, float]


@dataclass(frozen=True)
class Linearised:
    """A law's weighted residuals at a point, flat, with their derivatives by the parameters that a fit would free.

    Attributes:
        free: names of those parameters.
        residual: shape (residuals,).
        jacobian: shape (residuals, free).
    """

    free: tuple[str, ...]
    residual: Array
    jacobian: Array

    def cost_after_one_step(self) -> float:
        """Give half the sum of squared residuals that the derivatives can't explain: a cheap screen before a fit.

        From what is left, not as a difference of sums: far from the data these are so large that little of it is right.
        """
        with one_thread():
            left = self.residual + self.jacobian @ self.step()
            return float(left @ left) / 2

    def by(self, name: str) -> Array:
        """Give the residuals' derivatives by a free parameter, shape (residuals,)."""
        return self.jacobian[:, self.free.index(name)]

    def step(self) -> Array:
        """Give the step of linear least squares, shape (free,); none where the residuals don't determine it."""
        with one_thread():
            norms = np.linalg.norm(self.jacobian, axis=0)
            norms[norms == 0] = 1.0
            basis = self.jacobian / norms
            inverse = np.linalg.pinv(basis.T @ basis, rcond=SINGULAR_SHARE, hermitian=True)
            return np.asarray(-(inverse @ (basis.T @ self.residual)) / norms)


class SizedEffect(NamedTuple):
    """The parameters of an effect: those that its force is in proportion to, together, and those that shape it."""

    sizes: Sequence[str]
    shapes: Sequence[str]


def sized(
    start: Values, there: Linearised, known: Collection[str], effects: Sequence[SizedEffect]
) -> tuple[Values, Linearised]:
    """Give a start with each effect's force as large as the data ask for, and of the shape that it had.

    An effect's force is in proportion to its forces, stiffnesses and masses together, so that one step of linear least
    squares finds how large it is, the rest of the law following it. Where that is nothing, or the opposite, the start
    stays: from there a fit may find another shape.

    Args:
        start: a value for each parameter.
        there: the law linearised at the start.
        known: parameters of the law that the effects join.
        effects: the parameters of each.

    Returns:
        the start, and the law linearised there: what an effect adds to the residuals, and what its shape changes in
        them, grow with it.
    """
    scaled = [[name for name in effect.sizes if name in there.free] for effect in effects]
    ways = [sum((there.by(name) * start[name] for name in names), np.zeros_like(there.residual)) for names in scaled]
    law = [there.by(name) for name in there.free if name in known]
    change = Linearised((), there.residual, np.column_stack([*law, *ways])).step()
    sizes = [float(size) if size > SMALLEST_FORCE_SCALE else 1.0 for size in 1 + change[len(law) :]]
    larger = {
        name: start[name] * size for names, size in zip(scaled, sizes, strict=True) if size != 1.0 for name in names
    }
    residual = there.residual + sum((size - 1) * way for size, way in zip(sizes, ways, strict=True))
    slopes = {name: size for effect, size in zip(effects, sizes, strict=True) for name in effect.shapes}
    jacobian = there.jacobian * np.array([slopes.get(name, 1.0) for name in there.free])
    return {**start, **larger}, Linearised(there.free, residual, jacobian)


def starts_of_effects(equations: Equations, given: Values, scales: Sizes) -> list[list[Values]]:
    """Give each effect's starts, values of its parameters by name; one alone where all of its values are given.

    Args:
        equations: the composed law.
        given: values that are known, by name.
        scales: sizes of the data, in which starts are stated.
    """
    found: list[list[Values]] = []
    for _, group in itertools.groupby(equations.parameters, key=lambda parameter: parameter.effect):
        parameters = list(group)
        stated = [
            [number_in(start, scales) for start in parameter.starts]
            if parameter.name not in given
            else [given[parameter.name]]
            for parameter in parameters
        ]
        known = all(parameter.name in given for parameter in parameters)
        count = 1 if known else max(len(parameter.starts) for parameter in parameters)
        points: list[Values] = []
        for index in range(count):
            point = {
                parameter.name: starts[min(index, len(starts) - 1)]
                for parameter, starts in zip(parameters, stated, strict=True)
            }
            if point not in points:  # for some tests two starts are one
                points.append(point)
        found.append(points)
    return found


def kept(point: Values, given: Values) -> set[str]:
    """Give the names of the values that a start has of those given, which may be of a law with other effects too."""
    return {name for name, value in given.items() if point.get(name) == value}


def combined(choices: Sequence[Sequence[Values]]) -> list[dict[str, float]]:
    """Give every combination of effects' starts."""
    return [_together(parts) for parts in itertools.product(*choices)]


def most_promising(choices: Sequence[Sequence[Values]], cost: Callable[[Values], float]) -> list[dict[str, float]]:
    """Give combinations of effects' starts, all where they are few, else those that promise most.

    Effect by effect the starts are ranked beside the best ones of the effects before and the first ones of those after.
    Combinations then come in the order of their ranks' sum: a few evaluations of each effect stand for many fits.

    Args:
        choices: the starts of each effect.
        cost: what a start promises, the less the better.
    """
    if math.prod(map(len, choices)) <= MOST_STARTS:
        return combined(choices)
    ranked = [list(starts) for starts in choices]
    for place, starts in enumerate(choices):
        if len(starts) > 1:
            others = [one[0] for one in ranked]
            costs = [cost(_together([*others[:place], start, *others[place + 1 :]])) for start in starts]
            order = sorted(range(len(starts)), key=lambda index: costs[index])
            ranked[place] = [starts[index] for index in order]
    kept = [starts[:MOST_STARTS] for starts in ranked]
    ranks = itertools.product(*(range(len(starts)) for starts in kept))
    first = heapq.nsmallest(MOST_STARTS, ranks, key=lambda places: (sum(places), places))
    return [_together([starts[index] for starts, index in zip(kept, places, strict=True)]) for places in first]


def _together(parts: Sequence[Values]) -> dict[str, float]:
    return {name: value for part in parts for name, value in part.items()}
