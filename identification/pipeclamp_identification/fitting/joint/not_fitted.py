"""Parameters that a fit leaves alone, each with the reason."""

from __future__ import annotations

import numpy as np

from pipeclamp_identification.fitting.observations import Observations
from pipeclamp_identification.signals.levels import count_levels
from pipeclamp_models.law.law import Equations, Structure, find_base

HELD = "held by the law's structure"
WISHED = "held by wish"
IDLE = "held where it does nothing"
OF_THE_LAW = (HELD, IDLE, WISHED)
"""Reasons that lie in what the law is to be, and not in the tests."""
DENIED = "at rest before the tests there is no such force"
STATED = "taken from the tests: others are stated at it"
ONE_AMPLITUDE = "A doesn't vary, and without records nothing shows the loops' shape"


def undetermined(equations: Equations, observations: Observations) -> dict[str, str]:
    """Give the parameters that the data can't determine, with the reason.

    Nothing uses them, others are only stated at them, their condition doesn't vary, they make a constant force, which
    forces at rest deny, or loops of one amplitude don't show them, whose shape isn't known.
    """
    reasons: dict[str, str] = {}
    for parameter in equations.parameters:
        if not parameter.used:
            reasons[parameter.name] = "the law has nothing that it scales"
            continue
        if parameter.stated:
            reasons[parameter.name] = STATED
            continue
        if parameter.at_rest and observations.deny_constant_force:
            reasons[parameter.name] = DENIED
            continue
        if parameter.by_shape and not observations.show_shape and not varies_in_amplitude(observations):
            reasons[parameter.name] = ONE_AMPLITUDE
            continue
        for signal in parameter.follows:
            values = observations.motion.slow.get(signal)
            if signal in observations.motion.assumed:
                reasons[parameter.name] = f"{signal} isn't known"
            elif values is None or not np.all(np.isfinite(values)):
                reasons[parameter.name] = f"{signal} isn't known in every run"
            elif (count := count_levels(signal, values)) < parameter.levels:
                reasons[parameter.name] = (
                    f"{signal} doesn't vary in the data" if count == 1 else f"{signal} has {count} levels only"
                )
    return reasons


def varies_in_amplitude(observations: Observations) -> bool:
    """Tell whether loops of several amplitudes are there."""
    return count_levels("A", observations.motion.slow["A"]) > 1


def not_fitted(structure: Structure, equations: Equations, observations: Observations) -> dict[str, str]:
    """Give the parameters that aren't fitted, with the reason: held by the base's form, by wish, or undetermined."""
    fixed = find_base(structure.base).fixed
    held = structure.held()
    reasons = undetermined(equations, observations)
    for parameter in equations.parameters:
        value = held.get(parameter.name)
        if value is not None:
            idle = IDLE if value == parameter.neutral else WISHED
            reasons[parameter.name] = HELD if fixed.get(parameter.name) == value else idle
    return reasons
