"""What each column explains beyond the law's own tangents on left-out groups; what noise alone would, at its best.

With the columns freed of what the law's parameters can do, the strength that fits all groups but one is a quotient of
sums over those groups, and what it explains of the group left out follows from that group's sums. So signs of runs can
be turned hundreds of times at the cost of sums.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from pipeclamp_identification.discovery.columns import TermColumn
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray

FLIPS = 400
"""Times that signs of runs are turned."""
CHANCE_SHARE = 0.01
"""A term is beyond chance where it explains more than the best of the grammar does in all but this share of turns."""
WORTH_FITTING = 0.5
"""And worth fitting where it does so at a start of its parameters in all but this share: fitted, it explains more."""
ALIKE_CORRELATION = 0.9
"""Columns that correlate by more than this act alike."""
SAME_CORRELATION = 0.999
SEED = 20_261_123
SMALLEST_SQUARES = 1e-9
LEFT_BY_ROUNDING = 1e-6
"""What is left of a column beyond the law's tangents below this share of it is rounding."""


@dataclass(frozen=True)
class Screened:
    """Columns on the left-out groups, C of them.

    Attributes:
        columns: what they are.
        free: their whitened changes without what the law can do, shape (R m, C), of unit length.
        by_run: products with the residual and squares, summed over each run, shapes (R, C).
        groups: of each run, shape (R,).
        signed: whether each may be negative, shape (C,).
        lengths: of the changes before they were made unit, shape (C,).
    """

    columns: Sequence[TermColumn]
    free: npt.NDArray[np.float32]
    by_run: tuple[Array, Array]
    groups: IntArray
    signed: BoolArray
    lengths: Array

    def explained(self, signs: Array | None = None) -> Array:
        """Give the squares that each column explains on groups that its strength wasn't fitted to, shape (C,).

        Args:
            signs: of each run's residual, shape (R,).
        """
        products = self.by_run[0]
        if signs is not None:
            products = products * signs[:, None]
        own, squares = self._by_group(products), self._squares_by_group
        strength = (np.sum(own, axis=0) - own) / self._squares_of_others
        strength = np.where(self.signed, strength, np.maximum(strength, 0.0))
        return np.asarray(np.sum(2 * strength * own - strength**2 * squares, axis=0))

    @cached_property
    def _squares_by_group(self) -> Array:
        return self._by_group(self.by_run[1])

    @cached_property
    def _squares_of_others(self) -> Array:
        """Of each group: those of all the others, shape (groups, C)."""
        squares = self._squares_by_group
        return np.asarray(np.maximum(np.sum(squares, axis=0) - squares, SMALLEST_SQUARES))

    def _by_group(self, by_run: Array) -> Array:
        """Sum what each run has over the groups, shape (groups, C)."""
        sums: Array = np.zeros((int(self.groups.max()) + 1, by_run.shape[1]))
        for group, own in zip(self.groups, by_run, strict=True):  # eight times as fast as `np.add.at`
            sums[group] += own
        return sums

    def strength(self, place: int) -> float:
        """Give the strength that fits best, of one column."""
        products, squares = (sums[:, place].sum() for sums in self.by_run)
        return float(products / max(squares, SMALLEST_SQUARES))

    def by_chance(self, share: float = CHANCE_SHARE) -> float:
        """Give what the best column explains where signs of runs are turned at random, but for a share of the turns."""
        random = np.random.default_rng(SEED)
        runs = len(self.groups)
        best = [self.explained(signs=random.choice([-1.0, 1.0], runs)).max() for _ in range(FLIPS)]
        return float(np.quantile(best, 1 - share))

    def without(self, place: int) -> Screened:
        """Give the same on what one column, at the strength that fits best, leaves of the residual."""
        products, squares = self.by_run
        own = self.free[:, place].reshape(len(self.groups), -1)
        shared = np.einsum("rmc,rm->rc", self.free.reshape(*own.shape, -1), own)
        return replace(self, by_run=(products - self.strength(place) * shared, squares))

    def best_first(self, most: int) -> list[int]:
        """Give the columns that explain most, none that acts as a better one does.

        Of those that are as good as equal the one of fewest parameters stands for all.
        """
        explained = self.explained()
        parameters = np.array([len(column.term.declaration.parameters) for column in self.columns])
        chosen: list[int] = []
        met = np.zeros(len(explained), dtype=np.bool_)
        for best in np.argsort(-explained):
            if len(chosen) == most or explained[best] <= 0:
                break
            if met[best]:
                continue
            same = self.alike(best, SAME_CORRELATION) & (explained > 0)
            same[best] = True
            met |= same
            alike = np.flatnonzero(same)
            place = int(alike[np.lexsort((-explained[alike], parameters[alike]))[0]])
            if all(self.columns[other].term != self.columns[place].term for other in chosen):
                chosen.append(place)
        return chosen

    def starts(self, place: int, most: int) -> list[int]:
        """Give a column, and others of its term, at other starts, that explain something: best first, none alike."""
        explained = self.explained()
        own = [at for at, column in enumerate(self.columns) if column.term == self.columns[place].term]
        chosen = [place]
        for start in sorted((at for at in own if explained[at] > 0), key=lambda at: -explained[at]):
            if len(chosen) < most and not any(self.alike(other)[start] for other in chosen):
                chosen.append(start)
        return chosen

    def alike(self, place: int, least: float = ALIKE_CORRELATION) -> BoolArray:
        """Tell which columns act as one does, with this correlation at least, shape (C,)."""
        return np.asarray(np.abs(self.free.T @ self.free[:, place]) > least)


def screened_columns(columns: Sequence[TermColumn], residual: Array, jacobian: Array, groups: IntArray) -> Screened:
    """Free columns of what a law's parameters can do.

    Args:
        columns: what is tried.
        residual: whitened, of the law, shape (R, m).
        jacobian: its derivatives, shape (R, m, P).
        groups: of each run, shape (R,).
    """
    runs, size = residual.shape
    scale = np.linalg.norm(jacobian.reshape(runs * size, -1), axis=0)
    tangents, _ = np.linalg.qr(jacobian.reshape(runs * size, -1)[:, scale > 0] / scale[scale > 0])
    changes = np.stack([column.change.ravel() for column in columns], axis=1)
    before = np.linalg.norm(changes, axis=0)
    changes -= tangents @ (tangents.T @ changes)
    left = residual.ravel() - tangents @ (tangents.T @ residual.ravel())
    length = np.linalg.norm(changes, axis=0)
    own = length > LEFT_BY_ROUNDING * before
    changes = np.where(own, changes / np.where(own, length, 1.0), 0.0)
    by_run = changes.reshape(runs, size, -1)
    products = np.einsum("rmc,rm->rc", by_run, left.reshape(runs, size))
    return Screened(
        columns, changes.astype(np.float32), (products, np.sum(by_run**2, axis=1)), groups,
        np.array([column.signed for column in columns]), np.where(own, length, np.inf),
    )  # fmt: skip
