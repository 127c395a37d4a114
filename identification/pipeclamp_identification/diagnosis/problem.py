"""A diagnosis's data, prepared once, and the evidence of each law that is held against it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.diagnosis.evidence import LackOfFit, drifts, lack_of_fit
from pipeclamp_identification.diagnosis.left_out import LeftOutScore, Whitened, WithoutGroups, whitened
from pipeclamp_identification.diagnosis.noise import UNSEEN_VARIANCE, NoiseModel, WhitenedObservations, noise_model
from pipeclamp_identification.diagnosis.objections import objections, of_groups, reservations
from pipeclamp_identification.diagnosis.run_scatter import ScatterAxes, of_a_shift
from pipeclamp_identification.fitting.group_factors import GroupFactors
from pipeclamp_identification.fitting.groups import Groups, factors_of, find_groups
from pipeclamp_identification.fitting.heldout import condition_groups, further_groups, kept_at_ends, share_of_force
from pipeclamp_identification.fitting.identify import fit_structure
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.points import linearised
from pipeclamp_identification.fitting.least_squares import fit, unfitted
from pipeclamp_identification.fitting.observations import (
    LoopObservations,
    as_seen_at_few,
    coarser,
    loop_observations,
    points_enough,
)
from pipeclamp_identification.fitting.smooth_trends import smooth_basis
from pipeclamp_identification.loops.loops import Loops, by_stretch
from pipeclamp_identification.signals.real_harmonics import mean_squares_of
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import LawForce

CLOSELY = 1e-5
"""Tolerance of a candidate's fit: a step that gains less is far below what any verdict asks."""
NEARBY_TOLERANCE = 1e-4
"""Tolerance of a fit to all points of the cycle that begins where the fit to few of them ended."""
ROUGHLY = 1e-4
"""Tolerance of the fits that only tell the best of several starts, or of several pairs."""
VALLEYS = 2
"""Starts from which an effect is fitted, those that promise most: the error has valleys between them."""


@dataclass(frozen=True)
class Problem:
    """The data of a diagnosis.

    Attributes:
        loops: one row a run; one a run and stretch of cycles where the law, or the stiffness, changes along them.
        harmonics: the same, as they were measured.
        few: the same for rough fits, whose laws are evaluated at few points of the cycle: as the law as it is shows
            them there. A jump of force between two of few points is no physics, and can be many times the noise.
        noise: the noise model.
        smooth: smooth functions of the conditions, (R, q).
        groups: (amplitude, frequency) group of each row.
        further_groups: other groups that are left out to see how laws foretell them, by name.
        discrepancy: variance of each harmonic part that the laws' form is granted besides the noise, N2. Where the
            best law misses far more than noise, noise alone would let the quietest harmonics rule.
        factors: random factors of groups that differ beside their conditions; None where none do.
    """

    loops: Loops
    harmonics: LoopObservations
    few: LoopObservations
    noise: NoiseModel
    smooth: Array
    groups: IntArray
    further_groups: Mapping[str, IntArray]
    discrepancy: float = 0.0
    factors: GroupFactors | None = None

    @cached_property
    def observations(self) -> WhitenedObservations:
        """What laws are fitted to: whitened by noise and discrepancy."""
        return WhitenedObservations(self.harmonics, self.noise.whitener(self.discrepancy), self.factors)

    @cached_property
    def coarse(self) -> WhitenedObservations:
        """The same for rough fits: laws are evaluated at fewer points."""
        return WhitenedObservations(self.few, self.noise.whitener(self.discrepancy), self.factors)

    @cached_property
    def against_noise(self) -> WhitenedObservations:
        """What lack of fit is told from: whitened by the noise alone."""
        return WhitenedObservations(self.harmonics, self.noise.whitener(), self.factors)

    def plain_residual(self, law_force: LawForce) -> Array:
        """Give measured less law in N, what factors of groups explain left aside, shape (R, m)."""
        plain = self.harmonics.plain_residual(law_force)
        if self.factors is None:
            return plain
        values = self.observations.factors_beside(law_force)
        return np.asarray(plain - self.factors.beside(law_force).force(values))

    def groups_beside(self, law_force: LawForce) -> tuple[Groups, ...]:
        """Find the groups that differ beside a law."""
        return find_groups(self.loops, self.harmonics, law_force)

    @cached_property
    def ends(self) -> dict[str, BoolArray]:
        """Tell of each further condition which runs are at its ends, and left out with their A and f; shape (R,)."""
        return {name: ends & (self.groups >= 0) for name, ends in kept_at_ends(self.loops).items()}

    @cached_property
    def scatter_squares(self) -> Array:
        """Mean square of each run's error that scatter alone makes, N2, shape (R,)."""
        variance = np.where(self.noise.variance < UNSEEN_VARIANCE, self.noise.total_variance(), 0.0)
        return mean_squares_of(np.sqrt(variance))

    @cached_property
    def axes(self) -> ScatterAxes:
        """How each run's error scatters."""
        model = self.noise
        noise = mean_squares_of(np.sqrt(np.where(model.variance < UNSEEN_VARIANCE, model.variance, 0.0)))
        return model.scatter.axes(model.directions, model.stretches, noise)

    def excess_squares(self, score: LeftOutScore) -> Array:
        """Give the mean square of each run's error less what scatter makes of it, N2, shape (R,)."""
        return np.asarray(score.mean_squares - self.scatter_squares)

    @cached_property
    def directed(self) -> tuple[Array, ...]:
        """Changes of force that are looked for one by one, against the noise, in d directions each, shape (d, R, m).

        Stiffness and damping that follow one condition each; and a mean force that is the same in all runs.
        """
        constant = np.zeros((1, *self.noise.variance.shape))
        constant[0, :, 0] = 1.0
        changes = (*self.noise.share_trends(self.loops), constant)
        return tuple(np.einsum("rij,drj->dri", self.against_noise.whitener, change) for change in changes)


@dataclass(frozen=True)
class Judged:
    """A law, refitted jointly, with its evidence.

    Attributes:
        effects: what was added to the law as it is.
        result: the fit; its force holds no derivatives.
        fitted: whitened residuals and derivatives at the fit.
        score: how it foretells groups that were left out.
        lack: what it leaves over.
        missing: what is missing on left-out groups, N2: the mean square of the error beyond scatter, and at least of
            what follows the conditions in the fit to all, summed over the runs.
        heldout_nrmse: error on left-out groups as a share of the force, scatter included.
        heldout_by: the same for other groups that were left out (temperatures, specimens, further conditions).
        over_range: the same over all levels of each further condition: runs at its ends, which are never left out with
            their level, count as left out with their A and f.
        objections: why it can't be named, in words; empty where nothing speaks against it.
        reservations: why it can't be named as the cause, in words.
        akaike: Akaike's criterion of the fit to all data: squares, what free means cost, two per parameter.
    """

    effects: tuple[str, ...]
    result: Fit
    fitted: Whitened
    score: LeftOutScore
    lack: LackOfFit
    missing: float
    heldout_nrmse: float
    heldout_by: Mapping[str, float]
    over_range: Mapping[str, float]
    objections: tuple[str, ...]
    reservations: tuple[str, ...]
    akaike: float

    def squares_by_run(self, loops: Loops) -> Array:
        """Give the squared whitened residuals of each record, its cycles together, left out with its group."""
        records = np.unique(loops.run, return_inverse=True)[1]
        return np.bincount(records, weights=self.score.squares).astype(np.float64)

    @property
    def may_be_cause(self) -> bool:
        """Whether nothing speaks against naming it as the cause."""
        return not self.objections and not self.reservations

    @property
    def squares(self) -> float:
        """Sum of squared whitened residuals on left-out groups."""
        return float(self.score.squares.sum())


class Prepared(NamedTuple):
    """A diagnosis's data, and the law as it is fitted in N, without weights; see `prepare`."""

    problem: Problem
    in_newtons: Fit


def prepare(structure: Structure, loops: Loops, start: Mapping[str, float] | None = None) -> Prepared:
    """Fit the law as it is in N, which leaves least over, and estimate the noise.

    Args:
        structure: the law's structure.
        loops: the tests.
        start: values to start from, by name, where they are known.
    """
    loops = by_stretch(loops) if structure.equations.ages or drifts(loops) else loops
    harmonics = loop_observations(loops, points_enough(loops))
    first = fit_structure(structure, loops, harmonics, start=start, tolerance=CLOSELY)
    factors = factors_of(first.groups, loops, harmonics)
    residual = harmonics.plain_residual(first.law_force)
    if factors is not None:
        residual = residual - factors.beside(first.law_force).force()
    noise = noise_model(loops, of_a_shift(first.law, harmonics.motion, harmonics.transformed), residual)
    groups = condition_groups(loops)
    few = _as_seen_at_few(coarser(loops, harmonics), harmonics, first)
    problem = Problem(loops, harmonics, few, noise, smooth_basis(loops), groups, further_groups(loops), factors=factors)
    return Prepared(problem, first)


def weighed_for(problem: Problem, best: Fit) -> Problem:
    """Estimate noise and discrepancy with the best law so far: the better it is, the less physics hides in them."""
    residual = problem.plain_residual(best.law_force)
    shifted = of_a_shift(best.law, problem.harmonics.motion, problem.harmonics.transformed)
    again = noise_model(problem.loops, shifted, residual)
    noise = replace(again, scatter=again.scatter.least(problem.noise.scatter))
    seen = problem.harmonics.seen
    # Also of what no scatter makes: where scatter could make all of the size, the form may still be another one.
    excess = (residual**2 - noise.total_variance(), noise.no_scatter(residual) ** 2 - noise.noise_and_mean())
    factors = factors_of(problem.groups_beside(best.law_force), problem.loops, problem.harmonics)
    discrepancy = max(0.0, *(float(one[seen].sum()) / np.count_nonzero(seen) for one in excess))
    return replace(problem, noise=noise, discrepancy=discrepancy, factors=factors)


def weighed_again(problem: Problem, structure: Structure, best: Fit, starts: Sequence[Fit]) -> tuple[Problem, Judged]:
    """Weigh the data by noise and discrepancy as the best law so far shows them, and judge a law by that.

    Args:
        problem: the data.
        structure: of the law that is judged.
        best: the best law so far.
        starts: fits from whose values the law starts, most promising first.
    """
    weighed = weighed_for(problem, best)
    law = judge((), structure, [start.law.values for start in starts], weighed)
    return replace(weighed, few=_as_seen_at_few(weighed.few, weighed.harmonics, law.result)), law


def _as_seen_at_few(few: LoopObservations, harmonics: LoopObservations, law: Fit) -> LoopObservations:
    """Give what was measured as few points of the cycle show it, as a fitted law has it."""
    at_few = unfitted(law.law.structure, few, law.law.values).law_force
    return as_seen_at_few(few, harmonics, (at_few, law.law_force))


def judge(
    effects: tuple[str, ...],
    structure: Structure,
    starts: Sequence[Mapping[str, float]],
    problem: Problem,
    tolerance: float = CLOSELY,
) -> Judged:
    """Fit a structure to the problem and gather the evidence.

    Args:
        effects: what the structure has beyond the law as it is.
        structure: what is fitted.
        starts: values to start from, most promising first.
        problem: the data.
        tolerance: of the fit.
    """
    start = starts[0] if len(starts) == 1 else roughly(structure, starts, problem).values
    if structure.equations.states:
        start = fit(structure, problem.coarse, start=start, tolerance=tolerance).law.values
        tolerance = max(tolerance, NEARBY_TOLERANCE)
    result = fit(structure, problem.observations, start=start, tolerance=tolerance)
    fitted = whitened(result, problem.observations)
    against_noise = whitened(result, problem.against_noise, fitted.factors) if problem.discrepancy else fitted
    without = WithoutGroups(result, problem.observations, problem.coarse, fitted)
    score = without.score(problem.groups)
    left_out = problem.groups >= 0
    plain = problem.plain_residual(result.law_force)
    lack = lack_of_fit(
        against_noise, plain, problem.noise, problem.smooth, problem.directed, problem.loops.scatter_rms_N
    )
    beyond = float(problem.excess_squares(score)[left_out].sum())
    heldout_by, over_range = _further_errors(without, score, problem)
    price = _price_of_free_means(result, problem)
    return Judged(
        effects=effects,
        result=replace(result, law_force=replace(result.law_force, jacobian=None)),
        fitted=fitted,
        score=replace(score, squares=score.squares + price, axes=problem.axes),
        lack=lack,
        missing=max(beyond, lack.excess * np.count_nonzero(left_out)),
        heldout_nrmse=share_of_force(score.mean_squares, problem.loops, left_out),
        heldout_by=heldout_by,
        over_range=over_range,
        objections=objections(effects, result),
        reservations=(*reservations(effects, result), *of_groups(effects, structure, problem.factors)),
        akaike=2 * result.cost + float(price.sum()) + 2 * len(result.fitted),
    )


def _further_errors(
    without: WithoutGroups, score: LeftOutScore, problem: Problem
) -> tuple[dict[str, float], dict[str, float]]:
    """Give a law's errors on other groups that are left out, and over all levels of further conditions; see `Judged`.

    Args:
        without: the law's fit, prepared for leaving groups out.
        score: how it foretells the groups of A and f.
        problem: the data.
    """
    scores = {name: without.score(groups) for name, groups in problem.further_groups.items()}
    heldout_by = {
        name: share_of_force(scores[name].mean_squares, problem.loops, groups >= 0)
        for name, groups in problem.further_groups.items()
    }
    over_range = {}
    for name, ends in problem.ends.items():
        squares = np.where(ends, score.mean_squares, scores[name].mean_squares)
        over_range[name] = share_of_force(squares, problem.loops, ends | (problem.further_groups[name] >= 0))
    return heldout_by, over_range


class RoughFit(NamedTuple):
    """Where a rough fit ended: all of the law's parameters, and the cost."""

    values: Mapping[str, float]
    cost: float


def roughly(structure: Structure, starts: Sequence[Mapping[str, float]], problem: Problem) -> RoughFit:
    """Fit a structure roughly from the most promising starts; give the best."""
    rough = [fit(structure, problem.coarse, start=start, tolerance=ROUGHLY) for start in starts[:VALLEYS]]
    best = min(rough, key=lambda result: result.cost)
    return RoughFit(best.law.values, best.cost)


def most_promising_first(
    structure: Structure, observations: WhitenedObservations, starts: Sequence[Mapping[str, float]]
) -> list[Mapping[str, float]]:
    """Order values to start from by what one step of linear least squares promises from each."""
    return sorted(starts, key=lambda start: linearised(structure, observations, start).cost_after_one_step())


@dataclass(frozen=True)
class Contender:
    """A law to be judged: what it has beyond the law as it is, its structure, and values to start from.

    Starts are ordered, most promising first; `tolerance` is that of its fit.
    """

    effects: tuple[str, ...]
    structure: Structure
    starts: Sequence[Mapping[str, float]]
    tolerance: float = CLOSELY


def judge_each(contenders: Sequence[Contender], problem: Problem, workers: Workers) -> list[Judged]:
    """Judge laws side by side.

    Args:
        contenders: the laws.
        problem: the data.
        workers: share the laws out, and tell which is done.

    Returns:
        what came of each, in the same order.
    """
    return workers.each(
        partial(_judged, problem),
        contenders,
        lambda one: f"fitted {' and '.join(one.effects) or 'the law as it is'}",
    )


def _judged(problem: Problem, one: Contender) -> Judged:
    return judge(one.effects, one.structure, one.starts, problem, one.tolerance)


def _price_of_free_means(result: Fit, problem: Problem) -> Array:
    """Give what it costs each run that a law leaves the mean force of runs open, shape (R,).

    An element that never slips keeps whatever mean force it began with, so such a run's mean is no evidence against it.
    But a law that could have any mean foretells none: the means count as random, of the size that they turn out to
    have, and the logarithm of that size over what the residuals are weighed by is the price, as in any likelihood.
    """
    open_means = problem.harmonics.open_means(result.law_force)
    price = np.zeros(len(open_means))
    if open_means.any():
        off = problem.harmonics.off_in_mean(result.law_force)
        noise = problem.noise.variance[:, 0] + problem.discrepancy
        size = float(np.mean(off[open_means] ** 2))
        price[open_means] = (np.log1p(size / noise) + off**2 / (size + noise))[open_means]
    return price
