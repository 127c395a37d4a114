"""Candidates: the effects that promise something, fitted with the law one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial

from pipeclamp_identification.diagnosis.problem import (
    CLOSELY,
    ROUGHLY,
    Contender,
    Judged,
    Problem,
    RoughFit,
    judge,
    judge_each,
    most_promising_first,
    roughly,
)
from pipeclamp_identification.diagnosis.screen import Promise
from pipeclamp_identification.diagnosis.thresholds import (
    LARGER_MEMBER_SQUARES,
    RIVAL_LIKELIHOOD,
    WORTH_CLOSELY_SHARE,
    WORTH_FITTING_SHARE,
)
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.law import Structure, with_effect

MOST_FITTED = 8
"""Candidates that the screen lets through to a full fit, at most."""
MOST_PURSUED = 3
"""Best candidates that are gone on with: asked for larger members and special cases, or for a second effect."""


def candidates(
    structure: Structure,
    problem: Problem,
    law: Judged,
    promises: Sequence[Promise],
    workers: Workers,
) -> tuple[list[Judged], dict[str, float]]:
    """Fit the effects that promise something.

    Args:
        structure: the law's structure.
        problem: the data.
        law: the law as it is.
        promises: of each effect, most promising first.
        workers: who does it, and who is told.

    Returns:
        the law with each of them, best first; and effects that were screened out, each with its share of the largest
        promise.
    """
    chosen = _worth_fitting(structure, promises)
    top = promises[0].gain if promises else 0.0
    left = {promise.name: promise.gain / top if top > 0 else 0.0 for promise in promises if promise not in chosen}
    contenders = [
        Contender((promise.name,), with_effect(structure, promise.name), [start.values for start in promise.starts])
        for promise in chosen
    ]
    judged = ranked(judge_each(_closely_where_worth(contenders, problem, law, workers), problem, workers))
    growing = _worth_growing(judged)
    others = [each for each in judged if not any(each is one for one in growing)]
    return ranked([*each_larger_as_asked(growing, structure, problem, workers), *others]), left


def _worth_fitting(structure: Structure, promises: Sequence[Promise]) -> list[Promise]:
    """Give the effects that promise most, and special cases of the first of them, where they promise enough.

    One step may show what a general effect does and not what its special case would, once the law has moved to it.
    """
    ids = list(dict.fromkeys(effect_id(promise.name) for promise in promises))[:MOST_FITTED]
    worth = WORTH_FITTING_SHARE * (promises[0].gain if promises else 0.0)
    leading = [with_effect(structure, promise.name).effect(promise.name) for promise in promises[:MOST_PURSUED]]
    asked = {*ids, *(simple for effect in leading for simple in effect.special_cases)}
    gaining = [promise for promise in promises if promise.gain > 0 and promise.gain >= worth]
    return [promise for promise in gaining if effect_id(promise.name) in asked]


def _worth_growing(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best laws with an effect, and those with special cases of it, which may do as well once larger."""
    best = [each.result.law.structure.effect(each.effects[0]) for each in judged[:MOST_PURSUED]]
    special = {simple for effect in best for simple in effect.special_cases}
    return [each for place, each in enumerate(judged) if place < MOST_PURSUED or effect_id(each.effects[0]) in special]


def each_roughly(contenders: Sequence[Contender], problem: Problem, workers: Workers) -> list[RoughFit]:
    """Fit laws roughly side by side; give where each ended, in the same order."""
    return workers.each(
        partial(_roughly, problem), contenders, lambda one: f"fitted {' and '.join(one.effects)} roughly"
    )


def _roughly(problem: Problem, one: Contender) -> RoughFit:
    return roughly(one.structure, one.starts, problem)


def _closely_where_worth(
    contenders: Sequence[Contender], problem: Problem, law: Judged, workers: Workers
) -> list[Contender]:
    """Fit all roughly; give where to go on from, closely where a rough fit gains much of what the best one does."""
    rough = each_roughly(contenders, problem, workers)
    gains = [law.result.cost - result.cost for result in rough]
    worth = WORTH_CLOSELY_SHARE * max(gains, default=0.0)
    return [
        replace(each, starts=[result.values], tolerance=CLOSELY if gain >= worth else ROUGHLY)
        for each, result, gain in zip(contenders, rough, gains, strict=True)
    ]


def law_from_another_valley(law: Judged, judged: Sequence[Judged], problem: Problem, workers: Workers) -> Judged:
    """Give the law as it is, fitted from where candidates ended that do best: they may have left a poor valley.

    Of valleys the one that foretells left-out conditions best is chosen: where the error on all tests is much the same,
    a poor one fits what is peculiar to some of them.
    """
    structure = law.result.law.structure
    names = structure.equations.names
    starts = {}
    for each in (*_best_by(judged, lambda one: one.result.cost), *_best_by(judged, lambda one: one.squares)):
        own = structure.own(each.result.law.values)
        if len(own) == len(names):
            starts[each.effects] = own
    elsewhere = judge_each([Contender((), structure, [start]) for start in starts.values()], problem, workers)
    best = min(elsewhere, key=lambda each: each.squares, default=law)
    return best if best.squares < law.squares - RIVAL_LIKELIHOOD else law


def _best_by(judged: Sequence[Judged], what: Callable[[Judged], float]) -> list[Judged]:
    return sorted(judged, key=what)[:MOST_PURSUED]


def each_larger_as_asked(
    judged: Sequence[Judged], structure: Structure, problem: Problem, workers: Workers
) -> list[Judged]:
    """Give laws with added effects' members as large as the data ask for: larger while each does clearly better.

    Args:
        judged: the law with the effects, several times.
        structure: the law without them.
        problem: the data.
        workers: who does it, and who is told.
    """
    work = partial(larger_as_asked, structure, problem)
    return workers.each(work, judged, lambda one: f"asked {' and '.join(one.effects)} for larger members")


def larger_as_asked(structure: Structure, problem: Problem, judged: Judged) -> Judged:
    """Give a law with added effects' members as large as the data ask for, as `each_larger_as_asked` does."""
    for place in range(len(judged.effects)):
        while (larger := _with_larger(judged, place, structure, problem)) is not None:
            judged = larger
    return judged


def _with_larger(judged: Judged, place: int, structure: Structure, problem: Problem) -> Judged | None:
    """Give a law with the next larger member of one of its added effects; None where it doesn't do clearly better.

    Nor where the tests don't determine all of its parameters: an element that never slips only lets mean forces go.
    """
    smaller = structure.effect(judged.effects[place])
    if smaller.refinement is None or not smaller.refinement.at_once:
        return None
    effects = (*judged.effects[:place], smaller.refinement.name, *judged.effects[place + 1 :])
    larger = structure
    for effect in effects:
        larger = with_effect(larger, effect)
    starts = refined_starts(larger, smaller, problem.observations, judged.result.law.values)
    grown = judge(effects, larger, most_promising_first(larger, problem.observations, starts), problem)
    determined = grown.result.standard_errors()
    idle = any(parameter.name not in determined for parameter in larger.effect(effects[place]).parameters)
    return None if grown.objections or idle or grown.squares > judged.squares - LARGER_MEMBER_SQUARES else grown


def best_of_each(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best of each id, of candidates that are ranked."""
    names = distinct(candidate.effects[0] for candidate in judged)
    return [candidate for candidate in judged if candidate.effects[0] in names]


def distinct(names: Iterable[str]) -> tuple[str, ...]:
    """Give the first name of each id: members of one numbered family don't rival one another."""
    first: dict[str, str] = {}
    for name in names:
        first.setdefault(effect_id(name), name)
    return tuple(first.values())


def ranked(judged: Iterable[Judged]) -> list[Judged]:
    """Give laws by their squares on left-out conditions, best first."""
    return sorted(judged, key=lambda candidate: candidate.squares)


def likeliest(judged: Iterable[Judged]) -> Judged:
    """Give the candidate that the fit to all data prefers, of those that nothing speaks against."""
    return min((each for each in judged if not each.objections), key=lambda each: each.akaike)


def as_it_is(judged: Judged) -> Contender:
    """Give a law for judging it once more, from its own values."""
    return Contender(judged.effects, judged.result.law.structure, [judged.result.law.values])
