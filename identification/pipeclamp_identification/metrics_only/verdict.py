"""Diagnosis on loop metrics alone: which effect a law lacks, as far as dW and W of few conditions can tell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.candidates import distinct
from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.fitting.smooth_trends import smooth_functions
from pipeclamp_identification.metrics_only.campaign import SCATTER, MetricCampaign, metric_observations
from pipeclamp_identification.metrics_only.evidence import (
    EXPECTED_FREEDOMS,
    ROUGHLY,
    MetricJudged,
    Scatter,
    chance,
    chance_of_lack,
    heldout_error,
    judge_metrics,
    scatter_of,
    single_rows,
)
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.screen import Look, look
from pipeclamp_identification.metrics_only.thresholds import (
    FEWEST_FREEDOMS,
    GREATER_PART_SHARE,
    HOPELESS_CHANCE,
    NEARLY_ALL_SHARE,
    REAL_CHANCE,
    RIVAL_LIKELIHOOD,
)
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

MORE_TESTS = "run tests at further conditions, repeat some for the scatter, or record the loops"
IMITATED = "at these conditions the law's own parameters do all that it would do to dW and W"


@dataclass(frozen=True)
class MetricDiagnosis:
    """The answer.

    Attributes:
        verdict: complete, missing, ambiguous or unknown.
        effects: names, best first.
        law: the law as it is, refitted.
        candidates: the best of the effects that were fitted, and all that gain more than scatter often does, best
            first.
        richest: the law with all that the metrics support, which the scatter is told from.
        chances: chance that scatter alone makes what a candidate gains, once for each effect tried, its imitators
            included, by its name.
        screened_out: effects that were fitted and gain next to nothing.
        hidden: effects that metrics can't show here, with the reason: neither found nor refuted.
        observations: the metrics, in units of their scatter.
        scatter: what no law explains.
        heldout: rms log ratio on conditions that were left out, of the law ("") and of each candidate by its name.
        rests_on: runs without any one of which the named effect gains little.
        tested_once: conditions that the named effect follows and of which every level but one has a single run.
        reasons: why the verdict is what it is.
    """

    verdict: Verdict
    effects: tuple[str, ...]
    law: MetricJudged
    candidates: tuple[MetricJudged, ...]
    richest: MetricJudged
    chances: Mapping[str, float]
    screened_out: tuple[str, ...]
    hidden: Mapping[str, str]
    observations: MetricObservations
    scatter: Scatter
    heldout: Mapping[str, float]
    rests_on: tuple[int, ...]
    tested_once: tuple[str, ...]
    reasons: tuple[str, ...]

    @property
    def named(self) -> MetricJudged | None:
        """The law with what is named first; None where nothing is."""
        return next((judged for judged in self.candidates if judged.effects == self.effects[:1]), None)

    @property
    def kind(self) -> Kind | None:
        """Whether what is named first explains nearly all that the metrics show missing, or takes a part of it."""
        if self.named is None:
            return None
        return "cause" if self.explained(self.named) > NEARLY_ALL_SHARE else "part"

    def explained(self, judged: MetricJudged) -> float:
        """Give the share of what the richest law explains beyond the law as it is that a candidate explains alone."""
        whole = self.law.squares - min(self.richest.squares, judged.squares)
        return float(np.clip((self.law.squares - judged.squares) / whole, 0.0, 1.0)) if whole > 0 else 0.0

    @property
    def best(self) -> MetricJudged:
        """The best law with no more than one effect more."""
        return min((self.law, *self.candidates), key=lambda judged: judged.score)


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
    tell("law as it is")
    law = judge_metrics((), structure, {}, observations)
    refinements = [effect.refinement for effect in structure.all_effects() if effect.refinement]
    unseen = {refinement.name for refinement in refinements if not refinement.seen_in_metrics}
    names = [name for name in candidate_names(structure, campaign.condition_columns) if name not in unseen]
    looks = _looks(law, names, observations, tell)
    seen = [entry for entry in looks if not entry.hidden]
    fitted = [_with(law, entry, observations, tell) for entry in seen]
    richest = _richest(law, fitted, names, observations, tell)
    scatter = scatter_of(richest, observations, SCATTER)
    observations = metric_observations(campaign).with_scatter(scatter.share)
    tell("evidence in units of the scatter")
    again = partial(_again, observations=observations)
    law, richest = again(law), again(richest)
    candidates = sorted((again(judged) for judged in fitted), key=lambda judged: judged.score)
    apart = {entry.name for entry in seen if not entry.imitated}
    sound = (judged for judged in candidates if judged.effects[0] in apart and not judged.objections)
    tried = max(len(_unlike(judged.structure.effect(judged.effects[0]) for judged in sound)), 1)
    chances = {judged.effects[0]: min(1.0, tried * chance(law, judged, scatter)) for judged in candidates}
    hidden = {entry.name: entry.hidden for entry in looks if entry.hidden}
    hidden |= {entry.name: IMITATED for entry in seen if entry.imitated and chances[entry.name] > REAL_CHANCE}
    lack = [chance_of_lack(judged, observations, smooth, SCATTER) for judged in (law, richest)]
    verdict, named, reasons = _verdict(law, richest, candidates, chances, lack, scatter)
    rests_on: tuple[int, ...] = ()
    tested_once: tuple[str, ...] = ()
    if verdict == "missing":
        tell(f"what {named[0].effects[0]} rests on")
        rests_on = single_rows(named[0].result, structure, observations)
        tested_once = _tested_once(named[0], observations)
    shown = [
        judged for place, judged in enumerate(candidates)
        if place == 0 or (chances[judged.effects[0]] < HOPELESS_CHANCE and judged.effects[0] not in hidden)
    ]  # fmt: skip
    screened_out = tuple(judged.effects[0] for judged in candidates if judged not in shown)
    heldout = {}
    for judged in (law, *shown):
        tell(f"left-out conditions, {' + '.join(judged.effects) or 'law as it is'}")
        heldout["".join(judged.effects)] = heldout_error(judged.structure, observations, judged.result.law.values)
    effects = distinct(judged.effects[0] for judged in named)
    return MetricDiagnosis(
        verdict, effects, law, tuple(shown), richest, chances, screened_out, hidden, observations, scatter,
        heldout, rests_on, tested_once, reasons,
    )  # fmt: skip


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
    added = next(effect for effect in judged.result.equations.effects if effect.name == judged.effects[0])
    found = []
    for signal in dict.fromkeys(str(signal) for parameter in added.parameters for signal in parameter.follows):
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


def _with(law: MetricJudged, entry: Look, observations: MetricObservations, tell: Progress) -> MetricJudged:
    tell(f"fit {' + '.join((*law.effects, entry.name))}")
    larger = with_effect(law.structure, entry.name)
    # Not from the look's start alone: what one step promises doesn't tell which valley is deepest.
    return judge_metrics((*law.effects, entry.name), larger, law.result.law.values, observations, ROUGHLY)


def _again(judged: MetricJudged, observations: MetricObservations) -> MetricJudged:
    """Refit a law to the metrics as they are weighted now."""
    return judge_metrics(judged.effects, judged.structure, judged.result.law.values, observations)


def _richest(
    law: MetricJudged,
    fitted: Sequence[MetricJudged],
    names: Sequence[str],
    observations: MetricObservations,
    tell: Progress,
) -> MetricJudged:
    """Add what the metrics support, one effect after the other, for the scatter to be told from what is left."""
    expected = Scatter(np.full(2, SCATTER), np.full(2, EXPECTED_FREEDOMS))
    richest = law
    while len(richest.effects) < LONGEST:
        sound = [judged for judged in fitted if not judged.objections and judged.freedoms >= FEWEST_FREEDOMS]
        best = min(sound, key=lambda judged: judged.score, default=richest)
        if best is richest or chance(richest, best, expected) > REAL_CHANCE:
            break
        richest = best
        left = [name for name in names if name not in richest.effects]
        seen = [entry for entry in _looks(richest, left, observations, tell) if not entry.hidden]
        seen.sort(key=lambda entry: -entry.promise)
        unlike = _unlike([richest.structure.effect(entry.name) for entry in seen])
        chosen = [entry for entry in seen if entry.name in unlike][:ON_THE_WAY]
        fitted = [_with(richest, entry, observations, tell) for entry in chosen]
    return richest


def _verdict(
    law: MetricJudged,
    richest: MetricJudged,
    candidates: Sequence[MetricJudged],
    chances: Mapping[str, float],
    lack: Sequence[float],
    scatter: Scatter,
) -> tuple[Verdict, list[MetricJudged], tuple[str, ...]]:
    """Weigh the candidates; give the verdict, who is named, best first, and why.

    Args:
        law, richest: the law as it is, and with all that the metrics support.
        candidates: best first.
        chances: chance of each candidate's gain under scatter alone.
        lack: chance of what `law` and `richest` leave over under scatter alone.
        scatter: what no law explains.
    """
    told = _scatter_words(scatter)
    sound = [judged for judged in candidates if not judged.objections and judged.squares < law.squares]
    likely = [judged for judged in sound if chances[judged.effects[0]] < REAL_CHANCE]
    if not likely:
        hint = (
            f"the likeliest effect, {sound[0].effects[0]}, gains what scatter gains in "
            f"{chances[sound[0].effects[0]]:.0%} of all cases" if sound else "no effect gains anything"
        )  # fmt: skip
        if lack[0] < REAL_CHANCE:
            more = f"{hint}; {MORE_TESTS}"
            return "unknown", [], ("what is left is more than scatter, and no effect explains it", more, told)
        if law.freedoms < FEWEST_FREEDOMS:
            few = f"{law.residual.size} metrics less {law.parameters} parameters leave too little to judge the law by"
            return "unknown", [], (few, MORE_TESTS, told)
        return "complete", [], ("what dW and W show is scatter", hint, told)
    best = likely[0]
    name = best.effects[0]
    if lack[1] < REAL_CHANCE:
        together = " and ".join(richest.effects)
        return "unknown", [], (f"{together} together leave more than scatter", MORE_TESTS, told)
    share = (law.squares - best.squares) / max(law.squares - min(richest.squares, best.squares), 1e-300)
    if share < GREATER_PART_SHARE:
        patchwork = f"no effect alone explains the greater part of what is missing; the best, {name}, {share:.0%}"
        return "unknown", [], (patchwork, MORE_TESTS, told)
    rivals = [judged for judged in sound if judged is not best and judged.score < best.score + RIVAL_LIKELIHOOD]
    named = sorted((best, *rivals), key=lambda judged: judged.score)
    if rivals:
        words = " from ".join(judged.effects[0] for judged in named)
        return "ambiguous", named, (f"dW and W at these conditions can't tell {words}", told)
    gain = f"{name} explains {share:.0%} of what the metrics show missing"
    return (
        "missing",
        [best],
        (gain, f"scatter alone would gain as much in {100 * chances[name]:.2g} % of all cases", told),
    )


def _scatter_words(scatter: Scatter) -> str:
    dissipated, elastic = scatter.share
    few = int(scatter.freedoms.min() - EXPECTED_FREEDOMS)
    return (
        f"scatter is taken for {dissipated:.2%} of dW and {elastic:.2%} of W: {SCATTER:.0%} was expected, and what the "
        f"richest law leaves ({few} more numbers than it has parameters) corrected it"
    )
