"""Samples at reversals: where force steps with the sign of the velocity, and the smallest phase error flips it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray

PLACES_PER_CYCLE = 512
"""Points of the cycle between which reversals are looked for."""


@dataclass(frozen=True)
class Bridged:
    """The samples in whose interval, half a step to each side, the motion reverses.

    Such a sample says more about its timing than about the force. It stands for the mean over its interval instead:
    what the harmonics leave over at its neighbours, each for its own side of the reversal, stands for what they leave
    over at the sample. Measured and computed forces are bridged alike, so that no law is favoured.

    Attributes:
        places: of the sample before, the sample itself, and the one after, shape (3, K).
        before: the share of the sample's interval that lies before the reversal, shape (K,).
        yielding: by how much a change of the sample by one moves it against its neighbours, once the harmonics have
            followed; shape (K,).
    """

    places: IntArray
    before: Array
    yielding: Array

    @property
    def sample(self) -> IntArray:
        """Places of the samples themselves, shape (K,)."""
        return np.asarray(self.places[1])

    def within(self, first: int, last: int) -> Bridged:
        """Give those of one whole cycle, of samples `first` to `last` - 1, that begins and ends with itself."""
        inside = slice(*np.searchsorted(self.sample, (first, last)))
        places = (self.places[:, inside] - first) % (last - first)
        return Bridged(places, self.before[inside], self.yielding[inside])

    def between(self, error: Array) -> Array:
        """Give what the neighbours say of an error, each for its own side of the reversal.

        Args:
            error: at `places`, shape (..., 3, K).

        Returns:
            at the samples, shape (..., K).
        """
        return np.asarray(self.before * error[..., 0, :] + (1 - self.before) * error[..., 2, :])

    def change(self, left_over: Array) -> Array:
        """Give by how much bridging changes the samples, so that harmonics fitted to them leave over what they should.

        Args:
            left_over: what the harmonics leave over at `places`, shape (..., 3, K).

        Returns:
            at the samples, shape (..., K).
        """
        return np.asarray((self.between(left_over) - left_over[..., 1, :]) / self.yielding)

    @property
    def weights(self) -> Array:
        """By what `change` weighs what is left over at each of `places`, shape (3, K)."""
        return self.change(np.broadcast_to(np.eye(3)[:, :, None], (3, 3, len(self.before))))


def bridged(displacement: ComplexArray, phase: Array, per_cycle: float, count: int) -> Bridged:
    """Find the samples at reversals.

    Args:
        displacement: harmonics of the mean loop, mm, shape (H + 1,).
        phase: of each sample within its cycle, rad, 0 where the fundamental is largest, in the order of time; (N,).
            They fill whole cycles: the first follows the last.
        per_cycle: samples in a cycle.
        count: highest harmonic of the force.
    """
    following = _within_a_turn(np.roll(phase, -1) - phase) / 2
    leading = np.roll(following, 1)
    found, shares = [], []
    for reversal in _phases_of_reversals(displacement):
        off = _within_a_turn(reversal - phase)
        inside = np.flatnonzero((off >= -leading) & (off < following))
        found.append(inside)
        shares.append((off[inside] + leading[inside]) / (leading[inside] + following[inside]))
    sample, order = np.unique(np.concatenate(found), return_index=True)
    # Where a motion reverses at neighbouring samples, there is no neighbour to ask.
    gap = np.diff(sample, append=sample[:1] + len(phase))
    apart = (gap > 1) & (np.roll(gap, 1) > 1)
    sample, before = sample[apart], np.concatenate(shares)[order][apart]
    places = np.stack([sample - 1, sample, sample + 1]) % len(phase)
    # The harmonics follow a change of the sample, and leave over less of it than all.
    off = phase[places] - phase[sample]
    followed = (1 + 2 * np.sum(np.cos(off[..., None] * np.arange(1, count + 1)), axis=-1)) / per_cycle
    at = Bridged(places, before, np.ones_like(before))
    return replace(at, yielding=at.change(followed) + 1.0)


def _within_a_turn(angle: Array) -> Array:
    return np.asarray(angle - 2 * np.pi * np.rint(angle / (2 * np.pi)))


def _phases_of_reversals(displacement: ComplexArray) -> Array:
    """Give where the velocity changes its sign, rad, by linear interpolation between many points."""
    order = np.arange(len(displacement))
    velocity = ((1j * order * displacement) @ _phasors(len(displacement))).real
    following = np.roll(velocity, -1)
    crossing = np.flatnonzero((velocity >= 0) != (following >= 0))
    share = velocity[crossing] / (velocity[crossing] - following[crossing])
    return np.asarray((crossing + share) * (2 * np.pi / PLACES_PER_CYCLE))


@cache
def _phasors(count: int) -> ComplexArray:
    """Return exp(i n theta) of `count` harmonics at the points of the cycle, shape (count, PLACES_PER_CYCLE)."""
    theta = 2 * np.pi * np.arange(PLACES_PER_CYCLE) / PLACES_PER_CYCLE
    return np.asarray(np.exp(1j * np.outer(np.arange(count), theta)))
