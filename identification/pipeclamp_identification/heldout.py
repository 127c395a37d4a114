"""Left-out groups: how well a law that was fitted to some conditions foretells the others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from pipeclamp.law import Law
from pipeclamp.response import law_response
from pipeclamp_identification.fit import fit
from pipeclamp_identification.levels import number_levels
from pipeclamp_identification.loops import Loops
from pipeclamp_identification.observations import LoopObservations, Rows

FOLDS = 8
SAME = 0.05
"""Conditions closer than this share of each other count as the same: drives never hit their set points."""


def condition_groups(amplitude: npt.ArrayLike, frequency: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Give each run the number of its (amplitude, frequency) group.

    Args:
        amplitude: mm, shape (R,).
        frequency: Hz, shape (R,).

    Returns:
        group numbers, shape (R,).
    """
    levels = np.stack([_levels(np.asarray(values, dtype=float)) for values in (amplitude, frequency)], axis=1)
    return np.unique(levels, axis=0, return_inverse=True)[1].reshape(-1).astype(np.intp)


def further_groups(loops: Loops) -> dict[str, npt.NDArray[np.intp]]:
    """Give other ways to leave runs out: by temperature, specimen or further condition, each run's group by name.

    A condition needs three levels: what it does can't be foretold from one.
    """
    conditions = {"temperature": loops.temperature_K, "density": loops.density_g_cm3, **loops.conditions}
    groups = {}
    for name, values in conditions.items():
        levels = number_levels(values, relative=SAME)
        if len(levels) >= 3:
            groups[name] = np.empty(len(values), dtype=np.intp)
            for number, level in enumerate(levels):
                groups[name][level.rows] = number
    specimens = np.unique([name or "" for name in loops.specimen], return_inverse=True)[1]
    if specimens.max() > 0:
        groups["specimen"] = specimens.astype(np.intp)
    return groups


def _levels(values: npt.NDArray[np.float64], within: float = SAME) -> npt.NDArray[np.intp]:
    """Number the levels of positive values; neighbours that differ by less than a share belong together."""
    order = np.argsort(values)
    steps = np.diff(np.log(values[order])) > within
    levels = np.empty(len(values), dtype=np.intp)
    levels[order] = np.concatenate([[0], np.cumsum(steps)])
    return levels


def folds(groups: npt.NDArray[np.intp], most: int) -> Iterator[tuple[Rows, Rows]]:
    """Give (rows to fit, rows left out), whole groups left out at a time, in at most so many folds."""
    count = int(groups.max()) + 1
    number = min(most, count)
    for fold in range(number):
        left_out = groups % number == fold
        yield np.flatnonzero(~left_out), np.flatnonzero(left_out)


def heldout_nrmse(law: Law, loops: Loops, observations: LoopObservations, most: int = FOLDS) -> float:
    """Give the error of a law's structure on (amplitude, frequency) groups that weren't used to fit it.

    Args:
        law: the law, as fitted to all; each fit begins there and weighs by what it leaves over.
        loops: the tests.
        observations: the same, as observations.
        most: most folds.

    Returns:
        error over all left-out loops as a share of their force, scatter included.
    """
    groups = condition_groups(loops.amplitude_mm, loops.frequency_Hz)
    widened = observations.with_discrepancy(law_response(law, observations.motion))
    error = force = 0.0
    for used, left_out in folds(groups, most):
        refitted = fit(law.structure, widened.rows(used), start=law.values).law
        beyond = observations.rows(left_out)
        misfit = beyond.mean_squares(law_response(refitted, beyond.motion))
        error += float(np.sum(misfit + loops.noise_rms_N[left_out] ** 2))
        force += float(np.sum(loops.force_rms_N[left_out] ** 2))
    return float(np.sqrt(error / force))
