"""Evidence from loop metrics: how a refitted law does on them, on conditions left out, and on which rows that rests.

Metrics are few and seldom repeated, so their scatter is told from what the best law leaves, counted per degree of
freedom, together with an expectation from before the data that weighs as much as a few degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.objections import objections, reservations
from pipeclamp_identification.fitting.heldout import folds
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.starts import SINGULAR_SHARE
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.metrics_only.observations import METRICS, MetricObservations, as_seen_at_few
from pipeclamp_identification.metrics_only.thresholds import RESTS_ON_SHARE, WRONG_AT_MOST_LOG
from pipeclamp_identification.metrics_only.valleys import CANDIDATE_TOLERANCE, LEFT_OUT_TOLERANCE
from pipeclamp_identification.signals.chances import of_larger_ratio
from pipeclamp_identification.signals.levels import SAME_KELVIN, set_points
from pipeclamp_identification.signals.orthonormal import orthonormal
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.processes import ALONE, Workers
from pipeclamp_models.base.signals import OWN_SIGNALS
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_law

EXPECTED_FREEDOMS = 4.0
"""Degrees of freedom that the expected scatter weighs: keeps two or three rows that agree by chance from weighing far
too much."""
MOST_FOLDS = 12
"""Conditions are left out one by one, in so many folds at most."""
SAME_SCORE_DIGITS = 4
"""Digits after the point to which scores are told apart: an effect that ended as its special case does as well as that
but for rounding, which mustn't order them."""
ROWS_TRIED = 12
"""Rows that are left out to see whether an effect rests on them, at most: those that it helps most."""


@dataclass(frozen=True)
class Scatter:
    """What of dW and W no law explains, shapes (2,).

    Attributes:
        share: standard deviation of the log, rounding aside.
        freedoms: degrees of freedom that it is known by.
    """

    share: Array
    freedoms: Array

    def of(self, rounding: Array) -> Array:
        """Give the standard error of each metric, rounding (R, 2) included."""
        return np.hypot(self.share, rounding)


@dataclass(frozen=True)
class MetricJudged:
    """A law, refitted jointly to metrics.

    Attributes:
        effects: what was added to the law as it is.
        structure: what was fitted.
        result: the fit.
        residual: logs of measured over computed dW and W over their standard errors, shape (R, 2).
        objections: why it can't be named; empty where nothing speaks against it.
        reservations: why it isn't the cause, though it may take a part.
    """

    effects: tuple[str, ...]
    structure: Structure
    result: Fit
    residual: Array
    objections: tuple[str, ...]
    reservations: tuple[str, ...] = ()

    @property
    def may_be_cause(self) -> bool:
        """Whether nothing speaks against naming it as the cause."""
        return not self.objections and not self.reservations

    @property
    def name(self) -> str:
        """What was added, in words; empty of the law as it is."""
        return " + ".join(self.effects)

    @property
    def squares(self) -> float:
        """Sum of squared residuals in units of the scatter."""
        return float(np.sum(self.residual**2))

    @property
    def parameters(self) -> int:
        """Number of parameters that the data determines."""
        return len(self.result.fitted) + len(self.result.at_bound)

    @property
    def freedoms(self) -> int:
        """Metrics less parameters."""
        return self.residual.size - self.parameters

    @property
    def score(self) -> float:
        """Squares with the price of each parameter (Akaike's)."""
        return self.squares + 2.0 * self.parameters


def by_rank(judged: MetricJudged) -> tuple[float, int]:
    """Give what laws are ordered by, best first; of those as good the one with fewer parameters of any kind."""
    return round(judged.score, SAME_SCORE_DIGITS), len(judged.result.equations.names)


def judge_metrics(
    effects: tuple[str, ...],
    structure: Structure,
    start: Mapping[str, float],
    observations: MetricObservations,
    tolerance: float = CANDIDATE_TOLERANCE,
) -> MetricJudged:
    """Fit a structure to metrics and say what speaks against it.

    Args:
        effects: what the structure has beyond the law as it is.
        structure: what is fitted.
        start: values to start from.
        observations: the metrics, in units of their scatter.
        tolerance: of the fit.
    """
    return judged_fit(effects, fit(structure, observations, start=start, tolerance=tolerance), observations)


def judged_fit(effects: tuple[str, ...], result: Fit, observations: MetricObservations) -> MetricJudged:
    """Say what speaks against a law that has been fitted; arguments as for `judge_metrics`."""
    return MetricJudged(
        effects,
        result.law.structure,
        result,
        observations.residual(result.law_force),
        objections(effects, result),
        reservations(effects, result),
    )


def metric_scatter_of(judged: MetricJudged, observations: MetricObservations, expected: float) -> Scatter:
    """Tell the scatter from what a law leaves, metric by metric, and what was expected before.

    Args:
        judged: the richest law that the data supports.
        observations: what it was fitted to.
        expected: share that was expected.
    """
    logs = judged.residual * observations.relative_error
    taken = np.sum(_basis(judged, observations) ** 2, axis=1).reshape(logs.shape).sum(axis=0)
    freedoms = np.maximum(len(logs) - taken, 0.0)
    total = EXPECTED_FREEDOMS + freedoms
    return Scatter(np.sqrt((EXPECTED_FREEDOMS * expected**2 + np.sum(logs**2, axis=0)) / total), total)


def _basis(judged: MetricJudged, observations: MetricObservations) -> Array:
    """Give an orthonormal basis of what the fitted parameters move in the residuals, shape (2 R, P)."""
    slopes = np.moveaxis(observations.residual_slopes(judged.result.law_force, judged.result.places), 0, -1)
    return orthonormal_directions(slopes.reshape(judged.residual.size, -1))


def orthonormal_directions(columns: Array) -> Array:
    """Give an orthonormal basis of what columns span, each counted by its direction, not its size."""
    norms = np.linalg.norm(columns, axis=0)
    return orthonormal(columns / np.where(norms > 0, norms, 1.0), SINGULAR_SHARE)


def heldout_error(structure: Structure, observations: MetricObservations, start: Mapping[str, float]) -> float:
    """Give the rms log ratio of a structure on conditions that weren't used to fit it; see `heldout_squares`."""
    return root_mean(heldout_squares(structure, observations, start))


def root_mean(squares: Array) -> float:
    """Give the rms log ratio of runs of which each has this sum of squared logs, shape (R,)."""
    return float(np.sqrt(np.sum(squares) / (len(METRICS) * len(squares))))


def heldout_squares(
    structure: Structure, observations: MetricObservations, start: Mapping[str, float], workers: Workers = ALONE
) -> Array:
    """Give the sum of squared logs of a structure on each run by fits without its conditions, shape (R,).

    Each distinct condition is left out by itself, or with few others where there are many. What only the left-out
    condition could tell is unknown to the fit, as it would be before that test was run. No log counts for more than
    `thresholds.WRONG_AT_MOST_LOG`.
    """
    squares = np.zeros(len(observations.dissipated_energy))
    each = list(folds(distinct_conditions(observations), MOST_FOLDS))
    work = partial(_squares_left_out, structure, observations, start)
    for (_, left_out), found in zip(each, workers.share(work, each), strict=True):
        squares[left_out] = found
    return squares


def _squares_left_out(
    structure: Structure, observations: MetricObservations, start: Mapping[str, float], fold: tuple[IntArray, IntArray]
) -> Array:
    used, left_out = fold
    law = fit(structure, observations.rows(used), start=start, tolerance=LEFT_OUT_TOLERANCE).law
    beyond = observations.rows(left_out)
    logs = np.abs(beyond.logs(force_of_law(law, beyond.motion).force))
    return np.asarray(np.sum(np.fmin(logs, WRONG_AT_MOST_LOG) ** 2, axis=1))


@dataclass
class LeftOutErrors:
    """Errors of laws on left-out conditions, each law's once.

    Attributes:
        observations: the metrics.
        few: the same at few points of the cycle, for the fits.
        workers: who does it, and who is told.
    """

    observations: MetricObservations
    few: MetricObservations
    workers: Workers
    _known: dict[tuple[str, ...], Array] = field(default_factory=dict)

    def of_runs(self, judged: MetricJudged) -> Array:
        """Give the sum of squared logs on each run, shape (R,); see `heldout_squares`."""
        if judged.effects not in self._known:
            self.workers.tell(f"left-out conditions, {judged.name or 'law as it is'}")
            few = as_seen_at_few(self.few, self.observations, judged.result.law)
            found = heldout_squares(judged.structure, few, judged.result.law.values, self.workers)
            self._known[judged.effects] = found
        return self._known[judged.effects]

    def of_conditions(self, judged: MetricJudged) -> Array:
        """Give the same of each distinct condition, shape (C,)."""
        groups = distinct_conditions(self.observations)
        return np.bincount(groups, weights=self.of_runs(judged)).astype(np.float64)

    def error(self, judged: MetricJudged) -> float:
        """Give the rms log ratio."""
        return root_mean(self.of_runs(judged))


def fewest_numbers(observations: MetricObservations) -> int:
    """Give how many numbers a fit without some of the conditions has at least."""
    return len(METRICS) * min(len(used) for used, _ in folds(distinct_conditions(observations), MOST_FOLDS))


def distinct_conditions(observations: MetricObservations) -> IntArray:
    """Number the distinct conditions, shape (R,): repeats, of which drives miss what was set, are at one.

    The cycles that came before, of which each of repeats has its own number, tell conditions apart where nothing else
    does; where these don't either, each run is one by itself.
    """
    slow = {name: values[:, 0] for name, values in observations.motion.slow.items()}
    places = {name: set_points(values, SAME_KELVIN if name == "T" else np.inf) for name, values in slow.items()}
    cycles = places.pop(OWN_SIGNALS["first_cycle"], None)
    found = _numbered(list(places.values()))
    if not found.max() and cycles is not None:
        found = _numbered([cycles])
    return found if found.max() else np.arange(len(found), dtype=np.intp)


def _numbered(columns: Sequence[IntArray]) -> IntArray:
    """Number the rows that columns of numbers make, shape (R,)."""
    return np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)[1].reshape(-1).astype(np.intp)


def chance(law: MetricJudged, larger: MetricJudged, scatter: Scatter) -> float:
    """Give the chance that scatter alone makes a larger law do so much better (F test)."""
    more = max(larger.parameters - law.parameters, 1)
    return float(of_larger_ratio((law.squares - larger.squares) / more, more, float(scatter.freedoms.min())))


def chance_of_lack(judged: MetricJudged, observations: MetricObservations, smooth: Array, expected: float) -> float:
    """Give the chance that scatter alone makes what a law leaves over: it is too large, or it follows the conditions.

    Args:
        judged: the law.
        observations: what it was fitted to.
        smooth: orthonormal functions of the conditions, shape (R, q).
        expected: share of scatter that was expected.
    """
    if judged.freedoms < 1:
        return 1.0
    logs = judged.residual * observations.relative_error
    allowed = np.hypot(expected, observations.rounding)
    plain = float(np.sum((logs / allowed) ** 2))
    too_large = of_larger_ratio(plain / judged.freedoms, judged.freedoms, EXPECTED_FREEDOMS)
    leverage = _basis(judged, observations).reshape(len(logs), len(METRICS), -1)
    following = np.sum((smooth.T @ judged.residual) ** 2)
    taken = np.sum(np.einsum("rq,rmp->qmp", smooth, leverage) ** 2)
    freedoms = max(smooth.shape[1] * len(METRICS) - taken, 1.0)
    others = max(judged.freedoms - freedoms, 0.0)
    rest = (
        np.sum(judged.residual**2)
        - following
        + EXPECTED_FREEDOMS * np.mean((allowed / observations.relative_error) ** 2)
    )
    follows = of_larger_ratio(
        following / freedoms * (others + EXPECTED_FREEDOMS) / rest, freedoms, others + EXPECTED_FREEDOMS
    )
    return min(1.0, 2 * min(float(too_large), float(follows)))


def single_rows(larger: Fit, without: Structure, observations: MetricObservations) -> tuple[int, ...]:
    """Give the rows without any one of which a law gains little over the one without its last effect.

    Args:
        larger: the law with the effect.
        without: the structure without it.
        observations: what both are fitted to.
    """
    structure, values = larger.law.structure, larger.law.values

    def fits(rows: IntArray) -> tuple[Fit, Fit]:
        part = observations.rows(rows)
        return (
            fit(without, part, start=values, tolerance=CANDIDATE_TOLERANCE),
            fit(structure, part, start=values, tolerance=CANDIDATE_TOLERANCE),
        )

    everything = np.arange(len(observations.dissipated_energy))
    plain, richer = fits(everything)
    whole = plain.cost - richer.cost
    helped = np.sum(observations.residual(plain.law_force) ** 2 - observations.residual(richer.law_force) ** 2, axis=1)
    tried = np.sort(np.argsort(-helped)[:ROWS_TRIED])
    resting = []
    for row in tried:
        plain, richer = fits(np.delete(everything, row))
        if plain.cost - richer.cost < RESTS_ON_SHARE * whole:
            resting.append(int(row))
    return tuple(resting)
