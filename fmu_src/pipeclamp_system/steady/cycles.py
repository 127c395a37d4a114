"""Cycles of a pipe with clamps under a sine, marched in time as machine code.

Over a step the clamps' forces go straight from its start to its end, and the modes move exactly. The forces at the end
are enclosed clamp by clamp, the others held: a larger force leaves a clamp less motion, and so it gives no larger one,
whatever steps it makes; where its own steps over the one that is sought, friction holds the clamp with that. A force
that changes much in a step, as where a clamp sets in or turns, acts so through all of it: taken for straight it would
swing from step to step for as long as the clamp is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numba import njit, types

from pipeclamp_models.realise.scalar_law import ScalarLaw
from pipeclamp_models.steps.within_step import Step

STEPPING_FORCE_SHARE = 0.02
"""Share of the largest force so far by which one changes in a step that steps."""

AGREES, NARROWEST = 1e-10, 1e-13
"""Shares of the largest force to which one is found, and to which it is enclosed where the law's steps over it."""

MOST_TRIALS_A_SWEEP, MOST_SWEEPS = 200, 60
"""Of one clamp in one sweep; and sweeps over all clamps of a step."""

_VECTOR, _MATRIX, _NUMBER, _PLACE = types.float64[::1], types.float64[:, ::1], types.float64, types.int64
_LAWS = _NUMBER(_PLACE, _MATRIX, _MATRIX, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _MATRIX)
"""The laws of all clamps: the force, N, of a clamp's place, the coefficients and states of all, y before, y, v, h; the
states after are written into the last."""
_CLAMPS = types.FunctionType(_LAWS)


def machine_clamps(laws: Sequence[ScalarLaw]) -> Any:
    """Give the laws of all clamps as one function in machine code; laws that differ in values alone have one."""
    counts = (len(law.coefficients(1.0, 1.0, 293.15, *[1.0] * len(law.further))) for law in laws)
    return _compiled(tuple((law.step, count, len(law.states)) for law, count in zip(laws, counts, strict=True)))


@lru_cache(maxsize=32)
def _compiled(laws: tuple[tuple[Step, int, int], ...]) -> Any:
    """Compile steps of so many coefficients and states, which takes a second."""
    scope: dict[str, Any] = {}
    lines = ["def clamps(place, held, states, before, y, v, h, after):"]
    for place, (step, coefficients, states) in enumerate(laws):
        scope[f"step_{place}"] = njit(step)
        held = "".join(f"held[{place}, {i}], " for i in range(coefficients))
        own = "".join(f"states[{place}, {i}], " for i in range(states))
        lines += [
            f"    if place == {place}:",
            f"        force, _, found = step_{place}(({held}), ({own}), before, y, v, h)",
            *(f"        after[{place}, {i}] = found[{i}]" for i in range(states)),
            "        return force",
        ]
    lines.append("    return 0.0")
    exec("\n".join(lines), scope)
    return njit(_LAWS)(scope["clamps"])


@njit(_NUMBER(_CLAMPS, _PLACE, _MATRIX, _MATRIX, *[_NUMBER] * 7, _MATRIX, _NUMBER), cache=True)
def _enclosed(clamp, place, held, states, before, y0, v0, by_y, by_v, guess, h, after, scale):  # type: ignore[no-untyped-def]
    """Find the force of one clamp that its motion gives, y0 + by_y F and v0 + by_v F."""
    low = guess
    at_low = clamp(place, held, states, before, y0 + by_y * low, v0 + by_v * low, h, after) - low
    if abs(at_low) <= AGREES * scale:
        return low
    # The answer falls with the force: between a force and its answer lies the one that agrees.
    high = low + at_low
    at_high = clamp(place, held, states, before, y0 + by_y * high, v0 + by_v * high, h, after) - high
    for trial in range(MOST_TRIALS_A_SWEEP):
        if abs(at_high) <= AGREES * scale:
            return high
        if abs(high - low) <= NARROWEST * scale:
            return high
        # By secants (Illinois), in halves where that is slow.
        halved = trial % 4 == 3
        middle = 0.5 * (low + high) if halved else (low * at_high - high * at_low) / (at_high - at_low)
        at = clamp(place, held, states, before, y0 + by_y * middle, v0 + by_v * middle, h, after) - middle
        if at * at_high < 0.0:
            low, at_low = high, at_high
        else:
            at_low *= 0.5
        high, at_high = middle, at
    return high


@njit(types.void(_CLAMPS, _MATRIX, _MATRIX, _VECTOR, _VECTOR, _MATRIX, _VECTOR, _NUMBER, _MATRIX, _NUMBER), cache=True)
def _solved(clamp, held, states, before, free, by_force, force, h, after, scale):  # type: ignore[no-untyped-def]
    """Find the forces of all clamps at a step's end, from a guess that is changed; free is (y, v) without them."""
    count = force.size
    for _ in range(MOST_SWEEPS):
        moved = 0.0
        for place in range(count):
            y, v = free[place], free[count + place]
            for other in range(count):
                if other != place:
                    y += by_force[place, other] * force[other]
                    v += by_force[count + place, other] * force[other]
            found = _enclosed(
                clamp,
                place,
                held,
                states,
                before[place],
                y,
                v,
                by_force[place, place],
                by_force[count + place, place],
                force[place],
                h,
                after,
                scale,
            )
            moved = max(moved, abs(found - force[place]))
            force[place] = found
        if count == 1 or moved <= AGREES * scale:
            return


@njit(types.void(_CLAMPS, _MATRIX, _MATRIX, *[_VECTOR] * 3, *[_MATRIX] * 5, _NUMBER, _MATRIX, _MATRIX), cache=True)
def marched(  # type: ignore[no-untyped-def]
    clamp, held, states, start, force, scale, onward, sine, held_loads, sloped_loads, seen, h, path, forces
):
    """March a cycle.

    Args:
        clamp: the laws, as of `machine_clamps`.
        held, states: coefficients and states of each clamp, (c, ...); the states are changed.
        start: (q, q') at its beginning, (s,); changed.
        force: N, of each clamp, (c,); changed.
        scale: the largest force so far, N, (1,); changed.
        onward: what a step makes of (q, q'), (s, s); sine: what the excitation adds in each step, (n, s).
        held_loads, sloped_loads: what forces add that are constant in a step, or rise from 0 to 1, (s, c).
        seen: displacement and velocity of the clamps of (q, q'), mm and mm/s, (2 c, s).
        h: s.
        path, forces: (q, q') and forces after each step, (n, s) and (n, c); written.
    """
    count, steps = force.size, sine.shape[0]
    straight, whole = seen @ sloped_loads, seen @ held_loads
    after = np.zeros_like(states)
    now = seen @ start
    for index in range(steps):
        last = force.copy()
        moved = onward @ start + sine[index]
        begun = moved + (held_loads - sloped_loads) @ last
        _solved(clamp, held, states, now, seen @ begun, straight, force, h, after, scale[0])
        moved_to = begun + sloped_loads @ force
        if np.abs(force - last).max() > STEPPING_FORCE_SHARE * scale[0]:
            _solved(clamp, held, states, now, seen @ moved, whole, force, h, after, scale[0])
            moved_to = moved + held_loads @ force
        start[:] = moved_to
        now_to = seen @ start
        for place in range(count):
            clamp(place, held, states, now[place], now_to[place], now_to[count + place], h, after)
        states[:] = after
        now = now_to
        scale[0] = max(scale[0], np.abs(force).max())
        path[index], forces[index] = start, force
