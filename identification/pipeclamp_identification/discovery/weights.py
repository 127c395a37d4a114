"""The tests weighed again with the best term so far: the more it takes, the less of its kind hides in the weights.

A search begins with a law that lacks much, and grants it a discrepancy of that size. A term that takes most of it
leaves what is far below that, of which no other form of it could take anything that counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem, judge, weighed_again
from pipeclamp_identification.discovery.columns import Evaluation, weighed_anew
from pipeclamp_identification.discovery.hearing import Hearing, Hurdle, RefittedTerm, refitted_of

WORTH_WEIGHING_SHARE = 0.5
"""Tests are weighed again where the variance that counts as none of the law's falls below this share."""
MOST_WEIGHED = 8
"""Terms, best first, that are fitted again to tests weighed again."""


def weighed_by(
    best: RefittedTerm, near: Sequence[RefittedTerm], hearing: Hearing
) -> tuple[Hearing, list[RefittedTerm]]:
    """Weigh the tests by what the law with a term leaves, and fit what a refined form must better again.

    Args:
        best: the term.
        near: it and others, which are fitted again.
        hearing: what it was asked with.

    Returns:
        what a refined form is asked with, and `near` in the new weights; as they were where the weights hardly change.
    """
    before, old = hearing.evaluation, hearing.evaluation.problem
    problem, law = weighed_again(old, before.law.result.law.structure, best.judged.result, [before.law.result])
    if _granted(problem) > WORTH_WEIGHING_SHARE * _granted(old):
        return hearing, list(near)
    evaluation = Evaluation(problem, law)
    first = sorted(hearing.refitted, key=lambda one: one.squares)[:MOST_WEIGHED]
    every = [*near, *(one for one in first if all(one is not other for other in near))]
    fitted, stopped = (
        [refitted_of(weighed_as(one.judged, problem), one.term, evaluation) for one in group]
        for group in (every, hearing.stopped)
    )
    bar = hearing.bar
    asked = law if not hearing.gone else weighed_as(bar.law, problem)
    heard = Hearing(
        evaluation, weighed_anew(hearing.columns, before, evaluation), [one for each in fitted for one in each],
        Hurdle(asked, [weighed_as(one, problem) for one in bar.listed], bar.unseen, bar.named), hearing.gone,
        [one for each in stopped for one in each],
    )  # fmt: skip
    return heard, [one for each in fitted[: len(near)] for one in each]


def _granted(problem: Problem) -> float:
    """Give the variance, N2, that a law's error in a harmonic may have and count as none: noise and discrepancy."""
    return float(np.median(problem.noise.total_variance())) + problem.discrepancy


def weighed_as(one: Judged, problem: Problem) -> Judged:
    """Give a law in the weights of another problem of the same tests, so that it may be held against others there."""
    return judge(one.effects, one.result.law.structure, [one.result.law.values], problem)
