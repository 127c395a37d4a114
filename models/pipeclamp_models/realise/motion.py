"""Motions of a clamp, many at once: what laws are evaluated along."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import column_of
from pipeclamp_models.steps.ways import Ways

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True)
class Turning:
    """Samples in whose interval, or next to it, the velocity changes its sign.

    Attributes:
        row, sample: where they are, shape (K,).
        v: the sample's velocity and then those of its interval in mm/s, shape (K, 1 + q).
        weight: of each of the interval's in the mean over it, shape (K, q).
        share: by which the mean stands in the place of the sample, shape (K,).
    """

    row: IntArray
    sample: IntArray
    v: Array
    weight: Array
    share: Array


@dataclass(frozen=True)
class Motion:
    """Motions, one a row, sampled at n equal steps: one whole cycle each, or a record that starts at rest.

    Attributes:
        y, v, a: displacement mm, velocity mm/s, acceleration mm/s2; shape (R, n).
        slow: slow signals by name (`A` mm, `f` Hz, `T` K, `N`, `rho`, further conditions), each of shape (R, 1), or
            (R, n) where it changes along the row.
        h: time between samples in s, shape (R, 1).
        periodic: whether each row is a whole cycle that repeats.
        assumed: slow signals that nobody knows, whose values only let laws be evaluated that don't follow them.
        rest: where a record's rows lie at rest before their first sample, mm, shape (R, 1) or ().
        memory: the law's states there, shape (R,) each; None for an unloaded memory.
        ways: those on which a record goes from sample to sample, as an FMU's step goes; None where it is one straight
            move.
    """

    y: Array
    v: Array
    a: Array
    slow: Mapping[str, Array]
    h: Array
    periodic: bool = True
    assumed: frozenset[str] = frozenset()
    rest: Array | float = 0.0
    memory: Sequence[Array] | None = None
    ways: Ways | None = None

    @cached_property
    def y_previous(self) -> Array:
        """Displacement before the move to each sample, shape (R, n): a sample before, or where its last way begins."""
        if self.ways:
            return self.ways.y_previous[:, self.ways.last]
        before = np.roll(self.y, 1, axis=1)
        if not self.periodic:
            before[:, :1] = self.rest
        return before

    @property
    def moved_in(self) -> Array:
        """Time of the move from there in s, shape (R, 1) or (R, n)."""
        return self.ways.h[:, self.ways.last] if self.ways else self.h

    @property
    def between(self) -> Motion:
        """The motion along the ways between a record's samples, each a straight move: itself where it has none."""
        if not self.ways:
            return self
        slow = {name: self.ways.spread(values) for name, values in self.slow.items()}
        a = self.a[:, self.ways.step]
        return replace(self, y=self.ways.y, v=self.ways.v, a=a, slow=slow, h=self.ways.h, ways=None)

    def rows(self, chosen: IntArray) -> Motion:
        """Give some of the motions."""
        slow = {name: values[chosen] for name, values in self.slow.items()}
        rest = np.broadcast_to(self.rest, self.h.shape)[chosen]
        memory = None if self.memory is None else [state[chosen] for state in self.memory]
        return replace(
            self, y=self.y[chosen], v=self.v[chosen], a=self.a[chosen], slow=slow, h=self.h[chosen], rest=rest,
            memory=memory, ways=self.ways and self.ways.rows(chosen),
        )  # fmt: skip

    @cached_property
    def turning(self) -> Turning:
        """The samples of periodic motions whose interval, half a step to each side, holds a reversal.

        Beyond the interval the mean fades out over another half step, so that force stays continuous in the motion.
        """
        reach = np.abs(self.a) * self.h / 2
        row, sample = np.nonzero((np.abs(self.v) < 2 * reach) & self.periodic)
        middle, half = self.v[row, sample], reach[row, sample]
        # From the interval's one end to the reversal, if it is inside, and from there to the other end; v grows evenly.
        ends = np.stack([middle - half, np.clip(0.0, middle - half, middle + half), middle + half], axis=1)
        length = np.diff(ends)[:, :, None]
        v = (ends[:, :-1, None] + length * (1 + NODES) / 2).reshape(len(row), 2 * len(NODES))
        weight = (length * WEIGHTS / 2).reshape(v.shape) / (2 * half[:, None])
        own_first = np.concatenate([middle[:, None], v], axis=1)
        return Turning(row, sample, own_first, weight, np.clip(2 - np.abs(middle) / half, 0.0, 1.0))


def sinusoids(
    amplitude: npt.ArrayLike,
    frequency: npt.ArrayLike,
    temperature: npt.ArrayLike,
    samples: int = 512,
    about: float = 0.0,
) -> Motion:
    """Give the motions y_m + A cos(2 pi f t) of one cycle.

    Args:
        amplitude: mm, frequency: Hz, temperature: K; shapes that broadcast to (R,).
        samples: samples in the cycle.
        about: y_m, mm.
    """
    A, f, T = (
        np.atleast_1d(column)[:, None]
        for column in np.broadcast_arrays(*(np.asarray(entry, float) for entry in (amplitude, frequency, temperature)))
    )
    phase = 2 * np.pi * np.arange(samples) / samples
    omega = 2 * np.pi * f
    moved = A * np.cos(phase)
    slow = {"A": A, "f": f, "T": T}
    return Motion(about + moved, -A * omega * np.sin(phase), -(omega**2) * moved, slow, 1.0 / (f * samples))


def refuse_unknown_conditions(slow: Iterable[str], motion: Motion) -> None:
    """Refuse motions that don't state a condition which the law depends on.

    Args:
        slow: names of the slow signals that the law depends on.
        motion: the motions.

    Raises:
        UserError: with the column that is missing.
    """
    for name in slow:
        if name not in motion.slow:
            known = ", ".join(sorted(column_of(entry) for entry in motion.slow))
            raise UserError(
                f"the law depends on {column_of(name)}, which the tests don't state; got {known}; "
                "expected a column of that name in runs.csv"
            )
