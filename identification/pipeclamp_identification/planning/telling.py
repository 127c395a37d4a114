"""What tests on a grid would tell of each effect of the catalogue: at which size it is named, and what hides it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.planning.scene import RivalEffect, Scene
from pipeclamp_identification.planning.seen import Lack, lack_of
from pipeclamp_models.base.arrays import Array, BoolArray

NAMED = 0.9
"""Of the effects of a size, that a plan is to name."""
SMALLEST_SHARE_SOUGHT = 1e-6
"""Share of the law's own force below which no effect is looked for."""
SIZE_HALVINGS = 30
"""Of the range of sizes: the answer is known to a millionth."""


@dataclass(frozen=True, eq=False)
class Power:
    """What a plan names.

    Attributes:
        scene: the effects, each in a size.
        lack: of fit, which the law without them would show.
        away: squared standard deviations by which each effect differs from each of its V rivals; inf where it has
            fewer; shape (E, V).
        more: parameters that each rival has more, same shape.
        outside: standard deviations by which each rival's fit would pass its bounds, 0 where it doesn't, same shape.
    """

    scene: Scene
    lack: Lack
    away: Array
    more: Array
    outside: Array

    def chance(self, newtons: Array | float) -> Array:
        """Give the chance that each effect is named, whose rms force over the grid is so many N, shape (E,)."""
        times = newtons / self.scene.sizes
        away = times[:, None] ** 2 * self.away
        # twice the difference of two log likelihoods is normal with mean `away` and variance 4 `away`
        near = ndtr((RIVAL_LIKELIHOOD - self.more - away) / (2 * np.sqrt(np.clip(away, 1e-300, 1e100))))
        inside = np.where(self.outside > 0, ndtr(-times[:, None] * self.outside), 1.0)
        told = np.min(1.0 - near * inside, axis=1, initial=1.0)
        tried = times * self.scene.sizes >= [one.tried_from for one in self.scene.hidden]
        return np.asarray(np.where(tried, self.lack.chance(times, self.scene.least) * told, 0.0))

    @cached_property
    def sizes(self) -> Array:
        """Give the rms force, N, from which on each effect is named with a chance of `NAMED`; inf: in no size."""
        low, high = (
            np.full_like(self.scene.sizes, SMALLEST_SHARE_SOUGHT * self.scene.force),
            np.full_like(self.scene.sizes, self.scene.force),
        )
        never = self.chance(high) < NAMED
        for _ in range(SIZE_HALVINGS):
            middle = np.sqrt(low * high)
            enough = self.chance(middle) >= NAMED
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return np.where(never, np.inf, high)

    @cached_property
    def told(self) -> BoolArray:
        """Tell which effects can be named at all: in a size that is no larger than the law's own force, shape (E,)."""
        return np.isfinite(self.sizes)

    @cached_property
    def from_newtons(self) -> float:
        """Give the rms force, N, above which `NAMED` of the effects that can be told are named; inf: none can."""
        if not self.told.any():
            return np.inf
        low, high = SMALLEST_SHARE_SOUGHT * self.scene.force, self.scene.force
        for _ in range(SIZE_HALVINGS):
            middle = float(np.sqrt(low * high))
            enough = np.mean(self.chance(middle)[self.told]) >= NAMED
            low, high = (low, middle) if enough else (middle, high)
        return high


def power(scene: Scene, runs: Array) -> Power:
    """Give what a plan names.

    Each effect is taken for true in turn. What the base law, or the base law with another effect, can make up for by a
    refit doesn't count.

    Args:
        scene: what tests would tell.
        runs: how many there are at each condition, shape (R,).
    """
    lack = lack_of(scene.grid, runs, scene.covariance, scene.slopes, scene.does)
    shape = len(scene.hidden), max((len(one.rivals) for one in scene.hidden), default=0)
    away, more, outside = np.full(shape, np.inf), np.zeros(shape), np.zeros(shape)
    for row, one in enumerate(scene.hidden):
        for column, rival in enumerate(one.rivals):
            away[row, column], outside[row, column] = _apart(rival, runs)
            more[row, column] = rival.more
    return Power(scene, lack, away, more, outside)


def _apart(rival: RivalEffect, runs: Array) -> tuple[float, float]:
    """Give the squared standard deviations between an effect and a rival in tests, and those outside its bounds."""
    gram = np.tensordot(runs, rival.gram, axes=1)
    free = np.setdiff1d(np.arange(len(gram) - 1), rival.outside)
    away = gram[-1, -1] - gram[-1, free] @ _solved(gram[np.ix_(free, free)]) @ gram[free, -1]
    if not len(rival.outside):
        return max(float(away), 0.0), 0.0
    inverse = _solved(gram[:-1, :-1])
    steps = inverse @ gram[:-1, -1]
    errors = np.sqrt(np.maximum(np.diag(inverse), 1e-300))
    return max(float(away), 0.0), float(np.max(np.abs(steps / errors)[rival.outside]))


def _solved(gram: Array) -> Array:
    """Give the inverse of a Gram matrix, of what tests determine alone."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return np.asarray(
        np.linalg.pinv(gram / np.outer(scale, scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    )
