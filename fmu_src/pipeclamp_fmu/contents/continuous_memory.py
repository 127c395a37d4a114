"""Which laws' memory can be continuous states, and in how many parts a clamp's own step is walked."""

from __future__ import annotations

from typing import Any

from pipeclamp_fmu.contents.clamp_model import ClampModel
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.steps import jumps
from pipeclamp_models.steps.within_step import Step

REMEDY = "build the FMU without --memory-as-states"


def require_states(model: ClampModel) -> None:
    """Refuse a law whose memory can't be continuous states.

    Raises:
        UserError: one of its states jumps, it counts load cycles, or it is to follow A and f from the motion.
    """
    if model.start.track:
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
    return jumps.parts_of_step(*_in_the_middle(model))


def jumping(model: ClampModel) -> list[str]:
    """Give the names of the states that jump."""
    return [model.law.states[place][0] for place in jumps.jumping(*_in_the_middle(model))]


def _in_the_middle(model: ClampModel) -> tuple[Step, Any, list[float], float, float]:
    """Give what `jumps.jumping` takes, with the further conditions in the middle of their ranges."""
    law, A, f = model.law, model.range_A[1], model.range_f[1]
    k = law.coefficients(A, f, model.temperature, *(entry.scale * entry.start for entry in model.further))
    return law.step, k, [value for _, value in law.states], A, f
