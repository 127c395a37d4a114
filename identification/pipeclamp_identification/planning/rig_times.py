"""What a rig gives a campaign unless told: light to load, for the command line states it too."""

from __future__ import annotations

from dataclasses import dataclass

HOURS = 8.0
"""That a campaign may take."""
SCATTER_BEFOREHAND = 0.003
"""Rms share by which stiffness and damping differ from run to run, where nothing tells."""


@dataclass(frozen=True)
class RigTimes:
    """What a rig needs besides the runs.

    Attributes:
        heating: K per minute, heating and cooling.
        soak_min: minutes at a new temperature until the clamp has it throughout.
        pause_s: seconds between two runs.
    """

    heating: float = 2.0
    soak_min: float = 20.0
    pause_s: float = 30.0

    def change_min(self, before: float, after: float) -> float:
        """Give the minutes from one temperature to another, degC."""
        return abs(after - before) / self.heating + self.soak_min if abs(after - before) > 1e-9 else 0.0


RIG_TIMES = RigTimes()
