"""Left-out groups: how well a law that was fitted to some conditions foretells the others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from pipeclamp_identification.fitting.group_factors import PooledObservations
from pipeclamp_identification.fitting.groups import factors_of, find_groups
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import LoopObservations, as_seen_at_few, coarser
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_SHARE, Level, known_levels, name_levels, number_levels
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import condition_signal
from pipeclamp_models.law.law import Law
from pipeclamp_models.law.outline import ParameterOutline, levels_taken
from pipeclamp_models.realise.force import force_of_law

FOLDS = 8
OWN_GROUPS = {"temperature": "T", "density": "rho"}
"""Slow signals of groups that are left out but by further conditions."""
FOLD_TOLERANCE = 1e-6
"""Tolerance of a fold's fit: it begins at the fit to all, and its error is told to four digits."""


def condition_groups(loops: Loops) -> IntArray:
    """Give each loop the number of the group that is left out with it, shape (R,): its amplitude and frequency.

    Without one of two such groups nothing would show what amplitude and frequency do. Where there are two, a group has
    every condition alike, and where there is one, each run is a group of its own.
    """
    groups = amplitude_and_frequency_groups(loops)
    if groups.max() == 1:
        return _alike(_every_condition(loops))
    return groups if groups.max() else np.unique(loops.run, return_inverse=True)[1].astype(np.intp)


def left_out_at_once(loops: Loops) -> str:
    """Name what is the same within each of `condition_groups`."""
    return {1: "runs", 2: "settings"}.get(count_groups(loops), "A, f")


def are_few_settings(loops: Loops) -> bool:
    """Tell whether fits without a group have no more settings than it takes to tell what each condition does.

    One setting and one more for each condition that varies give what each does by itself. What such a fit errs on a
    setting that it lacks may come of what conditions do together, and tells no law from another.
    """
    every = _every_condition(loops)
    settings = _alike(every)
    levels = [[level for level in number_levels(values, relative=SAME_SHARE) if level.known] for values in every]
    varied = sum(len(known) > 1 for known in levels)
    return min(len(np.unique(settings[used])) for used, _ in folds(condition_groups(loops), FOLDS)) <= 1 + varied


def _every_condition(loops: Loops) -> tuple[Array, ...]:
    """Give amplitude, frequency and all further conditions, shape (R,) each."""
    further = loops.conditions.values()
    return loops.amplitude_mm, loops.frequency_Hz, loops.temperature_K, loops.density_g_cm3, *further


def amplitude_and_frequency_groups(loops: Loops) -> IntArray:
    """Give each loop the number of its (amplitude, frequency) group, shape (R,).

    Where conditions lie so dense that they would all be the same, classes of them make the groups.
    """
    return _alike((loops.amplitude_mm, loops.frequency_Hz))


def count_groups(loops: Loops) -> int:
    """Count the (amplitude, frequency) groups."""
    return int(amplitude_and_frequency_groups(loops).max()) + 1


def _alike(quantities: Sequence[Array]) -> IntArray:
    """Give each loop the number of those that have the same levels of all quantities, shape (R,)."""
    levels = [_numbers(number_levels(values, relative=SAME_SHARE), len(values)) for values in quantities]
    return np.unique(np.stack(levels, axis=1), axis=0, return_inverse=True)[1].reshape(-1).astype(np.intp)


def are_at_one_condition(loops: Loops) -> bool:
    """Tell whether no condition can be left out to see what a law foretells: leaving a run out leaves its repeats."""
    return count_groups(loops) == 1 and not further_groups(loops)


def further_groups(loops: Loops) -> dict[str, IntArray]:
    """Give other ways to leave runs out: by temperature, specimen or further condition, each run's group by name.

    A condition needs three levels: what it does can't be foretold from one. A further condition needs four, for its
    effect is described by a bend, which takes three (`effects.condition`); its lowest and its highest level are never
    left out (group -1): a description claims nothing beyond its range. Nor are runs of which it isn't known: together
    they are no level.
    """
    groups = {}
    for name, values in _further_conditions(loops).items():
        levels = known_levels(values)
        if name in OWN_GROUPS and len(levels) >= 3:
            groups[name] = _numbers(levels, len(values))
        elif len(levels) >= 4:
            groups[name] = _numbers(levels[1:-1], len(values))
    specimens = [level for level in name_levels(loops.specimen) if level.known]
    if len(specimens) >= 2:
        groups["specimen"] = _numbers(specimens, len(loops.specimen))
    return groups


def kept_at_ends(loops: Loops) -> dict[str, BoolArray]:
    """Tell by each further condition which runs are at its lowest or highest level, and are never left out by it.

    Returns:
        shape (R,) by name of `further_groups`, where levels between are left out.
    """
    found = {}
    for name in further_groups(loops).keys() & loops.conditions.keys():
        levels = known_levels(loops.conditions[name])
        found[name] = np.isin(np.arange(len(loops.run)), np.concatenate([levels[0].rows, levels[-1].rows]))
    return found


def is_foretold(name: str, loops: Loops, fitted: Iterable[ParameterOutline]) -> bool:
    """Tell whether the other levels of a condition determine what parameters of a law do over it.

    Args:
        name: of groups that are left out, as of `further_groups`.
        loops: the tests.
        fitted: the parameters that were fitted.
    """
    taken = levels_taken(signal_of_groups(name), fitted)
    return not taken or taken < len(known_levels(_further_conditions(loops)[name]))


def signal_of_groups(name: str) -> str:
    """Give the slow signal of the condition by which groups of this name are left out."""
    return OWN_GROUPS.get(name) or condition_signal(name)


def _further_conditions(loops: Loops) -> dict[str, Array]:
    """Give each condition beside A and f by the name of its groups, shape (R,)."""
    return {"temperature": loops.temperature_K, "density": loops.density_g_cm3, **loops.conditions}


def _numbers(levels: Sequence[Level], count: int) -> IntArray:
    """Give the number of the level of each of so many runs; -1 where none of these has it."""
    numbers = np.full(count, -1, dtype=np.intp)
    for number, level in enumerate(levels):
        numbers[level.rows] = number
    return numbers


def folds(groups: IntArray, most: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Give (rows to fit, rows left out), whole groups left out at a time, in at most so many folds.

    Raises:
        UserError: there is one group alone.
    """
    count = int(groups.max()) + 1
    if count == 1:
        raise UserError("one test alone: nothing is left to fit once it is left out; expected two tests or more")
    number = min(most, count)
    for fold in range(number):
        left_out = groups % number == fold
        yield np.flatnonzero(~left_out), np.flatnonzero(left_out)


def share_of_force(mean_squares: Array, loops: Loops, left_out: BoolArray) -> float:
    """Give the error on loops that were left out as a share of their force, scatter included.

    None counts for more than the largest force of all tests: of what only extrapolation could tell an error has no
    size.

    Args:
        mean_squares: of each loop's error, N2, scatter left aside, shape (R,); NaN or infinite where it has no size.
        loops: the tests.
        left_out: which count, shape (R,).
    """
    force = loops.force_rms_N**2
    squares = np.fmin(mean_squares + loops.noise_rms_N**2, np.max(force))
    return float(np.sqrt(np.sum(squares[left_out]) / np.sum(force[left_out])))


def refitted_nrmse(law: Law, loops: Loops, observations: LoopObservations, most: int = FOLDS) -> float:
    """Give the error of a law's structure on (amplitude, frequency) groups that weren't used to fit it.

    Args:
        law: the law, as fitted to all; each fit begins there and weighs by what it leaves over.
        loops: the tests.
        observations: the same, as observations.
        most: most folds.

    Returns:
        error over all left-out loops, as of `share_of_force`.
    """
    groups = condition_groups(loops)
    as_it_is, fitted_to = force_of_law(law, observations.motion), observations
    if law.equations.states:
        # Steps from point to point take their time; a fold's fit may be told at fewer points than its error.
        few, at_many = coarser(loops, observations), as_it_is
        as_it_is = force_of_law(law, few.motion)
        fitted_to = as_seen_at_few(few, observations, (as_it_is, at_many))
    factors = factors_of(find_groups(loops, fitted_to, as_it_is), loops, observations)
    explained = 0.0 if factors is None else factors.beside(as_it_is).force()
    widened = fitted_to.with_discrepancy(as_it_is, explained)
    mean_squares = np.zeros(len(groups))
    for used, left_out in folds(groups, most):
        rows = widened.rows(used)
        own = None if factors is None else PooledObservations(rows, factors.rows(used))
        refitted = fit(law.structure, own or rows, start=law.values, tolerance=FOLD_TOLERANCE)
        beyond = observations.rows(left_out)
        foretold = force_of_law(refitted.law, beyond.motion)
        shown: Array | float = 0.0
        if own and factors:
            # a group's factors come from its runs that are left
            shown = factors.rows(left_out).beside(foretold).force(own.estimate(refitted.law_force))
        mean_squares[left_out] = beyond.mean_squares(foretold, shown)
    return share_of_force(mean_squares, loops, np.ones(len(groups), dtype=np.bool_))
