"""Refine a term that passed: each number that its form fixes is freed by itself, and what betters it is asked again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pipeclamp_identification.diagnosis.problem import Contender, judge_each
from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.discovery.columns import Evaluation
from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import Term
from pipeclamp_identification.discovery.guards import beyond_chance, beyond_the_tests, confirmed, surely_better
from pipeclamp_identification.discovery.hearing import Found, Hearing, Refitted, best_of, refitted_of
from pipeclamp_identification.discovery.search import screened
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.law import with_effect

MOST_REFINED = 3
"""Terms that do as well, best first, of which refined forms are tried: what is missing may be a number of another."""


def refined(
    found: Found,
    near: Sequence[Refitted],
    hearing: Hearing,
    varied: tuple[Sequence[str], Mapping[str, float]],
    jobs: int,
    progress: Progress,
) -> Found:
    """Give a term that passed in the form that these tests ask for: as it is, or with more of its numbers free.

    A refined form must better the plain one beyond chance, doubt and what was kept back, as the term had to better the
    law, and must pass all that is asked of a term itself.

    Args:
        found: the term that passed.
        near: it, and what does as well, fitted together with the law.
        hearing: what it was asked with.
        varied: what varies over the tests, as the grammar takes it.
        jobs: processes.
        progress: is told what is being done.
    """
    while (further := _one_more(near, hearing, varied, jobs, progress)) is not None:
        found, near, hearing = further
    return found


def _one_more(
    near: Sequence[Refitted],
    hearing: Hearing,
    varied: tuple[Sequence[str], Mapping[str, float]],
    jobs: int,
    progress: Progress,
) -> tuple[Found, list[Refitted], Hearing] | None:
    """Free one number more; give what it was asked with too; None where that isn't asked for."""
    plain, problem = near[0], hearing.evaluation.problem
    forms = {
        term.declaration.id: (one, term, starts)
        for one in near[:MOST_REFINED]
        for term, starts in refinements(one.term, one.judged.result.law.values, *varied)
    }
    contenders = [_contender(hearing.evaluation, *form) for form in forms.values()]
    judged = [one for one in judge_each(contenders, problem, jobs, progress) if not one.objections]
    tried = [each for one in judged for each in refitted_of(one, forms[one.effects[0]][1], hearing.evaluation)]
    if not tried:
        return None
    best, rivals = best_of(tried)
    if best.squares > plain.squares - RIVAL_LIKELIHOOD or not _betters(best, plain, tried, hearing):
        return None
    wider = replace(hearing, refitted=[*hearing.refitted, *tried])
    found = wider.of(best, rivals)
    return (found, [best, *rivals], wider) if found.passed else None


def _betters(best: Refitted, plain: Refitted, tried: Sequence[Refitted], hearing: Hearing) -> bool:
    """Tell whether a refined form passes against the plain one what the plain one passed against the law."""
    problem, place = hearing.evaluation.problem, tried.index(best)
    fitted = plain.judged.fitted
    scanned = screened([one.column for one in tried], fitted.residual, fitted.jacobian, problem.groups)
    return all(
        guard.passed
        for guard in (
            beyond_chance(plain.squares - best.squares, scanned.without(place).by_chance()),
            beyond_the_tests(plain.judged, best.judged, problem),
            confirmed(plain.judged.result.law, best.judged.result.law, hearing.bar.unseen, problem),
        )
    ) and surely_better(best.judged, plain.judged, problem)


def _contender(evaluation: Evaluation, plain: Refitted, term: Term, starts: Sequence[float]) -> Contender:
    """Give the law with a refined form, to be fitted from where the plain one is."""
    structure = evaluation.law.result.law.structure
    larger = with_effect(structure.with_declared([term.declaration]), term.declaration.id)
    new, values = term.declaration.parameters[-1].symbol, plain.judged.result.law.values
    return Contender((term.declaration.id,), larger, [{**values, new: start} for start in starts])
