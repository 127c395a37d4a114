"""A pipe's modes as a state space (python-control), its truncation, and what the truncation costs."""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BAND_POINTS = 40
"""Frequencies at which the responses are compared."""

MOST_MODES = 60
"""Modes above the kept ones that the full model's state space has; those above them are still, in the band."""


@dataclass(frozen=True, eq=False)
class ModalModel:
    """Vibration modes with their loads and their points of observation.

    q'' + damping q' + omega^2 q = loads u, s = shapes q.

    Attributes:
        omega: rad/s, (m,).
        damping: 2 zeta omega, 1/s, (m,).
        loads: modal load per unit input, (m, inputs).
        shapes: displacement per unit modal displacement, (outputs, m).
    """

    omega: Array
    damping: Array
    loads: Array
    shapes: Array


@dataclass(frozen=True)
class ReductionErrors:
    """What the reduction costs: the largest error over all loads and points.

    Attributes:
        static_truncated: share of the static compliance that the left-out modes carry, were nothing put in their place.
        static: error of the static compliance of the reduced model, as a share of it.
        response: error of the frequency response up to the stated frequency, as a share of the largest there.
    """

    static_truncated: float
    static: float
    response: float


def state_space(model: ModalModel, moving: int | None = None) -> control.StateSpace:
    """Give the state space of modes, states (q1, q1', q2, q2', ...), inputs the loads, outputs the displacements.

    Args:
        model: the modes.
        moving: how many of them have states; the others add their static compliance. All of them unless told.
    """
    count = model.omega.size if moving is None else min(moving, model.omega.size)
    A = np.zeros((2 * count, 2 * count))
    position = np.arange(count) * 2
    A[position, position + 1] = 1.0
    A[position + 1, position] = -(model.omega[:count] ** 2)
    A[position + 1, position + 1] = -model.damping[:count]
    B = np.zeros((2 * count, model.loads.shape[1]))
    B[1::2] = model.loads[:count]
    C = np.zeros((model.shapes.shape[0], 2 * count))
    C[:, 0::2] = model.shapes[:, :count]
    D = (model.shapes[:, count:] / model.omega[count:] ** 2) @ model.loads[count:]
    return control.ss(A, B, C, D)


def truncate(full: control.StateSpace, kept: int) -> control.StateSpace:
    """Give the state space with the first `kept` modes and nothing in place of the others."""
    left_out = list(range(2 * kept, full.nstates))
    moving = control.ss(full.A, full.B, full.C, 0.0)
    return control.model_reduction(moving, left_out, method="truncate", warn_unstable=False) if left_out else moving


def reduction_errors(full: ModalModel, reduced: ModalModel, kept: int, omega_up_to: float) -> ReductionErrors:
    """Compare a reduced model with the full one.

    Args:
        full: all modes of the finite element model, ascending.
        reduced: the modes that stand for them.
        kept: how many of the full model's modes the reduced one holds unchanged.
        omega_up_to: the stated frequency, rad/s.
    """
    if not full.loads.size or not full.shapes.size:
        return ReductionErrors(0.0, 0.0, 0.0)
    whole, replacement = state_space(full, kept + MOST_MODES), state_space(reduced)
    truncated = truncate(whole, kept)
    # Rigid body modes have no static compliance: there, "static" is far below the stated frequency.
    low = 1e-3 * omega_up_to if full.omega[0] == 0 else 0.0
    band = np.concatenate([[low], np.linspace(omega_up_to / BAND_POINTS, omega_up_to, BAND_POINTS)])
    exact = _frequency_response(whole, band)
    error = np.abs(_frequency_response(replacement, band) - exact)
    lost = np.abs(_frequency_response(truncated, band[:1]) - exact[:, :, :1])
    return ReductionErrors(
        static_truncated=_largest_share(lost, exact[:, :, :1]),
        static=_largest_share(error[:, :, :1], exact[:, :, :1]),
        response=_largest_share(error, exact),
    )


def _largest_share(error: Array, response: NDArray[np.complex128]) -> float:
    """Give the largest error as a share of its channel's largest response, (outputs, inputs, frequencies)."""
    scale = np.abs(response).max(axis=2)
    # A probe that (nearly) stands still under a load is measured against the points that move.
    scale = np.maximum(scale, 1e-3 * scale.max(axis=0))
    return float((error.max(axis=2) / np.where(scale > 0, scale, 1.0)).max())


def _frequency_response(system: control.StateSpace, band: Array) -> NDArray[np.complex128]:
    """Give the frequency response, (outputs, inputs, frequencies)."""
    return np.asarray(control.frequency_response(system, band, squeeze=False).complex, dtype=np.complex128)
