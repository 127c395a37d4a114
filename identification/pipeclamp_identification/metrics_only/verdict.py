"""Diagnosis on loop metrics alone: which effect a law lacks, as far as dW and W of few conditions can tell."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.candidates import distinct
from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.fitting.smooth_trends import smooth_functions
from pipeclamp_identification.metrics_only.campaign import SCATTER, MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.evidence import (
    EXPECTED_FREEDOMS,
    LeftOutErrors,
    MetricJudged,
    Scatter,
    chance,
    chance_of_lack,
    judge_metrics,
    judged_fit,
    scatter_of,
    single_rows,
)
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.pairs import pairs
from pipeclamp_identification.metrics_only.screen import Look, look
from pipeclamp_identification.metrics_only.thresholds import (
    FEWEST_FREEDOMS,
    HOPELESS_CHANCE,
    NEARLY_ALL_SHARE,
    REAL_CHANCE,
)
from pipeclamp_identification.metrics_only.valleys import CLOSELY, ROUGHLY, fit_from_each, fit_to_metrics
from pipeclamp_identification.metrics_only.weighing import MetricScales, Weighed, outdoes_in_fit, weigh
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.progress import Progress
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.file import Kind, Verdict
from pipeclamp_models.law.law import Structure, with_effect

ON_THE_WAY = 4
"""Of the effects that promise most, so many that don't imitate each other are fitted for each further step to the
richest law."""
LONGEST = 3
"""Effects that are added on the way to the richest law, at most."""
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

    found: Weighed
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
    def kind(self) -> Kind | None:
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
        return tuple(sorted((*self.candidates, *self.pairs), key=_score))

    @property
    def best(self) -> MetricJudged:
        """The best law with one effect more at most, or with two that come together."""
        return min((self.law, *self.shown), key=lambda judged: judged.score)


def diagnose_metrics(
    structure: Structure, campaign: MetricCampaign, *, progress: Progress | None = None
) -> MetricDiagnosis:
    """Find which effect a law lacks, from metrics.

    Args:
        structure: the law's structure; its parameters are refitted.
        campaign: the metrics.
        progress: is told what is being done.

    Raises:
        UserError: there are too few metrics for the law's parameters.
    """
    tell = progress or (lambda _: None)
    observations = metric_observations(campaign, samples=COARSE_SAMPLES)
    smooth = _smooth(campaign, observations)
    lacks = partial(_lacks, observations=observations, smooth=smooth)
    tell("law as it is")
    law = judged_fit((), fit_to_metrics(structure, observations, {}, CLOSELY), observations)
    refinements = [effect.refinement for effect in structure.all_effects() if effect.refinement]
    unseen = {refinement.name for refinement in refinements if not refinement.seen_in_metrics}
    names = [name for name in candidate_names(structure, campaign.condition_columns) if name not in unseen]
    looks = _looks(law, names, observations, tell)
    seen = [entry for entry in looks if not entry.hidden]
    thoroughly = lacks(law)
    fitted = [_with(law, entry, observations, tell, thoroughly=thoroughly) for entry in seen]
    alone = min((judged for judged in fitted if judged.may_be_cause), key=_score, default=law)
    together = pairs(law, fitted, campaign.condition_columns, observations, tell) if lacks(alone) else []
    law = _from_another_valley(law, [*fitted, *together], observations) if thoroughly else law
    richest = _richest(law, fitted, together, names, observations, lacks, tell)
    scatter = scatter_of(richest, observations, SCATTER)
    observations = metric_observations(campaign).with_scatter(scatter.share)
    tell("evidence in units of the scatter")
    again = partial(_again, observations=observations)
    law, richest = again(law), again(richest)
    candidates, together = (sorted(map(again, judged), key=_score) for judged in (fitted, together))
    apart = {entry.name for entry in seen if not entry.imitated}
    sound = (judged for judged in candidates if judged.effects[0] in apart and judged.may_be_cause)
    tried = max(len(_unlike(judged.structure.effect(judged.effects[0]) for judged in sound)), 1)
    chances = {
        judged.name: min(1.0, count * chance(law, judged, scatter))
        for several, count in ((candidates, tried), (together, tried + len(together)))
        for judged in several
    }
    beside = {name for judged in together for name in judged.effects}  # they were tried with what they scale
    hidden = {entry.name: entry.hidden for entry in looks if entry.hidden and entry.name not in beside}
    hidden |= {entry.name: IMITATED for entry in seen if entry.imitated and chances[entry.name] > REAL_CHANCE}
    lack = chance_of_lack(law, observations, smooth, SCATTER), chance_of_lack(richest, observations, smooth, SCATTER)
    heldout = LeftOutErrors(observations, tell)
    scales = MetricScales(law, richest, candidates, together, chances, lack, scatter, heldout.of_conditions)
    found = weigh(scales)
    rests_on: tuple[int, ...] = ()
    tested_once: tuple[str, ...] = ()
    if found.verdict == "missing":
        named = found.laws[0]
        tell(f"what {named.name} rests on")
        rests_on = single_rows(named.result, structure, observations)
        tested_once = _tested_once(named, observations)
    shown = [
        judged for place, judged in enumerate(candidates)
        if place == 0 or (chances[judged.name] < HOPELESS_CHANCE and judged.name not in hidden)
    ]  # fmt: skip
    of_two = [judged for judged in found.laws if judged.effects[1:]] or [
        judged for judged in together if not judged.objections and chances[judged.name] < HOPELESS_CHANCE
    ][:1]
    screened_out = tuple(judged.name for judged in candidates if judged not in shown)
    errors = {judged.name: heldout.error(judged) for judged in (law, *shown, *of_two)}
    return MetricDiagnosis(
        found, scales, tuple(shown), tuple(of_two), screened_out, hidden, observations, errors, rests_on, tested_once
    )


def _score(judged: MetricJudged) -> float:
    return judged.score


def _lacks(judged: MetricJudged, observations: MetricObservations, smooth: Array) -> bool:
    """Tell whether a law leaves more than the scatter that was expected."""
    return chance_of_lack(judged, observations, smooth, SCATTER) < REAL_CHANCE


def _from_another_valley(
    law: MetricJudged, judged: Sequence[MetricJudged], observations: MetricObservations
) -> MetricJudged:
    """Give the law as it is, fitted from where candidates ended that do best: they may have left a poor valley."""
    best = sorted(judged, key=lambda one: one.squares)[:ON_THE_WAY]
    starts = [law.result.law.values, *(law.structure.own(one.result.law.values) for one in best)]
    return judged_fit((), fit_from_each(law.structure, observations, starts, CLOSELY), observations)


def _unlike(effects: Iterable[Effect]) -> list[str]:
    """Give the names of effects, in order, that imitate none before: what makes one gain makes its imitators gain."""
    chosen: list[Effect] = []
    for effect in effects:
        if not any(effect.id in other.imitated_by or other.id in effect.imitated_by for other in chosen):
            chosen.append(effect)
    return [effect.name for effect in chosen]


def _smooth(campaign: MetricCampaign, observations: MetricObservations) -> Array:
    """Give the functions of the conditions that count as smooth, shape (R, q)."""
    columns = {name: values[:, 0] for name, values in observations.motion.slow.items()}
    A, f, T = (columns.pop(name) for name in ("A", "f", "T"))
    return smooth_functions(A, f, T, list(columns.values()), [run.specimen for run in campaign.runs])


def _tested_once(judged: MetricJudged, observations: MetricObservations) -> tuple[str, ...]:
    """Find the conditions that the added effect follows and of which every level but one has a single run."""
    added = [effect for effect in judged.result.equations.effects if effect.name in judged.effects]
    parameters = [parameter for effect in added for parameter in effect.parameters]
    found = []
    for signal in dict.fromkeys(str(signal) for parameter in parameters for signal in parameter.follows):
        counts = np.sort(np.unique(observations.motion.slow[signal], return_counts=True)[1])
        if len(counts) > 1 and counts[-2] == 1:
            found.append(signal)
    return tuple(found)


def _looks(law: MetricJudged, names: Sequence[str], observations: MetricObservations, tell: Progress) -> list[Look]:
    looks = []
    for name in names:
        tell(f"look at {name}")
        looks.append(look(law, name, observations))
    return looks


def _with(
    law: MetricJudged, entry: Look, observations: MetricObservations, tell: Progress, *, thoroughly: bool
) -> MetricJudged:
    effects = (*law.effects, entry.name)
    tell(f"fit {' + '.join(effects)}")
    larger, start = with_effect(law.structure, entry.name), law.result.law.values
    # Not from the look's start alone: what one step promises doesn't tell which valley is deepest.
    if thoroughly:
        return judged_fit(effects, fit_to_metrics(larger, observations, start, ROUGHLY), observations)
    return judge_metrics(effects, larger, start, observations, ROUGHLY)


def _again(judged: MetricJudged, observations: MetricObservations) -> MetricJudged:
    """Refit a law to the metrics as they are weighted now."""
    return judge_metrics(judged.effects, judged.structure, judged.result.law.values, observations)


def _richest(
    law: MetricJudged,
    fitted: Sequence[MetricJudged],
    together: Sequence[MetricJudged],
    names: Sequence[str],
    observations: MetricObservations,
    lacks: Callable[[MetricJudged], bool],
    tell: Progress,
) -> MetricJudged:
    """Add what the metrics support, one effect after the other, for the scatter to be told from what is left.

    Where what may be the cause leaves more than scatter, also what may take a part only. Two that come together are
    added where they take half, or more, of what the best one alone would leave.
    """
    expected = Scatter(np.full(2, SCATTER), np.full(2, EXPECTED_FREEDOMS))
    richest = law
    while len(richest.effects) < LONGEST:
        supported = partial(_supported, richest=richest, expected=expected)
        usable = list(filter(supported, fitted))
        sound = [judged for judged in usable if judged.may_be_cause]
        able = sound or (usable if lacks(richest) else [])
        best = min(able, key=_score, default=richest)
        outdoing = [judged for judged in filter(supported, together) if outdoes_in_fit(judged, best)]
        best = min(outdoing, key=_score, default=best)
        if best is richest:
            break
        richest, together = best, ()
        left = [name for name in names if name not in richest.effects]
        seen = [entry for entry in _looks(richest, left, observations, tell) if not entry.hidden]
        seen.sort(key=lambda entry: -entry.promise)
        unlike = _unlike([richest.structure.effect(entry.name) for entry in seen])
        chosen = [entry for entry in seen if entry.name in unlike][:ON_THE_WAY]
        fitted = [_with(richest, entry, observations, tell, thoroughly=False) for entry in chosen]
    return richest


def _supported(judged: MetricJudged, richest: MetricJudged, expected: Scatter) -> bool:
    """Tell whether metrics support a law beyond the richest one so far."""
    enough = not judged.objections and judged.freedoms >= FEWEST_FREEDOMS
    return enough and chance(richest, judged, expected) <= REAL_CHANCE
