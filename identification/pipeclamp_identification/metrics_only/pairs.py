"""Pairs on metrics: an effect together with another one that scales what only it has."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from pipeclamp_identification.diagnosis.screen import candidate_names, fits, fits_beside
from pipeclamp_identification.metrics_only.campaign import MetricCampaign
from pipeclamp_identification.metrics_only.evidence import MetricJudged, judged_fit
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.screen import look
from pipeclamp_identification.metrics_only.valleys import ROUGH_TOLERANCE, fit_from_each, sized_by_shares
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.law import with_effect

MOST_FIRST = 2
"""Effects that are tried with each of those that scale them, most promising first: many act alike on metrics."""


def metric_pairs(
    law: MetricJudged,
    fitted: Sequence[MetricJudged],
    campaign: MetricCampaign,
    observations: MetricObservations,
    workers: Workers,
) -> list[MetricJudged]:
    """Fit effects together with what scales only them, and none of the law: by itself neither may help.

    Args:
        law: the law as it is.
        fitted: the law with one more effect each.
        campaign: the tests.
        observations: what they were fitted to.
        workers: who does it, and who is told.
    """
    after_one_step: dict[str, list[tuple[float, MetricJudged]]] = {}
    for first in fitted:
        known = candidate_names(first.structure, campaign.condition_columns, time_measured=campaign.time_measured)
        for name in known:
            if fits(law.structure, name) or not fits_beside(first.structure, name):
                continue
            seen = look(first, observations, name)
            if not seen.hidden:
                after_one_step.setdefault(name, []).append((first.squares - seen.promise, first))
    asked = [
        (first, second)
        for second, firsts in after_one_step.items()
        for _, first in sorted(firsts, key=lambda entry: entry[0])[:MOST_FIRST]
    ]
    return workers.each(
        partial(_fitted_together, law, observations),
        asked,
        lambda two: f"fitted {' and '.join((*two[0].effects, two[1]))}",
    )


def _fitted_together(
    law: MetricJudged, observations: MetricObservations, asked: tuple[MetricJudged, str]
) -> MetricJudged:
    first, second = asked
    larger = with_effect(first.structure, second)
    # the law's own values may be what keeps both from their place: without any, too
    sized = (sized_by_shares(larger, observations, values) for values in (law.result.law.values, {}))
    both = fit_from_each(larger, observations, (first.result.law.values, *sized), ROUGH_TOLERANCE)
    return judged_fit((*first.effects, second), both, observations)
