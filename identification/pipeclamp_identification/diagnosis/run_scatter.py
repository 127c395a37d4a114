"""What differs from run to run: stiffness, damping, mean force and the zero of the displacement, by how much."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.signals.real_harmonics import by_mean_square, mean_squares_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import Motion

SHIFT_SHARE = 1e-3
"""Share of the amplitude by which a displacement is shifted to see what that does."""


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
        each = np.array([self.stiffness, self.damping, self.zero_mm])
        return np.asarray(each[:, None, None] * directions.all())

    def covariance(self, directions: Directions) -> Array:
        """Give the covariance of harmonics that all of them make, N2, shape (R, m, m)."""
        by_harmonics = self.by_harmonics(directions)
        covariance = np.asarray(np.einsum("dri,drj->rij", by_harmonics, by_harmonics))
        covariance[:, 0, 0] += self.mean_N**2
        return covariance

    def axes(self, directions: Directions, stretches: Array | float, noise: Array) -> ScatterAxes:
        """Give the directions in which runs scatter.

        Args:
            directions: what goes with what scatters.
            stretches: into how many rows each row's run is parted, shape (R,).
            noise: mean square that noise makes of each run's error besides, N2, shape (R,).
        """
        made = self.by_harmonics(directions)
        mean = np.zeros_like(made[:1])
        mean[..., 0] = self.mean_N
        spread = by_mean_square(np.concatenate([made, mean]))
        ways, sizes, _ = np.linalg.svd(np.moveaxis(spread, 0, -1), full_matrices=False)
        return ScatterAxes(ways, sizes**2 * np.reshape(stretches, (-1, 1)), noise)


@dataclass(frozen=True)
class ScatterAxes:
    """The directions in which each run's harmonics scatter, to tell what of errors scatter can't have made.

    Where zeros, stiffness and damping scatter by more than is missing, the mean square of an error tells of scatter. In
    these directions an error counts only as far as it is likely to be missing physics: by the share that what is
    missing has in what is missing and scatter together (Wiener 1949).

    Attributes:
        ways: orthonormal where a harmonic counts by its mean square over the cycle, shape (R, m, d).
        variance: mean square by which runs scatter along each, N2, shape (R, d).
        noise: mean square that noise makes of each run's error besides, N2, shape (R,).
    """

    ways: Array
    variance: Array
    noise: Array

    def beside(self, errors: Array, missing: float) -> Array:
        """Give the mean square of each run's error beside scatter, N2, shape (R,).

        Args:
            errors: harmonics of it, N, shape (R, m).
            missing: mean square of what is missing, N2.
        """
        counted = by_mean_square(errors)
        along = np.einsum("rmd,rm->rd", self.ways, counted)
        return np.asarray(mean_squares_of(errors) - np.sum((1 - self._kept(missing)) * along**2, axis=1))

    def by_chance(self, missing: float) -> Array:
        """Give what noise and scatter make of that, N2, shape (R,); `missing` as above."""
        return np.asarray(self.noise + np.sum(self._kept(missing) * self.variance, axis=1))

    def _kept(self, missing: float) -> Array:
        """Give the share of the square along each direction that counts, shape (R, d)."""
        size = max(missing, np.finfo(np.float64).tiny)
        return np.asarray((size / (size + self.variance)) ** 2)


@dataclass(frozen=True)
class Directions:
    """What of a loop's harmonics goes with what differs from run to run, shape (R, m) each, as `as_real` orders.

    Attributes:
        elastic, damping: force by which a run is off when its stiffness or damping is off by 100 %, N; of the force's
            harmonics by `elastic_and_damping`.
        shifted: force by which it is off when the zero of its displacement is off by 1 mm, less the mean, N/mm.
    """

    elastic: Array
    damping: Array
    shifted: Array

    def all(self) -> Array:
        """Give all of them, shape (3, R, m)."""
        return np.stack([self.elastic, self.damping, self.shifted])


def of_a_shift(law: Law, motion: Motion, harmonics: Callable[[Array], Array]) -> Array:
    """Give what a law's loops change by when the displacement's zero is off by 1 mm, less the mean, N/mm, (R, m).

    Args:
        law: the law.
        motion: R motions.
        harmonics: gives those of forces on them, N, shape (R, m).
    """
    step = SHIFT_SHARE * motion.slow["A"]
    ahead, behind = (harmonics(force_of_law(law, replace(motion, y=motion.y + shift)).force) for shift in (step, -step))
    shifted = (ahead - behind) / (2 * step)
    shifted[:, 0] = 0.0
    return np.asarray(shifted)
