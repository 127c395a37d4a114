"""In which laws a term is sought: beside all effects of a law, and in the place of some of them.

Some effects that a ladder added may have stood for a term, and others be real. Those that stood for it needn't be the
last ones: what is needed beside the term comes back, whatever was added after it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from pipeclamp_identification.diagnosis.foretold import share_of_error
from pipeclamp_identification.diagnosis.problem import Contender, Judged, Problem, judge, judge_each
from pipeclamp_identification.diagnosis.thresholds import MATERIAL_PART_SHARE
from pipeclamp_identification.discovery.guards import surely_better
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.law import Structure

MOST_GONE = 4
"""Effects, the last ones of a law, in whose place a term is tried, at most: each number of them is a search more."""


@dataclass(frozen=True)
class Basis:
    """A law that a term is put into.

    Attributes:
        law: fitted.
        gone: effects of the law as it is that this one hasn't got: what they stand for may be a term.
    """

    law: Judged
    gone: tuple[str, ...] = ()


def without_last_effects(law: Judged, problem: Problem) -> Iterator[Basis]:
    """Give the law without the last effect that it was given, without the last two, and so on."""
    structure = law.result.law.structure
    for count in range(1, min(len(structure.effects), MOST_GONE) + 1):
        gone = structure.effects[-count:]
        try:
            judged = fitted_without(structure, gone, law, problem)
        except UserError:  # another effect modifies what only this one has
            continue
        yield Basis(judged, gone)


def with_needed_back(
    term: Judged, gone: Sequence[str], law: Judged, problem: Problem, workers: Workers
) -> Iterator[Basis]:
    """Give the law with those effects back that are needed beside a term in their place: the first, two of them, ...

    An effect is needed that takes a material part of what the law with the term leaves, beyond doubt. A form of the
    term that isn't yet the right one may need one that stands for the rest, so each step is a place of its own.

    Args:
        term: the law with a term in the place of effects.
        gone: these effects.
        law: the law with all of them, without the term.
        problem: the tests.
        workers: who does it, and who is told.
    """
    whole, left = law.result.law.structure, tuple(gone)
    while len(left) > 1:
        workers.tell(f"what of {' and '.join(left)} is needed beside a term")
        back = judge_each(list(_each_back(term, left, law)), problem, workers)
        best = min(back, key=lambda one: one.squares, default=None)
        if best is None or not is_worth_effects(best, term, problem):
            return
        term, left = best, tuple(name for name in left if name != best.effects[0])
        if left == whole.effects[-len(left) :]:  # the law without its last ones: that is asked anyway
            continue
        try:
            yield Basis(fitted_without(whole, left, term, problem), left)
        except UserError:  # an effect that is back modifies what only one has that isn't
            continue


def is_worth_effects(longer: Judged, law: Judged, problem: Problem) -> bool:
    """Tell whether a law takes a material part of what another leaves on left-out conditions, beyond doubt."""
    return share_of_error(longer, law) >= MATERIAL_PART_SHARE and surely_better(longer, law, problem)


def _each_back(term: Judged, gone: Sequence[str], law: Judged) -> Iterator[Contender]:
    """Give the law with a term with each of the effects again that it stands in the place of."""
    structure, values = term.result.law.structure, term.result.law.values
    own, order = structure.effects[-1], law.result.law.structure.effects
    for name in gone:
        effects = tuple(each for each in order if each == name or each in structure.effects)
        larger = replace(structure, effects=(*effects, own))
        try:
            start = larger.own({**law.result.law.values, **values})
        except UserError:  # it modifies what only an effect has that isn't there
            continue
        yield Contender((name,), larger, [start])


def fitted_without(structure: Structure, gone: Sequence[str], near: Judged, problem: Problem) -> Judged:
    """Fit a law without some of its effects.

    Args:
        structure: of the law.
        gone: effects.
        near: a law with what stays, from whose values the fit starts.
        problem: the tests.

    Raises:
        UserError: an effect that stays needs one that doesn't.
    """
    without = replace(structure, effects=tuple(name for name in structure.effects if name not in gone))
    return judge((), without, [without.own(near.result.law.values)], problem)
