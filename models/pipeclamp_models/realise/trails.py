"""Slopes of states carried along motions, as machine code: importing this module loads Numba."""

from __future__ import annotations

from numba import njit

from pipeclamp_models.base.arrays import Array


@njit("float64[:,:,:,::1](float64[:,:,::1], float64[:,:,:,::1], float64[:,:,:,::1])", cache=True)
def carried(start: Array, by_states: Array, inputs: Array) -> Array:
    """Carry slopes along all samples, as `states.trail` says."""
    rows, samples, count, width = inputs.shape
    after = inputs.copy()
    for row in range(rows):
        for index in range(samples):
            for state in range(count):
                for before in range(count):
                    slope = by_states[row, index, state, before]
                    if slope != 0.0:
                        for place in range(width):
                            came = start[row, before, place] if index == 0 else after[row, index - 1, before, place]
                            after[row, index, state, place] += slope * came
    return after
