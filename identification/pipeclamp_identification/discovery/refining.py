"""Refine a term: free one more of its numbers, or set a second term beside it, where the tests ask for that."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from pipeclamp_identification.diagnosis.foretold import share_of_error
from pipeclamp_identification.diagnosis.problem import Contender, judge_each
from pipeclamp_identification.diagnosis.thresholds import MATERIAL_PART_SHARE, RIVAL_LIKELIHOOD, UNEXPLAINED_SHARE
from pipeclamp_identification.discovery.columns import Evaluation, TermColumn
from pipeclamp_identification.discovery.following import followed_otherwise
from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import MOST_PARAMETERS, Term, linear_symbol
from pipeclamp_identification.discovery.guards import beyond_chance, beyond_the_tests, surely_better, surely_worse
from pipeclamp_identification.discovery.hearing import (
    Hearing,
    RefittedTerm,
    TermFound,
    best_of,
    best_of_each,
    refitted_of,
    worth_their_length,
)
from pipeclamp_identification.discovery.joining import SHARE, joined, may_join
from pipeclamp_identification.discovery.search import SAME_CORRELATION, screened_columns
from pipeclamp_identification.discovery.shapes import RATE
from pipeclamp_identification.discovery.weights import weighed_as, weighed_by
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.law import Structure, with_effect
from pipeclamp_models.realise.sizes import number_of

MOST_REFINED = 3
"""Terms, best first, of which refined forms are tried: what is missing may be a number of one that does worse."""
MOST_ASKED = 3
"""Refined forms, best first, that are asked until one passes."""
MOST_JOINED = 6
"""Second terms, best first by what they explain of what the first leaves over, that are fitted beside it."""
GUARDS_IN_PLACE = ("more than chance",)
"""What a term must pass to be refined in the place of a law's effects: a part of it needn't be better than they are,
nor come back, for of forms that all lack something each does best in some draws."""
GUARDS_BESIDE = (*GUARDS_IN_PLACE, "confirmed")
"""And beside all of them: with a part of it missing it may foretell the edges badly, and effects may do as well."""

Form: TypeAlias = tuple[Term, Sequence[Mapping[str, float]]]
"""What is fitted in the place of a term, with values to start from."""


@dataclass(frozen=True)
class Refining:
    """What terms are refined with.

    Attributes:
        varied: what varies over the tests, as the grammar takes it.
        workers: who does it, and who is told.
    """

    varied: tuple[Sequence[str], Mapping[str, float]]
    workers: Workers

    def of(self, found: TermFound, best: RefittedTerm, hearing: Hearing) -> TermFound:
        """Give a term in the form that the tests ask for: as it is, or with more numbers of its own.

        A refined form must better the plain one beyond chance and doubt, as a term must better the law, foretell no
        worse what was kept back and what lies beyond, and pass all that is asked of a term. On the way it needn't: with
        one thing missing still, a form may fail where the next one passes.

        Args:
            found: the term.
            best: the same, fitted together with the law.
            hearing: what it was asked with.
        """
        if not _may_be_refined(found):
            return found
        plain, asked = found, hearing
        while (further := self._one_more(best, hearing)) is not None:
            form, best, hearing = further
            found = form if form.passed else found
        if found is plain:
            return plain
        return replace(found, judged=weighed_as(found.judged, asked.evaluation.problem), law=asked.bar.law)

    def _one_more(self, best: RefittedTerm, hearing: Hearing) -> tuple[TermFound, RefittedTerm, Hearing] | None:
        """Give a term with one thing more, and what it was asked with; None where that isn't asked for.

        The best that passes all, else the best that may be refined further.
        """
        self.workers.tell(f"refine {best.term.acts_like}")
        shorter = [one for one in hearing.refitted if one.term.declaration.id in best.term.shorter]
        hearing, again = weighed_by(best, [best, *shorter], hearing)
        plain, problem = next((one for one in again if one.term is best.term), None), hearing.evaluation.problem
        if plain is None:
            return None
        shorter = [one for one in again if one is not plain]
        # what is new may be worth more than what a longer term has beyond a shorter one
        others = [one for one in (*hearing.refitted, *hearing.stopped) if one is not plain]
        others.sort(key=lambda one: one.squares)
        roomy = [one for one in (plain, *others) if one.parameters < MOST_PARAMETERS]
        forms = [form for one in (*roomy[:MOST_REFINED], *shorter) for form in self._freed(one)]
        needed = worth_their_length([plain, *others], problem)
        otherwise = (list(self._following(one, hearing.evaluation)) for one in needed)
        forms += itertools.chain(*itertools.islice(filter(None, otherwise), MOST_REFINED))
        forms += [form for one in (plain, *shorter) for form in _beside(one, hearing)]
        structure = hearing.evaluation.law.result.law.structure
        present = {one.id for one in structure.declared}  # of an earlier search: the law has it, or had it
        forms = [form for form in forms if form[0].declaration.id not in present]
        contenders = [_contender(structure, form) for form in forms]
        judged = judge_each(contenders, problem, self.workers)
        fitted = [
            each
            for one, (term, _) in zip(judged, forms, strict=True)
            for each in refitted_of(one, term, hearing.evaluation)
        ]
        tried = best_of_each(one for one in fitted if one.stands)
        wider = replace(hearing, refitted=[*hearing.refitted, *tried])
        on_the_way = None
        for best, rivals in best_first(tried, plain, wider):
            material = share_of_error(best.judged, plain.judged) >= MATERIAL_PART_SHARE
            if not material or not betters(best, plain, tried, hearing):
                continue
            found = wider.of(best, rivals)
            if found.passed:
                return found, best, wider
            if on_the_way is None and _may_be_refined(found) and _comes_near(best, hearing):
                on_the_way = found, best, wider
        return on_the_way

    def _freed(self, one: RefittedTerm) -> Iterator[Form]:
        """Give a term with each of its numbers freed, and values to start from."""
        values = one.judged.result.law.values
        for term, starts in refinements(one.term, values, *self.varied):
            new = term.declaration.parameters[-1].symbol
            yield term, [{**values, new: start} for start in starts]

    def _following(self, one: RefittedTerm, evaluation: Evaluation) -> Iterator[Form]:
        """Give a scaled term in each other form in which it may follow its condition, and values to start from."""
        values = one.judged.result.law.values
        for term in followed_otherwise(one.term, *self.varied):
            kept = {each.symbol for each in one.term.declaration.parameters} - {RATE}
            new = [each for each in term.effect.parameters if each.name not in kept]
            starts = zip(*(each.starts for each in new), strict=True)
            yield (
                term,
                [
                    {
                        **values,
                        **{each.name: number_of(at, evaluation.sizes) for each, at in zip(new, own, strict=True)},
                    }
                    for own in starts
                ],
            )


def _may_be_refined(found: TermFound) -> bool:
    """Tell whether a term passes what it must to be refined: with a part missing it may fail what it must later."""
    needed = GUARDS_IN_PLACE if found.gone else GUARDS_BESIDE
    return all(guard.passed for guard in found.guards if guard.name in needed)


def _comes_near(form: RefittedTerm, hearing: Hearing) -> bool:
    """Tell whether a term in the place of effects explains what they do, by and large: else a number more won't do."""
    if not hearing.gone:
        return True
    having, lacking = hearing.bar.law.squares, hearing.evaluation.law.squares
    return form.squares - having <= UNEXPLAINED_SHARE**2 * (lacking - having)


def best_first(
    tried: Sequence[RefittedTerm], plain: RefittedTerm, hearing: Hearing
) -> Iterator[tuple[RefittedTerm, Sequence[RefittedTerm]]]:
    """Give refined forms that better the plain one, and what rivals each: the best, and the next where it fails.

    The best may owe what it gains to numbers of the law that hardly anything determines, and the next be the right one.
    Those that act the same are given once.

    Args:
        tried: refined forms.
        plain: the term as it is.
        hearing: what they are asked with, they among its terms.
    """
    left = [one for one in tried if one.squares <= plain.squares - RIVAL_LIKELIHOOD]
    for _ in range(MOST_ASKED):
        if not left:
            return
        best, rivals = best_of(left, hearing.evaluation.problem)
        yield best, rivals
        same = hearing.alike(hearing.refitted.index(best), SAME_CORRELATION)
        gone = [one for one, each in zip(hearing.refitted, same, strict=True) if each]
        left = [one for one in left if not any(one is other for other in gone)]


def _contender(structure: Structure, form: Form) -> Contender:
    term, starts = form
    name = term.declaration.id
    return Contender((name,), with_effect(structure.with_declared([term.declaration]), name), starts)


def _beside(one: RefittedTerm, hearing: Hearing) -> Iterator[Form]:
    """Give a term with each of the second terms that explain most of what it leaves over, and values to start from."""
    fitted, values = one.judged.fitted, one.judged.result.law.values
    strength = values[linear_symbol(one.term.family)]
    columns = [column for column in hearing.columns if may_join(one.term, column.term)]
    if not columns or strength == 0.0:
        return
    scanned = screened_columns(columns, fitted.residual, fitted.jacobian, hearing.evaluation.problem.groups)
    for place in scanned.best_first(MOST_JOINED):
        column = columns[place]
        share = scanned.strength(place) / scanned.lengths[place] / abs(strength)
        yield joined(one.term, column.term, strength), [{**values, **_of_second(column), SHARE: share}]


def _of_second(column: TermColumn) -> dict[str, float]:
    return {f"{name.removesuffix('_x')}_b_x": value for name, value in column.values.items()}


def betters(best: RefittedTerm, plain: RefittedTerm, tried: Sequence[RefittedTerm], hearing: Hearing) -> bool:
    """Tell whether a refined form passes against the plain one what that must pass against the law, or does no harm.

    Args:
        best: the refined form.
        plain: the plain one.
        tried: all that were fitted in the place of the plain one.
        hearing: what that was asked with.
    """
    problem, fitted = hearing.evaluation.problem, plain.judged.fitted
    every = [*hearing.columns, *(one.column for one in tried)]
    scanned = screened_columns(every, fitted.residual, fitted.jacobian, problem.groups)
    chance = scanned.without(len(hearing.columns) + tried.index(best)).by_chance()
    laws = plain.judged.result.law, best.judged.result.law
    return (
        beyond_chance(plain.squares - best.squares, chance).passed
        and surely_better(best.judged, plain.judged, problem)
        and beyond_the_tests(plain.judged, best.judged, problem).passed
        and not surely_worse(*laws, hearing.bar.unseen, problem)
    )
