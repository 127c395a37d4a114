"""The energy balance of a co-simulation: what the excitation gave, where it went, what the coupling itself made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array

NAMES = {
    "excitation": "given by the excitation",
    "coupling": "made by the coupling",
    "pipe_stored": "stored in the pipe",
    "pipe_dissipated": "dissipated in the pipe",
    "clamps_stored": "stored in the clamps",
    "clamps_dissipated": "dissipated in the clamps",
    "unexplained": "unexplained",
}
"""How people are told the parts of `EnergyBalance.final`."""


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energies since the start at each communication point, J, (n,).

    Attributes:
        excitation: work of the excitation; for a moving base that of the inertia forces in the base's frame.
        pipe_stored: kinetic and strain energy of the pipe.
        pipe_dissipated: what the pipe's own damping has taken.
        clamps_received: work that the clamps have taken in, by their own forces and motion.
        clamps_dissipated: the part of it that is heat.
        delivered: work that the pipe has given to the clamps, by the forces that it was told.
    """

    excitation: Array
    pipe_stored: Array
    pipe_dissipated: Array
    clamps_received: Array
    clamps_dissipated: Array
    delivered: Array

    @property
    def clamps_stored(self) -> Array:
        """Elastic energy in the clamps."""
        return self.clamps_received - self.clamps_dissipated

    @property
    def coupling(self) -> Array:
        """Energy that the coupling made (below 0: destroyed): nobody's, as pipe and clamps saw different forces."""
        return self.clamps_received - self.delivered

    @property
    def coupling_share(self) -> float:
        """Largest energy that the coupling has made or destroyed, as a share of what the excitation has given."""
        return self._share(float(np.abs(self.coupling).max()))

    @property
    def clamps_share(self) -> float:
        """Heat that has come out of the clamps, as a share of what the excitation has given: above 0, they made it."""
        taken = self.clamps_dissipated[np.isfinite(self.clamps_dissipated)]  # a foreign clamp doesn't say
        return self._share(-float(taken.min(initial=0.0)))

    def _share(self, energy: float) -> float:
        """Give an energy as a share of the most that the excitation has given so far, less what it took back.

        What goes to and fro doesn't count: near and off resonance it is many times what moves and damps the pipe.
        """
        given = float(np.abs(self.excitation).max())
        if not np.isfinite(given):  # a foreign pipe that doesn't say
            given = float(np.abs(self.delivered).max())
        return energy / given if given > 0 else 0.0

    @property
    def unexplained(self) -> Array:
        """What is left of the balance: rounding, where the pipe keeps its own books exactly."""
        given = self.excitation + self.coupling
        return given - self.pipe_stored - self.pipe_dissipated - self.clamps_received

    def final(self) -> dict[str, float]:
        """Give the balance at the end by name, J."""
        parts = {
            "excitation": self.excitation,
            "coupling": self.coupling,
            "pipe_stored": self.pipe_stored,
            "pipe_dissipated": self.pipe_dissipated,
            "clamps_stored": self.clamps_stored,
            "clamps_dissipated": self.clamps_dissipated,
            "unexplained": self.unexplained,
        }
        return {name: float(values[-1]) for name, values in parts.items()}


def received_work(force: Array, displacement: Array, velocity: Array, time: Array) -> Array:
    """Give the work that each clamp has received.

    By the trapezoidal rule over straight ways, and what force and motion bend between the points: h dF dv/6 a step.
    Over whole cycles that leaves an error of the fourth order, where the rule alone loses 4 % of a dashpot's heat in
    12 steps a cycle (Euler and Maclaurin); within a cycle h^2 F' v'/12 goes to and fro.

    Args:
        force: into the clamp, N, (n, clamps).
        displacement, velocity: of the clamp, as the clamp was told, m and m/s, (n, clamps).
        time: s, (n,).

    Returns:
        work since the start, J, (n, clamps).
    """
    work = np.zeros_like(force)
    bent = np.diff(time)[:, None] * np.diff(force, axis=0) * np.diff(velocity, axis=0) / 6
    np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(displacement, axis=0) + bent, axis=0, out=work[1:])
    return work
