"""Where the error sits, in one sentence: the region of loop and conditions in which it is densest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.comparison.breakdown import (
    BRANCHES,
    Drift,
    along_cycles,
    along_loop,
    by_condition,
    cycle_edges,
    excess_table,
    phase_edges,
    place_of,
)
from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.error_parts import Breakdown
from pipeclamp_identification.comparison.sums import RunSums
from pipeclamp_identification.loops.scatter import PHASE_BINS
from pipeclamp_identification.signals.levels import Level
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.said import counted

PLACE_SETS = (
    ((0,), "just after the reversals"),
    ((4,), "just before the reversals"),
    ((2,), "through the middle"),
    ((0, 4), "near the reversals"),
    ((1, 2, 3), "away from the reversals"),
    ((0, 1), "on the way from the reversals to the middle"),
    ((3, 4), "on the way from the middle to the reversals"),
)
"""Places of `LOOP_PLACES` that have a name together."""
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
HARMONICS_NAMED = 3
HARMONICS_NAMED_SHARE = 0.8
"""Harmonics are named until they hold this share, or so many are."""
WORTH_NAMING = 0.05
"""A harmonic with less of the error than this isn't named."""
FARTHER_OFF = 2.0
"""Times the error of all runs, and times their own scatter, from which on the worst level of a condition is named."""
DRIFT_STANDARD_ERRORS = 3.0
"""Standard errors that make a drift."""
DRIFT_SHARE = 0.01
"""A drift that makes less than this share of the squared error isn't worth a sentence."""


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


def region(sums: Sequence[RunSums], conditions: Sequence[Condition]) -> Region | None:
    """Find where the error beyond scatter sits; None where it is spread evenly, or there is none."""
    if is_scatter(along_loop(sums)):
        return None
    excess, force = excess_table(sums)
    return densest(excess, force, [*_place_factors(len(sums)), *condition_factors(conditions, len(sums), PHASE_BINS)])


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
        rated = [(_divergence(*_inside([*chosen, factor], excess, force)), factor) for factor in free]
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


def farthest_off(sums: Sequence[RunSums], conditions: Sequence[Condition], nrmse: float) -> str:
    """Say at which level of a condition the law is farthest off, as a share of the force there; empty where none is.

    In the error of all runs, and in units of one force noise, small forces count little.

    Args:
        sums: the squared error of each run.
        conditions: what may be named.
        nrmse: error of all runs as a share of the force.
    """
    levels = [
        (part.nrmse or 0.0, part, condition, place)
        for condition in conditions
        for place, part in enumerate(by_condition(sums, condition).parts)
        if condition.levels[place].known
    ]
    if not levels:
        return ""
    worst, part, condition, place = max(levels, key=lambda entry: entry[0])
    scatter = part.noise_nrmse
    if worst < FARTHER_OFF * max(nrmse, scatter or 0.0):
        return ""
    runs = counted(part.runs, "run")
    of_it = "" if scatter is None else f"; scatter makes {scatter:.2%}"
    at = _interval_words(condition, condition.levels, place, place)
    return f"{at} the law errs by {worst:.2%} of the force there ({runs}){of_it}"


def _inside(factors: Sequence[Factor], excess: Array, force: Array) -> tuple[float, float]:
    """Give the shares of the error and of the evenly spread force that lie in a region."""
    runs = np.prod([factor.runs for factor in factors], axis=0)
    phases = np.prod([factor.phases for factor in factors], axis=0)
    return float(runs @ excess @ phases), float(runs @ force @ phases)


def _divergence(share: float, even: float) -> float:
    """Give the Kullback-Leibler divergence of a region's share from an even spread's; 0 where it holds too little."""
    if share < max(MUCH_OF_IT, even) or not 0.0 < even < 1.0:
        return 0.0
    inside = min(share, 1.0)
    outside = (1 - inside) * math.log((1 - inside) / (1 - even)) if inside < 1.0 else 0.0
    return inside * math.log(inside / even) + outside


def _place_factors(runs: int) -> Iterator[Factor]:
    places = np.array([place_of(index) for index in range(PHASE_BINS)])
    everywhere = np.ones(runs)
    for members, words in PLACE_SETS:
        yield Factor("place", words, everywhere, np.isin(places[:, 0], members).astype(np.float64))
    for branch, words in enumerate(BRANCHES):
        yield Factor("branch", f"on {words}", everywhere, (places[:, 1] == branch).astype(np.float64))
    positive = np.cos(np.radians([sum(phase_edges(index)) / 2 for index in range(PHASE_BINS)])) > 0
    yield Factor("side", "above the middle of the motion", everywhere, positive.astype(np.float64))
    yield Factor("side", "below the middle of the motion", everywhere, (~positive).astype(np.float64))


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
                    yield Factor(condition.key, _interval_words(condition, known, first, last), inside, always)


def _interval_words(condition: Condition, levels: Sequence[Level], first: int, last: int) -> str:
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


def hidden_sentence(whole: Breakdown) -> str | None:
    """Say who can tell whether scatter hides an effect; None where more than scatter is left."""
    return (
        "A diagnosis, which asks all runs at once, tells whether an effect hides in it." if is_scatter(whole) else None
    )


def harmonic_sentence(harmonics: Breakdown) -> str | None:
    """Say which harmonics the error lies in; None where it is scatter."""
    named = "" if is_scatter(harmonics) else shares_words(harmonics)
    return f"By harmonic, {named}." if named else None


def shares_words(parts: Breakdown) -> str:
    """Name the parts that hold most of the error; empty where none holds much."""
    named: list[str] = []
    held = 0.0
    # where noise happens to be small a part lies below its scatter, and the others make more than the whole
    whole = max(sum(max(parts.excess_share(part), 0.0) for part in parts.parts), 1.0)
    for part in sorted(parts.parts, key=parts.excess_share, reverse=True)[:HARMONICS_NAMED]:
        share = parts.excess_share(part) / whole
        if held > HARMONICS_NAMED_SHARE or share < WORTH_NAMING:
            break
        held += share
        named.append(f"{share:.0%}{'' if named else ' of it'} is {_meaning(part.label)}")
    return ", ".join(named)


def _meaning(label: str) -> str:
    """Say what the first harmonic's parts are to a test engineer."""
    return {
        "harmonic 1 in phase": "harmonic 1 in phase (stiffness)",
        "harmonic 1 in quadrature": "harmonic 1 in quadrature (damping)",
    }.get(label, label)


def cycles_sentence(sums: Sequence[RunSums]) -> str | None:
    """Say whether the records' first or last cycles hold most of the error; None where they don't, or it is scatter."""
    cycles, edges = along_cycles(sums), cycle_edges(sums)
    if is_scatter(cycles):
        return None
    share, even = (np.cumsum([of(part) for part in cycles.parts]) for of in (cycles.excess_share, cycles.even_share))
    choices = [
        choice
        for index, edge in enumerate(edges[1:-1])
        for choice in (
            (float(share[index]), float(even[index]), f"up to cycle {edge} of the records"),
            (float(1 - share[index]), float(1 - even[index]), f"from cycle {edge + 1} of the records on"),
        )
    ]
    held, spread, words = max(choices, key=lambda choice: _divergence(*choice[:2]), default=(0.0, 0.0, ""))
    if _divergence(held, spread) <= STANDS_OUT:
        return None
    return f"By cycle, {held:.0%} of it lies {words}; spread evenly, it would be {spread:.0%}."


def drift_sentence(found: Drift | None, nrmse: float) -> str | None:
    """Say how the measured force drifts against the law within records; None where it doesn't."""
    if found is None:
        return None
    parts = []
    for value, name in ((found.in_phase, "in phase (stiffness)"), (found.in_quadrature, "in quadrature (damping)")):
        # a line from -d/2 to d/2 has the mean square d^2/12
        if abs(value) > DRIFT_STANDARD_ERRORS * found.standard_error and value**2 / 12 > DRIFT_SHARE * nrmse**2:
            parts.append(f"by {100 * value:+.2g} ± {100 * found.standard_error:.1g}% of the force {name}")
    if not parts:
        return None
    return f"From a record's first cycle to its last the measured force drifts against the law {' and '.join(parts)}."
