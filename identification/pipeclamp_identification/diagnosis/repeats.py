"""Runs at the same stated conditions: what differs between them follows something that isn't stated, and no law of what
is stated explains it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from pipeclamp_identification.diagnosis.noise import MOST_SCATTER, NoiseModel
from pipeclamp_identification.diagnosis.thresholds import REAL_LACK_CHANCE
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import SAME_KELVIN, group_names, set_points
from pipeclamp_models.base.arrays import Array, IntArray

MOST_OF_MISFIT = 0.5
"""Where more of what a law misses than this share (mean square) differs between repeats, an effect of what is stated
has the smaller part to explain, and chance in the larger part names one."""


@dataclass(frozen=True)
class Unstated:
    """What differs between runs at the same stated conditions by more than on any rig.

    Attributes:
        runs: how many runs have such repeats.
        shares: standard deviation by which they differ, as a share of stiffness or damping, by that name.
        of_misfit: share of what the law misses in these runs (mean square) that differs between repeats.
        temperature_known: whether the runs' temperature is stated.
        texts: columns of texts that tell repeats apart, but hardly repeat themselves: no groups are made of them.
    """

    runs: int
    shares: dict[str, float]
    of_misfit: float
    temperature_known: bool
    texts: tuple[str, ...] = ()

    @property
    def is_most(self) -> bool:
        """Whether most of what the law misses differs between runs at the same stated conditions."""
        return self.of_misfit > MOST_OF_MISFIT

    def words(self) -> str:
        """Say it, and what to do."""
        differ = " and ".join(f"{100 * share:.2g}% of {name}" for name, share in self.shares.items())
        what = (
            "specimen, preload or mounting, say" if self.temperature_known else "temperature, specimen or preload, say"
        )
        found = (
            f"{self.runs} runs are at the same stated conditions as others, and differ from them by {differ} (standard "
            "deviation), more than rigs scatter: "
        )
        if self.texts:
            return (
                f"{found}only {' and '.join(self.texts)} in runs.csv may tell why, of which no groups can be made (two "
                "of them need two runs each), and no effect explains it; state it as a number, or test each group "
                "again, and identify again"
            )
        return (
            f"{found}what differs between them isn't stated ({what}), and no effect explains it; state it in runs.csv, "
            "and identify again"
        )


def unstated(loops: Loops, noise: NoiseModel, residual: Array, missed: Array) -> Unstated | None:
    """Find whether runs at the same stated conditions differ by more than rigs scatter; None where they don't.

    Each run's share is its residual's weighted projection on its elastic and on its damping force. Between repeats
    nothing that follows the conditions differs, so that their pooled variance, less what noise from cycle to cycle
    makes, is told without a law's help. It counts where scatter as large as on any rig makes so much with next to no
    chance.

    Args:
        loops: R rows.
        noise: of each row's harmonics.
        residual: measured less the best law so far in N, shape (R, 2 H + 1).
        missed: measured less the law as it is, in the same way.
    """
    repeats = _repeats(loops)
    runs = np.array([len(group) for group in repeats])
    free = int(np.sum(runs - 1))
    if free == 0:
        return None
    shares = {}
    for name, direction in (("stiffness", noise.directions.elastic), ("damping", noise.directions.damping)):
        weight = np.sum(direction**2 / noise.variance, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share, from_noise = np.sum(residual * direction / noise.variance, axis=1) / weight, 1 / weight
        excess = sum(
            np.sum((share[group] - share[group].mean()) ** 2) - (1 - 1 / len(group)) * np.sum(from_noise[group])
            for group in repeats
        )
        if np.isfinite(excess) and excess > MOST_SCATTER**2 * chdtri(free, REAL_LACK_CHANCE):
            shares[name] = float(np.sqrt(excess / free))
    known = bool(np.all(np.isfinite(loops.temperature_K)))
    texts = _texts_between(repeats, loops)
    return Unstated(int(runs.sum()), shares, _between(repeats, missed), known, texts) if shares else None


def _texts_between(repeats: Sequence[IntArray], loops: Loops) -> tuple[str, ...]:
    """Give the columns of texts that differ within every set of repeats, and make no groups of the runs."""
    labels = [row.labels for row in loops.rows]
    first = np.unique(loops.run, return_index=True)[1]
    return tuple(
        column
        for column in labels[0]
        if all(len({labels[row][column] for row in group}) > 1 for group in repeats)
        and not group_names([labels[row][column] for row in first])
    )


def _between(repeats: Sequence[IntArray], missed: Array) -> float:
    """Give the share of what is missed (mean square) that differs between repeats."""
    deviations = sum(np.sum((missed[group] - missed[group].mean(axis=0)) ** 2) for group in repeats)
    free = sum(len(group) - 1 for group in repeats)
    whole = np.mean([np.sum(missed[row] ** 2) for group in repeats for row in group])
    return float(deviations / free / whole) if whole > 0 else 0.0


def _repeats(loops: Loops) -> list[IntArray]:
    """Give the first rows of runs at the same stated conditions, several runs a group."""
    first = np.unique(loops.run, return_index=True)[1]
    keys = [np.unique([name or "" for name in loops.specimen], return_inverse=True)[1][first]]
    keys += [*(places for _, places in stated_set_points(loops, first)), set_points(loops.cycle[first])]
    groups = np.unique(np.stack(keys, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    members = (first[groups == number] for number in range(groups.max() + 1))
    return [group for group in members if len(group) > 1]


def stated_set_points(loops: Loops, rows: IntArray) -> list[tuple[Array, IntArray]]:
    """Give each condition that is stated of runs, with its set points, but for the cycles that they have seen before.

    Args:
        loops: the tests.
        rows: one of each run, N of them.

    Returns:
        for each condition its values, nan where not known, and which run's place stands for the set point, shape (N,)
        each; those of a condition that isn't known share one.
    """
    fixed = (loops.amplitude_mm, loops.frequency_Hz, loops.density_g_cm3)
    values = [each[rows] for each in (*fixed, *loops.conditions.values())]
    temperatures = loops.temperature_K[rows]
    return [(temperatures, set_points(temperatures, SAME_KELVIN)), *((each, set_points(each)) for each in values)]
