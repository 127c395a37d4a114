"""The frequency response of a pipe in modes, also of one that can move as a rigid body."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.pipe.receptance import are_coupled, receptance

SINGULAR_CONDITION = 1e14
"""Condition of the stiffness from which on the pipe can move as a rigid body."""

STATIC = 1e-3
"""Of the fundamental: the frequency that stands for 0 where there is no static compliance; it is then told to be 0."""


class Receptance:
    """What points move per unit of each load, q'' + damping q' + stiffness q = loads u, s = observed q."""

    def __init__(self, stiffness: Array, damping: Array, loads: Array, observed: Array) -> None:
        """Keep the matrices.

        Args:
            stiffness, damping: of the modes, (m, m).
            loads: (m, inputs).
            observed: (points, m).
        """
        self._stiffness, self._damping, self._loads, self._observed = stiffness, damping, loads, observed
        self._coupled = are_coupled(stiffness, damping)
        self.adrift = bool(np.linalg.cond(stiffness) >= SINGULAR_CONDITION)

    def at(self, omega: Array) -> ComplexArray:
        """Give the response at frequencies of rows and orders (rows, h), rad/s: (rows, points, inputs, h)."""
        if self.adrift:  # a pipe that can move as a rigid body has no mean position of its own
            omega = omega.copy()
            omega[:, 0] = STATIC * omega[:, 1]
        of_points = receptance(
            self._stiffness, self._damping, self._loads, self._observed, omega, coupled=self._coupled
        )
        found = np.moveaxis(of_points, 1, -1)
        if self.adrift:
            found[..., 0] = 0.0
        return found
