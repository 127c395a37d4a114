"""The motion from which a response is followed: out of rest, out of springs in the clamps' place, or out of a march."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.steady.continuation import Equation, Evaluated, Solution, Steps, follow, solve
from pipeclamp_system.steady.driven import STICKING, DrivenPipe
from pipeclamp_system.steady.equivalent import equivalent
from pipeclamp_system.steady.harmonics import (
    DOUBTFUL_SHARE,
    FEWEST_HARMONICS,
    SMALLEST_MOTION_MM,
    SPARE,
    TRUNCATED,
    left_out,
    packed,
    resized,
)
from pipeclamp_system.steady.truncation import truncated_at

SAME_MOTION_SHARE = 0.01
"""Share of a motion that was marched by which a balanced one may be off it and still be the same."""


def begun(pipe: DrivenPipe, frequency: float) -> Array | None:
    """Find the unknowns at a frequency where a response may begin; None where nothing near the motion is balanced.

    Where what grows out of rest isn't found, or strays, it is sought next to the motion to which a march comes.
    """
    found = grown(pipe, frequency)
    if found is None or (pipe.rubbing and not pipe.stated_harmonics and _strays(pipe, found, frequency)):
        return settled(pipe, frequency)
    return found


def _strays(pipe: DrivenPipe, unknowns: Array, frequency: float) -> bool:
    return truncated_at(pipe, unknowns, frequency, pipe.excitation(frequency)) > DOUBTFUL_SHARE


def settled(pipe: DrivenPipe, frequency: float) -> Array | None:
    """Find the unknowns at a frequency next to the motion to which a march from rest comes."""
    marched = pipe.in_time.at(frequency, pipe.excitation(frequency))
    if marched is None or marched.round != 1:
        return None
    motion = marched.points[: pipe.clamps]
    asked = max(FEWEST_HARMONICS, int(np.argmax(left_out(marched.points) <= SPARE * TRUNCATED)))
    H = pipe.stated_harmonics or min(asked, pipe.most_harmonics)
    guess = packed(resized(motion, H + 1)[None])[0]
    size = float(pipe.sizes(guess[None])[0])
    found = solve(pipe.over_frequency(), guess, frequency, size)
    if found is None:
        return None
    near, there = (resized(one, H + 1) for one in (motion, pipe.unpacked(found[None])[0]))
    return found if np.abs(near - there).max() <= SAME_MOTION_SHARE * size else None


def grown(pipe: DrivenPipe, frequency: float) -> Array | None:
    """Find the unknowns at a frequency by letting the excitation grow from nothing.

    Where a law has no slope at rest, or takes hold at once as a clearance does, no path may lead away from there:
    then springs and dashpots, as stiff as the clamps on the motion that they make, turn into the clamps.
    """
    if not pipe.clamps:
        return np.zeros(0)
    found = _grown_from_rest(pipe, frequency)
    return _turned_from_springs(pipe, frequency) if found is None else found


def _turned_from_springs(pipe: DrivenPipe, frequency: float) -> Array | None:
    """Find the unknowns at a frequency by turning springs and dashpots into the clamps, under the whole drive."""
    at, drive = np.array([frequency]), np.array([pipe.excitation(frequency)])
    more = STICKING if pipe.rubbing and not pipe.stated_harmonics else 1
    responses = pipe.responses(at, min(more * pipe.harmonics, pipe.most_harmonics))
    springs = equivalent(pipe.forces, responses[0, : pipe.clamps], -1j * float(drive[0]), at)
    if springs is None:
        return None
    guess, stiffness = springs
    size = float(np.abs(guess).max())

    def equation(unknowns: Array, share: float) -> Evaluated:
        whole, by_unknowns, _ = pipe.linearised(unknowns, at, drive, responses, rubbing=True)
        rows = pipe.unpacked(np.vstack([np.zeros(unknowns.size), np.eye(unknowns.size)]))
        forces = stiffness[None, :, None] * rows
        forces[:, :, 0] = forces[:, :, 0].real
        loaded = packed(pipe.under_forces(forces, drive, responses[:, : pipe.clamps]))
        springs = np.eye(unknowns.size) - (loaded[1:] - loaded[0]).T
        linear = springs @ unknowns - loaded[0]
        by_both = share * by_unknowns + (1 - share) * springs
        return Evaluated(share * whole + (1 - share) * linear, by_both, whole - linear)

    turning = Equation(equation, work=pipe.work)
    begin = solve(turning, packed(guess[None])[0], 0.0, size)
    if begin is None:
        return None
    path = list(follow(turning, Solution(0.0, begin), 1.0, size, Steps(longest=0.2)))
    if path[-1].parameter != 1.0:
        return None
    found = solve(pipe.over_frequency(), path[-1].unknowns, frequency, size)
    return None if found is None else with_sides(pipe, found, frequency)


def _grown_from_rest(pipe: DrivenPipe, frequency: float) -> Array | None:
    """Find the unknowns at a frequency by letting the excitation grow from nothing."""
    linear = pipe.excitation(frequency) * float(np.abs(pipe.responses(np.array([frequency]))[0, :, 0, 1]).max())
    at_rest = solve(pipe.over_level(frequency), np.zeros(pipe.size), 0.0, SMALLEST_MOTION_MM)
    if at_rest is None:
        return None
    path = list(follow(pipe.over_level(frequency), Solution(0.0, at_rest), 1.0, 0.1 * linear, Steps(longest=0.2)))
    if path[-1].parameter != 1.0:
        return None
    return with_sides(pipe, path[-1].unknowns, frequency)


def with_sides(pipe: DrivenPipe, unknowns: Array, frequency: float) -> Array | None:
    """Give a solution that `over_level` led to as `over_frequency` has it; None where it isn't found.

    They differ where a force steps: the harmonics that it makes beyond H count over frequency only. So it is sought
    in few, and in as many as were needed so far where that fails.
    """
    if not pipe.rubbing:
        return unknowns
    size = float(pipe.sizes(unknowns[None])[0])
    for count in sorted({min(pipe.size, unknowns.size), unknowns.size}):
        found = solve(pipe.over_frequency(), pipe.in_so_many(unknowns, count), frequency, size)
        if found is not None:
            return found
    return None
