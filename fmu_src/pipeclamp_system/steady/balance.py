"""Steady state of a pipe with clamps under a sine, by harmonic balance: no time integration.

The pipe is its frequency response G, each clamp the harmonics of its force F(Y) on a periodic motion:

    Y_h = G_e(i h omega) U_h - G_c(i h omega) F_h(Y),   h = 0 .. H.

With H = 1 this is the describing function of the clamp. Whether a motion is stable is told by Floquet's multipliers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi

import numpy as np

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_models.pipe.truncation import state_space
from pipeclamp_system.steady.clamp import SAMPLES, Complex, SteadyClamp, harmonics_of
from pipeclamp_system.steady.continuation import Equation, Solution, Steps, follow, solve
from pipeclamp_system.steady.floquet import growth
from pipeclamp_system.steady.tangents import linearised, tangents

NUDGE = 1e-5
"""By which share of its size an unknown is moved for a derivative."""

SMALLEST = 1e-6
"""mm: no motion is taken for smaller."""


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A periodic motion of pipe and clamps.

    Attributes:
        frequency: of the excitation, Hz.
        clamps: harmonics of each clamp's displacement, mm, (clamps, H + 1).
        probes: harmonics of each probe's displacement, mm, (probes, H + 1).
        forces: harmonics of the force into each clamp, N, (clamps, H + 1).
        conditions: A (mm) and f (Hz) that each clamp's law was taken for, (clamps, 2).
        growth: of the disturbance that grows fastest, 1/s; below 0 where the motion is stable.
        beyond: each clamp's conditions that lie beyond its law's data, by name: A (mm), f (Hz), T (K), further ones.
    """

    frequency: float
    clamps: Complex
    probes: Complex
    forces: Complex
    conditions: Array
    growth: float
    beyond: tuple[Mapping[str, float], ...]

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return self.growth < 0


@dataclass(frozen=True, eq=False)
class FollowedResponse:
    """A frequency response as far as it could be followed.

    Attributes:
        pieces: states from end to end; or what was followed from each end until it was given up, the lower one first.
        whole: whether it is one piece from end to end.
    """

    pieces: tuple[tuple[SteadyState, ...], ...]
    whole: bool

    @property
    def states(self) -> tuple[SteadyState, ...]:
        """The states of all pieces."""
        return tuple(state for piece in self.pieces for state in piece)

    def reach(self) -> str:
        """Say which frequencies the pieces reach."""
        frequencies = [[state.frequency for state in piece] for piece in self.pieces]
        ranges = " and ".join(f"from {min(piece):.4g} to {max(piece):.4g} Hz" for piece in frequencies)
        return f"followed {ranges} only{': what lies between them is missing' if len(self.pieces) > 1 else ''}"


@dataclass(frozen=True, eq=False)
class Passage:
    """Where a curve passes a frequency, by interpolation between two of its states.

    Attributes:
        clamps, probes: as of `SteadyState`.
        stable: whether both states are.
    """

    clamps: Complex
    probes: Complex
    stable: bool


def passages(states: Sequence[SteadyState], frequency: float) -> list[Passage]:
    """Give where a curve passes a frequency (Hz), in the order in which it does."""
    found = []
    for before, after in pairwise(states):
        if (before.frequency - frequency) * (after.frequency - frequency) > 0 or before.frequency == after.frequency:
            continue
        share = (frequency - before.frequency) / (after.frequency - before.frequency)
        found.append(
            Passage(
                before.clamps + share * (after.clamps - before.clamps),
                before.probes + share * (after.probes - before.probes),
                before.stable and after.stable,
            )
        )
    return found


def half_range(harmonics: Complex) -> Array:
    """Give half the peak-to-peak value of motions given by their harmonics, (points,)."""
    waves = np.exp(2j * pi * np.outer(np.arange(harmonics.shape[1]), np.arange(SAMPLES)) / SAMPLES)
    return np.asarray(np.ptp((harmonics @ waves).real, axis=1) / 2)


class SteadySystem:
    """A reduced pipe with its clamps' laws under a sine."""

    def __init__(
        self,
        pipe: ReducedPipe,
        clamps: Sequence[tuple[int, SteadyClamp]],
        excitation: Callable[[float], float],
        harmonics: int = 7,
    ) -> None:
        """Prepare the pipe's matrices.

        Args:
            pipe: the pipe.
            clamps: which of the pipe's clamps have a law, and the law.
            excitation: the sine's amplitude, m/s2 or N, over its frequency in Hz.
            harmonics: H.
        """
        self._pipe, self._clamps = pipe, [clamp for _, clamp in clamps]
        self._excitation, self._orders = excitation, np.arange(harmonics + 1)
        modes = len(pipe.omega)
        self._shapes = np.array([pipe.clamp_shapes[index] for index, _ in clamps]).reshape(len(clamps), modes)
        probes = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), modes)
        self._stiffness, self._damping = pipe.stiffness_matrix, pipe.damping_matrix
        loads = np.vstack([pipe.excitation_participation, -self._shapes]).T
        observed = MM * np.vstack([self._shapes, probes])
        self._linear = state_space(self._stiffness, self._damping, loads, observed)
        # A pipe that can move as a rigid body has no mean position of its own.
        self._has_mean = bool(np.linalg.cond(self._stiffness) < 1e14)

    @property
    def size(self) -> int:
        """How many real unknowns there are."""
        return len(self._clamps) * (2 * self._orders.size - 1)

    def responses(self, frequency: Array) -> Complex:
        """Give G in mm per unit of (excitation, force into each clamp), (rows, points, inputs, H + 1)."""
        points = 2j * pi * np.outer(frequency, self._orders)
        if not self._has_mean:
            points[:, 0] = 1e-3 * points[:, 1]
        found = self._linear(points.ravel(), squeeze=False)
        found = found.reshape(self._linear.noutputs, self._linear.ninputs, *points.shape)
        found = np.moveaxis(found, 2, 0)
        if not self._has_mean:
            found[..., 0] = 0.0
        return np.asarray(found, dtype=np.complex128)

    def unpacked(self, unknowns: Array) -> Complex:
        """Give harmonics (rows, clamps, H + 1) of unknowns (rows, m)."""
        H, count = self._orders.size - 1, len(self._clamps)
        parts = unknowns.reshape(len(unknowns), count, 2 * H + 1)
        return np.concatenate([parts[:, :, :1] + 0j, parts[:, :, 1 : H + 1] + 1j * parts[:, :, H + 1 :]], axis=2)

    def packed(self, harmonics: Complex) -> Array:
        """Give unknowns (rows, m) of harmonics (rows, clamps, H + 1)."""
        parts = [harmonics[:, :, :1].real, harmonics[:, :, 1:].real, harmonics[:, :, 1:].imag]
        return np.concatenate(parts, axis=2).reshape(len(harmonics), self.size)

    def _forces(self, motion: Complex, frequency: Array) -> Complex:
        """Give the harmonics of the clamps' forces, (rows, clamps, H + 1)."""
        forces = np.zeros_like(motion)
        for index, clamp in enumerate(self._clamps):
            forces[:, index] = clamp.forces(motion[:, index], frequency)
        return forces

    def moved(self, unknowns: Array, frequency: Array, drive: Array, responses: Complex) -> Complex:
        """Give the motion of clamps and probes under a sine and the forces of the clamps' motion.

        Args:
            unknowns: of the clamps' motion, (rows, m).
            frequency: Hz, (rows,).
            drive: the sine's amplitude, m/s2 or N, (rows,).
            responses: `responses(frequency)`.

        Returns:
            harmonics, mm, (rows, points, H + 1), the clamps first; where they are balanced the clamps' motion again.
        """
        return self._driven(self._forces(self.unpacked(unknowns), frequency), drive, responses)

    def _driven(self, forces: Complex, drive: Array, responses: Complex) -> Complex:
        """Give the motion under given forces of the clamps (rows, clamps, H + 1); the rest as of `moved`."""
        sine = np.zeros((len(forces), 1, self._orders.size), dtype=np.complex128)
        sine[:, 0, 1] = -1j * drive
        return np.asarray(np.einsum("rijh,rjh->rih", responses, np.concatenate([sine, forces], axis=1)))

    def residuals(self, unknowns: Array, frequency: Array, drive: Array, responses: Complex) -> Array:
        """Give by how much the clamps' motion isn't balanced, mm, (rows, m); arguments as of `moved`."""
        count = len(self._clamps)
        return unknowns - self.packed(self.moved(unknowns, frequency, drive, responses[:, :count]))

    def _linearised(
        self, unknowns: Array, frequencies: Array, drives: Array, responses: Complex
    ) -> tuple[Array, Array, Array]:
        """Give the residual at the first frequency, its derivatives by the unknowns, and the residual at the others.

        What the clamps make of a small change is taken from their laws' tangents: each law is solved once.
        """
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        others, width = len(frequencies) - 1, 2 * self._orders.size - 1
        motion = self.unpacked(unknowns[None])[0]
        forces = np.zeros((1 + self.size + others, *motion.shape), dtype=np.complex128)
        for index, clamp in enumerate(self._clamps):
            own = np.arange(index * width, (index + 1) * width)
            nudged = self.unpacked(unknowns + nudge * np.eye(self.size)[own])[:, index]
            motions = np.vstack([motion[index], nudged, np.tile(motion[index], (others, 1))])
            at = np.concatenate([np.full(1 + width, frequencies[0]), frequencies[1:]])
            force, changes = linearised(clamp, motions, at)
            forces[:, index] = force
            forces[1 + own, index] += changes[:width]
            forces[1 + self.size :, index] += changes[width:]
        which = np.concatenate([np.zeros(self.size + 1, dtype=np.intp), np.arange(1, others + 1)])
        moved = self._driven(forces, drives[which], responses[which][:, : len(self._clamps)])
        residuals = unknowns - self.packed(moved)
        by_unknowns = np.eye(self.size) + ((residuals[1 : self.size + 1] - residuals[0]) / nudge).T
        return residuals[0], by_unknowns, residuals[self.size + 1 :]

    def sizes(self, unknowns: Array) -> Array:
        """Give the size of unknowns (rows, m), mm, (rows,): what their accuracy is measured by."""
        return np.asarray(np.maximum(SMALLEST, np.abs(unknowns).max(axis=1, initial=0.0)), dtype=np.float64)

    def over_frequency(self) -> Equation:
        """Give the balance at the stated level of the excitation as an equation in unknowns and frequency."""

        def equation(unknowns: Array, frequency: float) -> tuple[Array, Array, Array]:
            two = frequency * np.array([1.0, 1 + NUDGE])
            drives = np.array([self._excitation(one) for one in two.tolist()])
            residual, by_unknowns, ahead = self._linearised(unknowns, two, drives, self.responses(two))
            return residual, by_unknowns, (ahead[0] - residual) / (two[1] - two[0])

        return equation

    def over_level(self, frequency: float) -> Equation:
        """Give the balance at a frequency (Hz) as an equation in unknowns and the excitation's level."""
        at, drive = np.array([frequency]), np.array([self._excitation(frequency)])
        responses = self.responses(at)
        pushed = np.zeros((1, len(self._clamps), self._orders.size), dtype=np.complex128)
        pushed[0, :, 1] = -1j * drive * responses[0, : len(self._clamps), 0, 1]
        by_level = -self.packed(pushed)[0]

        def equation(unknowns: Array, level: float) -> tuple[Array, Array, Array]:
            residual, by_unknowns, _ = self._linearised(unknowns, at, level * drive, responses)
            return residual, by_unknowns, by_level

        return equation

    def at(self, frequency: float) -> SteadyState | None:
        """Give the motion at a frequency (Hz) that grows out of rest with the excitation; None where it isn't found."""
        start = self.start(frequency)
        return None if start is None else self.state(start, frequency)

    def start(self, frequency: float) -> Array | None:
        """Find the unknowns at a frequency by letting the excitation grow from nothing."""
        if not self._clamps:
            return np.zeros(0)
        linear = self._excitation(frequency) * float(np.abs(self.responses(np.array([frequency]))[0, :, 0, 1]).max())
        at_rest = solve(self.over_level(frequency), np.zeros(self.size), 0.0, SMALLEST)
        if at_rest is None:
            return None
        path = list(follow(self.over_level(frequency), Solution(0.0, at_rest), 1.0, 0.1 * linear, Steps(longest=0.2)))
        return path[-1].unknowns if path[-1].parameter == 1.0 else None

    def curve(self, first: float, last: float) -> list[SteadyState]:
        """Give the frequency response from one frequency to another (Hz), round its turning points.

        The curve begins at the first frequency; where it ends before the last one, the list does too.
        """
        start = self.start(first)
        if start is None:
            return []
        if not self._clamps:
            return [self.state(start, frequency) for frequency in np.linspace(first, last, 200).tolist()]
        path = follow(self.over_frequency(), Solution(first, start), last, float(self.sizes(start[None])[0]))
        return [self.state(point.unknowns, point.parameter) for point in path]

    def followed(self, first: float, last: float) -> FollowedResponse:
        """Follow the frequency response from its lower end (Hz), and from its upper end where that isn't reached."""
        lower = tuple(self.curve(first, last))
        if lower and lower[-1].frequency == last:
            return FollowedResponse((lower,), whole=True)
        upper = tuple(reversed(self.curve(last, first)))
        if upper and upper[0].frequency == first:
            return FollowedResponse((upper,), whole=True)
        return FollowedResponse(tuple(piece for piece in (lower, upper) if piece), whole=False)

    def solutions(self, states: Sequence[SteadyState], frequency: float) -> list[Array]:
        """Give the unknowns, (m,) each, where a curve passes a frequency (Hz)."""
        found = []
        for passage in passages(states, frequency):
            guess = self.packed(passage.clamps[None])[0]
            size = float(self.sizes(guess[None])[0])
            unknowns = guess if not guess.size else solve(self.over_frequency(), guess, frequency, size)
            if unknowns is not None:
                found.append(unknowns)
        return found

    def crossings(self, states: Sequence[SteadyState], frequency: float) -> list[SteadyState]:
        """Give the states at a frequency (Hz) at which a curve passes it."""
        return [self.state(unknowns, frequency) for unknowns in self.solutions(states, frequency)]

    def state(self, unknowns: Array, frequency: float) -> SteadyState:
        """Evaluate a solution (m,) at a frequency (Hz), and its stability."""
        count = len(self._clamps)
        motion = self.unpacked(unknowns[None])
        at, drive = np.array([frequency]), np.array([self._excitation(frequency)])
        laws = [tangents(clamp, motion[0, index], frequency) for index, clamp in enumerate(self._clamps)]
        forces = np.zeros_like(motion)
        for index, law in enumerate(laws):
            forces[:, index] = harmonics_of(law.force[None], self._orders.size)
        moved = self._driven(forces, drive, self.responses(at))[0]
        conditions = [c.conditions(motion[:, i], np.array([frequency])) for i, c in enumerate(self._clamps)]
        farthest = half_range(moved[:count]).tolist()
        return SteadyState(
            frequency=frequency,
            clamps=moved[:count],
            probes=moved[count:],
            forces=forces[0],
            conditions=np.array([[A[0], f[0]] for A, f in conditions]).reshape(count, 2),
            growth=growth(self._stiffness, self._damping, self._shapes, laws, 1 / frequency, adrift=not self._has_mean),
            beyond=tuple(c.beyond(motion[0, i], frequency, farthest[i]) for i, c in enumerate(self._clamps)),
        )
