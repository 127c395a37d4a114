"""Broyden's method for interface forces: few unknowns, an expensive function, and a Jacobian that is kept between uses.

Finds f with answer(f) = f. C. G. Broyden, Math. Comp. 19 (1965) 577, in the form that updates the inverse Jacobian. The
systems are small (one unknown per clamp), so plain numbers are faster than arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

Vector = list[float]
Answer = Callable[[Vector], Vector]

SMALLEST_TURN = 0.05
"""An update may enlarge the inverse Jacobian's determinant by at most the inverse of this, and never turn its sign."""

SMALLEST_SCALE = 1e-9
"""Scale of an unknown that has stayed near zero, as a share of the largest one."""


@dataclass(frozen=True)
class SolverTolerance:
    """When the unknowns are found.

    Attributes:
        relative: of the residual, as a share of the largest value that the unknown has had.
        trials: how often the function may be called.
    """

    relative: float
    trials: int


class NotFoundError(Exception):
    """The tolerance wasn't reached; `error` is the residual that is left, as a share."""

    def __init__(self, error: float) -> None:
        super().__init__(f"residual {error:.1e}")
        self.error = error


class Solver:
    """The method's memory: the inverse Jacobian of answer(f) - f and the unknowns' scale."""

    def __init__(self, count: int, tolerance: SolverTolerance) -> None:
        """Start as plain repetition f := answer(f)."""
        self._tolerance = tolerance
        self._inverse = [[-1.0 if row == column else 0.0 for column in range(count)] for row in range(count)]
        self._peaks = [0.0] * count

    def fresh(self) -> Solver:
        """Give one that starts as plain repetition, with the same scale: for steps of other lengths."""
        other = Solver(len(self._peaks), self._tolerance)
        other._peaks = list(self._peaks)
        return other

    def solve(self, answer: Answer, guess: Sequence[float]) -> Vector:
        """Find the unknowns; the last call of `answer` is the one that agrees.

        Args:
            answer: the function.
            guess: where to start.

        Returns:
            the last answer.

        Raises:
            NotFoundError: not within the number of trials.
        """
        unknown = list(guess)
        given = answer(unknown)
        residual = _difference(given, unknown)
        left = self._tolerance.trials - 1
        rejected, share = 0, 1.0
        while True:
            scale = self.scale(given)
            error = _largest(residual, scale)
            if error <= self._tolerance.relative:
                self._peaks = [max(peak, abs(value)) for peak, value in zip(self._peaks, given, strict=True)]
                return given
            if left <= 0 or not isfinite(error):
                raise NotFoundError(error)
            if rejected == 2:  # the secant has lost its way
                self._measure(answer, unknown, residual, scale)
                left -= len(unknown)
            change = [-share * _product(row, residual) for row in self._inverse]
            trial = [value + part for value, part in zip(unknown, change, strict=True)]
            trial_given = answer(trial)
            left -= 1
            trial_residual = _difference(trial_given, trial)
            self._learn(change, _difference(trial_residual, residual))
            if _largest(trial_residual, scale) < error:
                unknown, given, residual = trial, trial_given, trial_residual
                rejected, share = 0, min(1.0, 2 * share)
            else:
                rejected += 1
                # The first time, the secant through a point beyond the kink is a shorter step already.
                share = share / 2 if rejected >= 2 else share

    def scale(self, given: Sequence[float]) -> Vector:
        """Give each unknown's scale: the largest value that it has had, or has now."""
        values = [max(peak, abs(value)) for peak, value in zip(self._peaks, given, strict=True)]
        floor = SMALLEST_SCALE * max(values, default=0.0) or 1.0
        return [max(value, floor) for value in values]

    def _learn(self, change: Vector, effect: Vector) -> None:
        """Correct the inverse Jacobian by Broyden's rank-one update, unless that would make it useless."""
        square = _product(change, change)
        expected = [_product(row, effect) for row in self._inverse]
        turn = _product(change, expected)
        if not (isfinite(turn) and turn > SMALLEST_TURN * square > 0.0):
            return
        columns = range(len(change))
        left = [sum(change[i] * self._inverse[i][column] for i in columns) for column in columns]
        self._inverse = [
            [entry + (part - seen) * value / turn for entry, value in zip(row, left, strict=True)]
            for row, part, seen in zip(self._inverse, change, expected, strict=True)
        ]

    def _measure(self, answer: Answer, unknown: Vector, residual: Vector, scale: Vector) -> None:
        """Find the Jacobian by finite differences."""
        columns = []
        for index, extent in enumerate(scale):
            moved = list(unknown)
            moved[index] += 10 * self._tolerance.relative * extent
            effect = _difference(_difference(answer(moved), moved), residual)
            columns.append([value / (moved[index] - unknown[index]) for value in effect])
        jacobian = np.array(columns).T
        if np.all(np.isfinite(jacobian)) and np.linalg.cond(jacobian) < 1e12:
            self._inverse = np.linalg.inv(jacobian).tolist()


def _difference(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def _product(a: Vector, b: Vector) -> float:
    return sum([x * y for x, y in zip(a, b, strict=True)])


def _largest(residual: Vector, scale: Vector) -> float:
    """Give the largest residual as a share of its scale; infinite where one isn't a number."""
    shares = [abs(value) / extent for value, extent in zip(residual, scale, strict=True)]
    return max(shares, default=0.0) if all(share == share for share in shares) else inf
