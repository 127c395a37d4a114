"""A pipe with clamps under a sine: what its harmonics and the clamps' forces make of each other, as an equation.

The pipe is its frequency response G, each clamp the harmonics of its force F(Y) on a periodic motion:

    Y_h = G_e(i h omega) U_h - G_c(i h omega) F_h(Y),   h = 0 .. H.

With H = 1 this is the describing function of the clamp. Unless it is told, H follows what the harmonics beyond it would
move.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from math import pi

import numpy as np

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_system.steady.clamp import SteadyClamp
from pipeclamp_system.steady.continuation import Equation, Evaluated, HarmonicRefinement, Work
from pipeclamp_system.steady.equivalent import LEAST_LOSS_FACTOR, loss_factor
from pipeclamp_system.steady.harmonics import (
    A_HARMONIC,
    FEWEST_HARMONICS,
    SMALLEST_MOTION_MM,
    left_out,
    packed,
    resized,
    unpacked,
    wanted,
)
from pipeclamp_system.steady.in_time import InTime
from pipeclamp_system.steady.receptance import Receptance
from pipeclamp_system.steady.stepping import CELLS, FLAT, ForceStep, Friction, Rubbed, step_of
from pipeclamp_system.steady.tangents import NUDGE, linearised

STICKING = 3
"""Times the fewest harmonics, in which a path of clamps that rub is followed that only leads somewhere: with fewer,
what is balanced moves as far as a clamp that sticks lets go of, and the path was lost on one of two cantilevers."""

RESPONSES_KEPT = 8
"""Of a pipe, at the frequencies that were asked for last."""

UNKNOWNS_OF_A_STEP, RUBBING_TIMES = 50, 10
"""Work of linearising the balance: so many unknowns cost as much as what is done whatever their number, and where sides
are sought so many times as much (2 ms by 20 unknowns, 5 by 130, 30 by 40 with sides)."""


class DrivenPipe:
    """A reduced pipe with its clamps' laws under a sine.

    Attributes:
        excitation: the sine's amplitude, m/s2 or N, over its frequency in Hz.
        stated_harmonics: H; None: as many as each motion asks for.
        told_harmonics: harmonics that a cycle's samples can tell; beyond them forces are known roughly.
        most_harmonics: the largest H.
        work: what was done to balance motions.
    """

    def __init__(
        self,
        pipe: ReducedPipe,
        clamps: Sequence[tuple[int, SteadyClamp]],
        excitation: Callable[[float], float],
        harmonics: int | None = None,
    ) -> None:
        """Prepare the pipe's matrices.

        Args:
            pipe: the pipe.
            clamps: which of the pipe's clamps have a law, and the law.
            excitation: the sine's amplitude, m/s2 or N, over its frequency in Hz.
            harmonics: H; None: as many as each motion asks for.
        """
        self._pipe, self._clamps = pipe, [clamp for _, clamp in clamps]
        self.excitation, self.stated_harmonics = excitation, harmonics
        modes = len(pipe.omega)
        self._shapes = np.array([pipe.clamp_shapes[index] for index, _ in clamps]).reshape(len(clamps), modes)
        probes = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), modes)
        self._stiffness, self._damping = pipe.stiffness_matrix, pipe.damping_matrix
        loads = np.vstack([pipe.excitation_participation, -self._shapes]).T
        observed = MM * np.vstack([self._shapes, probes])
        self._receptance = Receptance(self._stiffness, self._damping, loads, observed)
        self._modal = Receptance(self._stiffness, self._damping, loads, np.eye(modes))
        self._responses: dict[tuple[bytes, int], ComplexArray] = {}
        self.told_harmonics = min((clamp.samples for clamp in self._clamps), default=2) // 2 - 1
        self.most_harmonics = (self.told_harmonics + 1) * 2 // A_HARMONIC
        # Where the velocities of the next motion are sought from; what is found hangs on it within tolerances only.
        self._near: Array | None = None
        self.work = Work()
        self._refinement = HarmonicRefinement(self._asked, self.in_so_many) if harmonics is None and clamps else None

    @cached_property
    def rubbing(self) -> list[tuple[SteadyClamp, ForceStep]]:
        """The clamps in cells, and how their force steps with the velocity; none where none does."""
        # Of several clamps most of a cycle can be stuck: that takes minutes.
        step = step_of(self._clamps[0]) if self.clamps == 1 else None
        return [(replace(clamp, samples=CELLS), step) for clamp in self._clamps] if step else []

    @cached_property
    def coarsely(self) -> int:
        """H of a path that only leads somewhere, where the motion is solved again. Of clamps whose force steps with the
        velocity more count only for where it steps, which over the excitation's level isn't told."""
        stepping = not self.stated_harmonics and any(step_of(clamp) for clamp in self._clamps)
        return min(STICKING * self.harmonics, self.most_harmonics) if stepping else self.most_harmonics

    @property
    def holds_places(self) -> bool:
        """Whether dry friction lies behind a clearance: it holds the clamp at any of many places, between which the
        balance's corrections jump. Unless harmonics are stated such motions aren't balanced, but marched in time."""
        return not self.stated_harmonics and any(clamp.jumps for clamp, _ in self.rubbing)

    @cached_property
    def in_time(self) -> InTime:
        """The same pipe and clamps, to be marched in time."""
        return InTime(self._pipe, self._clamps, self._shapes)

    @property
    def length(self) -> float:
        """The pipe's, m."""
        return self._pipe.length

    @property
    def clamps(self) -> int:
        """How many clamps have a law."""
        return len(self._clamps)

    @property
    def harmonics(self) -> int:
        """H that is begun with; where it is stated, that of all motions."""
        return self.stated_harmonics or min(FEWEST_HARMONICS, self.most_harmonics)

    @property
    def size(self) -> int:
        """How many real unknowns are begun with."""
        return self.clamps * (2 * self.harmonics + 1)

    def responses(self, frequency: Array, harmonics: int | None = None) -> ComplexArray:
        """Give G in mm per unit of (excitation, force into each clamp), (rows, points, inputs, H + 1): read only.

        What was asked for lately is kept: paths over the excitation's level stay at one frequency.
        """
        H = self.harmonics if harmonics is None else harmonics
        asked = frequency.tobytes(), H
        if asked not in self._responses:
            if len(self._responses) == RESPONSES_KEPT:
                self._responses.pop(next(iter(self._responses)))
            self._responses[asked] = self._receptance.at(2 * pi * np.outer(frequency, np.arange(H + 1)))
        return self._responses[asked]

    def unpacked(self, unknowns: Array) -> ComplexArray:
        """Give harmonics (rows, clamps, H + 1) of unknowns (rows, m)."""
        return unpacked(unknowns, self.clamps) if self.clamps else np.zeros((len(unknowns), 0, 2), dtype=np.complex128)

    def forces(self, motion: ComplexArray, frequency: Array) -> ComplexArray:
        """Give the harmonics of the clamps' forces, (rows, clamps, H + 1)."""
        forces = np.zeros_like(motion)
        for index, clamp in enumerate(self._clamps):
            forces[:, index] = clamp.forces(motion[:, index], frequency)
        return forces

    def moved(self, unknowns: Array, frequency: Array, drive: Array, responses: ComplexArray) -> ComplexArray:
        """Give the motion of clamps and probes under a sine and the forces of the clamps' motion.

        Args:
            unknowns: of the clamps' motion, (rows, m).
            frequency: Hz, (rows,).
            drive: the sine's amplitude, m/s2 or N, (rows,).
            responses: `responses(frequency)`.

        Returns:
            harmonics, mm, (rows, points, H + 1), the clamps first; where they are balanced the clamps' motion again.
        """
        return self.under_forces(self.forces(self.unpacked(unknowns), frequency), drive, responses)

    def under_forces(self, forces: ComplexArray, drive: Array, responses: ComplexArray) -> ComplexArray:
        """Give the motion under given forces of the clamps (rows, clamps, H + 1); the rest as of `moved`."""
        sine = np.zeros((len(forces), 1, responses.shape[3]), dtype=np.complex128)
        sine[:, 0, 1] = -1j * drive
        loads = np.concatenate([sine, resized(forces, responses.shape[3])], axis=1)
        return np.asarray(np.einsum("rijh,rjh->rih", responses, loads))

    def pushed(self, frequency: float, forces: ComplexArray) -> ComplexArray:
        """Give the motion, mm, (Q, points, H + 1), that forces into the clamps, (Q, clamps, H + 1), make at Hz."""
        responses = self.responses(np.array([frequency]), forces.shape[2] - 1)[0]
        return np.asarray(np.einsum("ijh,qjh->qih", responses[:, 1:], forces))

    def changed(
        self, unknowns: Array, frequency: float, by_unknowns: Array, by_frequency: Array, forces: ComplexArray
    ) -> ComplexArray:
        """Give how the motion of clamps and probes changes, to first order.

        Args:
            unknowns: of the clamps' balanced motion, (m,), at a frequency, Hz.
            by_unknowns: changes of the clamps' motion, (Q, m).
            by_frequency: changes of the frequency that come with them, Hz, (Q,).
            forces: changes of the clamps' forces that brought them about, N, (Q, clamps, H + 1).

        Returns:
            changes of the harmonics, mm, (Q, points, H + 1).
        """
        relative = np.column_stack([by_unknowns / self.sizes(unknowns[None])[0], by_frequency / frequency])
        nudge = NUDGE / np.maximum(np.abs(relative).max(axis=1, initial=0.0), 1e-300)[:, None]
        rows = np.vstack([unknowns + nudge * by_unknowns, unknowns - nudge * by_unknowns])
        at = np.concatenate([frequency + nudge[:, 0] * by_frequency, frequency - nudge[:, 0] * by_frequency])
        drive = np.array([self.excitation(one) for one in at.tolist()])
        moved = self.moved(rows, at, drive, self.responses(at, self.up_to(unknowns)))
        above, below = np.split(moved, 2)
        return np.asarray((above - below) / (2 * nudge[:, :, None]) + self.pushed(frequency, forces))

    def residuals(self, unknowns: Array, frequency: Array, drive: Array, responses: ComplexArray) -> Array:
        """Give by how much the clamps' motion isn't balanced, mm, (rows, m); arguments as of `moved`."""
        return unknowns - packed(self.moved(unknowns, frequency, drive, responses[:, : self.clamps]))

    def linearised(
        self, unknowns: Array, frequencies: Array, drives: Array, responses: ComplexArray, *, rubbing: bool = False
    ) -> tuple[Array, Array, Array]:
        """Give the residual at the first frequency, its derivatives by the unknowns, and the residual at the others.

        What the clamps make of a small change is taken from their laws' tangents: each law is solved once.
        """
        rubs = rubbing and self.rubs(unknowns, float(frequencies[0]))
        self.work.done += (UNKNOWNS_OF_A_STEP + unknowns.size) * (RUBBING_TIMES if rubs else 1)
        forces = (self._rubbed_changes if rubs else self._changes)(unknowns, frequencies)
        size, others = unknowns.size, len(frequencies) - 1
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        which = np.concatenate([np.zeros(size + 1, dtype=np.intp), np.arange(1, others + 1)])
        moved = self.under_forces(forces, drives[which], responses[which][:, : self.clamps])
        residuals = unknowns - packed(moved)
        by_unknowns = np.eye(size) + ((residuals[1 : size + 1] - residuals[0]) / nudge).T
        return residuals[0], by_unknowns, residuals[size + 1 :]

    def _changes(self, unknowns: Array, frequencies: Array) -> ComplexArray:
        """Give the forces of a motion, those of its unknowns moved by `NUDGE` one by one, and those at the frequencies
        after the first, to first order, (1 + m + others, clamps, H + 1)."""
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        size, others = unknowns.size, len(frequencies) - 1
        width = size // self.clamps
        motion = self.unpacked(unknowns[None])[0]
        forces = np.zeros((1 + size + others, *motion.shape), dtype=np.complex128)
        for index, clamp in enumerate(self._clamps):
            own = np.arange(index * width, (index + 1) * width)
            nudged = self.unpacked(unknowns + nudge * np.eye(size)[own])[:, index]
            motions = np.vstack([motion[index], nudged, np.tile(motion[index], (others, 1))])
            at = np.concatenate([np.full(1 + width, frequencies[0]), frequencies[1:]])
            force, changes = linearised(clamp, motions, at)
            forces[:, index] = force
            forces[1 + own, index] += changes[:width]
            forces[1 + size :, index] += changes[width:]
        return forces

    def rubs(self, unknowns: Array, frequency: float) -> bool:
        """Tell whether a clamp's force steps, and it doesn't only creep where its law smooths sgn v."""
        if not self.rubbing:
            return False
        motion = self.unpacked(unknowns[None])[0]
        speed = 2 * pi * frequency * np.abs(motion * np.arange(motion.shape[1])).sum(axis=1)
        return any(fast > FLAT * clamp.law.v_r for fast, clamp in zip(speed.tolist(), self._clamps, strict=True))

    def rubbed(self, motion: ComplexArray, frequency: float, H: int) -> Rubbed:
        """Find the sides to which clamps slide on a motion (clamps, h) of which H harmonics are balanced."""
        responses = self.responses(np.array([frequency]), CELLS // 2)[0, : self.clamps, 1:]
        clamps, each = zip(*self.rubbing, strict=True)
        found = Friction(clamps, each, frequency, responses, H, motion).found(self._near)
        self._near = found.sides.velocity
        return found

    def _rubbed_changes(self, unknowns: Array, frequencies: Array) -> ComplexArray:
        """Give the same as `_changes` of clamps whose force steps."""
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        size, H = unknowns.size, self.up_to(unknowns)
        motion = self.unpacked(unknowns[None])[0]
        rubbed = self.rubbed(motion, float(frequencies[0]), H)
        force = rubbed.forces[None, :, : H + 1]
        nudged = force + rubbed.changes(self.unpacked(nudge * np.eye(size)))
        others = [self.rubbed(motion, other, H).forces[None, :, : H + 1] for other in frequencies[1:].tolist()]
        return np.concatenate([force, nudged, *others])

    def sizes(self, unknowns: Array) -> Array:
        """Give the size of unknowns (rows, m), mm, (rows,): what their accuracy is measured by."""
        return np.asarray(np.maximum(SMALLEST_MOTION_MM, np.abs(unknowns).max(axis=1, initial=0.0)), dtype=np.float64)

    def over_frequency(self) -> Equation:
        """Give the balance at the stated level of the excitation as an equation in unknowns and frequency."""

        def equation(unknowns: Array, frequency: float) -> Evaluated:
            two = frequency * np.array([1.0, 1 + NUDGE])
            drives = np.array([self.excitation(one) for one in two.tolist()])
            residual, by_unknowns, ahead = self.linearised(
                unknowns, two, drives, self.responses(two, self.up_to(unknowns)), rubbing=True
            )
            return Evaluated(residual, by_unknowns, (ahead[0] - residual) / (two[1] - two[0]))

        return Equation(equation, self._refinement, self.unbounded, self.work)

    def unbounded(self, unknowns: Array, frequency: float) -> bool:
        """Tell whether nothing bounds a motion: a clamp moves farther than the pipe is long, where no pipe is straight
        any more, and pipe and clamps take up less than steel does by itself."""
        motion = self.unpacked(unknowns[None])
        if np.abs(motion).sum(axis=2).max(initial=0.0) <= MM * self.length:
            return False
        forces = self.forces(motion, np.array([frequency]))
        loads = np.concatenate([np.zeros((1, 1, forces.shape[2])), forces], axis=1)
        loads[0, 0, 1] = -1j * self.excitation(frequency)
        omega = 2 * pi * frequency
        orders = np.arange(forces.shape[2], dtype=np.float64)[None]
        modal = np.einsum("ijh,jh->ih", self._modal.at(omega * orders)[0], loads[0])
        return loss_factor(modal, self._damping, motion[0] / MM, forces[0], omega) < LEAST_LOSS_FACTOR

    def over_level(self, frequency: float, most: int | None = None) -> Equation:
        """Give the balance at a frequency (Hz) as an equation in unknowns and the excitation's level.

        A motion has as many harmonics as it asks for, no more than `most` unless that is None.
        """
        largest = self.clamps * (2 * (self.most_harmonics if most is None else most) + 1)
        at, drive = np.array([frequency]), np.array([self.excitation(frequency)])

        def equation(unknowns: Array, level: float) -> Evaluated:
            responses = self.responses(at, self.up_to(unknowns))
            residual, by_unknowns, _ = self.linearised(unknowns, at, level * drive, responses)
            pushed = np.zeros((1, self.clamps, responses.shape[3]), dtype=np.complex128)
            pushed[0, :, 1] = -1j * drive * responses[0, : self.clamps, 0, 1]
            return Evaluated(residual, by_unknowns, -packed(pushed)[0])

        def asked(unknowns: Array, level: float) -> int:
            return min(largest, self._asked(unknowns, frequency, level))

        refinement = self._refinement and HarmonicRefinement(asked, self.in_so_many)
        return Equation(equation, refinement, work=self.work)

    def up_to(self, unknowns: Array) -> int:
        """Give H of unknowns (m,)."""
        return (unknowns.size // self.clamps - 1) // 2

    def in_so_many(self, unknowns: Array, size: int) -> Array:
        """Give unknowns, or a direction in them, with other harmonics: (m,) becomes (size,)."""
        count = (size // self.clamps + 1) // 2
        return np.asarray(packed(resized(self.unpacked(unknowns[None]), count))[0])

    def matched(self, unknowns: Sequence[Array]) -> list[Array]:
        """Give unknowns (m,) each with as many harmonics as the finest of them."""
        size = max(one.size for one in unknowns)
        return [self.in_so_many(one, size) for one in unknowns]

    def mirrored(self, unknowns: Array) -> Array:
        """Give the motion with both directions exchanged, half a cycle later: where pipe and laws have no preferred
        direction it is a solution too, and the same one unless the motion has even harmonics."""
        motion = self.unpacked(unknowns[None])
        return np.asarray(packed(np.where(np.arange(motion.shape[2]) % 2, motion, -motion))[0])

    def lopsided(self, unknowns: Array) -> Array:
        """Give the even harmonics of a motion, which change sign when it is mirrored; the others are 0, (m,)."""
        return np.asarray((unknowns - self.mirrored(unknowns)) / 2)

    def _asked(self, unknowns: Array, frequency: float, level: float | None = None) -> int:
        """Give how many unknowns a motion asks for; at a level, where steps of force have no harmonics of their own."""
        at, H = np.array([frequency]), self.up_to(unknowns)
        forces = self.all_forces(unknowns, frequency, rubbing=level is None)
        return self.clamps * (
            2 * wanted(self._left_out(forces, at, 1.0 if level is None else level), H, self.most_harmonics) + 1
        )

    def all_forces(self, unknowns: Array, frequency: float, *, rubbing: bool) -> ComplexArray:
        """Give all harmonics of a motion's forces, (1, clamps, h); beyond H without those that aren't left out."""
        motion, H = self.unpacked(unknowns[None]), self.up_to(unknowns)
        if not (rubbing and self.rubs(unknowns, frequency)):
            return self.forces(resized(motion, max(H, self.told_harmonics) + 1), np.array([frequency]))
        return self.rubbed(motion[0], frequency, H).smooth_beyond(H)[None, :, : max(H, self.told_harmonics) + 1]

    def _left_out(self, forces: ComplexArray, at: Array, level: float) -> Array:
        """Give what is left out by H, as of `left_out`, from all harmonics of a motion's forces."""
        drive = np.array([level * self.excitation(float(at[0]))])
        return left_out(self.under_forces(forces, drive, self.responses(at, forces.shape[2] - 1))[0])
