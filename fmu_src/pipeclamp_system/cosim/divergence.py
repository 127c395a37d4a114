"""Stopping a co-simulation that diverges."""

from __future__ import annotations

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.coupling.march import Point

IMPOSSIBLE = 10.0
"""A pipe that holds this many times what the excitation has moved to and fro has it from the coupling."""

PATIENCE = 50
"""Steps for which it may do so and the run still goes on."""

HOPELESS = 1e6
"""The same, where the run is stopped at once."""


class DivergedError(UserError):
    """A run was stopped whose coupling diverges."""


class EnergyGuard:
    """Stops a run that diverges: by energy in the pipe that nobody has put in.

    Attributes:
        since: the step from which on the pipe holds what the coupling must have made; 0 while it doesn't.
    """

    def __init__(self) -> None:
        self._work = 0.0
        self._moved = 0.0
        self.since = 0

    def check(self, point: Point, stored: float, work: float) -> None:
        """Take a communication point with the pipe's energy and the excitation's work, J.

        Raises:
            UserError: the run has diverged.
        """
        self._moved += abs(work - self._work)
        self._work = work
        if not stored > IMPOSSIBLE * self._moved:  # nor where a foreign pipe doesn't say what it stores
            self.since = 0
            return
        self.since = self.since or point.index
        # A start from rest into steep friction passes through such states, and comes back.
        if point.index - self.since >= PATIENCE or stored > HOPELESS * self._moved:
            raise UserError(
                f"step {point.index} (t = {point.time:.6g} s): the pipe holds {stored:.3g} J where the excitation has "
                f"moved no more than {self._moved:.3g} J"
            )
