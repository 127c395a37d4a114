"""Branches of a frequency response that nothing joins to the rest of it inside its range: closed ones, mostly.

They are found where the excitation's level joins them to the response that is known: from one of its states, with the
frequency held, the level is raised or lowered until the path comes back to the level that is asked for, elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle, islice

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.continuation import Solution, Steps, follow
from pipeclamp_system.steady.harmonics import packed
from pipeclamp_system.steady.states import SteadyState

HIGHEST = 4.0
"""Levels up to which, of the one that is asked for, the excitation is raised."""

PLACES = 12
"""Frequencies at which branches are sought, evenly spread inside the range."""

SAME = 1e-3
"""States whose unknowns differ by less, as a share of their size, are one."""

LOOKS = 10
"""States of a branch at which it is held against those that are known."""

MOST_HALVES = 20
"""No branch passes its first frequency more often."""

STEPS = Steps(first=0.05, longest=0.2)


def detached_branches(
    system: SteadySystem, known: Sequence[Sequence[SteadyState]], first: float, last: float
) -> tuple[tuple[SteadyState, ...], ...]:
    """Seek branches that a frequency response isn't joined to in its range.

    Args:
        system: pipe and clamps under their sine.
        known: the pieces of the response that are known.
        first, last: ends of the range, Hz.
    """
    found: list[tuple[SteadyState, ...]] = []
    if not system.clamps:  # without laws all is linear
        return ()
    for frequency in np.linspace(first, last, PLACES + 2)[1:-1].tolist():
        met = [unknowns for piece in [*known, *found] for unknowns in system.solutions(piece, frequency)]
        # Where a response that was given up has a gap, it begins at rest.
        unseen = [] if met else [start for start in [system.start(frequency)] if start is not None]
        waiting = list(met)
        while waiting or unseen:
            while unseen:
                branch = _followed(system, Solution(frequency, unseen[0]), first, last)
                crossed = [unseen[0], *system.solutions(branch, frequency)]
                unseen = _others(system, unseen, crossed)
                waiting += crossed
                met += crossed
                if not _is_known(system, branch, [*known, *found]):
                    found.append(branch)
            unseen = _others(system, list(_joined(system, waiting.pop(), frequency)), met)
    return tuple(found)


def _is_known(system: SteadySystem, branch: Sequence[SteadyState], pieces: Sequence[Sequence[SteadyState]]) -> bool:
    """Tell whether most of a branch lies on pieces, which a path that cuts a corner may have left and met again."""
    looked_at = branch[:: max(1, len(branch) // LOOKS)]
    there = [
        any(
            _same(system, unknowns, packed(state.balanced[None])[0])
            for piece in pieces
            for unknowns in system.solutions(piece, state.frequency)
        )
        for state in looked_at
    ]
    return sum(there) > len(there) / 2


def _same(system: SteadySystem, *two: Array) -> bool:
    one, other = system.matched(two)
    return bool(np.abs(one - other).max() <= SAME * np.abs(other).max())


def _others(system: SteadySystem, some: Sequence[Array], known: Sequence[Array]) -> list[Array]:
    return [one for one in some if not any(_same(system, one, other) for other in known)]


def _joined(system: SteadySystem, unknowns: Array, frequency: float) -> Iterator[Array]:
    """Give the states of a frequency (Hz) to which a higher or a lower level leads from one of them."""
    size = float(system.sizes(unknowns[None])[0])
    for end in (HIGHEST, 0.0):
        *_, there = follow(system.over_level(frequency), Solution(1.0, unknowns), end, size, STEPS)
        back = system.with_sides(there.unknowns, frequency) if there.parameter == 1.0 else None
        if back is not None and not _same(system, back, unknowns):
            yield back


def _followed(system: SteadySystem, start: Solution, first: float, last: float) -> tuple[SteadyState, ...]:
    """Follow a branch from one of its points to where it closes, leaves the range, or is given up."""
    onwards, closed = _half_by_half(system, start, (last, first))
    backwards = [] if closed else _half_by_half(system, start, (first, last))[0]
    return tuple(system.state(point.unknowns, point.parameter) for point in [*reversed(backwards[1:]), *onwards])


def _half_by_half(system: SteadySystem, start: Solution, ends: tuple[float, float]) -> tuple[list[Solution], bool]:
    """Follow a branch above and below its first frequency in turn; also say whether it came back to where it was."""
    path, passed = [start], [start.unknowns]
    for end in islice(cycle(ends), MOST_HALVES):
        size = float(system.sizes(path[-1].unknowns[None])[0])
        _, *half = follow(system.over_frequency(), path[-1], end, size)
        path += half
        if not half or half[-1].parameter != start.parameter:
            return path, False
        if not _others(system, [half[-1].unknowns], passed):
            return path, True
        passed.append(half[-1].unknowns)
    return path, False
