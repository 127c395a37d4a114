"""A step of vibration modes, exact for loads that are polynomials in time over it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg import expm

from pipeclamp_models.base.arrays import Array


def modal_step(rates: Array, loads: Array, step: float, powers: int) -> tuple[Array, list[Array]]:
    """Give what a step makes of the state (q, q'), and of loads that are 1, t/h, (t/h)^2/2, .. in it.

    Args:
        rates: q'' from the state, (..., m, 2 m).
        loads: modal loads per unit of each, (..., m, loads).
        step: h, s.
        powers: of time, how many.

    Returns:
        the state at the end, from that at the start, (..., 2 m, 2 m), and from the loads by power, (..., 2 m, loads).
    """
    *models, modes, size = rates.shape
    inputs = loads.shape[-1]
    # Over (w q, q') with w about the highest frequency the entries are alike; and over t/h, so are the inputs'.
    w = np.sqrt(np.maximum(1.0, np.abs(rates[..., :modes]).max(axis=(-2, -1))))[..., None, None]
    whole = np.zeros((*models, size + powers * inputs, size + powers * inputs))
    whole[..., :modes, modes:size] = step * w * np.eye(modes)
    whole[..., modes:size, :modes] = step * rates[..., :modes] / w
    whole[..., modes:size, modes:size] = step * rates[..., modes:]
    whole[..., modes:size, size : size + inputs] = step * loads
    places = [slice(size + power * inputs, size + (power + 1) * inputs) for power in range(powers)]
    for lower, higher in pairwise(places):
        whole[..., lower, higher] = np.eye(inputs)
    found = expm(whole)[..., :size, :]
    found[..., :modes, :] /= w
    found[..., :modes] *= w
    return found[..., :size], [found[..., place] for place in places]
