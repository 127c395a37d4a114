"""Joint nonlinear least squares of a law to all observations at once, with exact Jacobians."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from pipeclamp_identification.fitting.beforehand import (
    AT_BOUND,
    CLOSE,
    close_to_a_bound,
    parameter_bounds,
    priors_of,
    spreads_of,
    steps_over_a_bound,
)
from pipeclamp_identification.fitting.covariance import covariance_of
from pipeclamp_identification.fitting.groups import Groups
from pipeclamp_identification.fitting.observations import Observations, data_scales
from pipeclamp_identification.fitting.starts import (
    SINGULAR_SHARE,
    Linearised,
    Values,
    combined,
    kept,
    most_promising,
    sized,
    starts_of_effects,
)
from pipeclamp_identification.signals.levels import count_levels
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.base.units import grows_with_force
from pipeclamp_models.law.law import Equations, Law, Structure, find_base, scaled_in, smoothing
from pipeclamp_models.law.outline import ParameterOutline, Sizes, number_in
from pipeclamp_models.realise.force import LawForce, force_of_equations
from pipeclamp_models.realise.motion import refuse_unknown_conditions

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

FIT_TOLERANCE = 1e-10
HELD = "held by the law's structure"
WISHED = "held by wish"
DENIED = "at rest before the tests there is no such force"
MOST_EVALUATIONS = 100
BEYOND_REASON = 1e100
"""Residuals in units of their standard errors that no arithmetic can square and sum."""
ALIKE_SHARE = 1e-3
"""Parameters whose shares of an undetermined direction differ by less are alike in it."""
EQUALLY_GOOD = 1e-9
"""Starts whose costs differ by less than this share end in one valley: the last of them is taken, whatever rounding
says."""
STRONG_CORRELATION = 0.95


@dataclass(frozen=True)
class Fit:
    """A fitted law with its uncertainty.

    Attributes:
        law: structure and values.
        equations: the composed law.
        fitted: names of the fitted parameters, in the order of `covariance`.
        covariance: shape (fitted, fitted).
        frozen: why a parameter was held, by name.
        at_bound: parameters that ended at a bound, each with that bound.
        law_force: force (R, n) and Jacobian at the solution.
        cost: half the sum of squared weighted residuals, without the priors'.
        spreads: standard deviations of the priors, by parameter; those that have none are not in it.
        room: from each fitted parameter down and up to its bounds, shape (2, fitted).
        groups: columns of texts by which the runs differ beside the law, or may; what they do is no part of it.
    """

    law: Law
    equations: Equations
    fitted: tuple[str, ...]
    covariance: Array
    frozen: Mapping[str, str]
    at_bound: Mapping[str, float]
    law_force: LawForce
    cost: float
    spreads: Mapping[str, float]
    room: Array
    groups: tuple[Groups, ...] = ()

    @property
    def places(self) -> IntArray:
        """Places of the fitted parameters among all of the law's."""
        place = {name: index for index, name in enumerate(self.equations.names)}
        return np.array([place[name] for name in self.fitted], dtype=np.intp)

    @property
    def precision(self) -> Array:
        """One over the variance of the fitted parameters' priors, zero where there is none, shape (fitted,)."""
        return np.array([self.spreads.get(name, math.inf) ** -2.0 for name in self.fitted])

    @property
    def from_priors(self) -> Array:
        """How far the fitted parameters lie from the means of their priors, shape (fitted,)."""
        means = {parameter.name: parameter.neutral or 0.0 for parameter in self.equations.parameters}
        return np.array([self.law.values[name] - means[name] for name in self.fitted])

    def standard_errors(self) -> dict[str, float]:
        """Give the standard error of each fitted parameter by name."""
        return dict(zip(self.fitted, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def strong_correlations(self) -> list[tuple[str, str, float]]:
        """Give the pairs of parameters whose correlation exceeds `STRONG_CORRELATION`, strongest first."""
        scale = np.sqrt(np.diag(self.covariance))
        correlation = self.covariance / np.outer(scale, scale)
        pairs = [
            (self.fitted[i], self.fitted[j], float(np.clip(correlation[i, j], -1, 1)))
            for i, j in itertools.combinations(range(len(self.fitted)), 2)
            if abs(correlation[i, j]) > STRONG_CORRELATION
        ]
        return sorted(pairs, key=lambda pair: -abs(pair[2]))


@dataclass
class _Remembered:
    """The law's force and Jacobian at values of its parameters; remembers the last two evaluations.

    Two, for a step that is tried and refused leaves the fit at the point before.
    """

    observations: Observations
    equations: Equations
    smoothing: tuple[float, float]
    _known: dict[bytes, LawForce] = field(default_factory=dict)

    def at(self, values: Array) -> LawForce:
        """Give force and Jacobian at values in the order of the equations' parameters."""
        key = values.tobytes()
        if key not in self._known:
            while len(self._known) > 1:
                del self._known[next(iter(self._known))]
            self._known[key] = force_of_equations(
                self.equations, values, self.smoothing, self.observations.motion, derivatives=True
            )
        return self._known[key]


@dataclass(frozen=True)
class _Evaluator:
    """The law's weighted residuals as a function of the free parameters, the others at their values."""

    law: _Remembered
    values: Array
    free: IntArray

    @property
    def observations(self) -> Observations:
        """What the law is held against."""
        return self.law.observations

    def law_force(self, free_values: Array) -> LawForce:
        """Give force and Jacobian for values of the free parameters."""
        values = self.values.copy()
        values[self.free] = free_values
        return self.law.at(values)

    def residual(self, free_values: Array) -> Array:
        """Give the weighted residuals, flat; values beyond all reason count as huge, not as NaN."""
        residual = self.observations.residual(self.law_force(free_values))
        return np.nan_to_num(residual, nan=1e6, posinf=1e6, neginf=-1e6).ravel()

    def jacobian(self, free_values: Array) -> Array:
        """Give the residuals' derivatives by the free parameters, shape (residuals, free)."""
        slopes = self.observations.residual_slopes(self.law_force(free_values), self.free)
        return np.nan_to_num(slopes.reshape(len(self.free), slopes.shape[1] * slopes.shape[2]).T)


def undetermined(equations: Equations, observations: Observations) -> dict[str, str]:
    """Give the parameters that the data can't determine, with the reason.

    Nothing uses them, their condition doesn't vary, or they make a constant force, which forces at rest deny.
    """
    reasons: dict[str, str] = {}
    for parameter in equations.parameters:
        if not parameter.used:
            reasons[parameter.name] = "the law has nothing that it scales"
            continue
        if parameter.at_rest and observations.deny_constant_force:
            reasons[parameter.name] = DENIED
            continue
        for signal in parameter.follows:
            values = observations.motion.slow.get(signal)
            if signal in observations.motion.assumed:
                reasons[parameter.name] = f"{signal} isn't known"
            elif values is None or not np.all(np.isfinite(values)):
                reasons[parameter.name] = f"{signal} isn't known in every run"
            elif (count := count_levels(signal, values)) < parameter.levels:
                reasons[parameter.name] = (
                    f"{signal} doesn't vary in the data" if count == 1 else f"{signal} has {count} levels only"
                )
    return reasons


def _reasons(structure: Structure, equations: Equations, observations: Observations) -> dict[str, str]:
    """Give the parameters that aren't fitted, with the reason: held by the base's form, by wish, or undetermined."""
    fixed = find_base(structure.base).fixed
    held = {name: HELD if fixed.get(name) == value else WISHED for name, value in structure.held().items()}
    return {**undetermined(equations, observations), **{name: held[name] for name in held if name in equations.names}}


def fit(
    structure: Structure,
    observations: Observations,
    *,
    start: Mapping[str, float] | None = None,
    tolerance: float = FIT_TOLERANCE,
    progress: Progress = silent,
) -> Fit:
    """Fit all parameters of a law jointly.

    Args:
        structure: the law's structure; parameters that its base or `frozen` hold stay there.
        observations: what is fitted.
        start: values to start from, by name; the other parameters start where their effects say. Without a value here,
            an effect with several starts is tried from each of them, see `most_promising`. So is one with values here
            that an effect without values scales: without that one it may have come to a valley of its own.
        tolerance: relative change of cost or parameters below which the fit ends.
        progress: is told what is being done.

    Returns:
        The best fit over all starts, of equally good ones the last.

    Raises:
        UserError: there are fewer observations than free parameters.
    """
    equations = structure.equations
    refuse_unknown_conditions(sorted(equations.slow_signals), observations.motion)
    held = structure.held()
    reasons = _reasons(structure, equations, observations)
    scales = data_scales(observations)
    neutral = {parameter.name: _neutral(parameter, scales) for parameter in equations.parameters}
    A, f = observations.motion.slow["A"], observations.motion.slow["f"]
    smooth = smoothing(float(np.min(A)), float(np.min(f)))
    best: tuple[float, Array] | None = None
    given = start or {}
    choices = _choices(structure, given, scales)
    chosen = most_promising(choices, lambda at: linearised(structure, observations, at).cost_after_one_step())
    starts = [sized_start(structure, observations, values, kept(values, given)) for values in chosen]
    with one_thread():
        law = _Remembered(observations, equations, smooth)
        for attempt, values in enumerate(starts):
            if len(starts) > 1:
                progress(f"fit from start {attempt + 1} of {len(starts)}")
            begin = np.array(
                [held.get(name, neutral[name]) if name in reasons else values[name] for name in equations.names]
            )
            cost, solution = _minimise(law, begin, frozenset(reasons), scales, tolerance)
            if best is None or cost <= best[0] * (1 + EQUALLY_GOOD):
                best = cost, solution
        assert best is not None
        return _finish(structure, law, best[1], reasons, scales)


def starting_points(
    structure: Structure, observations: Observations, given: Mapping[str, float]
) -> list[dict[str, float]]:
    """Give the points that a fit starts from, each effect's in combination; see `fit`."""
    return combined(_choices(structure, given, data_scales(observations)))


def _choices(structure: Structure, given: Mapping[str, float], scales: Sizes) -> list[list[Values]]:
    """Give the points that each effect starts from: given values, the effect's own starts, or both; see `fit`."""
    equations = structure.equations
    stated = starts_of_effects(equations, given, scales)
    new = {parameter.effect for parameter in equations.parameters if parameter.name not in given}
    if not new or not given:  # then no effect has to be looked up, which loads the mathematics
        return stated
    scaled = set().union(*(scaled_in(structure, effect) for effect in structure.all_effects() if effect.name in new))
    anew = {name: value for name, value in given.items() if name not in scaled}
    return [
        [*points, *(point for point in own if point not in points)]
        for points, own in zip(stated, starts_of_effects(equations, anew, scales), strict=True)
    ]


def sized_start(
    structure: Structure, observations: Observations, start: Mapping[str, float], known: Collection[str]
) -> Mapping[str, float]:
    """Give a start with each effect that isn't known as large as the data ask for; see `sized`.

    Args:
        structure: the law's structure.
        observations: what is fitted.
        start: a value for each parameter.
        known: names of the parameters whose values are known.
    """
    of_effects = _unsized(structure, observations, known)
    return sized(start, linearised(structure, observations, start), known, of_effects) if of_effects else start


def sized_and_linearised(
    structure: Structure, observations: Observations, start: Mapping[str, float], known: Collection[str]
) -> tuple[Mapping[str, float], Linearised]:
    """Give a start with each effect that isn't known as large as the data ask for, and the law linearised there.

    Arguments as for `sized_start`.
    """
    there = linearised(structure, observations, start)
    of_effects = _unsized(structure, observations, known)
    larger = sized(start, there, known, of_effects) if of_effects else start
    return (start, there) if larger == start else (larger, linearised(structure, observations, larger))


def _unsized(structure: Structure, observations: Observations, known: Collection[str]) -> list[list[str]]:
    """Give, for each effect that isn't known, the parameters that its force is in proportion to, if it has others.

    Where the residuals aren't linear in the force, one step doesn't tell how large it is: none then.
    """
    if not observations.are_linear:
        return []
    held = structure.held()
    found = []
    for _, group in itertools.groupby(structure.equations.parameters, key=lambda parameter: parameter.effect):
        parameters = [one for one in group if one.name not in known and one.name not in held]
        sizes = [one.name for one in parameters if grows_with_force(one.unit)]
        if sizes and len(parameters) > 1:  # the size of a single one is a fit's first step
            found.append(sizes)
    return found


def linearised(structure: Structure, observations: Observations, values: Mapping[str, float]) -> Linearised:
    """Give a law's residuals at a point, linearised.

    Args:
        structure: the law's structure.
        observations: what it would be fitted to.
        values: the point, a value for each parameter.
    """
    equations = structure.equations
    out = set(structure.held()) | set(undetermined(equations, observations))
    free = np.array([index for index, name in enumerate(equations.names) if name not in out], dtype=np.intp)
    A, f = observations.motion.slow["A"], observations.motion.slow["f"]
    smooth = smoothing(float(np.min(A)), float(np.min(f)))
    begin = np.array([structure.held().get(name, values[name]) for name in equations.names])
    evaluator = _Evaluator(_Remembered(observations, equations, smooth), begin, free)
    with one_thread():
        residual, jacobian = evaluator.residual(begin[free]), evaluator.jacobian(begin[free])
    return Linearised(tuple(equations.names[index] for index in free), residual, jacobian)


def unfitted(structure: Structure, observations: Observations, values: Mapping[str, float]) -> Fit:
    """Give a law with the given values as it stands against observations, nothing fitted.

    Args:
        structure: the law's structure.
        observations: what it is held against.
        values: a value for each parameter; what is missing is neutral.
    """
    equations = structure.equations
    scales = data_scales(observations)
    chosen = {
        parameter.name: values.get(parameter.name, _neutral(parameter, scales)) for parameter in equations.parameters
    }
    A, f = observations.motion.slow["A"], observations.motion.slow["f"]
    law = Law(structure, chosen, *smoothing(float(np.min(A)), float(np.min(f))))
    law_force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), observations.motion)
    residual = observations.residual(law_force)
    return Fit(
        law=law,
        equations=equations,
        fitted=(),
        covariance=np.zeros((0, 0)),
        frozen=_reasons(structure, equations, observations),
        at_bound={},
        law_force=law_force,
        cost=float(np.sum(residual**2)) / 2,
        spreads=spreads_of(equations, scales),
        room=np.zeros((2, 0)),
    )


def _neutral(parameter: ParameterOutline, scales: Sizes) -> float:
    return parameter.neutral if parameter.neutral is not None else number_in(parameter.starts[0], scales)


def _minimise(
    law: _Remembered,
    begin: Array,
    held: frozenset[str],
    scales: Sizes,
    tolerance: float,
) -> tuple[float, Array]:
    """Minimise from one start; give the cost and all values."""
    equations = law.equations
    free = np.array([index for index, name in enumerate(equations.names) if name not in held], dtype=np.intp)
    evaluator = _Evaluator(law, begin, free)
    if len(free) == 0:
        residual = evaluator.residual(begin[free])
        return float(residual @ residual) / 2, begin
    lower, upper = (bound[free] for bound in parameter_bounds(equations, scales))
    x0 = np.clip(begin[free], lower, upper)
    inside = 1e-9 * np.maximum(1.0, np.abs(x0))
    x0 = np.clip(x0, lower + inside, upper - inside)
    if len(evaluator.residual(x0)) < len(free):
        raise UserError(
            f"{len(evaluator.residual(x0))} observations can't determine {len(free)} parameters; "
            "expected at least as many: add runs, or leave effects out"
        )
    if not np.max(np.abs(evaluator.residual(x0))) < BEYOND_REASON:
        raise UserError(
            f"the law gives forces beyond all reason at {dict(zip(equations.names, begin.tolist(), strict=True))}; "
            "expected held values of the size that the tests show"
        )

    # What only holds a law against tests does without it: it takes as long to load as all the rest.
    from scipy.optimize import least_squares

    prior = priors_of(equations, scales).of(free)
    prior_slopes = np.diag(prior.root)

    def minimise(method: str, at: Array) -> OptimizeResult:
        return least_squares(
            lambda point: np.concatenate([evaluator.residual(point), prior.residual(point)]),
            at,
            jac=lambda point: np.concatenate([evaluator.jacobian(point), prior_slopes]),
            bounds=(lower, upper),
            x_scale="jac",
            method=method,
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=MOST_EVALUATIONS,
        )

    # A step that goes too far may give what no number holds; it counts as huge, and is taken back.
    with np.errstate(over="ignore", invalid="ignore"):
        result = minimise("trf", x0)
        if result.status == 0:
            # The reflective method creeps along curved valleys between bounds; a plain dogleg walks down them.
            result = minimise("dogbox", result.x)
    values = begin.copy()
    values[free] = result.x
    return float(result.cost), values


def _finish(
    structure: Structure,
    law: _Remembered,
    values: Array,
    reasons: Mapping[str, str],
    scales: Sizes,
) -> Fit:
    """Find what is at a bound or undetermined at the solution, and the covariance of the rest."""
    equations = law.equations
    lower, upper = parameter_bounds(equations, scales)
    frozen = dict(reasons)
    priors = priors_of(equations, scales)
    fitted = np.array([name not in frozen for name in equations.names], dtype=bool)
    held = fitted & close_to_a_bound(values, lower, upper, AT_BOUND)
    close = np.flatnonzero(fitted & ~held & close_to_a_bound(values, lower, upper, CLOSE))
    if len(close):
        evaluator, prior = _Evaluator(law, values, close), priors.of(close)
        residual = np.concatenate([evaluator.residual(values[close]), prior.residual(values[close])])
        jacobian = np.concatenate([evaluator.jacobian(values[close]), np.diag(prior.root)])
        held[close] = steps_over_a_bound(values[close], lower[close], upper[close], residual, jacobian)
    nearer = np.where(values - lower < upper - values, lower, upper)
    at_bound = {equations.names[index]: float(nearer[index]) for index in np.flatnonzero(held)}
    free = np.flatnonzero(fitted & ~held)
    spreads = spreads_of(equations, scales)
    roots = priors.root
    while True:
        evaluator = _Evaluator(law, values, free)
        jacobian = evaluator.jacobian(values[free])
        norms = np.linalg.norm(jacobian, axis=0)
        norms[norms < SINGULAR_SHARE * roots[free]] = 0.0
        scaled = jacobian / np.where(norms > 0, norms, 1.0)
        _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
        if len(free) == 0 or (np.all(norms > 0) and singular[-1] > SINGULAR_SHARE * singular[0]):
            break
        weak = int(np.argmin(norms)) if np.any(norms == 0) else _last_of_largest(np.abs(directions[-1]))
        frozen[equations.names[free[weak]]] = "the data doesn't determine it"
        free = np.delete(free, weak)
    residual = evaluator.residual(values[free])
    law_force = evaluator.law_force(values[free])
    by_run = residual.reshape(law.observations.motion.y.shape[0], -1)
    return Fit(
        law=Law(structure, dict(zip(equations.names, values.tolist(), strict=True)), *law.smoothing),
        equations=equations,
        fitted=tuple(equations.names[index] for index in free),
        covariance=covariance_of(scaled, norms, by_run, law.observations.compared(law_force), roots[free] ** 2),
        frozen=frozen,
        at_bound=at_bound,
        law_force=law_force,
        cost=float(residual @ residual) / 2,
        spreads=spreads,
        room=np.stack([lower[free] - values[free], upper[free] - values[free]]),
    )


def _last_of_largest(shares: Array) -> int:
    """Give the last of the largest entries: rounding mustn't choose between parameters that only show together."""
    return int(np.flatnonzero(shares > (1 - ALIKE_SHARE) * shares.max())[-1])
