"""Steady state of a pipe with clamps under a sine, by harmonic balance: no time integration.

The pipe is its frequency response G, each clamp the harmonics of its force F(Y) on a periodic motion:

    Y_h = G_e(i h omega) U_h - G_c(i h omega) F_h(Y),   h = 0 .. H.

With H = 1 this is the describing function of the clamp. Unless it is told, H follows what the harmonics beyond it would
move. Whether a motion is stable is told by Floquet's multipliers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from math import pi

import numpy as np

from pipeclamp_fmu.slaves.clamp import MM
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_system.steady.clamp import Complex, SteadyClamp, harmonics_of
from pipeclamp_system.steady.continuation import Equation, Refinement, Solution, Steps, between, follow, solve
from pipeclamp_system.steady.equivalent import equivalent
from pipeclamp_system.steady.floquet import growth
from pipeclamp_system.steady.harmonics import (
    A_HARMONIC,
    FEWEST,
    SMALLEST,
    STILL,
    left_out,
    packed,
    resized,
    unpacked,
    wanted,
)
from pipeclamp_system.steady.receptance import Receptance
from pipeclamp_system.steady.states import FollowedResponse, SteadyState, half_range
from pipeclamp_system.steady.stepping import CELLS, FLAT, Friction, Rubbed, Step, step_of
from pipeclamp_system.steady.tangents import linearised, tangents

NUDGE = 1e-5
"""By which share of its size an unknown is moved for a derivative."""

OVER_FREQUENCY = Steps(widest=0.05)
"""Of a path over frequency: a resonance damped by 1 % stands out twentyfold so far from its frequency, as a share: in
a longer step one that is small beside others could begin and end unseen."""

STICKING = 3
"""Times the fewest harmonics, in which springs turn into clamps that rub: with fewer, what is balanced moves as far as
a clamp that sticks lets go of, and the path was lost on one of two cantilevers."""

STEEP = 100.0
"""Change of a motion over that of the frequency, both as shares, beyond which the path turns: what a motion is off by
is told along the path there, not at the frequency."""


class SteadySystem:
    """A reduced pipe with its clamps' laws under a sine."""

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
        self._excitation, self._stated = excitation, harmonics
        modes = len(pipe.omega)
        self._shapes = np.array([pipe.clamp_shapes[index] for index, _ in clamps]).reshape(len(clamps), modes)
        probes = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), modes)
        self._stiffness, self._damping = pipe.stiffness_matrix, pipe.damping_matrix
        loads = np.vstack([pipe.excitation_participation, -self._shapes]).T
        observed = MM * np.vstack([self._shapes, probes])
        self._receptance = Receptance(self._stiffness, self._damping, loads, observed)
        # Harmonics that a cycle's samples can tell; beyond them forces are known roughly.
        self._told = min((clamp.samples for clamp in self._clamps), default=2) // 2 - 1
        self._most = (self._told + 1) * 2 // A_HARMONIC
        # Where the velocities of the next motion are sought from; what is found hangs on it within tolerances only.
        self._near: Array | None = None
        self._refinement = Refinement(self._asked, self._in_so_many) if harmonics is None and clamps else None

    @cached_property
    def _rubbing(self) -> list[tuple[SteadyClamp, Step]]:
        """The clamps in cells, and how their force steps with the velocity; none where none does."""
        # Of several clamps most of a cycle can be stuck: that takes minutes.
        step = step_of(self._clamps[0]) if self.clamps == 1 else None
        return [(replace(clamp, samples=CELLS), step) for clamp in self._clamps] if step else []

    @property
    def clamps(self) -> int:
        """How many clamps have a law."""
        return len(self._clamps)

    @property
    def harmonics(self) -> int:
        """H that is begun with; where it is stated, that of all motions."""
        return self._stated or min(FEWEST, self._most)

    @property
    def size(self) -> int:
        """How many real unknowns are begun with."""
        return self.clamps * (2 * self.harmonics + 1)

    def responses(self, frequency: Array, harmonics: int | None = None) -> Complex:
        """Give G in mm per unit of (excitation, force into each clamp), (rows, points, inputs, H + 1)."""
        orders = np.arange((self.harmonics if harmonics is None else harmonics) + 1)
        return self._receptance.at(2 * pi * np.outer(frequency, orders))

    def unpacked(self, unknowns: Array) -> Complex:
        """Give harmonics (rows, clamps, H + 1) of unknowns (rows, m)."""
        return unpacked(unknowns, self.clamps) if self.clamps else np.zeros((len(unknowns), 0, 2), dtype=np.complex128)

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
        sine = np.zeros((len(forces), 1, responses.shape[3]), dtype=np.complex128)
        sine[:, 0, 1] = -1j * drive
        loads = np.concatenate([sine, resized(forces, responses.shape[3])], axis=1)
        return np.asarray(np.einsum("rijh,rjh->rih", responses, loads))

    def pushed(self, frequency: float, forces: Complex) -> Complex:
        """Give the motion, mm, (Q, points, H + 1), that forces into the clamps, (Q, clamps, H + 1), make at Hz."""
        responses = self.responses(np.array([frequency]), forces.shape[2] - 1)[0]
        return np.asarray(np.einsum("ijh,qjh->qih", responses[:, 1:], forces))

    def changed(
        self, unknowns: Array, frequency: float, by_unknowns: Array, by_frequency: Array, forces: Complex
    ) -> Complex:
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
        drive = np.array([self._excitation(one) for one in at.tolist()])
        moved = self.moved(rows, at, drive, self.responses(at, self._up_to(unknowns)))
        above, below = np.split(moved, 2)
        return np.asarray((above - below) / (2 * nudge[:, :, None]) + self.pushed(frequency, forces))

    def residuals(self, unknowns: Array, frequency: Array, drive: Array, responses: Complex) -> Array:
        """Give by how much the clamps' motion isn't balanced, mm, (rows, m); arguments as of `moved`."""
        return unknowns - packed(self.moved(unknowns, frequency, drive, responses[:, : self.clamps]))

    def _linearised(
        self, unknowns: Array, frequencies: Array, drives: Array, responses: Complex, *, rubbing: bool = False
    ) -> tuple[Array, Array, Array]:
        """Give the residual at the first frequency, its derivatives by the unknowns, and the residual at the others.

        What the clamps make of a small change is taken from their laws' tangents: each law is solved once.
        """
        rubs = rubbing and self._rubs(unknowns, float(frequencies[0]))
        forces = (self._rubbed_changes if rubs else self._changes)(unknowns, frequencies)
        size, others = unknowns.size, len(frequencies) - 1
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        which = np.concatenate([np.zeros(size + 1, dtype=np.intp), np.arange(1, others + 1)])
        moved = self._driven(forces, drives[which], responses[which][:, : self.clamps])
        residuals = unknowns - packed(moved)
        by_unknowns = np.eye(size) + ((residuals[1 : size + 1] - residuals[0]) / nudge).T
        return residuals[0], by_unknowns, residuals[size + 1 :]

    def _changes(self, unknowns: Array, frequencies: Array) -> Complex:
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

    def _rubs(self, unknowns: Array, frequency: float) -> bool:
        """Tell whether a clamp's force steps, and it doesn't only creep where its law smooths sgn v."""
        if not self._rubbing:
            return False
        motion = self.unpacked(unknowns[None])[0]
        speed = 2 * pi * frequency * np.abs(motion * np.arange(motion.shape[1])).sum(axis=1)
        return any(fast > FLAT * clamp.law.v_r for fast, clamp in zip(speed.tolist(), self._clamps, strict=True))

    def _rubbed(self, motion: Complex, frequency: float, H: int) -> Rubbed:
        """Find the sides to which clamps slide on a motion (clamps, h) of which H harmonics are balanced."""
        responses = self.responses(np.array([frequency]), CELLS // 2)[0, : self.clamps, 1:]
        clamps, each = zip(*self._rubbing, strict=True)
        found = Friction(clamps, each, frequency, responses, H, motion).found(self._near)
        self._near = found.sides.velocity
        return found

    def _rubbed_changes(self, unknowns: Array, frequencies: Array) -> Complex:
        """Give the same as `_changes` of clamps whose force steps."""
        nudge = NUDGE * self.sizes(unknowns[None])[0]
        size, H = unknowns.size, self._up_to(unknowns)
        motion = self.unpacked(unknowns[None])[0]
        rubbed = self._rubbed(motion, float(frequencies[0]), H)
        force = rubbed.forces[None, :, : H + 1]
        nudged = force + rubbed.changes(self.unpacked(nudge * np.eye(size)))
        others = [self._rubbed(motion, other, H).forces[None, :, : H + 1] for other in frequencies[1:].tolist()]
        return np.concatenate([force, nudged, *others])

    def sizes(self, unknowns: Array) -> Array:
        """Give the size of unknowns (rows, m), mm, (rows,): what their accuracy is measured by."""
        return np.asarray(np.maximum(SMALLEST, np.abs(unknowns).max(axis=1, initial=0.0)), dtype=np.float64)

    def over_frequency(self) -> Equation:
        """Give the balance at the stated level of the excitation as an equation in unknowns and frequency."""

        def equation(unknowns: Array, frequency: float) -> tuple[Array, Array, Array]:
            two = frequency * np.array([1.0, 1 + NUDGE])
            drives = np.array([self._excitation(one) for one in two.tolist()])
            residual, by_unknowns, ahead = self._linearised(
                unknowns, two, drives, self.responses(two, self._up_to(unknowns)), rubbing=True
            )
            return residual, by_unknowns, (ahead[0] - residual) / (two[1] - two[0])

        return Equation(equation, self._refinement)

    def over_level(self, frequency: float) -> Equation:
        """Give the balance at a frequency (Hz) as an equation in unknowns and the excitation's level."""
        at, drive = np.array([frequency]), np.array([self._excitation(frequency)])

        def equation(unknowns: Array, level: float) -> tuple[Array, Array, Array]:
            responses = self.responses(at, self._up_to(unknowns))
            residual, by_unknowns, _ = self._linearised(unknowns, at, level * drive, responses)
            pushed = np.zeros((1, self.clamps, responses.shape[3]), dtype=np.complex128)
            pushed[0, :, 1] = -1j * drive * responses[0, : self.clamps, 0, 1]
            return residual, by_unknowns, -packed(pushed)[0]

        def asked(unknowns: Array, level: float) -> int:
            return self._asked(unknowns, frequency, level)

        return Equation(equation, self._refinement and Refinement(asked, self._in_so_many))

    def _up_to(self, unknowns: Array) -> int:
        return (unknowns.size // self.clamps - 1) // 2

    def _in_so_many(self, unknowns: Array, size: int) -> Array:
        """Give unknowns, or a direction in them, with other harmonics: (m,) becomes (size,)."""
        count = (size // self.clamps + 1) // 2
        return np.asarray(packed(resized(self.unpacked(unknowns[None]), count))[0])

    def matched(self, unknowns: Sequence[Array]) -> list[Array]:
        """Give unknowns (m,) each with as many harmonics as the finest of them."""
        size = max(one.size for one in unknowns)
        return [self._in_so_many(one, size) for one in unknowns]

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
        at, H = np.array([frequency]), self._up_to(unknowns)
        forces = self._all_forces(unknowns, frequency, rubbing=level is None)
        return self.clamps * (
            2 * wanted(self._left_out(forces, at, 1.0 if level is None else level), H, self._most) + 1
        )

    def _all_forces(self, unknowns: Array, frequency: float, *, rubbing: bool) -> Complex:
        """Give all harmonics of a motion's forces, (1, clamps, h); beyond H without those that aren't left out."""
        motion, H = self.unpacked(unknowns[None]), self._up_to(unknowns)
        if not (rubbing and self._rubs(unknowns, frequency)):
            return self._forces(resized(motion, max(H, self._told) + 1), np.array([frequency]))
        return self._rubbed(motion[0], frequency, H).smooth_beyond(H)[None, :, : max(H, self._told) + 1]

    def _left_out(self, forces: Complex, at: Array, level: float) -> Array:
        """Give what is left out by H, as of `left_out`, from all harmonics of a motion's forces."""
        drive = np.array([level * self._excitation(float(at[0]))])
        return left_out(self._driven(forces, drive, self.responses(at, forces.shape[2] - 1))[0])

    def _truncated(self, unknowns: Array, at: Array, drive: Array, forces: Complex) -> float:
        """Give what a balanced motion is off by because harmonics are left out, as a share of it.

        It lacks them, to first order, and its force doesn't answer to them: where force steps with the velocity, they
        move the step, and with it the harmonics that are balanced. The larger of the two is given. What the harmonics
        up to the last that a cycle's samples tell answer falls with 1/H at a step; those beyond are reckoned so, too.

        Args:
            unknowns: of the clamps' motion, (m,).
            at: Hz, (1,).
            drive: the sine's amplitude, (1,).
            forces: all harmonics of the motion's forces, (1, clamps, h).
        """
        H = self._up_to(unknowns)
        responses = self.responses(at, forces.shape[2] - 1)
        first = self._driven(forces, drive, responses)
        whole = first[:, : self.clamps].copy()
        whole[:, :, : H + 1] = self.unpacked(unknowns[None])
        if self._rubs(unknowns, float(at[0])):
            answering = self._rubbed(whole[0], float(at[0]), H).forces[None, :, : H + 1]
        else:
            answering = self._forces(whole, at)
        again = self._driven(answering, drive, responses)[:, : self.clamps, : H + 1]
        two = float(at[0]) * np.array([1.0, 1 + NUDGE])
        stated = self._excitation(float(at[0]))
        drives = (float(drive[0]) / stated if stated else 1.0) * np.array(
            [self._excitation(one) for one in two.tolist()]
        )
        residual, by_unknowns, ahead = self._linearised(unknowns, two, drives, self.responses(two, H))
        missing, size = packed(again)[0] - unknowns, self.sizes(unknowns[None])[0]
        change = np.linalg.lstsq(by_unknowns, missing, rcond=None)[0]
        along = np.linalg.lstsq(
            np.column_stack([by_unknowns, (ahead[0] - residual) / (NUDGE * size)]), missing, rcond=None
        )[0]
        if np.linalg.norm(change) > STEEP * np.linalg.norm(along):
            change = along[:-1]
        moved = np.abs(self.unpacked(change[None])[0, :, 1:]) ** 2
        squares = (np.abs(first[0, :, 1:]) ** 2).sum(axis=1)
        held = np.maximum(squares[: self.clamps], STILL**2 * squares.max(initial=0.0))
        answered = float(np.sqrt((moved.sum(axis=1) / np.where(held > 0, held, 1.0)).max(initial=0.0)))
        rest = 1 - H / forces.shape[2]
        return float(max(answered / rest, left_out(first[0])[H]))

    def truncated(self, unknowns: Array, frequency: float, drive: float) -> float:
        """Give what a balanced motion is off by because harmonics are left out, as a share of it.

        Args:
            unknowns: of the clamps' motion, (m,).
            frequency: Hz.
            drive: amplitude of the excitation, m/s2 or N.
        """
        if not self._clamps:
            return 0.0
        forces = self._all_forces(unknowns, frequency, rubbing=True)
        return self._truncated(unknowns, np.array([frequency]), np.array([drive]), forces)

    def at(self, frequency: float) -> SteadyState | None:
        """Give the motion at a frequency (Hz) that grows out of rest with the excitation; None where it isn't found."""
        start = self.start(frequency)
        return None if start is None else self.state(start, frequency)

    def start(self, frequency: float) -> Array | None:
        """Find the unknowns at a frequency by letting the excitation grow from nothing.

        Where a law has no slope at rest, or takes hold at once as a clearance does, no path may lead away from there:
        then springs and dashpots, as stiff as the clamps on the motion that they make, turn into the clamps.
        """
        if not self._clamps:
            return np.zeros(0)
        found = self._grown_from_rest(frequency)
        return self._turned_from_springs(frequency) if found is None else found

    def _turned_from_springs(self, frequency: float) -> Array | None:
        """Find the unknowns at a frequency by turning springs and dashpots into the clamps, under the whole drive."""
        at, drive = np.array([frequency]), np.array([self._excitation(frequency)])
        more = STICKING if self._rubbing and not self._stated else 1
        responses = self.responses(at, min(more * self.harmonics, self._most))
        told = equivalent(self._forces, responses[0, : self.clamps], -1j * float(drive[0]), at)
        if told is None:
            return None
        guess, stiffness = told
        size = float(np.abs(guess).max())

        def equation(unknowns: Array, share: float) -> tuple[Array, Array, Array]:
            whole, by_unknowns, _ = self._linearised(unknowns, at, drive, responses, rubbing=True)
            rows = self.unpacked(np.vstack([np.zeros(unknowns.size), np.eye(unknowns.size)]))
            forces = stiffness[None, :, None] * rows
            forces[:, :, 0] = forces[:, :, 0].real
            loaded = packed(self._driven(forces, drive, responses[:, : self.clamps]))
            springs = np.eye(unknowns.size) - (loaded[1:] - loaded[0]).T
            linear = springs @ unknowns - loaded[0]
            return share * whole + (1 - share) * linear, share * by_unknowns + (1 - share) * springs, whole - linear

        turning = Equation(equation)
        begin = solve(turning, packed(guess[None])[0], 0.0, size)
        if begin is None:
            return None
        path = list(follow(turning, Solution(0.0, begin), 1.0, size, Steps(longest=0.2)))
        if path[-1].parameter != 1.0:
            return None
        found = solve(self.over_frequency(), path[-1].unknowns, frequency, size)
        return None if found is None else self.with_sides(found, frequency)

    def _grown_from_rest(self, frequency: float) -> Array | None:
        """Find the unknowns at a frequency by letting the excitation grow from nothing."""
        linear = self._excitation(frequency) * float(np.abs(self.responses(np.array([frequency]))[0, :, 0, 1]).max())
        at_rest = solve(self.over_level(frequency), np.zeros(self.size), 0.0, SMALLEST)
        if at_rest is None:
            return None
        path = list(follow(self.over_level(frequency), Solution(0.0, at_rest), 1.0, 0.1 * linear, Steps(longest=0.2)))
        if path[-1].parameter != 1.0:
            return None
        return self.with_sides(path[-1].unknowns, frequency)

    def with_sides(self, unknowns: Array, frequency: float) -> Array | None:
        """Give a solution that `over_level` led to as `over_frequency` has it; None where it isn't found.

        They differ where a force steps: the harmonics that it makes beyond H count over frequency only. So it is sought
        in few, and in as many as were needed so far where that fails.
        """
        if not self._rubbing:
            return unknowns
        size = float(self.sizes(unknowns[None])[0])
        for count in sorted({min(self.size, unknowns.size), unknowns.size}):
            found = solve(self.over_frequency(), self._in_so_many(unknowns, count), frequency, size)
            if found is not None:
                return found
        return None

    def curve(self, first: float, last: float) -> list[SteadyState]:
        """Give the frequency response from one frequency to another (Hz), round its turning points.

        The curve begins at the first frequency; where it ends before the last one, the list does too.
        """
        return [self.state(point.unknowns, point.parameter, point.side) for point in self.path(first, last)]

    def path(self, first: float, last: float) -> list[Solution]:
        """Give the solutions that `curve` evaluates, which takes as long as to find them."""
        start = self.start(first)
        if start is None:
            return []
        if not self._clamps:
            return [Solution(frequency, start) for frequency in np.linspace(first, last, 200).tolist()]
        size = float(self.sizes(start[None])[0])
        return list(follow(self.over_frequency(), Solution(first, start), last, size, OVER_FREQUENCY))

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
        """Give the unknowns, (m,) each, where a curve passes a frequency (Hz), in the order in which it does."""
        path = [Solution(state.frequency, packed(state.balanced[None])[0]) for state in states]
        return self.passing(path, frequency)

    def passing(self, path: Sequence[Solution], frequency: float) -> list[Array]:
        """Give the unknowns, (m,) each, where a path passes a frequency (Hz), in the order in which it does."""
        found = []
        for before, after in pairwise(path):
            if (before.parameter - frequency) * (after.parameter - frequency) < 0:
                met = between(self.over_frequency(), before, after, frequency) if self._clamps else before.unknowns
                if met is not None:
                    found.append(met)
            if before.parameter == frequency:
                found.append(before.unknowns)
        if path and path[-1].parameter == frequency:
            found.append(path[-1].unknowns)
        return found

    def crossings(self, states: Sequence[SteadyState], frequency: float) -> list[SteadyState]:
        """Give the states at a frequency (Hz) at which a curve passes it."""
        return [self.state(unknowns, frequency) for unknowns in self.solutions(states, frequency)]

    def state(self, unknowns: Array, frequency: float, side: int = 0) -> SteadyState:
        """Evaluate a solution (m,) at a frequency (Hz), and its stability; side as of `Solution`."""
        count = len(self._clamps)
        motion = self.unpacked(unknowns[None])
        at, drive = np.array([frequency]), np.array([self._excitation(frequency)])
        H = motion.shape[2] - 1
        told, rubs = max(H, self._told), self._rubs(unknowns, frequency)
        if rubs:
            rubbed = self._rubbed(motion[0], frequency, H)
            motion, forces = rubbed.whole[None, :, : told + 1], rubbed.smooth_beyond(H)[None, :, : told + 1]
            moving = np.concatenate([forces[:, :, : H + 1], rubbed.stepping[None, :, H + 1 : told + 1]], axis=2)
        laws = [tangents(clamp, motion[0, index], frequency) for index, clamp in enumerate(self._clamps)]
        if not rubs:
            forces = np.zeros((1, count, told + 1), dtype=np.complex128)
            for index, law in enumerate(laws):
                forces[:, index] = harmonics_of(law.force[None], told + 1)
            moving = forces[:, :, : H + 1]
        moved = self._driven(moving, drive, self.responses(at, moving.shape[2] - 1))[0]
        conditions = [c.conditions(motion[:, i], np.array([frequency])) for i, c in enumerate(self._clamps)]
        farthest = half_range(moved[:count]).tolist()
        adrift = self._receptance.adrift
        return SteadyState(
            frequency=frequency,
            clamps=moved[:count],
            probes=moved[count:],
            forces=forces[0, :, : H + 1],
            conditions=np.array([[A[0], f[0]] for A, f in conditions]).reshape(count, 2),
            growth=growth(self._stiffness, self._damping, self._shapes, laws, 1 / frequency, adrift=adrift),
            truncated=self._truncated(unknowns, at, drive, forces) if count else 0.0,
            beyond=tuple(c.beyond(motion[0, i], frequency, farthest[i]) for i, c in enumerate(self._clamps)),
            side=side,
        )
