"""Interface forces by brackets: for clamps whose force steps with the velocity, where no secant holds.

A larger force into a clamp leaves it less motion at the end of the step, and a clamp that moves less gives no larger
force: answer(f) falls with f, whatever steps it makes. Between a force and the answer to it, then, lies one that
agrees. It is enclosed clamp by clamp (Brent's method), the others held, over and over until all agree. Where the answer
itself jumps over it (sgn v as such), it is any force between the two that dry friction gives at rest: it agrees too.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from scipy.optimize import brentq

from pipeclamp_system.coupling.broyden import Answer, NotFoundError, SolverTolerance, Vector

MOST_SWEEPS = 40
"""Times that all clamps are gone through."""

MOST_TRIALS_A_SWEEP = 60
"""Of one clamp in one sweep."""

ENCLOSED_SHARE = 1e-14
"""Share of a force to which it is enclosed."""

LOST = 1e9
"""Residual, as a share of the scale, beyond which the unknowns have run away, to where no FMU takes the motion."""


class _AgreedError(Exception):
    """The forces agree: no bracket needs to be narrowed any further."""


def enclosed(answer: Answer, guess: Sequence[float], scale: Sequence[float], tolerance: SolverTolerance) -> Vector:
    """Find f with answer(f) = f, each answer falling with its own unknown.

    Args:
        answer: the function; its last call is the one that agrees.
        guess: where to start.
        scale: of each unknown, by which its residual is measured.
        tolerance: of the residual; its number of trials isn't looked at.

    Returns:
        the last answer; where it jumps, the force that it jumps over.

    Raises:
        NotFoundError: the unknowns don't come to agree.
    """
    unknown, given, error = list(guess), list(guess), inf
    jumps = [False] * len(unknown)

    def tried(index: int, value: float) -> float:
        nonlocal given, error
        unknown[index] = value
        given = answer(list(unknown))
        shares = [abs(a - b) / extent for a, b, extent in zip(given, unknown, scale, strict=True)]
        error = max(shares)
        if error <= tolerance.relative:
            raise _AgreedError
        if not error < LOST:
            raise NotFoundError(error)
        return given[index] - value

    try:
        for _ in range(MOST_SWEEPS):
            before = list(unknown)
            for index in range(len(unknown)):
                begin = unknown[index]
                residual = tried(index, begin)
                end = begin + residual
                if residual * tried(index, end) < 0:
                    found, how = brentq(lambda value, at=index: tried(at, value), begin, end,
                                        xtol=ENCLOSED_SHARE * scale[index], rtol=4 * ENCLOSED_SHARE,
                                        maxiter=MOST_TRIALS_A_SWEEP, full_output=True, disp=False)  # fmt: skip
                    tried(index, float(found))
                    jumps[index] = bool(how.converged)
            moved = [abs(a - b) / extent for a, b, extent in zip(unknown, before, scale, strict=True)]
            off = [abs(a - b) / extent for a, b, extent in zip(given, unknown, scale, strict=True)]
            if max(moved) <= tolerance.relative and all(
                jump or share <= tolerance.relative for jump, share in zip(jumps, off, strict=True)
            ):
                return [own if jump else answered for own, answered, jump in zip(unknown, given, jumps, strict=True)]
    except _AgreedError:
        return given
    raise NotFoundError(error)
