"""Following the solutions of equations along a parameter, round their turning points (pseudo-arclength)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array


class Evaluated(NamedTuple):
    """Residual (m,), its derivatives by the unknowns (m, m) and by the parameter (m,)."""

    residual: Array
    by_unknowns: Array
    by_parameter: Array


@dataclass(frozen=True)
class HarmonicRefinement:
    """How finely unknowns stand for what is sought, solution by solution.

    Attributes:
        asked: how many unknowns a solution at a parameter asks for.
        resized: gives unknowns, or a direction in them, in so many; what is added is 0.
    """

    asked: Callable[[Array, float], int]
    resized: Callable[[Array, int], Array]


@dataclass
class Work:
    """What solving takes, by evaluations and not by time, so that an answer that is cut short is the same everywhere.

    Attributes:
        done: work that is done.
        most: of `done`, beyond which paths are given up and nothing more is sought.
    """

    done: float = 0.0
    most: float = float("inf")

    @property
    def used_up(self) -> bool:
        """Whether nothing more is to be sought."""
        return self.done >= self.most

    @contextmanager
    def at_most(self, further: float) -> Iterator[None]:
        """Allow so much further work inside a block, or what is allowed already."""
        before, self.most = self.most, min(self.most, self.done + further)
        try:
            yield
        finally:
            self.most = before


@dataclass(frozen=True)
class Equation:
    """An equation in unknowns and a parameter.

    Attributes:
        evaluate: what is to vanish, and its derivatives, at unknowns and a parameter.
        refinement: where the number of unknowns follows the solution; else it stays.
        unbounded: tells of a solution that what lies beyond it on a path is of no use: the path ends there.
        work: what evaluating it takes is counted there; where that is used up a path is given up.
    """

    evaluate: Callable[[Array, float], Evaluated]
    refinement: HarmonicRefinement | None = None
    unbounded: Callable[[Array, float], bool] | None = None
    work: Work = field(default_factory=Work)

    def __call__(self, unknowns: Array, parameter: float) -> Evaluated:
        """Evaluate it."""
        return self.evaluate(unknowns, parameter)

    def asked(self, unknowns: Array, parameter: float) -> int:
        """Give how many unknowns a solution asks for."""
        return self.refinement.asked(unknowns, parameter) if self.refinement else unknowns.size

    def resized(self, vector: Array, size: int) -> Array:
        """Give unknowns, or a direction in them, in so many."""
        return self.refinement.resized(vector, size) if self.refinement and vector.size != size else vector


@dataclass(frozen=True)
class Steps:
    """How a path is followed; lengths are shares of the parameter's range and of the unknowns' size.

    Attributes:
        first: the first step.
        shortest: below it the path is given up.
        longest: no step is longer.
        widest: nor goes farther in the parameter, as a share of it.
        most: no path has more points.
        work: nor takes more, as of `Work`: about a minute and a half.
        tolerance: of the unknowns, as a share of their size.
    """

    first: float = 0.01
    shortest: float = 1e-6
    longest: float = 0.08
    widest: float = float("inf")
    most: int = 1500
    work: float = 4e6
    tolerance: float = 1e-6


CORRECTIONS = 10
QUICK = 4
"""Newton corrections after which a step is given up, and up to which the next one may be longer."""

STRAIGHT_COSINE = 0.7
"""Cosine of the angle by which a path may turn in a step: what turns by more may have left it for another, and so may
what changes its side."""

CAREFUL = 2e-3
"""Steps that are shorter may turn by more, or change sides: there a path can have a kink, or be crossed."""

CROSSING_HALVINGS = 3
CROSSING_STEPS = (0.02, 0.05, 0.1)
"""How often the piece of a path that another crosses is halved, and how far from there the other is looked for, as
shares of the unknowns' size: the first at which it is found."""

PASSING_HALVINGS = 30
BESIDE_SHARE, SAME_UNKNOWNS_SHARE = 0.25, 1e-4
"""Where a path passes a parameter: how often it is halved, how far from the straight line between two of its points it
is looked for, as a share of their distance, and what difference is none, as a share of the unknowns' size."""


@dataclass(frozen=True)
class Solution:
    """A solution.

    Attributes:
        parameter: the parameter.
        unknowns: the unknowns there, (m,).
        side: of a path, the sign of the determinant of all derivatives with its direction as the last row: it changes
            where another path crosses, not where the path turns. 0: not told.
    """

    parameter: float
    unknowns: Array
    side: int = 0


_Corrected = tuple[Solution, Array, Array, int]
"""A point of a path, the derivatives next to it, and how many corrections it took."""

_Refined = tuple[_Corrected, int]
"""The same in as many unknowns as the point asks for or more, and how many that are."""


def solve(equation: Equation, guess: Array, parameter: float, size: float, tolerance: float = 1e-8) -> Array | None:
    """Solve at one parameter by Newton's method from a guess, in as many unknowns as the solution asks for.

    None where it doesn't get there.
    """
    found = _solved(equation, guess, parameter, size, tolerance)
    while found is not None and (asked := equation.asked(found, parameter)) > found.size:
        found = _grown(equation, found, asked, parameter, size, tolerance)
    return found


def _grown(
    equation: Equation, found: Array, asked: int, parameter: float, size: float, tolerance: float
) -> Array | None:
    """Solve in more unknowns than a solution has: in as many as are asked for, else in half of what is added."""
    while (guess := equation.resized(found, asked)).size > found.size:
        finer = _solved(equation, guess, parameter, size, tolerance)
        if finer is not None:
            return finer
        asked = (found.size + guess.size) // 2
    return None


def _solved(equation: Equation, guess: Array, parameter: float, size: float, tolerance: float) -> Array | None:
    """Solve in as many unknowns as the guess has."""
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


def between(equation: Equation, before: Solution, after: Solution, parameter: float) -> Array | None:
    """Give the unknowns where a path passes a parameter between two of its points; None where it isn't found.

    A solution that is farther from the straight line between them than the path can be belongs to something else: the
    path is then halved.
    """
    size = max(before.unknowns.size, after.unknowns.size)
    ends = [Solution(end.parameter, equation.resized(end.unknowns, size)) for end in (before, after)]
    for _ in range(PASSING_HALVINGS):
        one, other = ends
        span, chord = other.parameter - one.parameter, other.unknowns - one.unknowns
        largest = float(np.abs([one.unknowns, other.unknowns]).max())
        near = BESIDE_SHARE * float(np.abs(chord).max()) + SAME_UNKNOWNS_SHARE * largest
        guess = one.unknowns + (parameter - one.parameter) / span * chord
        # Where forces step, corrections can run away from the line and come home from an end of it.
        for start in (guess, one.unknowns, other.unknowns):
            found = _solved(equation, start, parameter, largest, Steps.tolerance)
            if found is not None and np.abs(found - guess).max() <= near:
                return solve(equation, found, parameter, largest)
        scales = np.append(np.full(chord.size, largest), abs(span))
        direction = np.append(chord, span) / scales
        length = float(np.linalg.norm(direction))
        middle = _corrected(equation, one, direction / length, length / 2, scales, Steps.tolerance)
        if middle is None:
            return None
        halves = middle[0]
        if halves.parameter == parameter:
            return solve(equation, halves.unknowns, parameter, largest)
        passed = (one.parameter - parameter) * (halves.parameter - parameter) < 0
        ends = [one, halves] if passed else [halves, other]
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
        the start and then points of the path. The last one lies on an end of the range or is unbounded, unless the path
        was given up.
    """
    steps = steps or Steps()
    span = end - start.parameter
    step, point, largest = steps.first, start, size
    _, by_unknowns, by_parameter = equation(start.unknowns, start.parameter)
    ahead = _direction(by_unknowns, by_parameter, largest, span)
    ahead = ahead if ahead[-1] > 0 else -ahead
    finer: tuple[Solution, Array] | None = None
    towards, came = ahead, np.zeros(start.unknowns.size)
    point = replace(start, side=_side(by_unknowns, by_parameter, ahead, largest, span))
    yield point
    enough = equation.work.done + steps.work
    for _ in range(steps.most):
        if equation.work.used_up or equation.work.done > enough:
            return
        scales = np.append(np.full(point.unknowns.size, largest), span)
        if steps.widest * abs(point.parameter) < step * abs(ahead[-1] * span):
            step = steps.widest * abs(point.parameter) / abs(ahead[-1] * span)
        found = _corrected(equation, point, towards, step, scales, steps.tolerance)
        fitted = None if found is None else _refined(equation, point, towards, step, scales, found, steps.tolerance)
        if fitted is not None:
            (there, by_unknowns, by_parameter, corrections), asked = fitted
            largest = max(largest, float(np.abs(there.unknowns).max()))
            before = equation.resized(towards[:-1], there.unknowns.size)
            onwards = _direction(by_unknowns, by_parameter, largest, span)
            turn = float(onwards @ np.append(before, towards[-1]))
            onwards = onwards if turn > 0 else -onwards
            side = _side(by_unknowns, by_parameter, onwards, largest, span)
        if fitted is None or ((abs(turn) < STRAIGHT_COSINE or side != point.side) and step > CAREFUL):
            if finer is not None:
                (point, ahead), finer = finer, None
                towards = ahead
                continue
            step /= 2
            if step < steps.shortest:
                came = equation.resized(came, point.unknowns.size)
                if towards is not ahead or not came.any():
                    return
                towards, step = _held(came), CAREFUL
            continue
        last, point, ahead = point, replace(there, side=side), onwards
        towards, came = ahead, point.unknowns - equation.resized(last.unknowns, point.unknowns.size)
        if corrections <= QUICK:
            step = min(1.5 * step, steps.longest)
        share = (point.parameter - start.parameter) / span
        if not 0 <= share <= 1:
            edge = end if share > 1 else start.parameter
            at_edge = between(equation, last, point, edge)
            if at_edge is not None:
                yield Solution(edge, at_edge, last.side)
            return
        yield point
        if equation.unbounded and equation.unbounded(point.unknowns, point.parameter):
            return
        finer = None
        if asked < point.unknowns.size:  # from here on fewer will do, or else the path goes on from as many
            finer = point, ahead
            point = replace(point, unknowns=equation.resized(point.unknowns, asked))
            ahead = np.append(equation.resized(ahead[:-1], asked), ahead[-1])
            ahead = ahead / np.linalg.norm(ahead)
            towards = ahead


def _held(came: Array) -> Array:
    """Give the direction in which the unknowns came, with the parameter held: it leads round a kink where a path turns.

    No point of the path lies ahead there, but the unknowns go on.
    """
    return np.append(came / np.linalg.norm(came), 0.0)


def _direction(by_unknowns: Array, by_parameter: Array, largest: float, span: float) -> Array:
    """Give the direction of a path, along which the residual doesn't change, in scaled unknowns, (m + 1,)."""
    scales = np.append(np.full(by_parameter.size, largest), span)
    return np.asarray(np.linalg.svd(np.column_stack([by_unknowns, by_parameter]) * scales)[2][-1])


def _side(by_unknowns: Array, by_parameter: Array, ahead: Array, largest: float, span: float) -> int:
    """Give `Solution.side` of a path with a direction in scaled unknowns, (m + 1,)."""
    scales = np.append(np.full(by_parameter.size, largest), span)
    bordered = np.vstack([np.column_stack([by_unknowns, by_parameter]) * scales, ahead])
    return int(np.linalg.slogdet(bordered)[0] * np.sign(span))


def crossing(equation: Equation, before: Solution, after: Solution) -> Solution | None:
    """Give a point of the path that crosses another one between two of its points; None where none is found.

    Between them the other path must not turn. Where they cross the derivatives by the unknowns have a direction in
    which the residual doesn't change; there, at a right angle to it, the path that crosses is met again.
    """
    low, high = before, after
    for _ in range(CROSSING_HALVINGS):
        parameter = (low.parameter + high.parameter) / 2
        unknowns = between(equation, low, high, parameter)
        if unknowns is None:
            return None
        middle = Solution(parameter, unknowns)
        if _sign(equation, middle) == _sign(equation, low):
            low = middle
        else:
            high = middle
    scales = np.append(np.full(low.unknowns.size, np.abs(low.unknowns).max()), abs(low.parameter))
    by_unknowns = equation(low.unknowns, low.parameter).by_unknowns
    across = np.append(np.linalg.svd(by_unknowns)[2][-1], 0.0)
    for step in CROSSING_STEPS:
        found = _corrected(equation, low, across, step, scales, Steps.tolerance)
        fitted = None if found is None else _refined(equation, low, across, step, scales, found, Steps.tolerance)
        if fitted is not None:
            return fitted[0][0]
    return None


def _sign(equation: Equation, solution: Solution) -> float:
    """Give the sign of the determinant of the derivatives by the unknowns."""
    return float(np.linalg.slogdet(equation(solution.unknowns, solution.parameter).by_unknowns)[0])


def _refined(
    equation: Equation, point: Solution, ahead: Array, step: float, scales: Array, found: _Corrected, tolerance: float
) -> _Refined | None:
    """Give a point of the path in as many unknowns as it asks for; arguments as of `_corrected`, and what it gave."""
    result: _Corrected | None = found
    while result is not None:
        there = result[0]
        asked = equation.asked(there.unknowns, there.parameter)
        if asked <= there.unknowns.size:
            return result, asked
        point = Solution(point.parameter, equation.resized(point.unknowns, asked))
        ahead = np.append(equation.resized(ahead[:-1], asked), ahead[-1])
        scales = np.append(np.full(asked, scales[0]), scales[-1])
        guess = np.append(equation.resized(there.unknowns, asked), there.parameter)
        result = _corrected(equation, point, ahead, step, scales, tolerance, guess)
    return None


def _corrected(
    equation: Equation,
    point: Solution,
    tangent: Array,
    step: float,
    scales: Array,
    tolerance: float,
    guess: Array | None = None,
) -> _Corrected | None:
    """Go a step along the tangent and back to the path at a right angle to it, or there from a guess (m + 1,).

    Returns:
        the point, the derivatives next to it, and how many corrections it took; None where it wasn't found.
    """
    begin = np.append(point.unknowns, point.parameter)
    place, last = begin + step * tangent * scales if guess is None else guess, 0.0
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
