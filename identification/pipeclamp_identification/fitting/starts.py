"""Where a fit starts: the starts that effects state, in combination, or the most promising of these."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Mapping, Sequence

from pipeclamp_models.law.law import Equations
from pipeclamp_models.law.outline import Sizes, number_in

MOST_STARTS = 8
"""A fit starts from all combinations of its effects' starts, but from so many at most: those that promise most."""

Values = Mapping[str, float]


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
        found.append(
            [
                {
                    parameter.name: starts[min(index, len(starts) - 1)]
                    for parameter, starts in zip(parameters, stated, strict=True)
                }
                for index in range(count)
            ]
        )
    return found


def combined(choices: Sequence[Sequence[Values]]) -> list[dict[str, float]]:
    """Give every combination of effects' starts."""
    return [_together(parts) for parts in itertools.product(*choices)]


def most_promising(
    choices: Sequence[Sequence[Values]], cost: Callable[[Values], float], most: int = MOST_STARTS
) -> list[dict[str, float]]:
    """Give combinations of effects' starts, all where they are few, else those that promise most.

    Effect by effect the starts are ranked beside the best ones of the effects before and the first ones of those after.
    Combinations then come in the order of their ranks' sum: a few evaluations of each effect stand for many fits.

    Args:
        choices: the starts of each effect.
        cost: what a start promises, the less the better.
        most: combinations at most.
    """
    if math.prod(map(len, choices)) <= most:
        return combined(choices)
    ranked = [list(starts) for starts in choices]
    for place, starts in enumerate(choices):
        if len(starts) > 1:
            others = [one[0] for one in ranked]
            costs = [cost(_together([*others[:place], start, *others[place + 1 :]])) for start in starts]
            order = sorted(range(len(starts)), key=lambda index: costs[index])
            ranked[place] = [starts[index] for index in order]
    kept = [starts[:most] for starts in ranked]
    ranks = itertools.product(*(range(len(starts)) for starts in kept))
    first = heapq.nsmallest(most, ranks, key=lambda places: (sum(places), places))
    return [_together([starts[index] for starts, index in zip(kept, places, strict=True)]) for places in first]


def _together(parts: Sequence[Values]) -> dict[str, float]:
    return {name: value for part in parts for name, value in part.items()}
