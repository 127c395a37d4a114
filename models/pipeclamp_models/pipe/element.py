"""A beam's element: shapes that are exact under loads at its ends, and those of what inertia does within it.

The first four shapes belong to displacement and rotation of both ends (Friedman & Kosmatka, Computers & Structures 47
(1993) 473; Hermite's cubics for phi = 0). The others are what the element, held at its ends, does under a load per
length that is even, under one that changes its sign in the middle, and, where it shears, under an even moment per
length: inertia's, to the second order in the element's length. Ends' and inner shapes share no stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from pipeclamp_models.base.arrays import Array

_FROM_MINUS_ONE, _OF_TWO = np.polynomial.legendre.leggauss(6)
POINTS, WEIGHTS = (1 + _FROM_MINUS_ONE) / 2, _OF_TWO / 2
"""What integrates the product of two shapes over x from 0 to 1, polynomials of the fifth degree, exactly."""

SHEARED = 0.1
"""phi above which a moment per length has a shape of its own: below, it takes less than 1e-9 of an eigenfrequency, and
the shape would be lost in rounding."""


@dataclass(frozen=True)
class Element:
    """An element of a beam.

    Attributes:
        length: m.
        bending_stiffness: E I, N m2.
        shear_ratio: phi = 12 E I/(kappa G A l^2); 0 where shear is neglected.
    """

    length: float
    bending_stiffness: float
    shear_ratio: float

    @property
    def inner(self) -> int:
        """How many shapes it has besides those of its ends."""
        return 3 if self.shear_ratio > SHEARED else 2

    def shapes_at(self, x: float | Array) -> tuple[Array, Array, Array]:
        """Give the shapes at x from 0 to 1: displacement, its slope, the section's rotation, each (4 + inner, *x)."""
        a, phi = self.length, self.shear_ratio
        displacement = (
            2 * x**3 - 3 * x**2 - phi * x + 1 + phi,
            a * (x**3 - (2 + phi / 2) * x**2 + (1 + phi / 2) * x),
            -(2 * x**3 - 3 * x**2 - phi * x),
            a * (x**3 - (1 - phi / 2) * x**2 - phi / 2 * x),
        )
        slope = (
            (6 * x**2 - 6 * x - phi) / a,
            3 * x**2 - (4 + phi) * x + 1 + phi / 2,
            -(6 * x**2 - 6 * x - phi) / a,
            3 * x**2 - (2 - phi) * x - phi / 2,
        )
        rotation = (
            6 * (x**2 - x) / a,
            3 * x**2 - (4 + phi) * x + 1 + phi,
            -6 * (x**2 - x) / a,
            3 * x**2 - (2 - phi) * x,
        )
        inner_displacement, inner_rotation, _, sheared = self._within(x)
        return (
            np.concatenate([np.array(displacement) / (1 + phi), inner_displacement]),
            np.concatenate([np.array(slope) / (1 + phi), (inner_rotation + sheared) / a]),
            np.concatenate([np.array(rotation) / (1 + phi), inner_rotation / a]),
        )

    def _within(self, x: float | Array) -> tuple[Array, Array, Array, Array]:
        """Give inner shapes at x: displacement, rotation, its slope, shear angle, over powers of length, each (i, *x).

        They solve S' = -q, T'' = -S - m, W' = T + phi S/12 with W = T = 0 at both ends, for the shear force S, the
        rotation T and the displacement W under q = 24, q = 1 - 2 x, and m = 6 (1 + phi)/phi.
        """
        phi, y = self.shear_ratio, x * (1 - x)
        at_start = (1 / 5 + phi / 6) / (1 + phi)
        turned = at_start / 2 - 1 / 12
        found = [
            (y**2 + phi * y, 2 * y * (1 - 2 * x), 2 * (1 - 6 * y), phi * (1 - 2 * x)),
            (
                x**4 / 24 - x**5 / 60 - at_start * x**3 / 6 + turned * x**2 / 2
                + phi / 12 * (at_start * x - x**2 / 2 + x**3 / 3),
                x**3 / 6 - x**4 / 12 - at_start * x**2 / 2 + turned * x,
                x**2 / 2 - x**3 / 3 - at_start * x + turned,
                phi / 12 * (at_start - y),
            ),
            (3 / 2 * x**2 - x**3 - x / 2, 3 * y, 3 * (1 - 2 * x), 0 * x - 1 / 2),
        ]  # fmt: skip
        displacement, rotation, bent, sheared = np.array(found[: self.inner]).swapaxes(0, 1)
        return displacement, rotation, bent, sheared

    def stiffness(self) -> Array:
        """Give the stiffness over (w1, rotation1, w2, rotation2, inner shapes), N/m, (4 + inner, 4 + inner)."""
        a, phi = self.length, self.shear_ratio
        unscaled = [
            [12, 6 * a, -12, 6 * a],
            [6 * a, (4 + phi) * a**2, -6 * a, (2 - phi) * a**2],
            [-12, -6 * a, 12, -6 * a],
            [6 * a, (2 - phi) * a**2, -6 * a, (4 + phi) * a**2],
        ]
        whole = np.zeros((4 + self.inner, 4 + self.inner))
        whole[:4, :4] = np.array(unscaled) / (1 + phi)
        _, _, bent, sheared = self._within(POINTS)
        for strain in [bent, sheared * sqrt(12 / phi)] if phi else [bent]:
            whole[4:, 4:] += _integral(strain)
        return self.bending_stiffness / a**3 * whole

    def integrals(self, mass_per_length: float, rotary_inertia: float) -> tuple[Array, Array, Array]:
        """Give the mass (kg), the integral of w' w' (1/m) and that of w w', each of the stiffness's shape."""
        displacement, slope, rotation = self.shapes_at(POINTS)
        mass = mass_per_length * _integral(displacement) + rotary_inertia * _integral(rotation)
        crossing = (WEIGHTS * displacement) @ slope.T
        return self.length * mass, self.length * _integral(slope), self.length * crossing


def _integral(shapes: Array) -> Array:
    """Give the integrals of the shapes' products over x from 0 to 1, of what they are at `POINTS`; symmetric."""
    rooted = np.sqrt(WEIGHTS) * shapes
    return np.asarray(rooted @ rooted.T)
