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
    best = list(evaluate(begins))
    radii = [RADIUS] * len(problems)
    spent = [1] * len(problems)
    open_ones = [index for index, found in enumerate(best) if found is not None]
    while open_ones:
        trials, promised = [], {}
        for index in open_ones:
            at = best[index]
            assert at is not None
            step = _step(problems[index], at, radii[index]) if spent[index] < problems[index].most else None
            if step is None:
                continue
            gain = at.squared - float(np.sum((at.residual + at.jacobian @ step) ** 2))
            if gain > max(tolerance * at.squared, negligible):
                promised[index] = gain, float(np.abs(step / problems[index].scale).max())
                trials.append((index, at.values + step, at.state))
        open_ones = []
        for (index, *_), found in zip(trials, evaluate(trials) if trials else (), strict=True):
            spent[index] += 1
            at = best[index]
            assert at is not None
            gain, length = promised[index]
            gained = at.squared - found.squared if found is not None else -np.inf
            if gained < POOR * gain:
                radii[index] = SHORTER * length
            elif gained > GOOD * gain and length > GOOD * radii[index]:
                radii[index] *= LENGTHENING
            if gained > 0:
                best[index] = found
            if gained > max(tolerance * at.squared, negligible) or (gained <= 0 and radii[index] > SMALLEST_RADIUS):
                open_ones.append(index)
    return best


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
