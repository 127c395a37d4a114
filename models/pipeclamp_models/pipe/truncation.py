"""A pipe's modes as a state space (python-control), its truncation, and what the truncation costs."""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

from pipeclamp_models.base.arrays import Array

BAND_POINTS = 40
"""Frequencies at which the responses are compared."""

MOST_MODES = 60
"""Modes above the kept ones that the full model's state space has; those above them are still, in the band."""


@dataclass(frozen=True, eq=False)
class ModalModel:
    """Modes with their loads and their points of observation.

    q'' + (damping + coupling_damping) q' + (omega^2 + coupling_stiffness) q = loads u, s = shapes q.

    Attributes:
        omega: rad/s, (m,).
        damping: 2 zeta omega, 1/s, (m,).
        loads: modal load per unit input, (m, inputs).
        shapes: displacement per unit modal displacement, (outputs, m).
        coupling: stiffness, 1/s2, and damping, 1/s, by which axial force and flow couple the modes, each (m, m);
            None without.
    """

    omega: Array
    damping: Array
    loads: Array
    shapes: Array
    coupling: tuple[Array, Array] | None = None

    def matrices(self, count: int) -> tuple[Array, Array]:
        """Give stiffness and damping of the first modes, each (count, count)."""
        stiffness, damping = np.diag(self.omega[:count] ** 2), np.diag(self.damping[:count])
        if self.coupling is None:
            return stiffness, damping
        return stiffness + self.coupling[0][:count, :count], damping + self.coupling[1][:count, :count]


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


def state_space(
    stiffness: Array, damping: Array, loads: Array, shapes: Array, direct: Array | float = 0.0
) -> control.StateSpace:
    """Give q'' + damping q' + stiffness q = loads u, s = shapes q + direct u as a state space, states (q, q').

    Args:
        stiffness, damping: (m, m).
        loads: (m, inputs).
        shapes: (outputs, m).
        direct: (outputs, inputs), or 0.
    """
    none = np.zeros_like(stiffness)
    A = np.block([[none, np.eye(len(stiffness))], [-stiffness, -damping]])
    return control.ss(A, np.vstack([np.zeros_like(loads), loads]), np.hstack([shapes, np.zeros_like(shapes)]), direct)


def modal_state_space(model: ModalModel, moving: int | None = None) -> control.StateSpace:
    """Give the state space of modes, inputs the loads, outputs the displacements.

    Args:
        model: the modes.
        moving: how many of them have states; the others add their static compliance. All of them unless told.
    """
    count = model.omega.size if moving is None else min(moving, model.omega.size)
    static = (model.shapes[:, count:] / model.omega[count:] ** 2) @ model.loads[count:]
    return state_space(*model.matrices(count), model.loads[:count], model.shapes[:, :count], static)


def truncate(full: control.StateSpace, kept: int) -> control.StateSpace:
    """Give the state space with the first `kept` modes and nothing in place of the others."""
    modes = full.nstates // 2
    left_out = [*range(kept, modes), *range(modes + kept, 2 * modes)]
    moving = control.ss(full.A, full.B, full.C, 0.0)
    return control.model_reduction(moving, left_out, method="truncate", warn_unstable=False) if left_out else moving


class Reference:
    """The full model's response over the band, against which reductions are judged."""

    def __init__(self, full: ModalModel, kept: int, omega_up_to: float) -> None:
        """Compute the response once.

        Args:
            full: all modes of the finite element model, ascending.
            kept: how many of them lie in the band.
            omega_up_to: end of the band, rad/s.
        """
        self.most = min(kept + MOST_MODES, full.omega.size)
        self._whole = modal_state_space(full, self.most)
        # Rigid body modes have no static compliance: there, "static" is far below the stated frequency.
        low = 1e-3 * omega_up_to if full.omega[0] == 0 else 0.0
        self._band = np.concatenate([[low], np.linspace(omega_up_to / BAND_POINTS, omega_up_to, BAND_POINTS)])
        compared = bool(full.loads.size and full.shapes.size)
        self._exact = _frequency_response(self._whole, self._band) if compared else None

    def errors(self, reduced: ModalModel, kept: int) -> ReductionErrors:
        """Judge a reduced model.

        Args:
            reduced: the modes that stand for the full ones.
            kept: how many of the full model's modes it holds unchanged.
        """
        if self._exact is None:
            return ReductionErrors(0.0, 0.0, 0.0)
        error = np.abs(_frequency_response(modal_state_space(reduced), self._band) - self._exact)
        truncated = truncate(self._whole, kept)
        lost = np.abs(_frequency_response(truncated, self._band[:1]) - self._exact[:, :, :1])
        return ReductionErrors(
            static_truncated=_largest_share(lost, self._exact[:, :, :1]),
            static=_largest_share(error[:, :, :1], self._exact[:, :, :1]),
            response=_largest_share(error, self._exact),
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
