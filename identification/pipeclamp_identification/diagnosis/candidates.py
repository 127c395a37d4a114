"""Candidates: the effects that promise something, fitted with the law one by one and in pairs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
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
from pipeclamp_identification.diagnosis.screen import (
    Promise,
    beside,
    candidate_names,
    fits,
    fits_beside,
    promising_starts,
)
from pipeclamp_identification.diagnosis.thresholds import (
    LARGER_MEMBER_SQUARES,
    RIVAL_LIKELIHOOD,
    WORTH_CLOSELY_SHARE,
    WORTH_FITTING_SHARE,
)
from pipeclamp_identification.fitting.joint.not_fitted import undetermined
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.joint.starts import kept
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.catalogue import act_alike, effect_id
from pipeclamp_models.law.law import Structure, with_effect

MOST_FITTED = 8
"""Candidates that the screen lets through to a full fit, at most."""
MOST_PAIRED = 3
"""Best candidates that are tried together with a second effect, where one alone doesn't explain."""


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
    leading = [with_effect(structure, promise.name).effect(promise.name) for promise in promises[:MOST_PAIRED]]
    asked = {*ids, *(simple for effect in leading for simple in effect.special_cases)}
    gaining = [promise for promise in promises if promise.gain > 0 and promise.gain >= worth]
    return [promise for promise in gaining if effect_id(promise.name) in asked]


def _worth_growing(judged: Sequence[Judged]) -> list[Judged]:
    """Give the best laws with an effect, and those with special cases of it, which may do as well once larger."""
    best = [each.result.law.structure.effect(each.effects[0]) for each in judged[:MOST_PAIRED]]
    special = {simple for effect in best for simple in effect.special_cases}
    return [each for place, each in enumerate(judged) if place < MOST_PAIRED or effect_id(each.effects[0]) in special]


def _each_roughly(contenders: Sequence[Contender], problem: Problem, workers: Workers) -> list[RoughFit]:
    return workers.each(
        partial(_roughly, problem), contenders, lambda one: f"fitted {' and '.join(one.effects)} roughly"
    )


def _roughly(problem: Problem, one: Contender) -> RoughFit:
    return roughly(one.structure, one.starts, problem)


def _closely_where_worth(
    contenders: Sequence[Contender], problem: Problem, law: Judged, workers: Workers
) -> list[Contender]:
    """Fit all roughly; give where to go on from, closely where a rough fit gains much of what the best one does."""
    rough = _each_roughly(contenders, problem, workers)
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
    return sorted(judged, key=what)[:MOST_PAIRED]


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


def pairs(
    structure: Structure,
    problem: Problem,
    law: Judged,
    sound: Sequence[Judged],
    usable: Sequence[Judged],
    promises: Sequence[Promise],
    workers: Workers,
) -> list[Judged]:
    """Fit the best candidates together with the second effects that promise most; give the sound pairs, best first.

    Of all candidates those that promise most with what scales only them are tried, too: by itself such an effect may
    take nothing, or end at a bound, as relaxation that each temperature moves elsewhere.

    Args:
        structure, problem, law: what they join.
        sound: candidates that may be the cause, best first.
        usable: candidates that nothing physical speaks against, best first; the former among them.
        promises: what each effect promises by itself.
        workers: who does it, and who is told.
    """
    contenders: list[Contender] = []
    tried: set[frozenset[str]] = set()
    firsts = best_of_each(sound)[:MOST_PAIRED]
    for first in firsts:
        contenders += [each for _, each in _with_modifiers(structure, first, problem)]
        promising = _with_promising(structure, first, law, promises, tried)
        tried |= {_ids(*each.effects) for each in promising}
        contenders += promising
    others = [one for one in best_of_each(usable) if not any(one is first for first in firsts)]
    further = [pair for first in others for pair in _with_modifiers(structure, first, problem)]
    contenders += [each for _, each in sorted(further, key=lambda pair: pair[0])[:MOST_PAIRED]]
    best = judge_each(_best_roughly(contenders, problem, workers), problem, workers)
    found = ranked(pair for pair in best if pair.may_be_cause)
    return each_larger_as_asked(found[:1], structure, problem, workers) + found[1:]


def _with_promising(
    structure: Structure, first: Judged, law: Judged, promises: Sequence[Promise], tried: Collection[frozenset[str]]
) -> list[Contender]:
    """Give the pairs of an effect with those that promise most beside it.

    Args:
        structure, law: what they join.
        first: the law with the effect.
        promises: what each effect promises by itself.
        tried: pairs that another effect has brought, by their ids.
    """
    name = first.effects[0]
    larger = with_effect(structure, name)
    seconds = [
        beside(promise, first, law)
        for promise in promises
        if effect_id(promise.name) != effect_id(name)
        and _ids(name, promise.name) not in tried
        and fits_beside(larger, promise.name)
    ]
    return [
        Contender((name, second.name), with_effect(larger, second.name), [start])
        for _, start, second in sorted(seconds, key=lambda entry: -entry[0])[:MOST_PAIRED]
    ]


def _ids(*names: str) -> frozenset[str]:
    return frozenset(map(effect_id, names))


def together_with_each(
    best: Judged,
    others: Sequence[Judged],
    structure: Structure,
    problem: Problem,
    law: Judged,
    promises: Sequence[Promise],
    workers: Workers,
) -> list[Judged]:
    """Fit an effect together with each of others, where both fit into a law; give these laws.

    Args:
        best: the law with the effect.
        others: laws with one of the others each.
        structure, problem, law: what they join.
        promises: what each effect promises by itself.
        workers: who does it, and who is told.
    """
    larger = with_effect(structure, best.effects[0])
    asked = {effect_id(each.effects[0]) for each in others}
    found = [
        beside(promise, best, law)
        for promise in promises
        if effect_id(promise.name) in asked and fits_beside(larger, promise.name)
    ]
    contenders = [
        Contender((best.effects[0], second.name), with_effect(larger, second.name), [start])
        for _, start, second in found
    ]
    return judge_each(contenders, problem, workers)


def twins(
    pair: Judged,
    structure: Structure,
    problem: Problem,
    singles: Sequence[Judged],
    workers: Workers,
) -> list[Judged]:
    """Fit what acts like one of two effects in its place, beside the other; give what isn't objected to, best first.

    By itself the one may have done best while another does so with the second beside it.

    Args:
        pair: the law with the two.
        structure, problem: what they join.
        singles: every effect that was fitted by itself, best first.
        workers: who does it, and who is told.
    """
    values = pair.result.law.values
    contenders: list[Contender] = []
    for gone, stays in (pair.effects, pair.effects[::-1]):
        one = pair.result.law.structure.effect(gone)
        alike = [
            each
            for each in singles
            if act_alike(one, name := each.effects[0])
            and effect_id(name) != effect_id(stays)
            and one.id not in structure.effect(name).special_cases  # a general effect fits as well by itself
        ]
        for twin in alike[:MOST_PAIRED]:
            larger = with_effect(structure, twin.effects[0])
            if fits_beside(larger, stays):
                both, alone = with_effect(larger, stays), twin.result.law.values
                # what is there only where the one scales what the other brings is in neither
                rest = both.equations.neutral_values
                starts = [both.own({**rest, **start}) for start in ({**alone, **values}, {**values, **alone})]
                in_order = most_promising_first(both, problem.coarse, starts)
                contenders.append(Contender((twin.effects[0], stays), both, in_order))
    return ranked(each for each in judge_each(contenders, problem, workers) if not each.objections)


def in_place_of(
    gone: str, come: Sequence[str], whole: Judged, structure: Structure, problem: Problem, law: Judged
) -> Contender | None:
    """Give a law with several effects in the place of one; None where they don't all fit into it, or one modifies it.

    Args:
        gone: the effect that goes.
        come: those that take its place.
        whole: the law with it, and what was added with it.
        structure, problem, law: what they join.
    """
    larger = structure
    added = (*(name for name in whole.effects if name != gone), *come)
    for name in added:
        if not fits_beside(larger, name):
            return None
        larger = with_effect(larger, name)
    points = []
    for values in (law.result.law.values, whole.result.law.values):
        stated = larger.own({**whole.result.law.values, **values})
        points += _points_from(stated, larger, problem)
    return Contender(added, larger, [start.values for start in promising_starts(larger, problem, points)])


def _points_from(
    stated: Mapping[str, float], structure: Structure, problem: Problem
) -> list[tuple[Mapping[str, float], Collection[str]]]:
    """Give the points that a law is tried from beside stated values, and the names of those of them that stay."""
    return [(point, kept(point, stated)) for point in starting_points(structure, problem.coarse, stated)]


def _with_modifiers(structure: Structure, first: Judged, problem: Problem) -> list[tuple[float, Contender]]:
    """Give the pairs of an effect with those that scale what only it has: none of them can be screened without it.

    Not with one of which these tests show nothing: one over T where T doesn't vary. Each comes with the cost after one
    step from the best of its starts.
    """
    larger = with_effect(structure, first.effects[0])
    contenders = []
    loops = problem.loops
    for name in candidate_names(larger, loops.conditions, time_measured=loops.time_measured):
        if fits(structure, name) or not fits_beside(larger, name):
            continue
        both, stated = with_effect(larger, name), first.result.law.values
        if undetermined(both.equations, problem.coarse).keys() >= {one.name for one in both.effect(name).parameters}:
            continue
        promising = promising_starts(both, problem, _points_from(stated, both, problem))
        starts = [start.values for start in promising]
        going_on = next(start for start in starts if kept(start, stated) == set(stated))
        in_order = [going_on, *(start for start in starts if start is not going_on)]
        contenders.append((promising[0].cost, Contender((first.effects[0], name), both, in_order)))
    return contenders


def _best_roughly(contenders: Sequence[Contender], problem: Problem, workers: Workers) -> list[Contender]:
    """Give those that do best when all are fitted roughly, from where that ended."""
    rough = _each_roughly(contenders, problem, workers)
    order = sorted(range(len(rough)), key=lambda place: rough[place].cost)[:MOST_PAIRED]
    return [replace(contenders[place], starts=[rough[place].values]) for place in order]


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
