"""Laws with effects more, fitted to metrics: one by one, in pairs, and the richest that the metrics support."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.metrics_only.campaign import SCATTER_BEFOREHAND, MetricCampaign
from pipeclamp_identification.metrics_only.evidence import (
    EXPECTED_FREEDOMS,
    MetricJudged,
    Scatter,
    by_rank,
    chance,
    chance_of_lack,
    judge_metrics,
    judged_fit,
)
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.pairs import metric_pairs
from pipeclamp_identification.metrics_only.screen import Look, look
from pipeclamp_identification.metrics_only.thresholds import FEWEST_FREEDOMS, REAL_CHANCE
from pipeclamp_identification.metrics_only.valleys import (
    CANDIDATE_TOLERANCE,
    ROUGH_TOLERANCE,
    fit_from_each,
    fit_to_metrics,
)
from pipeclamp_identification.metrics_only.weighing import outdoes_in_fit
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.law import Structure, with_effect

ON_THE_WAY = 4
"""Of the effects that promise most, so many that don't imitate each other are fitted for each further step to the
richest law."""
MOST_ADDED = 3
"""Effects that are added on the way to the richest law, at most."""
EXPECTED = Scatter(np.full(2, SCATTER_BEFOREHAND), np.full(2, EXPECTED_FREEDOMS))
"""Scatter as it is expected before the metrics tell it."""


@dataclass(frozen=True)
class Candidates:
    """Laws that were fitted, and weighed by the scatter that was expected.

    Attributes:
        law: as it is, refitted.
        looks: at every effect, fitted or hidden.
        alone: the law with one effect more each.
        together: with an effect and one that scales what only that brings.
        richest: with all that the metrics support.
    """

    law: MetricJudged
    looks: tuple[Look, ...]
    alone: tuple[MetricJudged, ...]
    together: tuple[MetricJudged, ...]
    richest: MetricJudged


def candidates_of(
    structure: Structure,
    campaign: MetricCampaign,
    observations: MetricObservations,
    smooth: Array,
    workers: Workers,
) -> Candidates:
    """Fit a law as it is, with each effect that could be missing, and with all that the metrics support.

    Args:
        structure: the law's structure.
        campaign: the tests.
        observations: their R metrics, in units of the scatter that was expected.
        smooth: the functions of the conditions that count as smooth, shape (R, q).
        workers: who does it, and who is told.

    Raises:
        UserError: there are too few metrics for the law's parameters.
    """
    lacks = partial(_lacks, observations=observations, smooth=smooth)
    workers.tell("law as it is")
    law = judged_fit((), fit_to_metrics(structure, observations, {}, CANDIDATE_TOLERANCE), observations)
    refinements = [effect.refinement for effect in structure.all_effects() if effect.refinement]
    unseen = {refinement.name for refinement in refinements if not refinement.seen_in_metrics}
    known = candidate_names(structure, campaign.condition_columns, time_measured=campaign.time_measured)
    names = [name for name in known if name not in unseen]
    looks = _looks(law, names, observations, workers)
    thoroughly = lacks(law)
    alone = _with_each(law, [one for one in looks if not one.hidden], observations, workers, thoroughly=thoroughly)
    best = min((judged for judged in alone if judged.may_be_cause), key=by_rank, default=law)
    together = metric_pairs(law, alone, campaign, observations, workers) if lacks(best) else []
    law = _from_another_valley(law, [*alone, *together], observations) if thoroughly else law
    richest = _richest(law, alone, together, names, observations, lacks, workers)
    return Candidates(law, tuple(looks), tuple(alone), tuple(together), richest)


def unlike(effects: Iterable[Effect]) -> list[str]:
    """Give the names of effects, in order, that imitate none before: what makes one gain makes its imitators gain."""
    chosen: list[Effect] = []
    for effect in effects:
        if not any(effect.id in other.imitated_by or other.id in effect.imitated_by for other in chosen):
            chosen.append(effect)
    return [effect.name for effect in chosen]


def _lacks(judged: MetricJudged, observations: MetricObservations, smooth: Array) -> bool:
    """Tell whether a law leaves more than the scatter that was expected."""
    return chance_of_lack(judged, observations, smooth, SCATTER_BEFOREHAND) < REAL_CHANCE


def _from_another_valley(
    law: MetricJudged, judged: Sequence[MetricJudged], observations: MetricObservations
) -> MetricJudged:
    """Give the law as it is, fitted from where candidates ended that do best: they may have left a poor valley."""
    best = sorted(judged, key=lambda one: one.squares)[:ON_THE_WAY]
    starts = [law.result.law.values, *(law.structure.own(one.result.law.values) for one in best)]
    return judged_fit((), fit_from_each(law.structure, observations, starts, CANDIDATE_TOLERANCE), observations)


def _looks(law: MetricJudged, names: Sequence[str], observations: MetricObservations, workers: Workers) -> list[Look]:
    return workers.each(partial(look, law, observations), names, "looked at {}".format)


def _with_each(
    law: MetricJudged, entries: Sequence[Look], observations: MetricObservations, workers: Workers, *, thoroughly: bool
) -> list[MetricJudged]:
    return workers.each(
        partial(_with, law, observations, thoroughly),
        entries,
        lambda entry: f"fitted {' + '.join((*law.effects, entry.name))}",
    )


def _with(law: MetricJudged, observations: MetricObservations, thoroughly: bool, entry: Look) -> MetricJudged:
    effects = (*law.effects, entry.name)
    larger, start = with_effect(law.structure, entry.name), law.result.law.values
    # Not from the look's start alone: what one step promises doesn't tell which valley is deepest.
    if thoroughly:
        return judged_fit(effects, fit_to_metrics(larger, observations, start, ROUGH_TOLERANCE), observations)
    return judge_metrics(effects, larger, start, observations, ROUGH_TOLERANCE)


def _richest(
    law: MetricJudged,
    fitted: Sequence[MetricJudged],
    together: Sequence[MetricJudged],
    names: Sequence[str],
    observations: MetricObservations,
    lacks: Callable[[MetricJudged], bool],
    workers: Workers,
) -> MetricJudged:
    """Add what the metrics support, one effect after the other, for the scatter to be told from what is left.

    Where what may be the cause leaves more than scatter, also what may take a part only. Two that come together are
    added where they take half, or more, of what the best one alone would leave.
    """
    climb = partial(_climb, names=names, observations=observations, lacks=lacks, workers=workers)
    by_one = climb(law, fitted, together)
    supported = (judged for judged in together if _supported(judged, law))
    two = min(supported, key=by_rank, default=by_one)
    # one effect after the other may end at more than two leave that come together: that is no scatter
    return min((by_one, climb(two)), key=by_rank) if two.score < by_one.score else by_one


def _climb(
    law: MetricJudged,
    fitted: Sequence[MetricJudged] | None = None,
    together: Sequence[MetricJudged] = (),
    *,
    names: Sequence[str],
    observations: MetricObservations,
    lacks: Callable[[MetricJudged], bool],
    workers: Workers,
) -> MetricJudged:
    """Add to a law what the metrics support; `fitted` is it with one effect more each, where that is known."""
    richest = law
    while len(richest.effects) < MOST_ADDED:
        fitted = _with_the_likeliest(richest, names, observations, workers) if fitted is None else fitted
        supported = partial(_supported, richest=richest)
        usable = list(filter(supported, fitted))
        sound = [judged for judged in usable if judged.may_be_cause]
        able = sound or (usable if lacks(richest) else [])
        best = min(able, key=by_rank, default=richest)
        outdoing = [judged for judged in filter(supported, together) if outdoes_in_fit(judged, best)]
        best = min(outdoing, key=by_rank, default=best)
        if best is richest:
            break
        richest, together, fitted = best, (), None
    return richest


def _with_the_likeliest(
    law: MetricJudged, names: Sequence[str], observations: MetricObservations, workers: Workers
) -> list[MetricJudged]:
    left = [name for name in names if name not in law.effects]
    seen = [entry for entry in _looks(law, left, observations, workers) if not entry.hidden]
    seen.sort(key=lambda entry: -entry.promise)
    apart = unlike([law.structure.effect(entry.name) for entry in seen])
    chosen = [entry for entry in seen if entry.name in apart][:ON_THE_WAY]
    return _with_each(law, chosen, observations, workers, thoroughly=False)


def _supported(judged: MetricJudged, richest: MetricJudged) -> bool:
    """Tell whether metrics support a law beyond the richest one so far."""
    enough = not judged.objections and judged.freedoms >= FEWEST_FREEDOMS
    return enough and chance(richest, judged, EXPECTED) <= REAL_CHANCE
