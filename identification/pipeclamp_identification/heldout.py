"""Left-out groups: how well a law that was fitted to some conditions foretells the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

Rows = npt.NDArray[np.intp]


def condition_groups(amplitude: npt.ArrayLike, frequency: npt.ArrayLike) -> npt.NDArray[np.intp]:
    """Give each run the number of its (amplitude, frequency) group.

    Conditions within 5 % of each other count as the same: drives never hit their set points.

    Args:
        amplitude: mm, shape (R,).
        frequency: Hz, shape (R,).

    Returns:
        group numbers, shape (R,).
    """
    levels = np.stack([_levels(np.asarray(values, dtype=float)) for values in (amplitude, frequency)], axis=1)
    return np.unique(levels, axis=0, return_inverse=True)[1].reshape(-1).astype(np.intp)


def _levels(values: npt.NDArray[np.float64], within: float = 0.05) -> npt.NDArray[np.intp]:
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


def heldout_nrmse(
    groups: npt.NDArray[np.intp], most: int, squared_errors: Callable[[Rows, Rows], tuple[float, float]]
) -> float:
    """Give the error on left-out groups as a share of the force there.

    Args:
        groups: group of each row.
        most: most folds.
        squared_errors: fits to the first rows; gives the sum of squared error and of squared force on the second.
    """
    sums = [squared_errors(used, left_out) for used, left_out in folds(groups, most)]
    return float(np.sqrt(sum(error for error, _ in sums) / sum(force for _, force in sums)))
