"""Diagnosis on loop metrics alone: which effect a law lacks, as far as dW and W of few conditions can tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from pipeclamp_identification.diagnosis.candidates import distinct
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.smooth_trends import smooth_functions
from pipeclamp_identification.metrics_only.campaign import SCATTER_BEFOREHAND, MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.candidates import candidates_of, unlike
from pipeclamp_identification.metrics_only.evidence import (
    LeftOutErrors,
    MetricJudged,
    Scatter,
    by_rank,
    chance,
    chance_of_lack,
    judge_metrics,
    metric_scatter_of,
    single_rows,
)
from pipeclamp_identification.metrics_only.observations import MetricObservations, as_seen_at_few
from pipeclamp_identification.metrics_only.screen import Look
from pipeclamp_identification.metrics_only.thresholds import (
    HOPELESS_CHANCE,
    NEARLY_ALL_SHARE,
    REAL_CHANCE,
)
from pipeclamp_identification.metrics_only.valleys import CANDIDATE_TOLERANCE, ROUGH_TOLERANCE
from pipeclamp_identification.metrics_only.weighing import MetricScales, MetricWeighed, weigh
from pipeclamp_identification.signals.levels import SAME_KELVIN, SAME_SHARE, number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.law.file import NamedKind, Verdict
from pipeclamp_models.law.law import Structure

COARSE_SAMPLES = 64
"""Points of the cycle while effects are sought and valleys compared: what they miss of an extreme, 0.2 % at most, is
much the same in all rows. What is then judged is fitted again on all points."""
IMITATED = "at these conditions the law's own parameters do all that it would do to dW and W"


@dataclass(frozen=True)
class MetricDiagnosis:
    """The answer.

    Attributes:
        found: the verdict, the laws with what is named, best first, and why.
        scales: what was weighed: the law as it is, refitted, all candidates and pairs, and the richest law, with all
            that the metrics support, which the scatter is told from.
        candidates: the best of the effects that were fitted, and all that gain more than scatter often does, best
            first.
        pairs: of an effect with what scales only it those that are named, or the best that gains more than scatter
            often does.
        screened_out: effects that were fitted and gain next to nothing.
        hidden: effects that metrics can't show here, with the reason: neither found nor refuted.
        observations: the metrics, in units of their scatter.
        heldout: rms log ratio on conditions that were left out, of the law ("") and of each candidate by its name.
        rests_on: runs without any one of which the named effect gains little.
        tested_once: conditions that the named effect follows and of which every level but one has a single run.
    """

    found: MetricWeighed
    scales: MetricScales
    candidates: tuple[MetricJudged, ...]
    pairs: tuple[MetricJudged, ...]
    screened_out: tuple[str, ...]
    hidden: Mapping[str, str]
    observations: MetricObservations
    heldout: Mapping[str, float]
    rests_on: tuple[int, ...]
    tested_once: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """The verdict: complete, missing, ambiguous or unknown."""
        return self.found.verdict

    @property
    def effects(self) -> tuple[str, ...]:
        """What is missing, or may be, as `add` takes it; best first."""
        return distinct(judged.effects[0] for judged in self.found.laws)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the verdict is what it is."""
        return self.found.reasons

    @property
    def law(self) -> MetricJudged:
        """The law as it is, refitted."""
        return self.scales.law

    @property
    def richest(self) -> MetricJudged:
        """The law with all that the metrics support."""
        return self.scales.richest

    @property
    def scatter(self) -> Scatter:
        """What no law explains."""
        return self.scales.scatter

    @property
    def chances(self) -> Mapping[str, float]:
        """Chance that scatter alone makes what a candidate or pair gains, once for each that was tried, by its name."""
        return self.scales.chances

    @property
    def named(self) -> MetricJudged | None:
        """The law with what is named first; None where nothing is."""
        return next(iter(self.found.laws), None)

    @property
    def kind(self) -> NamedKind | None:
        """Whether what is named first explains nearly all that the metrics show missing, or takes a part of it."""
        if self.named is None:
            return None
        nearly_all = self.explained(self.named) > NEARLY_ALL_SHARE
        return "cause" if nearly_all and not self.of_left_out else "part"

    @property
    def of_left_out(self) -> bool:
        """Whether shares are of left-out conditions: much remains, or what is named first hasn't the right form."""
        return self.scales.much_remains or (self.named is not None and not self.named.may_be_cause)

    def explained(self, judged: MetricJudged) -> float:
        """Give the share of what is missing that a law explains.

        Of what the richest law explains, or, where that can't be relied on, of the squares on left-out conditions.
        Nothing where nothing is named and the metrics support no effect: what one gains is scatter.
        """
        if self.named is None and not self.of_left_out and self.richest.structure == self.law.structure:
            return 0.0
        return self.scales.on_left_out(judged) if self.of_left_out else self.scales.of_richest(judged)

    @property
    def shown(self) -> tuple[MetricJudged, ...]:
        """The candidates and the pairs, best first."""
        return tuple(sorted((*self.candidates, *self.pairs), key=by_rank))

    @property
    def best(self) -> MetricJudged:
        """The best law with one effect more at most, or with two that come together."""
        return min((self.law, *self.shown), key=by_rank)


def diagnose_metrics(structure: Structure, campaign: MetricCampaign, *, workers: Workers = ALONE) -> MetricDiagnosis:
    """Find which effect a law lacks, from metrics.

    Args:
        structure: the law's structure; its parameters are refitted.
        campaign: the metrics.
        workers: who does it, and who is told.

    Raises:
        UserError: there are too few metrics for the law's parameters.
    """
    coarse = metric_observations(campaign, samples=COARSE_SAMPLES)
    smooth = _smooth(campaign, coarse)
    fitted = candidates_of(structure, campaign, coarse, smooth, workers)
    scatter = metric_scatter_of(fitted.richest, coarse, SCATTER_BEFOREHAND)
    observations, few = (each.with_scatter(scatter.share) for each in (metric_observations(campaign), coarse))
    workers.tell("evidence in units of the scatter")
    again = partial(_again, observations, few)
    law, richest = again(fitted.law), again(fitted.richest)
    alone, together = (sorted(workers.share(again, judged), key=by_rank) for judged in (fitted.alone, fitted.together))
    chances = _chances(law, alone, together, fitted.looks, scatter)
    hidden = _hidden(fitted.looks, together, chances)
    lack = (
        chance_of_lack(law, observations, smooth, SCATTER_BEFOREHAND),
        chance_of_lack(richest, observations, smooth, SCATTER_BEFOREHAND),
    )
    heldout = LeftOutErrors(observations, few, workers)
    scales = MetricScales(law, richest, alone, together, chances, lack, scatter, heldout.of_conditions)
    found = weigh(scales)
    rests_on: tuple[int, ...] = ()
    tested_once: tuple[str, ...] = ()
    if found.verdict == "missing":
        named = found.laws[0]
        workers.tell(f"what {named.name} rests on")
        rests_on = single_rows(named.result, structure, as_seen_at_few(few, observations, named.result.law))
        tested_once = _tested_once(named, observations)
    shown = [
        judged for place, judged in enumerate(alone)
        if place == 0 or (chances[judged.name] < HOPELESS_CHANCE and judged.name not in hidden)
    ]  # fmt: skip
    of_two = [judged for judged in found.laws if judged.effects[1:]] or [
        judged for judged in together if not judged.objections and chances[judged.name] < HOPELESS_CHANCE
    ][:1]
    screened_out = tuple(judged.name for judged in alone if judged not in shown)
    errors = {judged.name: heldout.error(judged) for judged in (law, *shown, *of_two)}
    return MetricDiagnosis(
        found, scales, tuple(shown), tuple(of_two), screened_out, hidden, observations, errors, rests_on, tested_once
    )


def _chances(
    law: MetricJudged,
    alone: Sequence[MetricJudged],
    together: Sequence[MetricJudged],
    looks: Sequence[Look],
    scatter: Scatter,
) -> dict[str, float]:
    """Give the chance that scatter alone makes what a candidate or pair gains, once for each that was tried."""
    imitated = {entry.name for entry in looks if entry.imitated}
    sound = (judged for judged in alone if judged.effects[0] not in imitated and judged.may_be_cause)
    tried = max(len(unlike(judged.structure.effect(judged.effects[0]) for judged in sound)), 1)
    return {
        judged.name: min(1.0, count * chance(law, judged, scatter))
        for several, count in ((alone, tried), (together, tried + len(together)))
        for judged in several
    }


def _hidden(looks: Sequence[Look], together: Sequence[MetricJudged], chances: Mapping[str, float]) -> dict[str, str]:
    """Give the effects that metrics can't show, with the reason."""
    beside = {name for judged in together for name in judged.effects}  # they were tried with what they scale
    unseen = {entry.name: entry.hidden for entry in looks if entry.hidden and entry.name not in beside}
    imitated = (entry.name for entry in looks if entry.imitated and not entry.hidden)
    return unseen | {name: IMITATED for name in imitated if chances[name] > REAL_CHANCE}


def _tested_once(judged: MetricJudged, observations: MetricObservations) -> tuple[str, ...]:
    """Find the conditions that the added effect follows and of which every level but one has a single run."""
    added = [effect for effect in judged.result.equations.effects if effect.name in judged.effects]
    parameters = [parameter for effect in added for parameter in effect.parameters]
    found = []
    for signal in dict.fromkeys(str(signal) for parameter in parameters for signal in parameter.follows):
        values = observations.motion.slow[signal][:, 0]
        alike = {"absolute": SAME_KELVIN} if signal == "T" else {"relative": SAME_SHARE}
        counts = sorted(len(level.rows) for level in number_levels(values, **alike))
        if len(counts) > 1 and counts[-2] == 1:
            found.append(signal)
    return tuple(found)


def _again(observations: MetricObservations, few: MetricObservations, judged: MetricJudged) -> MetricJudged:
    """Refit a law to the metrics as they are weighted now: at few points of the cycle, and from there at all."""
    seen = as_seen_at_few(few, observations, judged.result.law)
    near = fit(judged.structure, seen, start=judged.result.law.values, tolerance=CANDIDATE_TOLERANCE).law.values
    return judge_metrics(judged.effects, judged.structure, near, observations, ROUGH_TOLERANCE)


def _smooth(campaign: MetricCampaign, observations: MetricObservations) -> Array:
    """Give the functions of the conditions that count as smooth, shape (R, q)."""
    columns = {name: values[:, 0] for name, values in observations.motion.slow.items()}
    A, f, T = (columns.pop(name) for name in ("A", "f", "T"))
    return smooth_functions(A, f, T, list(columns.values()), [run.setup.specimen for run in campaign.runs])
