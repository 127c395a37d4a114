"""Pairs of parameters that are wrong at once: which ones promise most, and their refits.

What a further parameter promises beside a refitted one is the least squares of both in the model linearised there. One
evaluation tells it of all further parameters, so pairs are asked for wherever one alone is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from pipeclamp_identification.attribution.refit import Refit, RefitStart, bounds_of, refit
from pipeclamp_identification.attribution.suspect import Suspect
from pipeclamp_identification.attribution.task import RefitTask
from pipeclamp_models.base.arrays import Array, IntArray

HOPEFUL = 6
"""Suspects that pairs are made of, each with all others."""
FEWEST_PAIRS, MOST_PAIRS = 5, 12
"""Pairs that are refitted: so many at least, and all that promise as much, up to so many."""
STARTS_OF_A_PAIR = 2
"""Of each pair that are followed: the valleys of a position, and the two suspects as the first one."""


@dataclass(frozen=True, eq=False)
class PromisedPair:
    """A pair that isn't refitted yet.

    Attributes:
        start: where its refit begins.
        squared: what the linearised model would leave.
    """

    start: RefitStart
    squared: float

    @property
    def ids(self) -> frozenset[str]:
        """The two suspects' ids."""
        return frozenset(suspect.id for suspect in self.start.suspects)


def promised_pairs(task: RefitTask, singles: Sequence[Refit]) -> list[PromisedPair]:
    """Give all pairs of a hopeful suspect and any other, best first.

    Args:
        task: what is fitted to.
        singles: refits of each suspect alone, best first.
    """
    starts = [start for one in singles[:HOPEFUL] for start in _beside(one, [other.suspects[0] for other in singles])]
    begun = refit(task, starts, most=1)
    return sorted((pair for one in begun for pair in _promised(one)), key=lambda pair: pair.squared)


def refitted_pairs(task: RefitTask, promised: Sequence[PromisedPair], reach: float) -> list[Refit]:
    """Refit the pairs that promise most; of a pair's starts the best is kept.

    Args:
        task: what is fitted to.
        promised: pairs, best first.
        reach: squares by which a pair may promise less than the best one and still is refitted.
    """
    chosen: dict[frozenset[str], list[RefitStart]] = {}
    for pair in promised:
        own = chosen.get(pair.ids)
        if own is None:
            full = len(chosen) >= FEWEST_PAIRS and pair.squared > promised[0].squared + reach
            if full or len(chosen) >= MOST_PAIRS:
                continue
            own = chosen[pair.ids] = []
        if len(own) < STARTS_OF_A_PAIR:
            own.append(pair.start)
    best: dict[frozenset[str], Refit] = {}
    for one in refit(task, [start for starts in chosen.values() for start in starts]):
        ids = frozenset(suspect.id for suspect in one.suspects)
        if ids not in best or one.squared < best[ids].squared:
            best[ids] = one
    return list(best.values())


def _beside(one: Refit, suspects: Sequence[Suspect]) -> Iterator[RefitStart]:
    """Give starts of all other suspects beside a refitted one, all at neutral values: a start for each set of these."""
    others = [suspect for suspect in suspects if suspect.id != one.suspects[0].id]
    for turn in range(max(len(suspect.neutrals) for suspect in others)):
        having = [suspect for suspect in others if turn < len(suspect.neutrals)]
        neutral = [value for suspect in having for value in suspect.neutrals[turn]]
        yield RefitStart((*one.suspects, *having), (*one.values, *neutral), one.computed)


def _promised(begun: Refit) -> Iterator[PromisedPair]:
    """Give what each of the further suspects promises beside the first."""
    first, *others = begun.suspects
    own = np.arange(len(first.lower))
    begin = own.size
    values = np.array(begun.values)
    for other in others:
        columns = np.concatenate([own, np.arange(begin, begin + len(other.lower))])
        begin += len(other.lower)
        lower, upper = bounds_of((first, other))
        start = RefitStart((first, other), tuple(values[columns].tolist()), begun.computed)
        yield PromisedPair(start, _least(begun, columns, lower - values[columns], upper - values[columns]))


def _least(begun: Refit, columns: IntArray, lower: Array, upper: Array) -> float:
    """Give the least squares of the linearised model that some parameters leave within bounds."""
    J = begun.jacobian[:, columns]
    size = np.linalg.norm(J, axis=0)
    moving = (size > 0) & (lower < upper)
    if not moving.any():
        return begun.squared
    scaled, size = J[:, moving] / size[moving], size[moving]
    found = lsq_linear(scaled, -begun.residual, (lower[moving] * size, upper[moving] * size), method="bvls")
    return float(np.sum((begun.residual + scaled @ found.x) ** 2))
