"""Refine a term: free one more of its numbers, or set a second term beside it, where the tests ask for that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.diagnosis.problem import Contender, judge_each
from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.discovery.columns import Column
from pipeclamp_identification.discovery.freeing import refinements
from pipeclamp_identification.discovery.grammar import Term, linear_symbol
from pipeclamp_identification.discovery.guards import beyond_chance, beyond_the_tests, confirmed, surely_better
from pipeclamp_identification.discovery.hearing import Found, Hearing, Refitted, best_of, refitted_of
from pipeclamp_identification.discovery.joining import SHARE, joined, may_join
from pipeclamp_identification.discovery.search import Screened, screened
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.law.law import with_effect

MOST_REFINED = 3
"""Terms that do as well, best first, of which refined forms are tried: what is missing may be a number of another."""
MOST_JOINED = 10
"""Second terms, best first by what they explain of what the first leaves over, that are fitted beside it."""
CROWDED = ("does no harm beyond", "beyond the catalogue")
"""What a term may fail that is refined all the same: with a part of it missing it foretells badly, and effects of the
catalogue do as well."""


@dataclass(frozen=True)
class Refining:
    """What terms are refined with.

    Attributes:
        varied: what varies over the tests, as the grammar takes it.
        jobs: processes.
        progress: is told what is being done.
    """

    varied: tuple[Sequence[str], Mapping[str, float]]
    jobs: int
    progress: Progress

    def of(self, found: Found, near: Sequence[Refitted], hearing: Hearing) -> Found:
        """Give a term in the form that the tests ask for: as it is, or with more numbers of its own.

        A refined form must better the plain one beyond chance, doubt and what was kept back, as a term must better the
        law, and must pass all that is asked of a term.

        Args:
            found: the term.
            near: it, and what does as well, fitted together with the law.
            hearing: what it was asked with.
        """
        if any(not guard.passed and guard.name not in CROWDED for guard in found.guards):
            return found
        while (further := self._one_more(near, hearing)) is not None:
            found, near, hearing = further
        return found

    def _one_more(self, near: Sequence[Refitted], hearing: Hearing) -> tuple[Found, list[Refitted], Hearing] | None:
        """Give a term with one thing more, and what it was asked with; None where that isn't asked for."""
        plain, problem, fitted = near[0], hearing.evaluation.problem, near[0].judged.fitted
        self.progress(f"refine {plain.term.acts_like}")
        scanned = screened(hearing.columns, fitted.residual, fitted.jacobian, problem.groups)
        shorter = [one for one in hearing.refitted if one.term.declaration.id in plain.term.shorter]
        forms = {term.declaration.id: (term, starts) for term, starts in self._forms(near, shorter, scanned)}
        structure = hearing.evaluation.law.result.law.structure
        contenders = [
            Contender((name,), with_effect(structure.with_declared([term.declaration]), name), starts)
            for name, (term, starts) in forms.items()
        ]
        judged = [one for one in judge_each(contenders, problem, self.jobs, self.progress) if not one.objections]
        tried = [each for one in judged for each in refitted_of(one, forms[one.effects[0]][0], hearing.evaluation)]
        if not tried:
            return None
        best, rivals = best_of(tried)
        if best.squares > plain.squares - RIVAL_LIKELIHOOD or not betters(best, plain, tried, hearing):
            return None
        wider = replace(hearing, refitted=[*hearing.refitted, *tried])
        found = wider.of(best, rivals)
        return (found, [best, *rivals], wider) if found.passed else None

    def _forms(
        self, near: Sequence[Refitted], shorter: Sequence[Refitted], scanned: Screened
    ) -> Iterator[tuple[Term, Sequence[Mapping[str, float]]]]:
        """Give what is fitted in the place of a term, with values to start from."""
        for one in (*near[:MOST_REFINED], *shorter):  # a number freed may be worth more than the scaling
            values = one.judged.result.law.values
            for term, starts in refinements(one.term, values, *self.varied):
                new = term.declaration.parameters[-1].symbol
                yield term, [{**values, new: start} for start in starts]
        plain, values = near[0].term, near[0].judged.result.law.values
        strength = values[linear_symbol(plain.family)]
        seconds = [place for place in np.argsort(-scanned.explained()) if may_join(plain, scanned.columns[place].term)]
        for place in seconds[:MOST_JOINED]:
            column = scanned.columns[place]
            share = scanned.strength(place) / scanned.lengths[place] / abs(strength)
            yield joined(plain, column.term, strength), [{**values, **_of_second(column), SHARE: share}]


def _of_second(column: Column) -> dict[str, float]:
    return {f"{name.removesuffix('_x')}_b_x": value for name, value in column.values.items()}


def betters(best: Refitted, plain: Refitted, tried: Sequence[Refitted], hearing: Hearing) -> bool:
    """Tell whether a refined form passes against the plain one what that must pass against the law.

    Args:
        best: the refined form.
        plain: the plain one.
        tried: all that were fitted in the place of the plain one.
        hearing: what that was asked with.
    """
    problem, fitted = hearing.evaluation.problem, plain.judged.fitted
    every = [*hearing.columns, *(one.column for one in tried)]
    scanned = screened(every, fitted.residual, fitted.jacobian, problem.groups)
    chance = scanned.without(len(hearing.columns) + tried.index(best)).by_chance()
    guards = (
        beyond_chance(plain.squares - best.squares, chance),
        beyond_the_tests(plain.judged, best.judged, problem),
        confirmed(plain.judged.result.law, best.judged.result.law, hearing.bar.unseen, problem),
    )
    return all(guard.passed for guard in guards) and surely_better(best.judged, plain.judged, problem)
