"""Where the error of sines sits, in sentences: in the loop and conditions, by harmonic, along the records' cycles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
from pipeclamp_identification.comparison.densest_region import (
    STANDS_OUT,
    Factor,
    Region,
    condition_factors,
    densest,
    divergence,
    interval_words,
    is_scatter,
)
from pipeclamp_identification.comparison.error_parts import Breakdown
from pipeclamp_identification.comparison.sums import RunSums
from pipeclamp_identification.loops.scatter import PHASE_BINS
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


def region(sums: Sequence[RunSums], conditions: Sequence[Condition]) -> Region | None:
    """Find where the error beyond scatter sits; None where it is spread evenly, or there is none."""
    if is_scatter(along_loop(sums)):
        return None
    excess, force = excess_table(sums)
    return densest(excess, force, [*_place_factors(len(sums)), *condition_factors(conditions, len(sums), PHASE_BINS)])


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
    at = interval_words(condition, condition.levels, place, place)
    return f"{at} the law errs by {worst:.2%} of the force there ({runs}){of_it}"


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
    held, spread, words = max(choices, key=lambda choice: divergence(*choice[:2]), default=(0.0, 0.0, ""))
    if divergence(held, spread) <= STANDS_OUT:
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
