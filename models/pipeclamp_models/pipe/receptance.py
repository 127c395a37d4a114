"""The frequency response of modes, at many frequencies at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pipeclamp_models.base.arrays import Array

Complex = NDArray[np.complex128]


def receptance(stiffness: Array, damping: Array, loads: Array, observed: Array, omega: Array) -> Complex:
    """Give what points move per unit of each load, q'' + damping q' + stiffness q = loads u, s = observed q.

    Args:
        stiffness, damping: of the modes, (m, m).
        loads: (m, inputs).
        observed: (points, m).
        omega: rad/s, of any shape.

    Returns:
        omega's shape and (points, inputs).
    """
    both = np.stack([stiffness, damping])
    if np.all(both[:, ~np.eye(len(stiffness), dtype=bool)] == 0):
        dynamic = np.diag(stiffness) - omega[..., None] ** 2 + 1j * omega[..., None] * np.diag(damping)
        modal = loads / dynamic[..., None]
    else:
        square, linear = omega[..., None, None] ** 2, 1j * omega[..., None, None]
        dynamic = stiffness - square * np.eye(len(stiffness)) + linear * damping
        modal = np.linalg.solve(dynamic, np.broadcast_to(loads, (*omega.shape, *loads.shape)))
    return np.asarray(observed @ modal, dtype=np.complex128)
