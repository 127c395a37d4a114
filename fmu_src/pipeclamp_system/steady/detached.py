"""Branches of a frequency response besides the curve that its ends lead to.

Those that leave a curve begin where they cross it: where a symmetric motion becomes unstable, a pair of less symmetric
ones does, each the other's mirror image, of which one stands for both. Those that nothing joins to the rest inside its
range, closed ones mostly, are found where the excitation's level joins them to the response that is known: from one of
its states, with the frequency held, the level is raised or lowered until the path comes back to the level that is asked
for, elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import cycle, islice, pairwise

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.progress import Progress, silent
from pipeclamp_system.steady.balance import OVER_FREQUENCY, SteadySystem
from pipeclamp_system.steady.continuation import Solution, Steps, crossing, follow, solve
from pipeclamp_system.steady.harmonics import TRUNCATED, packed
from pipeclamp_system.steady.start import grown, with_sides
from pipeclamp_system.steady.states import SteadyState

HIGHEST_LEVEL = 4.0
"""Levels up to which, of the one that is asked for, the excitation is raised."""

FREQUENCIES_SOUGHT = 12
"""Frequencies at which branches are sought, evenly spread inside the range."""

SAME_STATE_SHARE = 1e-3
"""States whose unknowns differ by less, as a share of their size, are one; in other harmonics what these may
move is added."""

LOOKS = 10
"""States of a branch at which it is held against those that are known."""

MOST_HALVES = 20
"""No branch passes its first frequency more often."""

PATH_STEPS = Steps(first=0.05, longest=0.2)


def leaving_branches(
    system: SteadySystem, known: Sequence[Sequence[SteadyState]], first: float, last: float
) -> tuple[tuple[SteadyState, ...], ...]:
    """Follow the branches that leave pieces of a frequency response inside its range, and those that leave these.

    Args:
        system: pipe and clamps under their sine.
        known: the pieces of the response that are known.
        first, last: ends of the range, Hz.

    What is found before the system's work is used up is given.
    """
    found: list[tuple[SteadyState, ...]] = []
    waiting = list(known)
    while waiting:
        for before, after in pairwise(waiting.pop(0)):
            if system.work.used_up:
                return tuple(found)
            if before.side * after.side >= 0 or any(_ends_between(system, one, before, after) for one in found):
                continue
            start = crossing(system.over_frequency(), *(_solution(state) for state in (before, after)))
            if start is None or not first < start.parameter < last:
                continue
            met = (one for piece in [*known, *found] for one in system.solutions(piece, start.parameter))
            if not any(_same(system, start.unknowns, one) for one in met):
                branch = _followed(system, start, first, last)
                if _is_known(system, branch, [*known, *found]):
                    continue
                found.append(branch)
                waiting.append(branch[1:-1])  # at its ends it crosses what it leaves
    return tuple(found)


def _ends_between(system: SteadySystem, branch: Sequence[SteadyState], before: SteadyState, after: SteadyState) -> bool:
    """Tell whether a branch leaves a curve between two of its states, no farther from it than these are apart.

    The curve is taken for straight there: where a branch leaves it, no solver tells the two of them apart.
    """
    for last_three in (branch[:3], branch[:-4:-1]):
        end = meeting(system, [_solution(state) for state in last_three])
        if (before.frequency - end.parameter) * (after.frequency - end.parameter) > 0:
            continue
        here, first, last = system.matched([end.unknowns, *(_solution(one).unknowns for one in (before, after))])
        share = (end.parameter - before.frequency) / ((after.frequency - before.frequency) or 1.0)
        there = first + share * (last - first)
        if np.abs(here - there).max() <= np.abs(last - first).max():
            return True
    return False


def meeting(system: SteadySystem, points: Sequence[Solution]) -> Solution:
    """Give where a branch meets the symmetric motions, from its last points, the end first.

    A branch that meets them ends beyond, at its mirror image. Where they meet, frequency and symmetric part change with
    the square of what is lopsided (a pitchfork's normal form); the two points before the end tell both.
    """
    unknowns = system.matched([point.unknowns for point in points])
    lopsided = [system.lopsided(one) for one in unknowns]
    symmetric = [
        np.append(one - off, point.parameter) for one, off, point in zip(unknowns, lopsided, points, strict=True)
    ]
    end, *before = symmetric
    if len(before) == 2 and lopsided[0] @ lopsided[1] < 0:
        near, far = (float(off @ off) for off in lopsided[1:])
        end = before[0] - (before[1] - before[0]) * near / (far - near) if far > near else before[0]
    return Solution(float(end[-1]), end[:-1])


def _solution(state: SteadyState) -> Solution:
    return Solution(state.frequency, packed(state.balanced[None])[0])


def detached_branches(
    system: SteadySystem,
    known: Sequence[Sequence[SteadyState]],
    first: float,
    last: float,
    leaving: Sequence[Sequence[SteadyState]] = (),
    *,
    over_levels: bool = True,
    tell: Progress = silent,
) -> tuple[tuple[SteadyState, ...], ...]:
    """Seek branches that a frequency response isn't joined to in its range.

    Args:
        system: pipe and clamps under their sine.
        known: the pieces of the response that are known, from whose states others are sought.
        first, last: ends of the range, Hz.
        leaving: further ones that are known, from which none is sought: that would take as long again.
        over_levels: whether they are sought from those that are known; else only where none is, out of rest.
        tell: told at which frequency they are sought.

    What is found before the system's work is used up is given.
    """
    found: list[tuple[SteadyState, ...]] = []
    if not system.clamps:  # without laws all is linear
        return ()
    for frequency in np.linspace(first, last, FREQUENCIES_SOUGHT + 2)[1:-1].tolist():
        if system.work.used_up:
            break
        tell(f"branches apart, at {frequency:.4g} Hz")
        waiting = [unknowns for piece in [*known, *found] for unknowns in system.solutions(piece, frequency)]
        # Where a response that was given up has a gap, it begins at rest.
        unseen = [] if waiting else [start for start in [grown(system, frequency)] if start is not None]
        met = [*waiting, *(unknowns for piece in leaving for unknowns in system.solutions(piece, frequency))]
        while (waiting or unseen) and not system.work.used_up:
            while unseen and not system.work.used_up:
                branch = _followed(system, Solution(frequency, unseen[0]), first, last)
                crossed = [unseen[0], *system.solutions(branch, frequency)]
                unseen = _others(system, unseen, crossed)
                waiting += crossed
                met += crossed
                if not _is_known(system, branch, [*known, *leaving, *found]):
                    found.append(branch)
            if not over_levels:
                break
            if waiting:
                unseen = _others(system, list(_joined(system, waiting.pop(), frequency)), met)
    return tuple(found)


def _is_known(system: SteadySystem, branch: Sequence[SteadyState], pieces: Sequence[Sequence[SteadyState]]) -> bool:
    """Tell whether most of a branch lies on pieces, which a path that cuts a corner may have left and met again."""
    looked_at = branch[:: max(1, len(branch) // LOOKS)]
    there = [
        any(
            _same(system, unknowns, _solution(state).unknowns)
            for piece in pieces
            for unknowns in system.solutions(piece, state.frequency)
        )
        for state in looked_at
    ]
    return sum(there) > len(there) / 2


def _same(system: SteadySystem, *two: Array) -> bool:
    """Tell whether two motions of one frequency are the same, or each the other's mirror image.

    They are held against each other in the harmonics that both balance: what a step of force makes beyond those of the
    one isn't among its unknowns.
    """
    size = min(motion.size for motion in two)
    one, other = (system.in_so_many(motion, size) for motion in two)
    apart = SAME_STATE_SHARE if two[0].size == two[1].size else SAME_STATE_SHARE + 2 * TRUNCATED
    return any(np.abs(one - it).max() <= apart * np.abs(it).max() for it in (other, system.mirrored(other)))


def _others(system: SteadySystem, some: Sequence[Array], known: Sequence[Array]) -> list[Array]:
    return [one for one in some if not any(_same(system, one, other) for other in known)]


def _joined(system: SteadySystem, unknowns: Array, frequency: float) -> Iterator[Array]:
    """Give the states of a frequency (Hz) to which a higher or a lower level leads from one of them."""
    size, over_level = float(system.sizes(unknowns[None])[0]), system.over_level(frequency, system.coarsely)
    start = system.in_so_many(unknowns, min(unknowns.size, system.clamps * (2 * system.coarsely + 1)))
    for end in (HIGHEST_LEVEL, 0.0):
        path = list(follow(over_level, Solution(1.0, start), end, size, PATH_STEPS))
        if len(path) == 1:  # what isn't balanced in so few harmonics leads nowhere
            begin = solve(over_level, start, 1.0, size)
            path = [] if begin is None else list(follow(over_level, Solution(1.0, begin), end, size, PATH_STEPS))
        if path and path[-1].parameter == 1.0:
            back = _solved_again(system, path[-1].unknowns, frequency)
            if back is not None and not _same(system, back, unknowns):
                yield back


def _solved_again(system: SteadySystem, unknowns: Array, frequency: float) -> Array | None:
    """Give the motion at a frequency (Hz) to which a path over levels led; None where it isn't found."""
    if system.rubbing or system.coarsely == system.most_harmonics:
        return with_sides(system, unknowns, frequency)
    return solve(system.over_frequency(), unknowns, frequency, float(system.sizes(unknowns[None])[0]))


def _followed(system: SteadySystem, start: Solution, first: float, last: float) -> tuple[SteadyState, ...]:
    """Follow a branch from one of its points to where it closes, leaves the range, or is given up."""
    onwards, closed = _half_by_half(system, start, (last, first))
    backwards = [] if closed else _half_by_half(system, start, (first, last))[0]
    back = [replace(point, side=-point.side) for point in reversed(backwards[1:])]
    return tuple(system.state(point.unknowns, point.parameter, point.side) for point in [*back, *onwards])


def _half_by_half(system: SteadySystem, start: Solution, ends: tuple[float, float]) -> tuple[list[Solution], bool]:
    """Follow a branch above and below its first frequency in turn; also say whether it came back to where it was.

    Where it meets its own mirror image it has come to the symmetric motion that it branches off from, and ends.
    """
    path, passed = [start], [start.unknowns]
    mirrored = _is_mirrored(system, start)
    for end in islice(cycle(ends), MOST_HALVES):
        size = float(system.sizes(path[-1].unknowns[None])[0])
        onwards = follow(system.over_frequency(), path[-1], end, size, OVER_FREQUENCY)
        begun, *half = _until_mirrored(system, onwards, mirrored=mirrored)
        path = [*path[:-1], begun, *half]
        if not half or half[-1].parameter != start.parameter:
            return path, False
        if not _others(system, [half[-1].unknowns], passed):
            return path, True
        passed.append(half[-1].unknowns)
    return path, False


def _is_mirrored(system: SteadySystem, point: Solution) -> bool:
    """Tell whether a motion has a mirror image that isn't itself and that is balanced too."""
    mirrored = system.mirrored(point.unknowns)
    size = SAME_STATE_SHARE * float(np.abs(mirrored).max())
    unbalanced = np.abs(system.over_frequency()(mirrored, point.parameter)[0]).max()
    return bool(np.abs(mirrored - point.unknowns).max() > size >= unbalanced)


def _until_mirrored(system: SteadySystem, path: Iterator[Solution], *, mirrored: bool) -> Iterator[Solution]:
    """Give the points of a path; where it is mirrored, to the first that is nearer to the image of that before, or that
    is symmetric, as where a step leads across the place at which the branch ends."""
    before = None
    for point in path:
        yield point
        if before is not None and mirrored:
            off, other = (system.lopsided(one) for one in system.matched([point.unknowns, before.unknowns]))
            nothing = Steps.tolerance * float(system.sizes(point.unknowns[None])[0])
            if off @ other < 0 or np.abs(off).max() <= nothing:
                return
        before = point
