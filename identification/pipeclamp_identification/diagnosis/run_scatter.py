"""What differs from run to run: stiffness, damping, mean force and the zero of the displacement, by how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array


@dataclass(frozen=True)
class RunScatter:
    """Standard deviations from run to run.

    Attributes:
        stiffness, damping: shares by which elastic and damping force are off.
        mean_N: of the mean force, N: of a load that is hung on, a preload that is set, the zeros of the channels.
        zero_mm: of the displacement's zero, mm.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    mean_N: float = 0.0
    zero_mm: float = 0.0

    def least(self, other: RunScatter) -> RunScatter:
        """Give the smaller of two estimates of each."""
        return RunScatter(
            min(self.stiffness, other.stiffness), min(self.damping, other.damping),
            min(self.mean_N, other.mean_N), min(self.zero_mm, other.zero_mm),
        )  # fmt: skip

    def by_harmonics(self, directions: Directions) -> Array:
        """Give the force that one standard deviation makes of each but the mean, N, shape (3, R, m)."""
        return np.stack(
            [self.stiffness * directions.elastic, self.damping * directions.damping, self.zero_mm * directions.shifted]
        )

    def covariance(self, directions: Directions) -> Array:
        """Give the covariance of harmonics that all of them make, N2, shape (R, m, m)."""
        by_harmonics = self.by_harmonics(directions)
        covariance = np.asarray(np.einsum("dri,drj->rij", by_harmonics, by_harmonics))
        covariance[:, 0, 0] += self.mean_N**2
        return covariance


@dataclass(frozen=True)
class Directions:
    """What of a loop's harmonics goes with what differs from run to run, shape (R, m) each, as `harmonics_of` orders.

    Attributes:
        elastic, damping: force by which a run is off when its stiffness or damping is off by 100 %, N.
        shifted: force by which it is off when the zero of its displacement is off by 1 mm, less the mean, N/mm.
    """

    elastic: Array
    damping: Array
    shifted: Array

    def all(self) -> Array:
        """Give all of them, shape (3, R, m)."""
        return np.stack([self.elastic, self.damping, self.shifted])


def directions(harmonics: Array, amplitude_mm: Array) -> Directions:
    """Give what goes with what differs from run to run.

    The cosines of a loop, in phase with the displacement A cos(theta), make its elastic force, a sum of Chebyshev
    polynomials in y / A, the sines its damping. The slope of that sum is the force that a shift of the displacement
    makes: T_k' = 2 k (T_{k-1} + T_{k-3} + ...).

    Args:
        harmonics: of the force, N, shape (R, m).
        amplitude_mm: A, shape (R,).
    """
    elastic, damping, shifted = np.zeros_like(harmonics), np.zeros_like(harmonics), np.zeros_like(harmonics)
    elastic[:, 1::2] = harmonics[:, 1::2]
    damping[:, 2::2] = harmonics[:, 2::2]
    cosines = harmonics[:, 1::2]
    count = cosines.shape[1]
    order = np.arange(1, count + 1)
    made_by = (order > order[:, None]) & ((order - order[:, None]) % 2 == 1)
    shifted[:, 1::2] = 2 / amplitude_mm[:, None] * ((order * cosines) @ made_by.T)
    return Directions(elastic, damping, shifted)
