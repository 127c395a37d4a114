"""How a clamp's law answers a small change of its steady motion: sample by sample, and over the whole cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.force import force_of_equations, step_slopes
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.states import SETTLED_SHARE
from pipeclamp_system.steady.clamp import SteadyClamp, harmonics_of
from pipeclamp_system.steady.harmonics import SMALLEST_MOTION_MM

NUDGE = 1e-5
"""By which share of its size an argument or an unknown is moved for a derivative."""

KINKED = 1e-3
"""By which share a derivative by differences is off one side's where the other side's is in it."""

Y, V, BEFORE, STEP, AMPLITUDE, FREQUENCY = range(6)
"""Arguments of a law's step but its states: y, v at a sample, y a sample before, the step h, A, f.

No law that is carried to a pipe depends on acceleration: only what the rig adds does."""


@dataclass(frozen=True, eq=False)
class Passage:
    """What a force that steps with the velocity does to a disturbance of that velocity, at n samples of a cycle.

    Attributes:
        damping: change of the force over that of the velocity where the side changes gradually, N s/mm, (n,).
        left: share of a disturbance of the velocity that is left where the side changes at once, (n,); else 1.
    """

    damping: Array
    left: Array


@dataclass(frozen=True, eq=False)
class Tangents:
    """A law's force on a cycle of n samples and the derivatives of its steps; mm, s, N.

    Attributes:
        force: at each sample, (n,).
        by_argument: derivatives of the force and then of the states, by the six arguments, (1 + J, 6, n).
        by_state: the same by the states a sample before, (1 + J, J, n).
        follows: n times the change of A by that of y at each sample, (n,); 0 where the law's A is given or held.
        adrift: whether states keep a constant for ever, which is neither stable nor unstable.
        passage: of a force that steps with the velocity; its step is then in no derivative.
    """

    force: Array
    by_argument: Array
    by_state: Array
    follows: Array
    adrift: bool
    passage: Passage | None = None

    @property
    def memory(self) -> int:
        """How many states there are."""
        return len(self.by_state) - 1

    @property
    def tracks(self) -> bool:
        """Whether force or states hang on an A that follows the motion."""
        return bool(self.follows.any() and self.by_argument[:, AMPLITUDE].any())


def tangents(clamp: SteadyClamp, motion: ComplexArray, frequency: float) -> Tangents:
    """Linearise a clamp's law about a periodic motion.

    Where the velocity turns, a derivative by it is that over the velocity's change in a step, as force itself is
    averaged there.

    Args:
        clamp: the law with its conditions.
        motion: harmonics of y, mm, (h,).
        frequency: Hz.
    """
    return along(clamp, clamp.cycle(motion[None], np.array([frequency])))


def linearised(clamp: SteadyClamp, motions: ComplexArray, frequencies: Array) -> tuple[ComplexArray, ComplexArray]:
    """Give a clamp's force on a periodic motion, and what motions next to it change of the force to first order.

    Args:
        clamp: the law with its conditions.
        motions: harmonics of y, mm, (rows, h): the motion, then those next to it.
        frequencies: Hz, (rows,).

    Returns:
        harmonics of the force, N, (h,), and of its changes, (rows - 1, h).
    """
    cycles = clamp.cycle(motions, frequencies)
    law = along(clamp, cycles.rows(np.array([0])))
    each = arguments(cycles)
    force = answered(law, each[:, 1:] - each[:, :1])
    found = harmonics_of(np.concatenate([law.force[None], force]), motions.shape[1])
    return found[0], found[1:]


def answered(law: Tangents, changes: Array) -> Array:
    """Give what the force changes by at each sample, to first order, (rows, n), for changes of `arguments`."""
    by_arguments = np.einsum("san,arn->srn", law.by_argument, changes)
    force = by_arguments[0]
    if law.memory:
        # What keeps a constant for ever has it from its first move, which began where nothing had moved yet.
        first = by_arguments[1:, :, -1] - law.by_argument[1:, BEFORE, -1:] * changes[BEFORE, :, -1]
        states = _states_before(law.by_state[1:], by_arguments[1:], first)
        force = force + np.einsum("jn,jrn->rn", law.by_state[0], states)
    return np.asarray(force)


def _states_before(slopes: Array, inputs: Array, first: Array) -> Array:
    """Give how the states a sample before change in a periodic motion, (J, rows, n).

    Args:
        slopes: of the states by those a sample before, (J, J, n).
        inputs: changes of the states by all else, (J, rows, n).
        first: changes of the states after a first move from rest to the cycle's last sample, (J, rows).
    """
    # Loading it takes longer than a clamp without memory, which doesn't come here.
    from pipeclamp_models.realise.trails import carried

    count, rows, samples = inputs.shape
    # What the states at the cycle's begin make of a cycle goes along as further rows.
    added = np.concatenate([inputs.transpose(2, 0, 1), np.zeros((samples, count, count))], axis=2)
    start = np.hstack([first, np.eye(count)])
    after = np.asarray(carried(*map(np.ascontiguousarray, (start, slopes.transpose(2, 0, 1), added))))
    before = np.concatenate([start[None], after[:-1]])
    to_begin = np.linalg.pinv(np.eye(count) - after[-1, :, rows:], rcond=SETTLED_SHARE)
    begin = to_begin @ (after[-1, :, :rows] - first)
    return np.asarray((before[:, :, :rows] + before[:, :, rows:] @ begin).transpose(1, 2, 0))


def arguments(cycles: Motion) -> Array:
    """Give the arguments but the states of motions' steps, (6, rows, n)."""
    still = (cycles.h, cycles.slow["A"], cycles.slow["f"])
    shape = cycles.y.shape
    return np.stack([cycles.y, cycles.v, np.roll(cycles.y, 1, axis=1), *(np.broadcast_to(one, shape) for one in still)])


def along(clamp: SteadyClamp, cycle: Motion) -> Tangents:
    """Linearise a clamp's law along one cycle."""
    equations = clamp.law.structure.equations_without_rig
    values, smoothing = clamp.law.vector(equations), (clamp.law.v_r, clamp.law.y_r)
    compiled = realise(equations)
    along_cycle = force_of_equations(equations, values, smoothing, cycle)
    y, a, h, A = cycle.y[0], cycle.a[0], cycle.h[0, 0], cycle.slow["A"][0, 0]

    still = arguments(cycle)[:, 0]
    own = len(still)
    at = np.stack([*still, *(np.roll(state[0], 1) for state in along_cycle.states)])
    least = np.full((len(at), 1), np.finfo(float).tiny)
    least[[Y, BEFORE]] = SMALLEST_MOTION_MM  # at rest a law may give a force, beside which less than that is lost
    nudges = NUDGE * np.maximum(np.abs(at).max(axis=1, keepdims=True), least) * np.ones_like(at)
    nudges[V] = np.maximum(nudges[V], np.abs(a) * h / 2)
    each = np.eye(len(at))[:, :, None] * nudges
    moved = np.concatenate([at + each, at - each]).swapaxes(0, 1)  # (arguments, rows, n)
    slow = {**cycle.slow, "A": moved[AMPLITUDE, :, :1], "f": moved[FREQUENCY, :, :1]}
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        coefficients = compiled.coefficients(*(slow[name] for name in compiled.slow), *values, *smoothing)
        held = [*coefficients, *values, *smoothing]
        fast = [moved[Y], moved[V], a, moved[BEFORE], moved[STEP]]
        after = compiled.update(*fast, *moved[own:], *held) if along_cycle.states else []
        results = [*compiled.force(*fast, *after, *held), *after]
    found = np.stack([np.broadcast_to(result, moved[Y].shape) for result in results])
    above, below = np.split(found, 2, axis=1)
    slopes = (above - below) / (2 * nudges)
    if along_cycle.states:  # exact, so that what a state keeps for ever is told from what it nearly keeps
        exact = step_slopes(equations, values, smoothing, cycle, along_cycle.states)[0].transpose(1, 2, 0)
        # At a kink both sides count, as they do for the other arguments: else what is kept for ever seems to grow.
        kinked = (np.abs(slopes[1:, own:] - exact) > KINKED * np.maximum(1.0, np.abs(exact))).any(axis=(0, 1))
        slopes[1:, own:] = np.where(kinked, slopes[1:, own:], exact)

    follows = np.zeros_like(y)
    if clamp.amplitude is None and clamp.range_A[0] < A < clamp.range_A[1]:
        follows = 2 * (y - y.mean()) / A
    return Tangents(along_cycle.force[0], slopes[:, :own], slopes[:, own:], follows, bool(along_cycle.adrift[0]))
