"""What a law that has grown is asked again: is each effect still needed, does its like or another base do better?"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.candidates import larger_as_asked
from pipeclamp_identification.diagnosis.foretold import gains, share_of_error, takes_part
from pipeclamp_identification.diagnosis.open_means import with_means_counted
from pipeclamp_identification.diagnosis.problem import (
    Judged,
    Prepared,
    Problem,
    RoughFit,
    judge,
    prepare,
    roughly,
    weighed_again,
)
from pipeclamp_identification.diagnosis.screen import candidate_names, promising_starts
from pipeclamp_identification.diagnosis.thresholds import MATERIAL_PART_SHARE, ratio_without_powers
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.series_orders import choose_series
from pipeclamp_identification.fitting.surfaces import surface_values
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.catalogue import act_alike, effect_id
from pipeclamp_models.law.law import BASES, Law, Structure, find_base

MOST_SWAPPED = 3
"""Laws with another effect in one's place that are fitted closely."""


@dataclass(frozen=True)
class RevisedLaw:
    """A law to be asked again, with the tests: fitted, and weighed by its own residuals."""

    structure: Structure
    problem: Problem
    law: Judged

    @property
    def values(self) -> Mapping[str, float]:
        """Its parameters' values."""
        return self.law.result.law.values


def ask_again(law: Law, loops: Loops, prepared: Prepared | None = None) -> RevisedLaw:
    """Fit a law for asking it again.

    Args:
        law: the law.
        loops: the tests.
        prepared: `prepare` of both, where it is known already.

    Raises:
        UserError: the tests can't serve the law.
    """
    problem, fitted = prepared or prepare(law.structure, loops, law.values)
    return RevisedLaw(law.structure, *weighed_again(problem, law.structure, fitted, [fitted]))


def superfluous(asked: RevisedLaw, keep: str, progress: Progress) -> str | None:
    """Give the effect that the law does as well without on left-out conditions; None where each is needed.

    Args:
        asked: the law.
        keep: the effect that was added last, which isn't asked.
        progress: is told what is being done.
    """
    spare: list[tuple[float, str]] = []
    for name in asked.structure.effects:
        if name == keep:
            continue
        progress(f"does the law do as well without {name}?")
        without = replace(asked.structure, effects=tuple(one for one in asked.structure.effects if one != name))
        try:
            judged = judge((), without, [without.own(asked.values)], asked.problem)
        except UserError:  # another effect modifies what only this one has
            continue
        if _does_as_well(judged, asked):
            spare.append((float(gains(asked.law, judged, asked.problem).sum()), name))
    return min(spare)[1] if spare else None


def _does_as_well(other: Judged, asked: RevisedLaw) -> bool:
    """Tell whether the law is no better than another one on left-out conditions, beyond its doubt or materially."""
    gain = gains(asked.law, other, asked.problem)
    doubt = np.sqrt(len(gain) * np.var(gain, ddof=1)) if len(gain) > 1 else np.inf
    return bool(gain.sum() < doubt and share_of_error(asked.law, other) < MATERIAL_PART_SHARE)


def without_spare_powers(asked: RevisedLaw, complete: bool, progress: Progress) -> Structure | None:
    """Give the law with those powers of the amplitude held at 0 that its memory spares; None where it needs each.

    The base's coefficients follow A, which along a sine stands for all that has gone before. A law with memory knows
    that by itself, and along other motions by that alone: there such powers lead astray, by several times what they
    take from sines. Held are as many as may be, those first that the tests determine least: of a complete law those
    that it does as well without, in the fit to all tests too, parameters counted; of another one, whose powers may
    imitate what it lacks, those that take little from its error on left-out conditions.

    Args:
        asked: the law.
        complete: whether nothing is missing.
        progress: is told what is being done.
    """
    if not asked.structure.equations.states:
        return None
    spares = _is_preferred if complete else _errs_little_more
    powers = _amplitude_powers(asked)
    for count in range(len(powers), 0, -1):
        progress(f"does the law do as well without {' and '.join(powers[:count])}?")
        frozen = (*asked.structure.frozen, *((name, 0.0) for name in powers[:count]))
        without = replace(asked.structure, frozen=tuple(sorted(frozen)))
        starts = [asked.values, {**asked.values, **surface_values(without, asked.problem.loops)}]
        if spares(judge((), without, starts, asked.problem), asked):
            return without
    return None


def _is_preferred(other: Judged, asked: RevisedLaw) -> bool:
    """Tell whether a law with fewer parameters does as well, and the fit to all tests prefers it."""
    return _does_as_well(other, asked) and other.akaike < asked.law.akaike


def _errs_little_more(other: Judged, asked: RevisedLaw) -> bool:
    """Tell whether a law that isn't complete errs on left-out conditions by next to no more without powers."""
    return other.heldout_nrmse <= ratio_without_powers(complete=False) * asked.law.heldout_nrmse


def _amplitude_powers(asked: RevisedLaw) -> list[str]:
    """Give the fitted exponents over A of a law's base, those first that the tests determine least."""
    result, of_base = asked.law.result, find_base(asked.structure.base).terms
    errors = result.standard_errors()
    powers = [
        parameter.name
        for parameter in result.fitted_parameters
        if parameter.effect in of_base and parameter.follows == ("A",) and parameter.neutral == 0.0
    ]
    return sorted(powers, key=lambda name: abs(asked.values[name]) / errors.get(name, np.inf))


def simpler_structure(asked: RevisedLaw, names: Collection[str], workers: Workers) -> Structure | None:
    """Give the law with an effect in one's place that acts alike, and fewer parameters; None where none does as well.

    An element of `memory` that the law has becomes one of several where that takes the place. It does as well on
    left-out conditions, and the fit to all tests prefers it, its parameters counted.

    Args:
        asked: the law.
        names: the effects that are asked.
        workers: who does it, and who is told.
    """
    parameters = _parameters(asked.structure)
    swaps = [swap for swap in _alike(asked) if swap.gone in names and _parameters(swap.structure) < parameters]
    found = [each for each in _swapped(asked, swaps, workers) if not each.objections]
    simpler = [
        each for each in found if _is_preferred(each, asked) and _parameters(each.result.law.structure) < parameters
    ]
    return min(simpler, key=lambda judged: judged.akaike).result.law.structure if simpler else None


def better_structures(asked: RevisedLaw, names: Collection[str] | None, workers: Workers) -> list[Structure]:
    """Give the law with another of its effects' family in one's place, or on another base, where it does better.

    To do better is to take a part of what the law lacks, on every kind of left-out condition and beyond doubt, and not
    in mean forces that it leaves open. A base that does so with the law's effects is also given alone, after that: they
    may have made up for the base that the law had, and what nothing needs goes astray on left-out conditions.

    Args:
        asked: the law.
        names: its effects that are asked; None for all, and its base.
        workers: who does it, and who is told.

    Returns:
        what does better, best first; empty where nothing does.
    """
    swaps = [swap for swap in _alike(asked) if names is None or swap.gone in names]
    found = [*_swapped(asked, swaps, workers), *(_on_another_base(asked, workers) if names is None else ())]
    sound = (each for each in found if not with_means_counted(each, asked.law, asked.problem).objections)
    better = [each for each in sound if takes_part(each, asked.law, asked.problem)]
    structures: list[Structure] = []
    for each in sorted(better, key=lambda judged: judged.squares):
        structure = each.result.law.structure
        structures.append(structure)
        if structure.base != asked.structure.base and structure.effects:
            structures.append(_on(structure.base.partition(":")[0], (), asked))
    return structures


@dataclass(frozen=True)
class _Swap:
    """A law with another effect in one's place."""

    gone: str
    come: str
    structure: Structure


def _alike(asked: RevisedLaw) -> Iterator[_Swap]:
    """Give the law with each effect of the catalogue in the place of each of its own that acts alike."""
    loops = asked.problem.loops
    known = candidate_names(asked.structure, loops.conditions, time_measured=loops.time_measured)
    effects = asked.structure.effects
    for name in effects:
        for other in known:
            if act_alike(asked.structure.effect(name), other):
                # a larger member takes the place of the one that the law has
                kept = [one for one in effects if one == name or effect_id(one) != effect_id(other)]
                exchanged = tuple(other if one == name else one for one in kept)
                yield _Swap(name, other, replace(asked.structure, effects=exchanged))


def _parameters(structure: Structure) -> int:
    """Count the parameters of a law's effects."""
    return sum(len(effect.parameters) for effect in structure.all_effects())


def _swapped(asked: RevisedLaw, swaps: Sequence[_Swap], workers: Workers) -> list[Judged]:
    """Put another effect in the place of one, for each of these swaps: all roughly, the best closely.

    Members of a family are as large as the tests ask for.
    """
    fits = workers.each(
        partial(_swapped_roughly, asked), swaps, lambda swap: f"fitted {swap.come} in place of {swap.gone} roughly"
    )
    rough = [(swap, fit) for swap, fit in zip(swaps, fits, strict=True) if fit]
    rough.sort(key=lambda entry: entry[1].cost)
    return workers.each(
        partial(_swapped_closely, asked),
        rough[:MOST_SWAPPED],
        lambda entry: f"fitted {entry[0].come} in place of {entry[0].gone}",
    )


def _swapped_roughly(asked: RevisedLaw, swap: _Swap) -> RoughFit | None:
    """Fit a law with another effect in one's place roughly; None where one that stays modifies what is gone."""
    try:
        own = swap.structure.own(asked.values)
        points = ((point, own) for point in starting_points(swap.structure, asked.problem.coarse, own))
        starts = [start.values for start in promising_starts(swap.structure, asked.problem, points)]
        return roughly(swap.structure, starts, asked.problem)
    except UserError:
        return None


def _swapped_closely(asked: RevisedLaw, rough: tuple[_Swap, RoughFit]) -> Judged:
    """Fit such a law closely, from where its rough fit ended, with members of a family as large as is asked for."""
    swap, fit = rough
    structure, come = swap.structure, swap.come
    judged = replace(judge((), structure, [fit.values], asked.problem), effects=(come,))
    others = replace(structure, effects=tuple(name for name in structure.effects if name != come))
    return larger_as_asked(others, asked.problem, judged)


def _on_another_base(asked: RevisedLaw, workers: Workers) -> list[Judged]:
    own = asked.structure.base.partition(":")[0]
    bases = [name for name, entry in BASES.items() if entry.general and name != own]
    found = workers.each(partial(_judged_on, asked), bases, "fitted the law on base {}".format)
    return [judged for judged in found if judged]


def _judged_on(asked: RevisedLaw, base: str) -> Judged | None:
    """Fit the law on another base; None where an effect scales what that base hasn't got."""
    try:
        other = _on(base, asked.structure.effects, asked)
        return judge((), other, _starts(other, asked), asked.problem)
    except UserError:
        return None


def _on(base: str, effects: tuple[str, ...], asked: RevisedLaw) -> Structure:
    """Give the law on another base, with these of its effects; one that is a term of the base is in it already.

    Orders of a series are chosen without effects that have states: each of dozens of fits would step them.
    """
    terms = find_base(base).terms
    effects = tuple(name for name in effects if name not in terms)
    other = replace(asked.structure, base=base, effects=effects)
    if base != "series":
        return other
    light = replace(other, effects=tuple(name for name in effects if not asked.structure.effect(name).states))
    return replace(other, base=choose_series(asked.problem.loops, asked.problem.harmonics, light).base)


def _starts(other: Structure, asked: RevisedLaw) -> list[Mapping[str, float]]:
    """Give where the law on another base starts: from the law's own values, and from the base's beginnings."""
    surfaces = surface_values(other, asked.problem.loops)
    added = {parameter.name for name in other.effects for parameter in other.effect(name).parameters}
    anew = starting_points(
        other,
        asked.problem.observations,
        {**surfaces, **{name: asked.values[name] for name in added & set(asked.values)}},
    )
    return [{**anew[0], **surfaces, **other.own(asked.values)}, *anew]
