"""Which laws' memory jumps in a step, however short: it can't be continuous states, and needs short ways."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pipeclamp_fmu.contents.clamp_model import ClampModel
from pipeclamp_models.base.errors import UserError

SAMPLES = 200
"""Places on a cycle at which short steps are tried."""

SHORT = 1e-7
"""A step so short that it moves what moves at all by far less than a jump, in periods."""

JUMP = 1e-3
"""Of a state's largest value: what it moves by in a short step is no jump below it."""

PARTS = 16
"""In which a step is walked of a law whose memory jumps: at a part's end instead of the step's. Play's force errs by
4 % of its rms in 12 steps a cycle without, and by 0.4 % with them."""

REMEDY = "build the FMU without --memory-as-states"


def require_states(model: ClampModel) -> None:
    """Refuse a law whose memory can't be continuous states.

    Raises:
        UserError: one of its states jumps, it counts load cycles, or it is to follow A and f from the motion.
    """
    if model.told.track:
        raise UserError(
            f"law {model.name!r}: the FMU is to track A and f, which takes averages over completed integrator steps; "
            f"expected A and f that are told, with memory as states: give --amplitude and --frequency, or {REMEDY}"
        )
    counted = next((entry.name for entry in model.further if entry.counted), "")
    if counted:
        raise UserError(
            f"law {model.name!r} depends on load cycles ({counted}), which the FMU counts at completed integrator "
            f"steps; expected a law without, with memory as states: {REMEDY}"
        )
    names = jumping(model)
    if names:
        raise UserError(
            f"law {model.name!r}: its memory {', '.join(names)} jumps at reversals; expected memory that moves "
            f"steadily, with memory as states: {REMEDY}"
        )


def parts_of_step(model: ClampModel) -> int:
    """Give in how many parts a clamp's own step is walked."""
    return PARTS if jumping(model) else 1


def jumping(model: ClampModel) -> list[str]:
    """Give the names of the states that a short step moves by a jump, somewhere on one of two cycles."""
    A, f, T = model.range_A[1], model.range_f[1], model.temperature
    law = model.law
    k = law.coefficients(A, f, T, *(entry.scale * entry.start for entry in model.further))
    found: set[int] = set()
    for share, mean in ((1.0, 0.0), (0.3, 0.6)):
        motion = [_place(A * share, A * mean, f, n) for n in range(2 * SAMPLES + 1)]
        states: Sequence[float] = [value for _, value in law.states]
        sizes, moves = [0.0] * len(states), [0.0] * len(states)
        before = motion[0][0]
        for y, v in motion[1:]:
            _, _, states = law.step(k, states, before, y, v, 1 / (f * SAMPLES))
            for turned in (v, -v):
                h = SHORT / f
                here = law.step(k, states, y, y, turned, 0.0)[2]
                ahead = law.step(k, here, y, y + h * turned, turned, h)[2]
                moves = [max(most, abs(b - a)) for most, a, b in zip(moves, here, ahead, strict=True)]
            sizes = [max(most, abs(value)) for most, value in zip(sizes, states, strict=True)]
            before = y
        found |= {n for n, (move, size) in enumerate(zip(moves, sizes, strict=True)) if move > JUMP * size}
    return [law.states[n][0] for n in sorted(found)]


def _place(amplitude: float, mean: float, f: float, n: int) -> tuple[float, float]:
    """Give displacement and velocity at a sample of a cycle."""
    theta = 2 * math.pi * (n + 0.5) / SAMPLES
    return mean + amplitude * math.sin(theta), 2 * math.pi * f * amplitude * math.cos(theta)
