"""Least squares of several problems in lock step, so that what is dear is evaluated for all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.optimize import lsq_linear

from pipeclamp_models.base.arrays import Array

State = TypeVar("State")

RADIUS = 2.0
"""Of the first step at most, in each parameter's scale."""
POOR, GOOD = 0.25, 0.75
"""Shares of the promised gain below which steps become shorter, and above which longer ones are allowed."""
SHORTER, LENGTHENING = 0.25, 2.5
SMALLEST_RADIUS = 1e-4


@dataclass(frozen=True, eq=False)
class LeastSquares(Generic[State]):
    """One problem.

    Attributes:
        begin: values to begin from, (p,).
        lower, upper: bounds, (p,).
        scale: by which each value changes much, (p,).
        near: the state that the first evaluation begins from.
        most: evaluations at most.
    """

    begin: Array
    lower: Array
    upper: Array
    scale: Array
    near: State
    most: int


@dataclass(frozen=True, eq=False)
class Evaluated(Generic[State]):
    """A problem at some values: state, residual (n,) and its derivatives (n, p)."""

    values: Array
    state: State
    residual: Array
    jacobian: Array

    @property
    def squared(self) -> float:
        """Sum of squares of the residual."""
        return float(self.residual @ self.residual)


Evaluate = Callable[[Sequence[tuple[int, Array, State]]], Sequence[Evaluated[State] | None]]
"""Evaluates problems, by number, at values, each near a state; None where there is no value."""


def fit_together(
    problems: Sequence[LeastSquares[State]], evaluate: Evaluate[State], tolerance: float, negligible: float = 0.0
) -> list[Evaluated[State] | None]:
    """Give the values of least squares, by Gauss-Newton steps within boxes; None where there is no value to begin with.

    Args:
        problems: what is solved.
        evaluate: gives residuals and derivatives.
        tolerance: a problem is done where no more than this share of its squares is to be gained,
        negligible: or where no more than this is.
    """
    begins = [(index, problem.begin, problem.near) for index, problem in enumerate(problems)]
    searches = {
        index: _Search(problems[index], found) for index, found in enumerate(evaluate(begins)) if found is not None
    }
    going_on = list(searches)
    while going_on:
        least = {index: max(tolerance * searches[index].best.squared, negligible) for index in going_on}
        trials = {index: trial for index in going_on if (trial := searches[index].trial(least[index])) is not None}
        asked = [
            (index, searches[index].best.values + trial.step, searches[index].best.state)
            for index, trial in trials.items()
        ]
        found = evaluate(asked) if asked else ()
        going_on = [
            index
            for (index, trial), one in zip(trials.items(), found, strict=True)
            if searches[index].goes_on(trial, one, least[index])
        ]
    return [searches[index].best if index in searches else None for index in range(len(problems))]


@dataclass(frozen=True, eq=False)
class _Trial:
    """A step that is tried: the step (p,), the gain in squares that it promises, its length in the values' scales."""

    step: Array
    gain: float
    length: float


@dataclass(eq=False)
class _Search(Generic[State]):
    """How far the search of one problem has come: the best so far, the trust region's radius, evaluations spent."""

    problem: LeastSquares[State]
    best: Evaluated[State]
    radius: float = RADIUS
    spent: int = 1

    def trial(self, least: float) -> _Trial | None:
        """Give the next step; None where it promises no more than the least gain, or no evaluation is left."""
        if self.spent >= self.problem.most:
            return None
        step = _step(self.problem, self.best, self.radius)
        if step is None:
            return None
        gain = self.best.squared - float(np.sum((self.best.residual + self.best.jacobian @ step) ** 2))
        return _Trial(step, gain, float(np.abs(step / self.problem.scale).max())) if gain > least else None

    def goes_on(self, trial: _Trial, found: Evaluated[State] | None, least: float) -> bool:
        """Take what came of a step, and tell whether another one may gain more than the least."""
        self.spent += 1
        gained = self.best.squared - found.squared if found is not None else -np.inf
        if gained < POOR * trial.gain:
            self.radius = SHORTER * trial.length
        elif gained > GOOD * trial.gain and trial.length > GOOD * self.radius:
            self.radius *= LENGTHENING
        if found is not None and gained > 0:
            self.best = found
        return gained > least or (gained <= 0 and self.radius > SMALLEST_RADIUS)


def _step(problem: LeastSquares[State], at: Evaluated[State], radius: float) -> Array | None:
    """Give the step of least squares of the linearised problem, within bounds and radius; None where none is left."""
    reach = radius * problem.scale
    lower = np.maximum(problem.lower - at.values, -reach)
    upper = np.minimum(problem.upper - at.values, reach)
    if not np.all(lower < upper):
        return None
    found = lsq_linear(
        at.jacobian * problem.scale, -at.residual, (lower / problem.scale, upper / problem.scale), method="bvls"
    )
    return np.asarray(np.clip(found.x * problem.scale, lower, upper))
