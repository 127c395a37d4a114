"""Joint nonlinear least squares of a law to all observations at once, with exact Jacobians."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeclamp_identification.fitting.joint.beforehand import (
    AT_BOUND,
    CLOSE,
    close_to_a_bound,
    parameter_bounds,
    priors_of,
    spreads_of,
    steps_over_a_bound,
)
from pipeclamp_identification.fitting.joint.covariance import covariance_of
from pipeclamp_identification.fitting.joint.evaluator import Evaluator, Remembered, smoothing_of
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.not_fitted import not_fitted
from pipeclamp_identification.fitting.joint.points import linearised, no_force, sized_start, starts_by_effect
from pipeclamp_identification.fitting.joint.starts import SINGULAR_SHARE, kept, most_promising
from pipeclamp_identification.fitting.observations import Observations, data_scales
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_models.law.law import Equations, Law, Structure
from pipeclamp_models.law.outline import ParameterOutline, Sizes, number_in
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import refuse_unknown_conditions

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

FIT_TOLERANCE = 1e-10
MOST_EVALUATIONS = 100
HARDLY_SHOWN = 1e-3
"""Of a parameter that a start hardly shows, its whole size moves the residuals by less than this, in units of their
standard errors."""
BEYOND_REASON = 1e100
"""Residuals in units of their standard errors that no arithmetic can square and sum."""
ALIKE_SHARE = 1e-3
"""Parameters whose shares of an undetermined direction differ by less are alike in it."""
EQUALLY_GOOD = 1e-9
"""Starts whose costs differ by less than this share end in one valley: the last of them is taken, whatever rounding
says."""


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
        UserError: there are fewer observations than free parameters, bounds that follow the tests leave a parameter
            nothing, or the law has no force on the tests at any start.
    """
    equations = structure.equations
    refuse_unknown_conditions(sorted(equations.slow_signals), observations.motion)
    held = structure.held()
    reasons = not_fitted(structure, equations, observations)
    scales = data_scales(observations)
    bounds = _bounds(equations, reasons, scales)
    neutral = equations.neutral_values
    best: tuple[float, Array] | None = None
    given = start or {}
    points = starts_by_effect(structure, given, scales)
    chosen = most_promising(points, lambda at: linearised(structure, observations, at).cost_after_one_step())
    starts = [sized_start(structure, observations, values, kept(values, given)) for values in chosen]
    with one_thread():
        law = Remembered(observations, equations, smoothing_of(observations))
        for attempt, values in enumerate(starts):
            if len(starts) > 1:
                progress(f"fit from start {attempt + 1} of {len(starts)}")
            stay = {name: held.get(name, neutral.get(name, values[name])) for name in reasons}
            begin = _within(bounds, np.array([stay.get(name, values[name]) for name in equations.names]))
            refusal = no_force(structure, observations, law.at(begin))
            if refusal is not None:
                continue
            cost, solution = _minimise(law, begin, frozenset(reasons), bounds, scales, tolerance)
            if best is None or cost <= best[0] * (1 + EQUALLY_GOOD):
                best = cost, solution
        if best is None:
            assert refusal is not None
            raise refusal
        return _finish(structure, law, best[1], reasons, bounds, scales)


def unfitted(structure: Structure, observations: Observations, values: Mapping[str, float]) -> Fit:
    """Give a law with the given values as it stands against observations, nothing fitted.

    Args:
        structure: the law's structure.
        observations: what it is held against.
        values: a value for each parameter; what is missing is neutral, or where its first start is.
    """
    equations = structure.equations
    scales = data_scales(observations)
    first = {one.name: number_in(one.starts[0], scales) for one in equations.parameters}
    chosen = {**first, **equations.neutral_values, **structure.own(values)}
    law = Law(structure, chosen, *smoothing_of(observations))
    law_force = force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), observations.motion)
    residual = observations.residual(law_force)
    return Fit(
        law=law,
        equations=equations,
        fitted=(),
        covariance=np.zeros((0, 0)),
        frozen=not_fitted(structure, equations, observations),
        at_bound={},
        law_force=law_force,
        cost=float(np.sum(residual**2)) / 2,
        spreads=spreads_of(equations, scales),
        room=np.zeros((2, 0)),
    )


def _sizes(parameters: Sequence[ParameterOutline], scales: Sizes) -> Array:
    """Give the size of each parameter, by which it is told whether the data shows it: its spread, else a usual one."""
    return np.array([abs(number_in(one.spread or one.size, scales)) for one in parameters])


def _bounds(equations: Equations, held: Container[str], scales: Sizes) -> tuple[Array, Array]:
    """Give the bounds of each parameter for these tests, shape (P,) each; those that are held have none.

    Raises:
        UserError: bounds that follow the tests leave a parameter nothing.
    """
    free = np.array([name not in held for name in equations.names], dtype=bool)
    lower, upper = parameter_bounds(equations, scales)
    for place in np.flatnonzero(free & ~(lower < upper)):
        raise UserError(
            f"parameter {equations.names[place]}: for these tests its bounds are {lower[place]:g} and "
            f"{upper[place]:g}; expected a lower one below an upper one"
        )
    return np.where(free, lower, -np.inf), np.where(free, upper, np.inf)


def _within(bounds: tuple[Array, Array], begin: Array) -> Array:
    """Give where a fit begins, shape (P,): just inside the bounds, where the solver may step to both sides."""
    within = np.clip(begin, *bounds)
    inside = 1e-9 * np.maximum(1.0, np.abs(within))
    return np.clip(within, bounds[0] + inside, bounds[1] - inside)


def _minimise(
    law: Remembered,
    begin: Array,
    held: frozenset[str],
    bounds: tuple[Array, Array],
    scales: Sizes,
    tolerance: float,
) -> tuple[float, Array]:
    """Minimise from one start within the bounds; give the cost and all values."""
    equations = law.equations
    free = np.array([index for index, name in enumerate(equations.names) if name not in held], dtype=np.intp)
    evaluator = Evaluator(law, begin, free)
    if len(free) == 0:
        residual = evaluator.residual(begin[free])
        return float(residual @ residual) / 2, begin
    lower, upper = (bound[free] for bound in bounds)
    x0 = begin[free]
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

    priors = priors_of(equations, scales)

    def minimise(method: str, values: Array, places: IntArray, at: Array) -> OptimizeResult:
        own, prior = Evaluator(law, values, places), priors.of(places)
        prior_slopes = np.diag(prior.root)
        inside = np.isin(free, places)
        return least_squares(
            lambda point: np.concatenate([own.residual(point), prior.residual(point)]),
            at,
            jac=lambda point: np.concatenate([own.jacobian(point), prior_slopes]),
            bounds=(lower[inside], upper[inside]),
            x_scale="jac",
            method=method,
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=MOST_EVALUATIONS,
        )

    # A step that goes too far may give what no number holds; it counts as huge, and is taken back.
    with np.errstate(over="ignore", invalid="ignore"):
        # What the start hardly shows would take steps of no size, and shorten those of all others: these go first.
        sizes = _sizes(equations.parameters, scales)[free]
        shown = np.linalg.norm(evaluator.jacobian(x0), axis=0) * sizes > HARDLY_SHOWN
        if np.any(shown) and not np.all(shown):
            values = begin.copy()
            values[free] = x0
            x0[shown] = minimise("trf", values, free[shown], x0[shown]).x
        result = minimise("trf", begin, free, x0)
        if result.status == 0:
            # The reflective method creeps along curved valleys between bounds; a plain dogleg walks down them.
            result = minimise("dogbox", begin, free, result.x)
    values = begin.copy()
    values[free] = result.x
    return float(result.cost), values


def _finish(
    structure: Structure,
    law: Remembered,
    values: Array,
    reasons: Mapping[str, str],
    bounds: tuple[Array, Array],
    scales: Sizes,
) -> Fit:
    """Find what is at a bound or undetermined at the solution, and the covariance of the rest."""
    equations = law.equations
    lower, upper = bounds
    frozen = dict(reasons)
    priors = priors_of(equations, scales)
    fitted = np.array([name not in frozen for name in equations.names], dtype=bool)
    held = fitted & close_to_a_bound(values, lower, upper, AT_BOUND)
    close = np.flatnonzero(fitted & ~held & close_to_a_bound(values, lower, upper, CLOSE))
    if len(close):
        evaluator, prior = Evaluator(law, values, close), priors.of(close)
        residual = np.concatenate([evaluator.residual(values[close]), prior.residual(values[close])])
        jacobian = np.concatenate([evaluator.jacobian(values[close]), np.diag(prior.root)])
        held[close] = steps_over_a_bound(values[close], lower[close], upper[close], residual, jacobian)
    nearer = np.where(values - lower < upper - values, lower, upper)
    at_bound = {equations.names[index]: float(nearer[index]) for index in np.flatnonzero(held)}
    free = np.flatnonzero(fitted & ~held)
    spreads = spreads_of(equations, scales)
    roots = priors.root
    while True:
        evaluator = Evaluator(law, values, free)
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
    by_row = residual.reshape(law.observations.motion.y.shape[0], -1)
    return Fit(
        law=Law(structure, dict(zip(equations.names, values.tolist(), strict=True)), *law.smoothing),
        equations=equations,
        fitted=tuple(equations.names[index] for index in free),
        covariance=covariance_of(
            scaled, norms, by_row, law.observations.compared(law_force), roots[free] ** 2, law.observations.runs
        ),
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
