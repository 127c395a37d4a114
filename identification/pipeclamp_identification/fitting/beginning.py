"""How a law's memory was loaded before a record of free motion begins: what the force at rest says of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.free_motion import FreeRun
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import LawForce, force_of_law
from pipeclamp_models.realise.motion import Motion

REST_SPEED_SHARE = 0.01
"""Share of a record's largest speed below which it still rests at its beginning."""
SURE_STANDARD_ERRORS = 3.0
"""Standard errors by which the force at rest must differ from that of an unloaded law."""
MATERIAL = 0.01
"""Share of the rms force, too: what is less than laws err by at best isn't worth a past."""
PLACES_ON_A_SIDE = 400
"""Places on one side that the clamp may have come from."""
FARTHEST_AWAY = 2.0
"""Of the law's largest amplitude, or the record's own way: from so far, at most, has it come."""
APPROACH_STEPS = 100
"""In which it came, straight."""
SECONDS_OF_A_STEP = 1e6
"""Seconds of each of these steps: what fades in time has faded at rest."""


@dataclass(frozen=True)
class Beginning:
    """The law's memory before a record's first sample.

    Attributes:
        came_from: displacement in mm from which the clamp came straight, its memory unloaded there.
        memory: the law's states at rest, shape (1,) each.
    """

    came_from: float
    memory: tuple[Array, ...]


def beginning(law: Law, run: FreeRun, motion: Motion, unloaded: Array, largest: float) -> Beginning | None:
    """Give the law's memory where a record begins; None where it is unloaded.

    A specimen has a past: where friction holds it, or a clearance stands at one end, its force at rest isn't that of an
    unloaded law. Only the force before the motion begins is asked, and the nearest place is taken that explains it;
    none where the force doesn't differ, its mean isn't known, or the record begins in motion.

    Args:
        law: the law.
        run: of free motion.
        motion: the same for the law, one row of n samples.
        unloaded: the law's force along it in N, its memory unloaded, shape (n,).
        largest: amplitude in the law's range, mm.
    """
    if not law.equations.states or not run.begins_at_rest or not run.mean_known:
        return None
    lack, error = _lack_at_rest(run, unloaded)
    if not abs(lack) > max(SURE_STANDARD_ERRORS * error, MATERIAL * float(np.sqrt(np.mean(run.record.force_N**2)))):
        return None
    here = float(approached(law, motion, np.zeros(1)).force[0, -1])
    reach = FARTHEST_AWAY * max(largest, float(np.ptp(motion.y)))
    # the farther a clamp comes from below, the higher its force
    side = -1.0 if lack > 0 else 1.0
    low, high = 0.0, reach
    for _ in range(2):  # the second time within the first's interval
        away = np.linspace(low, high, PLACES_ON_A_SIDE + 1)
        force = approached(law, motion, side * away).force[:, -1]
        risen = np.maximum.accumulate(-side * (force - here))
        if not np.all(np.isfinite(risen)) or risen[-1] <= 0.0:
            return None
        reached = max(int(np.argmax(risen >= min(abs(lack), float(risen[-1])))), 1)
        low, high = float(away[reached - 1]), float(away[reached])
    return came_from(law, motion, side * high)


def came_from(law: Law, motion: Motion, away: float) -> Beginning:
    """Give the law's memory where it has come from so far away, mm."""
    found = approached(law, motion, np.array([away]))
    return Beginning(float(motion.y[0, 0]) + away, tuple(state[:, -1] for state in found.states))


def approached(law: Law, motion: Motion, away: Array) -> LawForce:
    """Give force and states of a law on straight ways to a motion's first sample, from so far away, mm, shape (P,)."""
    first = {name: values[:, :1] for name, values in motion.slow.items()}
    share = 1 - np.arange(1, APPROACH_STEPS + 1) / APPROACH_STEPS
    begin = motion.y[0, 0] + away[:, None]
    y = motion.y[0, 0] + away[:, None] * share
    still = np.zeros_like(y)
    return force_of_law(
        law,
        Motion(y, still, still, first, np.full((len(away), 1), SECONDS_OF_A_STEP), periodic=False, rest=begin),
    )


def _lack_at_rest(run: FreeRun, unloaded: Array) -> tuple[float, float]:
    """Give what the force of an unloaded law lacks before the motion begins, N, and its standard error."""
    speed = np.abs(run.motion.v)
    begun = max(int(np.argmax(speed > REST_SPEED_SHARE * np.max(speed))), 1)
    force = np.interp(run.motion.time[:begun], run.record.time_s - run.record.time_s[0], run.record.force_N)
    lack = force - unloaded[:begun]
    return float(np.mean(lack)), float(np.std(lack)) / math.sqrt(begun)
