"""A force channel that isn't straight: a rival of every effect that gives more or less beyond a force.

What a load cell or its amplifier makes of the force is a function of the force alone, whatever amplitude, frequency or
temperature made it; what a clamp does follows its motion. Over several conditions the two part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import UNEXPLAINED_SHARE
from pipeclamp_identification.fitting.joint.starts import Linearised
from pipeclamp_identification.loops.loops import on_grid
from pipeclamp_identification.signals.real_harmonics import mean_squares_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import newtons

LEVELS_SHARE = np.arange(10) / 10
"""Shares of the largest force from which on a channel is asked for a bend."""
LARGEST_SHARE = 0.1
"""No channel that is in use bends by more; a spring may."""
OWN_PARAMETERS = 2
"""Level and share."""
WHERE = {1: "in the positive direction", -1: "in the negative direction", 0: "in either direction"}


@dataclass(frozen=True)
class BentChannel:
    """A force channel that gives more or less beyond a force, beside the law as it is.

    Attributes:
        level: from which force on, N.
        share: by which it gives more there; below zero less.
        side: of the force, 1 or -1; 0 for both.
        takes: share of what is missing (mean square beyond the noise, all tests) that it explains.
        akaike: Akaike's criterion, as of `Judged`.
    """

    level: float
    share: float
    side: int
    takes: float
    akaike: float

    def words(self) -> str:
        """Say what would explain it, and what to look at."""
        share = f"{abs(self.share):.2%} {'more' if self.share > 0 else 'less'}"
        bent = f"{share} of what lies beyond {newtons(self.level)}, {WHERE[self.side]},"
        uneven = f"{share} {WHERE[self.side]} than in the other"
        return (
            f"a force channel that gives {bent if self.level else uneven} takes {self.takes:.0%} of what is missing: "
            "look at load cell and amplifier first"
        )


def bent_channel(problem: Problem, law: Judged) -> BentChannel | None:
    """Find the bend of the force channel that explains best what a law misses; None where none explains it.

    Args:
        problem: the data.
        law: the law as it is; its parameters follow linearly.
    """
    residual = law.fitted.residual
    squares = float(np.sum(residual**2))
    missed = _beyond_noise(residual, problem)
    found: list[BentChannel] = []
    for side, level, bend in _bends(on_grid(problem.loops.force, problem.harmonics.motion.y.shape[1])):
        (seen,) = problem.observations.in_units(problem.harmonics.transformed(bend)[None])
        ways = np.concatenate([law.fitted.jacobian, -seen[..., None]], axis=2)
        step = Linearised((), residual.ravel(), ways.reshape(residual.size, -1)).step()
        left = residual + ways @ step
        takes = 1 - _beyond_noise(left, problem) / missed if missed > 0 else 0.0
        akaike = law.akaike - squares + float(np.sum(left**2)) + 2 * OWN_PARAMETERS
        found.append(BentChannel(level, float(step[-1]), side, min(takes, 1.0), akaike))
    able = [one for one in found if abs(one.share) < LARGEST_SHARE and one.takes > 1 - UNEXPLAINED_SHARE**2]
    return min(able, key=lambda one: one.akaike, default=None)


def _beyond_noise(residual: Array, problem: Problem) -> float:
    """Give the mean square of whitened residuals beyond the noise, N2; what isn't measured counts for nothing."""
    plain = np.linalg.solve(problem.observations.whitener, residual[..., None])[..., 0]
    seen = problem.harmonics.seen
    excess = mean_squares_of(np.where(seen, plain, 0.0)) - mean_squares_of(
        np.where(seen, np.sqrt(problem.noise.total_variance()), 0.0)
    )
    return float(np.mean(excess))


def _bends(force: Array) -> Iterator[tuple[int, float, Array]]:
    """Give side, level in N and what goes beyond, of the shape of the force over the cycle, N."""
    largest = float(np.max(np.abs(force)))
    for level in LEVELS_SHARE * largest:
        beyond = np.sign(force) * np.maximum(np.abs(force) - level, 0.0)
        yield 1, float(level), np.where(force > 0, beyond, 0.0)
        if level > 0:  # less in one direction is more in the other; less in both is a gain, which no law can tell
            yield -1, float(level), np.where(force < 0, beyond, 0.0)
            yield 0, float(level), beyond
