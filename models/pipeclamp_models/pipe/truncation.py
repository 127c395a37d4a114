"""A pipe's modes as a state space (python-control), its truncation, and what the truncation costs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.pipe.receptance import are_coupled, receptance

if TYPE_CHECKING:
    import control

POINTS_A_MODE = 20
"""Frequencies, even in wave number, at which the responses are compared, besides the resonances."""

FLANKS = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Of a resonance's half width at half power, where they are compared beside it: another mode that cancels its own part
on one side makes the error largest there."""

STIFFNESSES = (1.0, 10.0, 100.0, 1e4)
"""Of the clamps, as multiples of the pipe's own: beside it a clamp is soft, stiff, and as good as rigid."""

LEAST_DAMPING = 1e-3
"""Of critical, at least compared with: below it the elements' own error of 3e-6 of a frequency shows at peaks."""

FREQUENCIES_AT_ONCE = 100
"""Frequencies whose matrices are solved together: more would take memory."""

STILL_SHARE = 1e-3
"""Share of what moves most under a load below which a point counts as still."""

MOST_MODES = 60
"""Modes above the kept ones that the full model's state space has, and that axial force and flow couple."""


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

    def receptance(self, omega: Array, moving: int | None = None) -> ComplexArray:
        """Give displacements per unit load at frequencies, rad/s, (n,): (n, outputs, inputs).

        Args:
            omega: the frequencies.
            moving: how many modes axial force and flow couple; the others move by themselves. All of them unless told.
        """
        if moving is not None and moving < self.omega.size and self.coupling is not None:
            rest = replace(self.part(moving, self.omega.size), coupling=None)
            return self.part(0, moving).receptance(omega) + rest.receptance(omega)
        matrices = self.matrices(self.omega.size)
        parts = np.array_split(omega, -(-omega.size // FREQUENCIES_AT_ONCE))
        coupled = are_coupled(*matrices)
        return np.concatenate([receptance(*matrices, self.loads, self.shapes, part, coupled=coupled) for part in parts])

    def part(self, begin: int, end: int) -> ModalModel:
        """Give some of the modes by themselves."""
        some = slice(begin, end)
        coupling = self.coupling and (self.coupling[0][some, some], self.coupling[1][some, some])
        return ModalModel(self.omega[some], self.damping[some], self.loads[some], self.shapes[:, some], coupling)

    def static_compliance(self, begin: int) -> Array:
        """Give the static compliance of the modes from one on, without axial force and flow, (outputs, inputs)."""
        return (self.shapes[:, begin:] / self.omega[begin:] ** 2) @ self.loads[begin:]


@dataclass(frozen=True)
class ReductionErrors:
    """What the reduction costs: the largest error over all loads and points.

    Attributes:
        static_truncated: share of the static compliance that the left-out modes carry, were nothing put in their place.
        static: error of the static compliance of the reduced model, as a share of it.
        response: error of the frequency response up to the stated frequency, without clamps, as a share of what it is
            at the same frequency.
        clamped: the same of what the excitation makes at the probes and in the clamps, with clamps as stiff as any.
        clamped_at: stiffness of the clamps where that is largest, N/m; () without clamps.
    """

    static_truncated: float
    static: float
    response: float
    clamped: float = 0.0
    clamped_at: tuple[float, ...] = ()

    @property
    def largest(self) -> float:
        """The largest of the reduced model's errors."""
        return max(self.static, self.response, self.clamped)


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
    # It takes a second to load, which a clamp's FMU, built by the same module as a pipe's, can do without.
    import control

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
    static = model.static_compliance(count)
    return state_space(*model.matrices(count), model.loads[:count], model.shapes[:, :count], static)


def truncate(full: control.StateSpace, kept: int) -> control.StateSpace:
    """Give the state space with the first `kept` modes and nothing in place of the others."""
    import control

    modes = full.nstates // 2
    left_out = [*range(kept, modes), *range(modes + kept, 2 * modes)]
    moving = control.ss(full.A, full.B, full.C, 0.0)
    return control.model_reduction(moving, left_out, method="truncate", warn_unstable=False) if left_out else moving


class FullResponse:
    """The full model's response over the band, against which reductions are judged.

    An error counts against the response at its own frequency: one resonance would hide what is wrong elsewhere. Where
    modes cancel each other it counts against the geometric mean of the response over a spacing of modes around it,
    which passes midway between resonances and antiresonances (Skudrzyk's mean-value method, J. Acoust. Soc. Am. 67
    (1980) 1105).
    """

    def __init__(self, full: ModalModel, kept: int, omega_up_to: float, clamps: int = 0) -> None:
        """Compute the response once.

        Args:
            full: all modes of the finite element model, ascending.
            kept: how many of them lie in the band.
            omega_up_to: end of the band, rad/s.
            clamps: how many of the inputs, and of the outputs, are clamps, from the first; the last input excites.
        """
        self.most = min(kept + MOST_MODES, full.omega.size)
        self._whole, self._clamps = modal_state_space(full, self.most), clamps
        # Rigid body modes have no static compliance: there, "static" is far below the stated frequency.
        self._low = np.array([1e-3 * omega_up_to if full.omega[0] == 0 else 0.0])
        full = _damped(full)
        self._compared = bool(full.loads.size and full.shapes.size)
        if not self._compared:
            return
        self._static = _frequency_response(self._whole, self._low)
        even = omega_up_to * np.linspace(0.0, 1.0, POINTS_A_MODE * (kept + 2) + 1)[1:] ** 2
        own = own_stiffness(full.receptance(even, self.most)[:, :clamps, :clamps])
        self._stiffnesses = [np.zeros(0), *(share * own for share in STIFFNESSES if clamps)]
        peaks = [flanked(resonances(full, self.most, stiffness), full) for stiffness in self._stiffnesses]
        band = np.unique(np.concatenate([even, *peaks]))
        self._band = band[(band >= even[0]) & (band <= omega_up_to)]
        receptance = full.receptance(self._band, self.most)
        self._exact = [clamped(receptance, stiffness) for stiffness in self._stiffnesses]
        self._scales = [local_scale(one, self._band, full.omega, clamps) for one in self._exact]

    def errors(self, reduced: ModalModel, kept: int) -> ReductionErrors:
        """Judge a reduced model.

        Args:
            reduced: the modes that stand for the full ones.
            kept: how many of the full model's modes it holds unchanged.
        """
        if not self._compared:
            return ReductionErrors(0.0, 0.0, 0.0)
        static = np.abs(_frequency_response(modal_state_space(reduced), self._low) - self._static)
        lost = np.abs(_frequency_response(truncate(self._whole, kept), self._low) - self._static)
        receptance = _damped(reduced).receptance(self._band)
        free, *held = [
            float((np.abs(clamped(receptance, stiffness) - exact) / scale).max())
            for stiffness, exact, scale in zip(self._stiffnesses, self._exact, self._scales, strict=True)
        ]
        worst = int(np.argmax(held)) if held else None
        return ReductionErrors(
            static_truncated=_largest_share(lost, self._static),
            static=_largest_share(static, self._static),
            response=free,
            clamped=0.0 if worst is None else held[worst],
            clamped_at=() if worst is None else tuple(self._stiffnesses[1 + worst].tolist()),
        )


def _damped(model: ModalModel) -> ModalModel:
    """Give modes with no less than the least damping."""
    return replace(model, damping=np.maximum(model.damping, 2 * LEAST_DAMPING * model.omega))


def own_stiffness(receptance: ComplexArray) -> Array:
    """Give the pipe's stiffness at each clamp, N/m, (clamps,): geometric mean over (frequencies, clamps, clamps)."""
    driven = np.abs(np.diagonal(receptance, axis1=1, axis2=2))
    return np.asarray(np.exp(-np.log(driven).mean(axis=0)), dtype=np.float64)


def resonances(model: ModalModel, count: int, stiffness: Array) -> Array:
    """Give the natural frequencies of the first modes on springs at the clamps, without flow, rad/s, (count,).

    The other modes yield with the springs.

    Args:
        model: the modes; its first outputs, and inputs, are the clamps.
        count: of modes.
        stiffness: of each clamp, N/m; (0,) without clamps.
    """
    clamps = stiffness.size
    seen, rest = model.shapes[:clamps, :count], model.static_compliance(count)[:clamps, :clamps]
    springs = np.linalg.inv(np.diag(1 / stiffness) + rest)
    squared = np.linalg.eigvalsh(np.diag(model.omega[:count] ** 2) + seen.T @ springs @ seen)
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)), dtype=np.float64)


def flanked(resonances: Array, model: ModalModel) -> Array:
    """Give resonances, (n,), rad/s, and the flanks of their peaks, with the damping of the modes near them."""
    moving = model.omega > 0.0
    half_width = np.interp(resonances, model.omega[moving], model.damping[moving] / 2)
    return np.ravel(resonances[:, None] + half_width[:, None] * FLANKS)


def clamped(receptance: ComplexArray, stiffness: Array) -> ComplexArray:
    """Give what the excitation makes where springs stand for the clamps.

    Args:
        receptance: without clamps, (frequencies, outputs, inputs); clamps first, the excitation the last input.
        stiffness: of each clamp, N/m; (0,) without clamps.

    Returns:
        (frequencies, clamps + probes, 1): force into each clamp, displacement of each probe, per unit of excitation;
        the receptance itself without clamps.
    """
    count = stiffness.size
    if not count:
        return receptance
    force = np.linalg.solve(receptance[:, :count, :count] + np.diag(1 / stiffness), receptance[:, :count, -1:])
    probes = receptance[:, count:, -1:] - receptance[:, count:, :count] @ force
    return np.concatenate([force, probes], axis=1)


def local_scale(response: ComplexArray, band: Array, natural: Array, clamps: int) -> Array:
    """Give what the error of a response counts against, like it.

    Args:
        response: (frequencies, outputs, inputs).
        band: ascending, rad/s, (frequencies,).
        natural: natural frequencies without clamps, ascending, rad/s.
        clamps: how many of the outputs, from the first, are clamps, whose unit may be another.
    """
    size = np.abs(response)
    # each point stands for the band around it: there are more of them at peaks
    stands_for = np.gradient(band)
    logarithm = stands_for[:, None, None] * np.log(np.maximum(size, np.finfo(float).tiny))
    so_far = np.concatenate([np.zeros_like(logarithm[:1]), np.cumsum(logarithm, axis=0)])
    width = np.concatenate([[0.0], np.cumsum(stands_for)])
    edges = np.concatenate([[0.0], natural[natural > 0.0], [np.inf]])
    above = np.searchsorted(edges, band)
    first = np.searchsorted(band, edges[np.maximum(above - 1, 0)])
    past = np.searchsorted(band, edges[above], side="right")
    mean = np.exp((so_far[past] - so_far[first]) / (width[past] - width[first])[:, None, None])
    scale = np.maximum(size, mean)
    # What (nearly) stands still under a load is measured against what moves.
    for part in (scale[:, :clamps], scale[:, clamps:]):
        np.maximum(part, STILL_SHARE * part.max(axis=1, initial=0.0, keepdims=True), out=part)
    return np.where(scale > 0.0, scale, 1.0)


def _largest_share(error: Array, response: ComplexArray) -> float:
    """Give the largest error as a share of its channel's response, (outputs, inputs, 1)."""
    scale = np.abs(response)
    scale = np.maximum(scale, STILL_SHARE * scale.max(axis=0))
    return float((error / np.where(scale > 0, scale, 1.0)).max())


def _frequency_response(system: control.StateSpace, band: Array) -> ComplexArray:
    """Give the frequency response, (outputs, inputs, frequencies)."""
    import control

    return np.asarray(control.frequency_response(system, band, squeeze=False).complex, dtype=np.complex128)
