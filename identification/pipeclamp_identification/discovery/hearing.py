"""Terms that were fitted together with a law, and what is asked of the best of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import RIVAL_DRAWS_SHARE, RIVAL_LIKELIHOOD
from pipeclamp_identification.discovery.bases import fitted_without
from pipeclamp_identification.discovery.columns import Evaluation, TermColumn
from pipeclamp_identification.discovery.grammar import Term, linear_symbol
from pipeclamp_identification.discovery.guards import (
    Guard,
    as_well_in_draws,
    beyond_chance,
    beyond_the_tests,
    changes_untested,
    comes_back,
    confirmed,
    not_in_the_catalogue,
    surely_better,
    worse_between_levels_words,
)
from pipeclamp_identification.discovery.search import ALIKE_CORRELATION, Screened, screened_columns
from pipeclamp_identification.discovery.telling import telling_test
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.declaration import Declaration


@dataclass(frozen=True)
class RivalTerm:
    """A term that does as well as another.

    Attributes:
        term: the term.
        place: where it stands, in words, if not where the other one does; else empty.
    """

    term: Term
    place: str = ""

    @property
    def declaration(self) -> Declaration:
        """The term's."""
        return self.term.declaration

    @property
    def acts_like(self) -> str:
        """What it does, and where it stands."""
        return f"{self.term.acts_like}, {self.place}" if self.place else self.term.acts_like


@dataclass(frozen=True)
class TermFound:
    """A term that passed, or the one that came nearest.

    Attributes:
        term: the term.
        judged: the law with it, fitted to the tests that the search saw.
        law: the law without it, likewise.
        rivals: other terms that do as well, best first.
        next_test: the sine on which the term and its first rival differ most, in words; empty where there is none.
        guards: what was asked of it.
        gone: effects of the law in whose place it stands.
        caution: what isn't to be trusted of it, in words; empty where nothing is said against it.
    """

    term: Term
    judged: Judged
    law: Judged
    rivals: tuple[RivalTerm, ...]
    next_test: str
    guards: tuple[Guard, ...]
    gone: tuple[str, ...] = ()
    caution: str = ""

    @property
    def passed(self) -> bool:
        """Whether it may be proposed."""
        return all(guard.passed for guard in self.guards)


@dataclass(frozen=True)
class Hurdle:
    """What a term must better.

    Attributes:
        law: the law as it is.
        listed: the catalogue's best effects in it, on the same tests.
        unseen: the tests that were kept back.
        named: effects that the law's diagnosis names.
    """

    law: Judged
    listed: Sequence[Judged]
    unseen: Loops
    named: Sequence[str]


@dataclass(frozen=True, eq=False)
class RefittedTerm:
    """A term and the law with it, fitted together.

    Attributes:
        judged: the law with it.
        term: the term.
        column: the term at its fitted values.
    """

    judged: Judged
    term: Term
    column: TermColumn

    @property
    def squares(self) -> float:
        """Sum of squared whitened residuals on left-out groups."""
        return self.judged.squares

    @property
    def stands(self) -> bool:
        """Whether nothing speaks against it as it is fitted."""
        return not self.judged.objections

    @property
    def parameters(self) -> int:
        """How many parameters the term has."""
        return len(self.term.declaration.parameters)


def screened_beside(one: RefittedTerm, groups: IntArray, others: Sequence[TermColumn] = ()) -> Screened:
    """Screen other columns, and a refitted term as the last, on what the law that was fitted with it leaves without it.

    That law's parameters may lie far from where the law alone has them, and so do its tangents: of the law alone they
    may leave next to nothing of a term that takes half of the squares.

    Args:
        one: the term.
        groups: of each run, shape (R,).
        others: what is screened too.
    """
    result, fitted = one.judged.result, one.judged.fitted
    own = {table.symbol for table in one.term.declaration.parameters}
    tangents = [place for place, name in enumerate(result.fitted) if name not in own]
    tangents += range(len(result.fitted), fitted.jacobian.shape[2])  # factors of groups
    linear = linear_symbol(one.term.family)
    change = np.zeros_like(fitted.residual)
    if linear in result.fitted:
        change = -fitted.jacobian[:, :, result.fitted.index(linear)]
    residual = fitted.residual + result.law.values[linear] * change
    columns = [*others, replace(one.column, change=change)]
    return screened_columns(columns, residual, fitted.jacobian[:, :, tangents], groups)


@dataclass(frozen=True)
class Hearing:
    """What terms are asked with.

    Attributes:
        evaluation: the law that the terms are put into, on the tests that the search saw.
        columns: all that was screened.
        refitted: the terms that were fitted together with the law.
        bar: what they must better.
        gone: the effects in whose place they stand.
        stopped: terms against which a bound speaks that they ran into, which a refined form may not.
    """

    evaluation: Evaluation
    columns: Sequence[TermColumn]
    refitted: Sequence[RefittedTerm]
    bar: Hurdle
    gone: tuple[str, ...] = ()
    stopped: Sequence[RefittedTerm] = ()

    @cached_property
    def screened(self) -> Screened:
        """All that was screened, and after it each refitted term at its fitted values."""
        law, problem = self.evaluation.law, self.evaluation.problem
        return screened_columns(self._every, law.fitted.residual, law.fitted.jacobian, problem.groups)

    @property
    def _every(self) -> list[TermColumn]:
        return [*self.columns, *(one.column for one in self.refitted)]

    def by_chance(self, place: int) -> float:
        """Give what the best of all terms explains by chance of what one of the refitted leaves.

        What the term itself explains is no noise: turned, it would be explained by chance, the more the larger it is.
        """
        return (
            screened_beside(self.refitted[place], self.evaluation.problem.groups, self._every).without(-1).by_chance()
        )

    @cached_property
    def explained(self) -> Array:
        """The squares that each refitted term explains, the law's parameters being where they are fitted beside it.

        No more than the law gains by it: what it does in the place of the law's own parameters, these do without it.
        """
        groups, without = self.evaluation.problem.groups, self.evaluation.law.squares
        beside = [float(screened_beside(one, groups).explained()[-1]) for one in self.refitted]
        return np.array([min(own, without - one.squares) for own, one in zip(beside, self.refitted, strict=True)])

    def alike(self, place: int, least: float = ALIKE_CORRELATION) -> BoolArray:
        """Tell which of the refitted terms are one of them, act as it does at their fitted values, or add to it."""
        alike = self.screened.alike(len(self.columns) + place, least)[len(self.columns) :]
        alike[place] = True
        name = self.refitted[place].term.declaration.id
        return np.asarray(alike | [name in one.term.shorter for one in self.refitted])

    def returning(self, place: int) -> BoolArray:
        """Tell which of the refitted terms stand for one of them where conditions are drawn again.

        Those that act as it does, and those with which the law comes to the same: beside parts that stand for much of
        what is missing, what is left of two terms beyond the law's tangents may differ, and what they make of it not.
        """
        before = self.evaluation.law.fitted.residual
        changes = np.stack([(before - one.judged.fitted.residual).ravel() for one in self.refitted])
        lengths = np.linalg.norm(changes, axis=1)
        same = changes @ changes[place] > ALIKE_CORRELATION * lengths * lengths[place]
        return np.asarray(self.alike(place) | same)

    def rivals_of(self, best: RefittedTerm, near: Sequence[RefittedTerm]) -> list[RefittedTerm]:
        """Give what rivals a term: what does as well, and what does as well as the best in a share of draws.

        Where errors on left-out conditions scatter, one draw of them tells no form for sure. What only adds to another
        of them is no rival.

        Args:
            best: the term.
            near: what does as well, best first.
        """
        shares = np.mean(as_well_in_draws([one.judged for one in self.refitted], self.evaluation.problem.groups), 0)
        kept = [best, *near]
        for place in np.argsort([one.parameters for one in self.refitted], kind="stable"):
            one = self.refitted[place]
            adds = any(other.term.declaration.id in (one.term.declaration.id, *one.term.shorter) for other in kept)
            if shares[place] >= RIVAL_DRAWS_SHARE and not adds:
                kept.append(one)
        return kept[1:]

    @cached_property
    def catalogue(self) -> list[Judged]:
        """The catalogue's best effects in the law that the terms are put into, where they win ties."""
        if not self.gone:
            return list(self.bar.listed)
        found = []
        for one in self.bar.listed:
            try:
                judged = fitted_without(one.result.law.structure, self.gone, one, self.evaluation.problem)
            except UserError:  # it modifies what only an effect has that is gone
                continue
            found.append(replace(judged, effects=one.effects))
        return found

    def of(self, best: RefittedTerm, rivals: Sequence[RefittedTerm]) -> TermFound:
        """Ask a term, at its fitted values, among all the others."""
        law, problem = self.bar.law, self.evaluation.problem
        found, place = best.judged, self.refitted.index(best)
        replaced, by_chance = [replace(law, effects=self.gone)] if self.gone else [], self.by_chance(place)
        guards = (
            beyond_chance(float(self.explained[place]), by_chance),
            comes_back([one.judged for one in self.refitted], self.returning(place), problem.groups),
            beyond_the_tests(law, found, problem),
            confirmed(law.result.law, found.result.law, self.bar.unseen, problem),
            not_in_the_catalogue(
                found, [*replaced, *self.catalogue], problem, named=self.bar.named, own=bool(replaced),
                longer=self.bar.listed if self.gone else (), by_chance=by_chance,
            ),
        )  # fmt: skip
        rivals = self.rivals_of(best, rivals)
        telling = telling_test(found.result.law, rivals[0].judged.result.law, problem.loops) if rivals else ""
        cautions = (
            worse_between_levels_words(law, found, problem),
            changes_untested(best.term, found.result.law, problem),
        )
        caution = "; ".join(filter(None, cautions))
        return TermFound(
            best.term, found, law, tuple(RivalTerm(one.term) for one in rivals), telling, guards, self.gone, caution
        )


def best_of(refitted: Sequence[RefittedTerm], problem: Problem) -> tuple[RefittedTerm, list[RefittedTerm]]:
    """Give the term that is likeliest of those that foretell as well, of equals that of fewest parameters; the others.

    Which term foretells best, left-out conditions tell by draws only: one of them that the rest hardly determine may
    decide between two forms. The fit to all of them leaves far less to chance. What has more parameters is a rival too,
    where it isn't one of them with something added.

    Args:
        refitted: terms that were fitted together with a law.
        problem: the tests.
    """
    first = min(refitted, key=lambda one: one.squares)
    as_well = [one for one in refitted if one is first or not surely_better(first.judged, one.judged, problem)]
    least = min(one.judged.akaike for one in as_well)
    near = [one for one in as_well if one.judged.akaike <= least + RIVAL_LIKELIHOOD]
    best, *longer = sorted(near, key=lambda one: (one.parameters, one.judged.akaike))
    kept = [best]
    for one in longer:  # what only adds to one of them is no rival
        if not any(other.term.declaration.id in one.term.shorter for other in kept):
            kept.append(one)
    return best, sorted(kept[1:], key=lambda one: one.squares)


def worth_their_length(terms: Sequence[RefittedTerm], problem: Problem) -> list[RefittedTerm]:
    """Leave out terms that only add to another of them, and foretell no better for it beyond doubt."""

    def adds(one: RefittedTerm, other: RefittedTerm) -> bool:
        return other.term.declaration.id in one.term.shorter and not surely_better(one.judged, other.judged, problem)

    return [one for one in terms if not any(adds(one, other) for other in terms)]


def best_of_each(refitted: Iterable[RefittedTerm]) -> list[RefittedTerm]:
    """Give of each term, which may be fitted from several starts, the fit that foretells best; the best term first."""
    found: dict[str, RefittedTerm] = {}
    for one in sorted(refitted, key=lambda one: one.squares):
        found.setdefault(one.term.declaration.id, one)
    return list(found.values())


def refitted_of(judged: Judged, term: Term, evaluation: Evaluation) -> list[RefittedTerm]:
    """Give a term that was fitted together with the law; none where it does nothing at its fitted values."""
    return [RefittedTerm(judged, term, column) for column in evaluation.columns_at(term, [judged.result.law.values])]
