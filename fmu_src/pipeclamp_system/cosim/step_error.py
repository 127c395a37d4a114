"""How far a co-simulation is off for its macro step, as the same run in another step tells.

No balance of energy sees all of it: a force that is late or cut off is stiffness and mass too, and near a resonance the
pipe magnifies what is missing, the more the less it is damped. Two runs in steps of h and r h, of a scheme of order p,
differ by r^p - 1 times the error of the first (Richardson's extrapolation). Where a force steps, as dry friction's that
turns, it steps somewhere within a macro step, and no scheme is better than of order 1.
"""

from __future__ import annotations

from itertools import product
from math import inf

import numpy as np
from scipy.interpolate import CubicSpline

from pipeclamp_system.cosim.repetition import LAST_SHARE
from pipeclamp_system.cosim.result import CosimResult
from pipeclamp_system.description.scheme import ORDER

STILL_SHARE = 1e-6
"""What moves by less than this share of what moves most is not asked."""


def step_error(result: CosimResult, other: CosimResult) -> float:
    """Estimate the error that a result owes to its macro step.

    Args:
        result: the one that is judged.
        other: the same run in longer or shorter steps.

    Returns:
        rms of the error of displacement over the rms of displacement: amplitude and phase, over the whole run or its
        last fifth, at the clamp or probe where it is largest; infinite where the steps are the same.
    """
    ratio = (result.time.size - 1) / (other.time.size - 1)
    if ratio == 1.0:
        return inf
    return _difference(result, other) / abs(ratio ** order_of(result, other) - 1)


def order_of(result: CosimResult, other: CosimResult) -> int:
    """Give with which power of the step a result's error falls: its scheme's, or 1 where a clamp's force steps.

    The largest change of a smooth force from point to point falls with the step; that of one which steps doesn't.
    """
    fine, coarse = sorted((result, other), key=lambda run: -run.time.size)
    shorter = (coarse.time.size - 1) / (fine.time.size - 1)
    for name in result.clamp_names:
        changes = [_largest_change(run, f"{name}.f") for run in (fine, coarse)]
        if changes[0] > np.sqrt(shorter) * changes[1]:
            return 1
    return ORDER[result.scheme]


def _largest_change(run: CosimResult, column: str) -> float:
    """Give the largest change from point to point in the last part of a run."""
    begin = int(np.searchsorted(run.time, (1 - LAST_SHARE) * run.time[-1]))
    return float(np.abs(np.diff(run.columns[column][begin:])).max(initial=0.0))


def _difference(result: CosimResult, other: CosimResult) -> float:
    """Give the largest rms difference of two runs, as a share of the motion."""
    fine, coarse = sorted((result, other), key=lambda run: -run.time.size)
    columns = [f"{name}.s" for name in (*result.clamp_names, *result.probe_names)]
    if not columns:
        return 0.0
    seen = np.column_stack([coarse.columns[name] for name in columns])
    truer = CubicSpline(fine.time, np.column_stack([fine.columns[name] for name in columns]))(coarse.time)
    windows = (slice(None), slice(int(np.searchsorted(coarse.time, (1 - LAST_SHARE) * coarse.time[-1])), None))
    least = STILL_SHARE * float(truer.std(axis=0).max())
    shares = [
        float(np.sqrt(np.mean((seen[window, index] - truer[window, index]) ** 2)) / scale)
        for window, index in product(windows, range(len(columns)))
        if (scale := float(truer[window, index].std())) > least
    ]
    return max(shares, default=0.0)
