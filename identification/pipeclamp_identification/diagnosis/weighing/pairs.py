"""Effects fitted together, where one alone doesn't explain what is missing, or where others may stand for one."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from pipeclamp_identification.diagnosis.candidates import (
    MOST_PURSUED,
    best_of_each,
    each_larger_as_asked,
    each_roughly,
    ranked,
)
from pipeclamp_identification.diagnosis.problem import Contender, Judged, Problem, judge_each, most_promising_first
from pipeclamp_identification.diagnosis.screen import (
    Promise,
    beside,
    candidate_names,
    fits,
    fits_beside,
    promising_starts,
)
from pipeclamp_identification.diagnosis.weighing.scales import Scales
from pipeclamp_identification.fitting.joint.not_fitted import undetermined
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.joint.starts import kept
from pipeclamp_models.law.catalogue import act_alike, effect_id
from pipeclamp_models.law.law import Structure, with_effect


def pairs(sound: Sequence[Judged], promises: Sequence[Promise], scales: Scales) -> list[Judged]:
    """Fit the best candidates together with the second effects that promise most; give the sound pairs, best first.

    Of all candidates those that promise most with what scales only them are tried, too: by itself such an effect may
    take nothing, or end at a bound, as relaxation that each temperature moves elsewhere.

    Args:
        sound: candidates that may be the cause, best first.
        promises: what each effect promises by itself.
        scales: all candidates, and the law that they join.
    """
    structure, problem = scales.structure, scales.problem
    contenders: list[Contender] = []
    seen: set[frozenset[str]] = set()
    firsts = best_of_each(sound)[:MOST_PURSUED]
    for first in firsts:
        contenders += [each for _, each in _with_modifiers(first, scales)]
        with_seconds = _with_most_promising(first, promises, seen, scales)
        contenders += with_seconds
        seen |= {_ids(*each.effects) for each in with_seconds}
    others = [one for one in best_of_each(scales.usable) if not any(one is first for first in firsts)]
    further = [pair for first in others for pair in _with_modifiers(first, scales)]
    contenders += [each for _, each in sorted(further, key=lambda pair: pair[0])[:MOST_PURSUED]]
    best = judge_each(_best_roughly(contenders, scales), problem, scales.workers)
    found = ranked(pair for pair in best if pair.may_be_cause)
    return each_larger_as_asked(found[:1], structure, problem, scales.workers) + found[1:]


def _with_most_promising(
    first: Judged, promises: Sequence[Promise], seen: Collection[frozenset[str]], scales: Scales
) -> list[Contender]:
    """Give the laws with an effect and a second one each, of those that promise most beside it, most promising first.

    Args:
        first: the law with the effect.
        promises: what each effect promises by itself.
        seen: pairs of ids that are tried already.
        scales: the law that they join.
    """
    larger = with_effect(scales.structure, first.effects[0])
    others = [promise for promise in promises if effect_id(promise.name) != effect_id(first.effects[0])]
    seconds = [beside(promise, first, scales.law) for promise in others if fits_beside(larger, promise.name)]
    in_order = sorted(seconds, key=lambda entry: -entry[0])
    new = [(start, second.name) for _, start, second in in_order if _ids(first.effects[0], second.name) not in seen]
    return [
        Contender((first.effects[0], name), with_effect(larger, name), [start]) for start, name in new[:MOST_PURSUED]
    ]


def _ids(*names: str) -> frozenset[str]:
    return frozenset(map(effect_id, names))


def together_with_each(
    best: Judged, others: Sequence[Judged], promises: Sequence[Promise], scales: Scales
) -> list[Judged]:
    """Fit an effect together with each of others, where both fit into a law; give these laws.

    Args:
        best: the law with the effect.
        others: laws with one of the others each.
        promises: what each effect promises by itself.
        scales: the law that they join.
    """
    larger = with_effect(scales.structure, best.effects[0])
    asked = {effect_id(each.effects[0]) for each in others}
    found = [
        beside(promise, best, scales.law)
        for promise in promises
        if effect_id(promise.name) in asked and fits_beside(larger, promise.name)
    ]
    contenders = [
        Contender((best.effects[0], second.name), with_effect(larger, second.name), [start])
        for _, start, second in found
    ]
    return judge_each(contenders, scales.problem, scales.workers)


def twins(pair: Judged, scales: Scales) -> list[Judged]:
    """Fit what acts like one of two effects in its place, beside the other; give what isn't objected to, best first.

    By itself the one may have done best while another does so with the second beside it.

    Args:
        pair: the law with the two.
        scales: every effect that was fitted by itself, and the law that they join.
    """
    structure, problem, values = scales.structure, scales.problem, pair.result.law.values
    contenders: list[Contender] = []
    for gone, stays in (pair.effects, pair.effects[::-1]):
        one = pair.result.law.structure.effect(gone)
        alike = [
            each
            for each in scales.candidates
            if act_alike(one, name := each.effects[0])
            and effect_id(name) != effect_id(stays)
            and one.id not in structure.effect(name).special_cases  # a general effect fits as well by itself
        ]
        for twin in alike[:MOST_PURSUED]:
            larger = with_effect(structure, twin.effects[0])
            if fits_beside(larger, stays):
                both, alone = with_effect(larger, stays), twin.result.law.values
                # what is there only where the one scales what the other brings is in neither
                rest = both.equations.neutral_values
                starts = [both.own({**rest, **start}) for start in ({**alone, **values}, {**values, **alone})]
                in_order = most_promising_first(both, problem.coarse, starts)
                contenders.append(Contender((twin.effects[0], stays), both, in_order))
    return ranked(each for each in judge_each(contenders, problem, scales.workers) if not each.objections)


def in_place_of(gone: str, come: Sequence[str], whole: Judged, scales: Scales) -> Contender | None:
    """Give a law with several effects in the place of one; None where they don't all fit into it, or one modifies it.

    Args:
        gone: the effect that goes.
        come: those that take its place.
        whole: the law with it, and what was added with it.
        scales: the law that they join.
    """
    larger = scales.structure
    added = (*(name for name in whole.effects if name != gone), *come)
    for name in added:
        if not fits_beside(larger, name):
            return None
        larger = with_effect(larger, name)
    points = []
    for values in (scales.law.result.law.values, whole.result.law.values):
        stated = larger.own({**whole.result.law.values, **values})
        points += _points_from(stated, larger, scales.problem)
    return Contender(added, larger, [start.values for start in promising_starts(larger, scales.problem, points)])


def _points_from(
    stated: Mapping[str, float], structure: Structure, problem: Problem
) -> list[tuple[Mapping[str, float], Collection[str]]]:
    """Give the points that a law is tried from beside stated values, and the names of those of them that stay."""
    return [(point, kept(point, stated)) for point in starting_points(structure, problem.coarse, stated)]


def _with_modifiers(first: Judged, scales: Scales) -> list[tuple[float, Contender]]:
    """Give the pairs of an effect with those that scale what only it has: none of them can be screened without it.

    Not with one of which these tests show nothing: one over T where T doesn't vary. Each comes with the cost after one
    step from the best of its starts.
    """
    structure, problem, loops = scales.structure, scales.problem, scales.problem.loops
    larger = with_effect(structure, first.effects[0])
    contenders = []
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


def _best_roughly(contenders: Sequence[Contender], scales: Scales) -> list[Contender]:
    """Give those that do best when all are fitted roughly, from where that ended."""
    rough = each_roughly(contenders, scales.problem, scales.workers)
    order = sorted(range(len(rough)), key=lambda place: rough[place].cost)[:MOST_PURSUED]
    return [replace(contenders[place], starts=[rough[place].values]) for place in order]
