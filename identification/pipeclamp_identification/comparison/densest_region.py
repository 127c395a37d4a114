"""The region in which an error is densest: which places and conditions confine it, and the sentence that says so."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.error_parts import Breakdown
from pipeclamp_identification.signals.levels import Level
from pipeclamp_models.base.arrays import Array

MUCH_OF_IT = 0.4
"""A region must hold this share of the error beyond scatter."""
MOST_FACTORS_NAMED = 3
"""A sentence names at most so many places and conditions."""
STANDS_OUT = 0.05
"""Divergence in nats from an even spread below which a further restriction says nothing: 50 % of the error in a third
of the tests, say."""
MOSTLY_SCATTER = 0.1
"""Share of the squared error beyond scatter below which no place of it can be told; a diagnosis, which asks all runs at
once, may still find an effect."""


@dataclass(frozen=True)
class Region:
    """A region of loop and conditions.

    Attributes:
        words: what confines it.
        share: of the squared error beyond scatter that lies in it.
        even: the share that would if it were spread evenly.
    """

    words: tuple[str, ...]
    share: float
    even: float


@dataclass(frozen=True)
class Factor:
    """A way to confine a region.

    Attributes:
        name: what it confines; a region takes one factor of each name.
        words: how.
        runs, phases: which runs, and which parts of each, it keeps: 1, else 0; (R,), (parts,).
    """

    name: str
    words: str
    runs: Array
    phases: Array


def densest(excess: Array, even: Array, factors: Sequence[Factor]) -> Region | None:
    """Find the region in which an error is densest; None where it is spread evenly.

    Restrictions are added one by one, each the one after which the region's share of the error diverges most from the
    share of an even spread (Kullback-Leibler), as a scan statistic has it (Kulldorff, 1997).

    Args:
        excess: squared error beyond scatter, (R, parts).
        even: what it would be if it were spread evenly, up to a factor, (R, parts).
        factors: what may confine the region.
    """
    excess, force = excess / np.sum(excess), even / np.sum(even)
    chosen: list[Factor] = []
    best = 0.0
    while len(chosen) < MOST_FACTORS_NAMED:
        free = [factor for factor in factors if factor.name not in {one.name for one in chosen}]
        rated = [(divergence(*_inside([*chosen, factor], excess, force)), factor) for factor in free]
        reached, factor = max(rated, key=lambda entry: entry[0], default=(best, None))
        if factor is None or reached < best + STANDS_OUT:
            break
        chosen.append(factor)
        best = reached
    if not chosen:
        return None
    share, spread = _inside(chosen, excess, force)
    in_order = [factor for factor in factors if any(factor is one for one in chosen)]
    return Region(tuple(factor.words for factor in in_order), min(share, 1.0), spread)


def is_scatter(parts: Breakdown) -> bool:
    """Tell whether the error is scatter, or nothing: then no place of it stands out."""
    return parts.squared_error <= 0.0 or parts.excess <= MOSTLY_SCATTER * parts.squared_error


def _inside(factors: Sequence[Factor], excess: Array, force: Array) -> tuple[float, float]:
    """Give the shares of the error and of the evenly spread force that lie in a region."""
    runs = np.prod([factor.runs for factor in factors], axis=0)
    phases = np.prod([factor.phases for factor in factors], axis=0)
    return float(runs @ excess @ phases), float(runs @ force @ phases)


def divergence(share: float, even: float) -> float:
    """Give the Kullback-Leibler divergence of a region's share from an even spread's; 0 where it holds too little."""
    if share < max(MUCH_OF_IT, even) or not 0.0 < even < 1.0:
        return 0.0
    inside = min(share, 1.0)
    outside = (1 - inside) * math.log((1 - inside) / (1 - even)) if inside < 1.0 else 0.0
    return inside * math.log(inside / even) + outside


def condition_factors(conditions: Sequence[Condition], runs: int, parts: int) -> Iterator[Factor]:
    """Give the intervals of each condition, as factors over so many runs of so many parts."""
    always = np.ones(parts)
    for condition in conditions:
        known = [level for level in condition.levels if level.known]
        for first in range(len(known)):
            for last in range(first, len(known) if condition.ordered else first + 1):
                if last - first + 1 < len(condition.levels):
                    inside = np.zeros(runs)
                    inside[np.concatenate([level.rows for level in known[first : last + 1]])] = 1.0
                    yield Factor(condition.key, interval_words(condition, known, first, last), inside, always)


def interval_words(condition: Condition, levels: Sequence[Level], first: int, last: int) -> str:
    """Say an interval of a condition, from the first to the last of these levels of it, by their places."""
    name, unit = condition.name, f" {condition.unit}" if condition.unit else ""
    low, high = levels[first].low, levels[last].high
    if not condition.ordered:
        return f"on {name} {low}"
    if low == high:
        return f"at {name} = {low}{unit}"
    if first == 0:
        return f"at {name} up to {high}{unit}"
    if last == len(levels) - 1:
        return f"at {name} from {low}{unit} up"
    return f"at {name} from {low} to {high}{unit}"


def region_sentence(found: Region | None, whole: Breakdown, model: str = "law") -> str:
    """Say where the error of a law, or of another model, sits."""
    scatter_known = any(part.squared_scatter is not None for part in whole.parts)
    beyond = "of the squared error that is not scatter" if scatter_known else "of the squared error"
    if is_scatter(whole):
        return f"What the {model} leaves is scatter, nearly all of it: no place stands out."
    if found is None:
        return f"No place or condition holds much more than its share {beyond}."
    return f"{found.share:.0%} {beyond} sits {', '.join(found.words)}; spread evenly, it would be {found.even:.0%}."
