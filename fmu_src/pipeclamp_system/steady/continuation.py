"""Following the solutions of equations along a parameter, round their turning points (pseudo-arclength)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array

Equation = Callable[[Array, float], tuple[Array, Array, Array]]
"""(unknowns (m,), parameter) -> residual (m,), its derivatives by the unknowns (m, m) and by the parameter (m,)."""


@dataclass(frozen=True)
class Steps:
    """How a path is followed; lengths are shares of the parameter's range and of the unknowns' size.

    Attributes:
        first: the first step.
        shortest: below it the path is given up.
        longest: no step is longer.
        most: no path has more points.
        tolerance: of the unknowns, as a share of their size.
    """

    first: float = 0.01
    shortest: float = 1e-6
    longest: float = 0.08
    most: int = 1500
    tolerance: float = 1e-6


CORRECTIONS = 10
QUICK = 4
"""Newton corrections after which a step is given up, and up to which the next one may be longer."""


@dataclass(frozen=True)
class Solution:
    """A solution: the parameter and the unknowns there, (m,)."""

    parameter: float
    unknowns: Array


def solve(equation: Equation, guess: Array, parameter: float, size: float, tolerance: float = 1e-8) -> Array | None:
    """Solve at one parameter by Newton's method from a guess; None where it doesn't get there."""
    unknowns, last = guess.copy(), 0.0
    for _ in range(3 * CORRECTIONS):
        residual, by_unknowns, _ = equation(unknowns, parameter)
        try:
            change = np.linalg.solve(by_unknowns, -residual)
        except np.linalg.LinAlgError:
            return None
        if not np.all(np.isfinite(change)):
            return None
        unknowns += change
        largest = float(np.abs(change).max())
        if _missing(largest, last) <= tolerance * max(size, float(np.abs(unknowns).max())):
            return unknowns
        last = largest
    return None


def _missing(correction: float, before: float) -> float:
    """Give what a solution still lacks after corrections of these sizes: the rest of their geometric series.

    Of corrections that don't shrink, or of a first one, its own size.
    """
    return correction**2 / (before - correction) if correction < before else correction


def follow(
    equation: Equation, start: Solution, end: float, size: float, steps: Steps | None = None
) -> Iterator[Solution]:
    """Follow a path of solutions from a start until it leaves the parameter's range.

    Args:
        equation: what is solved.
        start: a solution; its parameter is one end of the range.
        end: the other end.
        size: of the unknowns; grows with the largest that the path meets.

    Yields:
        the start and then points of the path. The last one lies on an end of the range, unless the path was given up.
    """
    steps = steps or Steps()
    span = end - start.parameter
    step, point, largest = steps.first, start, size
    _, by_unknowns, by_parameter = equation(start.unknowns, start.parameter)
    previous: Array | None = None
    yield start
    for _ in range(steps.most):
        largest = max(largest, float(np.abs(point.unknowns).max()))
        scales = np.append(np.full(point.unknowns.size, largest), span)
        # The path's direction is the one along which the residual doesn't change.
        tangent = np.linalg.svd(np.column_stack([by_unknowns, by_parameter]) * scales)[2][-1]
        onwards = tangent[-1] if previous is None else tangent @ previous
        tangent = tangent if onwards > 0 else -tangent
        found = None
        while found is None:
            found = _corrected(equation, point, tangent, step, scales, steps.tolerance)
            if found is None:
                step /= 2
                if step < steps.shortest:
                    return
        before, previous = point, tangent
        point, by_unknowns, by_parameter, corrections = found
        if corrections <= QUICK:
            step = min(1.5 * step, steps.longest)
        share = (point.parameter - start.parameter) / span
        if not 0 <= share <= 1:
            edge = end if share > 1 else start.parameter
            part = (edge - before.parameter) / (point.parameter - before.parameter)
            guess = before.unknowns + part * (point.unknowns - before.unknowns)
            last = solve(equation, guess, edge, largest, steps.tolerance)
            if last is not None:
                yield Solution(edge, last)
            return
        yield point


def _corrected(
    equation: Equation, point: Solution, tangent: Array, step: float, scales: Array, tolerance: float
) -> tuple[Solution, Array, Array, int] | None:
    """Go a step along the tangent and back to the path at a right angle to it.

    Returns:
        the point, the derivatives next to it, and how many corrections it took; None where it wasn't found.
    """
    begin = np.append(point.unknowns, point.parameter)
    place, last = begin + step * tangent * scales, 0.0
    for correction in range(1, CORRECTIONS + 1):
        residual, by_unknowns, by_parameter = equation(place[:-1], float(place[-1]))
        ahead = float(tangent @ ((place - begin) / scales)) - step
        matrix = np.vstack([np.column_stack([by_unknowns, by_parameter]) * scales, tangent])
        if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(residual))):
            return None
        try:
            change = np.linalg.solve(matrix, -np.append(residual, ahead))
        except np.linalg.LinAlgError:
            return None
        place = place + change * scales
        largest = float(np.abs(change).max())
        if largest > 3 * step:
            return None
        if _missing(largest, last) <= tolerance:
            return Solution(float(place[-1]), place[:-1]), by_unknowns, by_parameter, correction
        last = largest
    return None
