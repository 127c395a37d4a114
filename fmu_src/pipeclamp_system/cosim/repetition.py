"""Whether a motion under a sine repeats itself from cycle to cycle of the sine.

Its amplitude may stand still though it doesn't: a clamp that strikes, or hardens much, may come round once in two or
three cycles, or never (subharmonic, quasi-periodic, irregular). That isn't the motion that harmonic balance gives.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from pipeclamp_models.base.arrays import Array

REPEATING_SHARE = 0.02
"""Share of a motion's rms by which it may differ from that a cycle before."""

LAST_SHARE = 0.2
"""Of a run, at its end: what has settled is told there."""


def off_a_cycle_before(time: Array, signal: Array, frequency: float) -> float:
    """Give by how much a signal differs at the end of a run, a cycle at least, from itself a cycle before.

    Args:
        time: s, (n,).
        signal: (n,).
        frequency: of the excitation, Hz.

    Returns:
        rms of the difference over that of the signal about its mean; 0 where it stands still, or the run is too short.
    """
    cycle = 1 / frequency
    first = time[-1] - max(LAST_SHARE * (time[-1] - time[0]), cycle)
    if first - cycle < time[0]:
        return 0.0
    last = time >= first
    moved = float(np.std(signal[last]))
    if moved == 0:
        return 0.0
    # Steps needn't divide the cycle.
    before = CubicSpline(time, signal)(time[last] - cycle)
    return float(np.sqrt(np.mean((signal[last] - before) ** 2))) / moved
