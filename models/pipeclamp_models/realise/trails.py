"""Changes of states carried along a motion, as machine code: importing this module loads Numba."""

from __future__ import annotations

from numba import njit

from pipeclamp_models.base.arrays import Array


@njit("float64[:,:,::1](float64[:,::1], float64[:,:,::1], float64[:,:,::1])", cache=True)
def carried(start: Array, by_states: Array, inputs: Array) -> Array:
    """Carry changes of states along all samples.

    Args:
        start: before the first sample, (J, M).
        by_states: slopes of each step by the states before it, (n, J, J).
        inputs: what each step adds, (n, J, M).

    Returns:
        after each sample, (n, J, M).
    """
    samples, count, width = inputs.shape
    after = inputs.copy()
    for index in range(samples):
        for state in range(count):
            for before in range(count):
                slope = by_states[index, state, before]
                if slope != 0.0:
                    for place in range(width):
                        came = start[before, place] if index == 0 else after[index - 1, before, place]
                        after[index, state, place] += slope * came
    return after
