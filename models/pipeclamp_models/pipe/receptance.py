"""The frequency response of modes, at many frequencies at once."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray


def are_coupled(stiffness: Array, damping: Array) -> bool:
    """Tell whether modes act on each other, by their matrices (m, m)."""
    apart = ~np.eye(len(stiffness), dtype=bool)
    return bool(np.any(stiffness[apart]) or np.any(damping[apart]))


def receptance(
    stiffness: Array, damping: Array, loads: Array, observed: Array, omega: Array, *, coupled: bool
) -> ComplexArray:
    """Give what points move per unit of each load, q'' + damping q' + stiffness q = loads u, s = observed q.

    Args:
        stiffness, damping: of the modes, (m, m).
        loads: (m, inputs).
        observed: (points, m).
        omega: rad/s, of any shape.
        coupled: whether the modes act on each other, as of `are_coupled`.

    Returns:
        omega's shape and (points, inputs).
    """
    if not coupled:
        dynamic = np.diag(stiffness) - omega[..., None] ** 2 + 1j * omega[..., None] * np.diag(damping)
        modal = loads / dynamic[..., None]
    else:
        square, linear = omega[..., None, None] ** 2, 1j * omega[..., None, None]
        dynamic = stiffness - square * np.eye(len(stiffness)) + linear * damping
        modal = np.linalg.solve(dynamic, np.broadcast_to(loads, (*omega.shape, *loads.shape)))
    return np.asarray(observed @ modal, dtype=np.complex128)
