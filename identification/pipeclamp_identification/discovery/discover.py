"""Find a term that a law lacks and no catalogue has, or say that there is none that these tests can tell."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.diagnosis.diagnosed import RecordDiagnosed, diagnosed
from pipeclamp_identification.diagnosis.named import WITH, in_vain_on
from pipeclamp_identification.diagnosis.problem import (
    VALLEYS,
    Contender,
    Judged,
    Problem,
    judge,
    judge_each,
    prepare,
    weighed_again,
)
from pipeclamp_identification.diagnosis.thresholds import FEWEST_GROUPS, RIVAL_LIKELIHOOD
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_identification.discovery.bases import (
    Basis,
    is_worth_effects,
    with_needed_back,
    without_last_effects,
)
from pipeclamp_identification.discovery.columns import Evaluation, TermColumn, all_columns, beside_another_law
from pipeclamp_identification.discovery.conditions import FOLLOWED
from pipeclamp_identification.discovery.grammar import Term, linear_symbol, terms
from pipeclamp_identification.discovery.hearing import (
    Hearing,
    Hurdle,
    RefittedTerm,
    RivalTerm,
    TermFound,
    best_of,
    best_of_each,
    refitted_of,
)
from pipeclamp_identification.discovery.listed import EffectFound, effect_instead
from pipeclamp_identification.discovery.refining import MOST_REFINED, Refining
from pipeclamp_identification.discovery.search import WORTH_FITTING, Screened, screened_columns
from pipeclamp_identification.discovery.telling import telling_test
from pipeclamp_identification.discovery.weights import weighed_as
from pipeclamp_identification.fitting.heldout import condition_groups, count_groups
from pipeclamp_identification.loops.loops import Loops, loops_of
from pipeclamp_identification.signals.levels import varies
from pipeclamp_models.base.arrays import BoolArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, law_of, structure_of
from pipeclamp_models.law.law import Structure, with_effect
from pipeclamp_models.realise.sizes import about

MOST_REFITTED = 30
"""Terms that are refitted together with the law, at most."""
KEPT_BACK = 5
"""Of so many groups of A and f one is kept back from the search: of each five the third by what the law errs there."""
MOST_RELATED = 5
"""Terms, best first, of which shorter ones are also fitted, for from few starts longer ones are screened better; and
those that are the same while they are small, of which one alone stands for both where terms are screened."""
MOST_HEARD = 3
"""Terms that are asked, best first, until one passes: each more is one more chance to pass by luck."""
LISTED = 3
"""Effects of the catalogue, best first, that a term must better."""

SEVERAL = 2
"""Effects by which a law that leaves scatter only may owe this to what they stand for together: one is what it is."""

NOTHING_MISSING = "nothing is missing: what the law leaves over is scatter"
NOTHING_BETTER = f"{NOTHING_MISSING}, and no term does better in the place of its effects"


@dataclass(frozen=True)
class TermSearch:
    """What a search came to.

    Attributes:
        diagnosed: the law's diagnosis before it.
        found: the best term, whether it passed or not; None where none was looked at.
        tried: terms that were evaluated.
        reason: why nothing is proposed; empty where something is.
        others: terms that passed in other places, for the best one may not hold on all tests.
        instead: an effect of the catalogue that passes, too, for no term may pass, or hold on all tests; None where
            there is none.
    """

    diagnosed: RecordDiagnosed
    found: TermFound | None
    tried: int
    reason: str = ""
    others: tuple[TermFound, ...] = ()
    instead: EffectFound | None = None

    @property
    def passed(self) -> tuple[TermFound, ...]:
        """Terms that passed, the best first."""
        return (self.found, *self.others) if self.found and self.found.passed else ()


def search(
    file: LawFile,
    campaign: Campaign,
    loops: Loops | None = None,
    *,
    declared: Collection[Declaration] = (),
    workers: Workers,
) -> TermSearch:
    """Search the grammar for a term that a law lacks.

    Of a law that leaves scatter only, a term is sought in the place of several effects, which may stand for one. Where
    one of several effects is missing and the tests can't tell which, a term that betters all of them is what is.

    Args:
        file: the law.
        campaign: the tests.
        loops: `loops_of(campaign)`, where they are known already.
        declared: a user's own effects, which count as the catalogue's.
        workers: who does it, and who is told.

    Raises:
        UserError: the tests can't serve the law, or are too few.
    """
    loops = loops or loops_of(campaign)
    count = count_groups(loops)
    if count < FEWEST_GROUPS:
        raise UserError(
            f"groups of amplitude and frequency: {count}, too few for a new term; expected at least "
            f"{FEWEST_GROUPS}, so that one can be kept back"
        )
    found = diagnosed(file, campaign, loops, declared=declared, workers=workers)
    causes = found.effects if found.kind == "cause" or leaves_scatter_with_one(found) else ()
    if len(causes) == 1:
        return TermSearch(found, None, 0, catalogue_first(causes))
    structure = structure_of(file).with_declared(declared)
    is_adequate = found.diagnosis.is_adequate(found.diagnosis.law)
    leaves_scatter = found.verdict == "complete" and is_adequate
    if leaves_scatter and len(structure.effects) < SEVERAL:
        return TermSearch(found, None, 0, NOTHING_MISSING)
    loops = _by_name(loops)
    kept = kept_back(loops, found.diagnosis)
    problem, law = _weighed(structure, _rows(loops, ~kept), law_of(file).values)
    present = {declaration.id for declaration in structure.declared}
    every = [term for term in terms_asked(problem) if term.declaration.id not in present]
    listed = [
        judge(each.effects, each.result.law.structure, [each.result.law.values], problem)
        for each in to_better(found.diagnosis.candidates, in_vain_on(file, campaign.fingerprint, declared), causes)
    ]
    bar = Hurdle(law, listed, _rows(loops, kept), found.effects)

    evaluation = Evaluation(problem, law)
    columns = all_columns(evaluation, every, workers.tell)

    def asked(basis: Basis) -> TermFound | str:
        other = Evaluation(problem, basis.law)
        beside = beside_another_law(columns, evaluation, other, every, workers.tell)
        return _asked(other, beside, basis.gone, bar, workers)

    own = NOTHING_BETTER if leaves_scatter else _asked(evaluation, columns, (), bar, workers)
    heard = [own] if isinstance(own, TermFound) else []
    heard += in_the_place_of_effects(law, problem, asked, workers)
    if causes and not any(one.passed for one in heard):
        return TermSearch(found, None, len(every), catalogue_first(causes))
    instead = None
    # what is let pass asks for no effect: as form, or where the tests are too few to call the law complete
    if found.verdict == "unknown" and not is_adequate:
        workers.tell("effects of the catalogue in the place of a term")
        instead = effect_instead(found.diagnosis, bar, problem, columns)
    if not heard:
        return TermSearch(found, None, len(every), own if isinstance(own, str) else "", instead=instead)
    heard = weighed_by_the_best(heard, problem)
    best = best_heard(heard, problem)
    result = with_rivals_elsewhere(best, heard, problem.loops)
    failed = next((guard for guard in result.guards if not guard.passed), None)
    others = sorted((one for one in heard if one.passed and one is not best), key=lambda one: one.judged.squares)
    reason = f"{result.term.acts_like}: {failed.words}" if failed else ""
    return TermSearch(found, result, len(every), reason, tuple(others), instead)


def kept_back(loops: Loops, diagnosis: Diagnosis) -> BoolArray:
    """Tell which runs are kept back from the search, shape (R,): of groups on which the law errs much, and little.

    By number they may be those that the law foretells well as it is, which confirm nothing, or the one that shows most
    of what is missing. Which they are, the law tells without any term.

    Args:
        loops: the tests.
        diagnosis: of the law on the same runs, in any order and in parts.
    """
    groups = condition_groups(loops)
    runs, of_run = np.unique(diagnosis.problem.loops.run, return_inverse=True)
    by_run = dict(zip(runs, np.bincount(of_run, weights=diagnosis.law.score.squares), strict=True))
    by_group = np.bincount(groups, weights=[by_run[run] for run in loops.run])
    worst_first = np.argsort(np.argsort(-by_group, kind="stable"))
    return np.asarray(worst_first[groups] % KEPT_BACK == KEPT_BACK // 2)


def leaves_scatter_with_one(found: RecordDiagnosed) -> bool:
    """Tell whether a law leaves scatter only with the one effect that is named: as a part, too, that is enough."""
    named = (one for one in found.diagnosis.candidates if one.effects == found.effects)
    return found.verdict == "missing" and len(found.effects) == 1 and any(map(found.diagnosis.is_adequate, named))


def terms_asked(problem: Problem) -> list[Term]:
    """Give the terms of the grammar that tests may ask: none of speed or time where no time was measured."""
    motion, varied = problem.observations.motion, _varied(problem)
    every = terms(*varied, about(motion), span_K=float(np.ptp(motion.slow["T"])) if "T" in varied[0] else 0.0)
    return [term for term in every if problem.loops.time_measured or not term.effect.is_of_time]


def to_better(candidates: Sequence[Judged], in_vain: Collection[str], causes: Collection[str] = ()) -> Sequence[Judged]:
    """Give the catalogue's best, best first, but for what was added in vain: who gets no term can't add that either.

    Args:
        candidates: of the diagnosis, best first.
        in_vain: effects that were tried on the same tests and didn't lower the error; of two together both names.
        causes: effects of which one is missing, which are all asked.
    """
    asked = [one for one in candidates if WITH.join(one.effects) not in in_vain]
    return [one for place, one in enumerate(asked) if place < LISTED or WITH.join(one.effects) in causes]


def catalogue_first(causes: Sequence[str]) -> str:
    """Say that effects of the catalogue come before a term: the one that is missing, or several that it may be."""
    if len(causes) == 1:
        return f"the catalogue has what is missing: {causes[0]}; `add` it first"
    return (
        f"one of these of the catalogue is missing, and these tests can't tell which: {', '.join(causes)}; a test that "
        "tells comes first, or `add` one of them as a part and search again"
    )


def in_the_place_of_effects(
    law: Judged, problem: Problem, asked: Callable[[Basis], TermFound | str], workers: Workers
) -> list[TermFound]:
    """Give terms that pass in the place of some of a law's effects: of its last ones, and of those that aren't needed.

    Args:
        law: the law.
        problem: the tests.
        asked: searches the grammar for a term in a law.
        workers: who does it, and who is told.
    """

    def found_in(bases: Iterable[Basis]) -> Iterator[TermFound]:
        for basis in bases:
            workers.tell(f"a term in the place of {' and '.join(basis.gone)}")
            found = asked(basis)
            if isinstance(found, TermFound):
                yield found

    found = list(found_in(without_last_effects(law, problem)))
    if found:
        widest = found[-1]
        for one in found_in(with_needed_back(widest.judged, widest.gone, law, problem, workers)):
            found.append(one)
            if one.passed:
                break
    return [one for one in found if one.passed]


def _asked(
    evaluation: Evaluation,
    columns: Sequence[TermColumn],
    gone: tuple[str, ...],
    bar: Hurdle,
    workers: Workers,
) -> TermFound | str:
    """Search the grammar for a term in a law; give the first that passes, else the best, or why none was looked at.

    Args:
        evaluation: the law on the tests.
        columns: of all terms beside it.
        gone: effects in whose place the term stands.
        bar: what it must better.
        workers: who does it, and who is told.
    """
    law = evaluation.law
    workers.tell("what chance would explain")
    scanned = screened_columns(columns, law.fitted.residual, law.fitted.jacobian, evaluation.problem.groups)
    chance, explained = scanned.by_chance(WORTH_FITTING), scanned.explained()
    places = [place for place in scanned.best_first(MOST_REFITTED) if explained[place] > chance]
    if not places:
        return "no term of the grammar explains more than the best of them by an even chance"
    refitted, stopped = _refitted(evaluation, scanned, places, workers)
    if not refitted:
        return "no term of the grammar could be fitted together with the law"
    workers.tell("ask the conditions that were kept back")
    hearing = Hearing(evaluation, columns, refitted, bar, gone, stopped=stopped[:MOST_REFINED])
    # what does nothing at its fitted values has only let the law itself be fitted better
    left = [one for one, own in zip(refitted, hearing.explained, strict=True) if own > chance] or refitted
    # of each term the start that was screened best
    place_of = {columns[place].term.declaration.id: int(place) for place in np.argsort(explained)}
    refining = Refining(_varied(evaluation.problem), workers)
    heard: list[TermFound] = []
    while left and len(heard) < (1 if gone else MOST_HEARD) and not (heard and heard[-1].passed):
        best, rivals = best_of(left, evaluation.problem)
        found = hearing.of(best, rivals)
        heard.append(found if heard and not found.passed else refining.of(found, best, hearing))
        # asked before they are fitted, for then all act much the same
        alike = scanned.alike(place_of[best.term.declaration.id])
        left = left_to_hear(left, best, [bool(alike[place_of[one.term.declaration.id]]) for one in left])
    return heard[-1] if heard[-1].passed else heard[0]


def _refitted(
    evaluation: Evaluation, scanned: Screened, places: Sequence[int], workers: Workers
) -> tuple[list[RefittedTerm], list[RefittedTerm]]:
    """Fit terms together with the law, and what is related to the best of them.

    Args:
        evaluation: the law on the tests.
        scanned: the terms' columns.
        places: of the columns that are fitted.
        workers: who does it, and who is told.

    Returns:
        of each term the best fit that nothing speaks against; and the best of the others.
    """
    law = evaluation.law
    known = {column.term.declaration.id: column.term for column in scanned.columns}

    def together(contenders: Sequence[Contender]) -> list[RefittedTerm]:
        judged = judge_each(contenders, evaluation.problem, workers)
        return [each for one in judged for each in refitted_of(one, known[one.effects[0]], evaluation)]

    # a term may fit best in another valley than the one that its best start lies in
    fitted = together([_contender(law, scanned, start) for place in places for start in scanned.starts(place, VALLEYS)])
    standing, stopped = (best_of_each(one for one in fitted if one.stands == stands) for stands in (True, False))
    standing += [one for one in together(_related(law, standing, known)) if one.stands]
    return standing, stopped


def left_to_hear(left: Sequence[RefittedTerm], failed: RefittedTerm, alike: Sequence[bool]) -> list[RefittedTerm]:
    """Give the terms that may be asked after one failed: what acts as it does would fail too, or pass by luck.

    So would what only scales or places it: had that been needed, the longer term would have been asked first.

    Args:
        left: terms that weren't asked yet, and the one that failed.
        failed: that one.
        alike: which of them act as it does.
    """
    name = failed.term.declaration.id
    return [
        one
        for one, same in zip(left, alike, strict=True)
        if one is not failed and not same and name not in one.term.shorter
    ]


def weighed_by_the_best(heard: Sequence[TermFound], problem: Problem) -> list[TermFound]:
    """Give terms that passed in different places in the weights of the best of them, in which they are held together.

    In those of the law without them, which lacks much, all that take most of it would be equals.
    """
    passed = [one for one in heard if one.passed]
    if len(passed) < 2:
        return list(heard)
    best = min(passed, key=lambda one: one.judged.squares).judged.result
    weighed, _ = weighed_again(problem, best.law.structure, best, [best])
    return [replace(one, judged=weighed_as(one.judged, weighed)) for one in heard]


def best_heard(heard: Sequence[TermFound], problem: Problem) -> TermFound:
    """Give what foretells best of terms beside a law's effects and in their place; of equals that of the shortest law.

    What the law as it is has beside a term, and a term in the place of it does without, must be needed as an effect
    must that comes back: it may share with the term what is missing, and leave of its form what nobody would know
    again. Numbers of a term's own needn't be: in the place of as many effects, or more, the likelier term stands.
    The first is the law's own, which counts only where it passed or no other did.

    Args:
        heard: terms that were asked, in one problem's weights.
        problem: the tests.
    """
    passed = [one for one in heard if one.passed] or heard
    best = min(passed, key=lambda one: one.judged.squares)
    near = [one for one in passed if not is_worth_effects(best.judged, one.judged, problem)]
    shortest = min(near, key=lambda one: (len(one.judged.result.law.values), one.judged.squares))
    most = shortest.judged.akaike - RIVAL_LIKELIHOOD
    likelier = [one for one in near if len(one.gone) >= len(shortest.gone) and one.judged.akaike <= most]
    return min(likelier, key=lambda one: one.judged.akaike, default=shortest)


def with_rivals_elsewhere(best: TermFound, heard: Sequence[TermFound], loops: Loops) -> TermFound:
    """Name among a term's rivals what does as well in another place, and the test that tells the two laws apart.

    Args:
        best: the term.
        heard: it, and terms that passed beside a law's effects or in their place.
        loops: the tests.
    """
    others = [
        one for one in heard
        if one is not best and one.passed and one.judged.squares <= best.judged.squares + RIVAL_LIKELIHOOD
    ]  # fmt: skip
    if not others:
        return best
    rivals = tuple(
        RivalTerm(
            one.term, f"in the place of {' and '.join(one.gone)}" if one.gone else "beside all effects of the law"
        )
        for one in others
    )
    telling = best.next_test or telling_test(best.judged.result.law, others[0].judged.result.law, loops)
    return replace(best, rivals=(*best.rivals, *rivals), next_test=telling)


def _by_name(loops: Loops) -> Loops:
    """Give the runs in the order of their names: what is drawn for each then doesn't hang on where it stands."""
    return replace(loops, rows=tuple(sorted(loops.rows, key=lambda row: row.run)))


def _rows(loops: Loops, chosen: BoolArray) -> Loops:
    return replace(loops, rows=tuple(row for row, one in zip(loops.rows, chosen, strict=True) if one))


def _weighed(structure: Structure, loops: Loops, start: Mapping[str, float]) -> tuple[Problem, Judged]:
    """Fit the law to tests, weighed by noise and by what it leaves over."""
    problem, in_newtons = prepare(structure, loops, start)
    law = judge((), structure, [in_newtons.law.values], problem)
    return weighed_again(problem, structure, in_newtons, [in_newtons, law.result])


def _varied(problem: Problem) -> tuple[Sequence[str], Mapping[str, float]]:
    """Give what varies over the tests: of A, f, T and N, and further columns with their largest magnitude."""
    slow = problem.observations.motion.slow
    names = [name for name in FOLLOWED if name in slow and varies(name, slow[name])]
    conditions = {
        name: float(np.max(np.abs(values)))
        for name, values in problem.loops.conditions.items()
        if np.all(np.isfinite(values)) and np.ptp(values) > 0
    }
    return names, conditions


def _contender(law: Judged, scanned: Screened, place: int) -> Contender:
    column = scanned.columns[place]
    term = column.term
    larger = with_effect(law.result.law.structure.with_declared([term.declaration]), term.declaration.id)
    symbol = linear_symbol(term.family)
    start = {**law.result.law.values, **column.values, symbol: scanned.strength(place) / scanned.lengths[place]}
    return Contender((term.declaration.id,), larger, [start])


def _related(law: Judged, refitted: Sequence[RefittedTerm], known: Mapping[str, Term]) -> list[Contender]:
    """Give the best terms without their scaling or place, and as they may have grown, where that wasn't fitted yet."""
    best = sorted(refitted, key=lambda one: one.squares)[:MOST_RELATED]
    fitted = {one.term.declaration.id for one in refitted}
    starts = {
        name: one.judged.result.law.values for one in reversed(best) for name in (*one.term.shorter, *one.term.grown)
    }
    structure = law.result.law.structure
    contenders = []
    for name in sorted(set(starts) & set(known) - fitted):
        larger = with_effect(structure.with_declared([known[name].declaration]), name)
        contenders.append(Contender((name,), larger, [larger.own(starts[name])]))
    return contenders
