"""How a steady state moves with what isn't known of its clamps: exact to first order, round turning points too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_models.law.file import law_of
from pipeclamp_models.realise.force import force_of_equations, known_jacobian
from pipeclamp_system.bands.quantities import Unknown
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp, harmonics_of, sampled
from pipeclamp_system.steady.harmonics import packed
from pipeclamp_system.steady.states import SteadyState

SAMPLES_PER_CYCLE = 512
"""Of a cycle, in which its ends are sought."""


@dataclass(frozen=True, eq=False)
class Moves:
    """How a state moves, at a right angle to its curve, per quantity that isn't known.

    Attributes:
        frequency: Hz, shape (Q,).
        amplitudes: half the peak-to-peak displacement of each clamp and probe, mm, shape (Q, points).
        turning: where the curve turns back next to the state, how that frequency moves, Hz, shape (Q,).
    """

    frequency: Array
    amplitudes: Array
    turning: Array


def moves(system: SteadySystem, clamps: Sequence[SteadyClamp], state: SteadyState, unknown: Unknown) -> Moves:
    """Give how a state moves.

    Of the states into which it may move, that one counts whose difference from it is at a right angle to the curve, in
    unknowns as shares of the motion and frequency as a share of it: it exists at turning points too.

    Args:
        system: pipe and clamps under their sine.
        clamps: the laws at the state's temperature, with the parameters of `unknown`'s laws.
        state: a steady state.
        unknown: what isn't known.
    """
    unknowns = packed(state.balanced[None])[0]
    forces = _disturbances(clamps, state, unknown)
    count = len(unknown.quantities)
    size = float(system.sizes(unknowns[None])[0])
    scales = np.append(np.full(unknowns.size, size), state.frequency)
    pushed = system.pushed(state.frequency, forces)[:, : len(clamps)]
    _, by_unknowns, by_frequency = system.over_frequency()(unknowns, state.frequency)
    slopes = np.column_stack([by_unknowns, by_frequency]) * scales
    along = np.linalg.svd(slopes)[2][-1]
    right = np.concatenate([packed(pushed).T, np.zeros((1, count))])
    moved = np.linalg.solve(np.vstack([slopes, along]), right).T * scales
    changes = system.changed(unknowns, state.frequency, moved[:, :-1], moved[:, -1], forces)
    motion = np.concatenate([state.clamps, state.probes])
    # at a turning point the balance can't answer a push along this
    unanswered = np.linalg.svd(by_unknowns)[0][:, -1]
    turning = packed(pushed) @ unanswered / (by_frequency @ unanswered)
    return Moves(moved[:, -1], of_half_range(motion, changes), turning)


def moves_at(system: SteadySystem, clamps: Sequence[SteadyClamp], state: SteadyState, unknown: Unknown) -> ComplexArray:
    """Give how a state moves at its own frequency: harmonics of clamps and probes, mm, (Q, points, H + 1).

    At turning points of its curve it moves without bound. Arguments as of `moves`.
    """
    unknowns = packed(state.balanced[None])[0]
    forces = _disturbances(clamps, state, unknown)
    pushed = packed(system.pushed(state.frequency, forces)[:, : len(clamps)])
    _, by_unknowns, _ = system.over_frequency()(unknowns, state.frequency)
    moved = np.asarray(np.linalg.solve(by_unknowns, pushed.T).T, dtype=np.float64)
    return system.changed(unknowns, state.frequency, moved, np.zeros(len(moved)), forces)


def _disturbances(clamps: Sequence[SteadyClamp], state: SteadyState, unknown: Unknown) -> ComplexArray:
    """Give what each quantity changes of the clamps' forces on a motion, N, (Q, clamps, H + 1)."""
    count = state.forces.shape[1]
    found = np.zeros((len(unknown.quantities), len(clamps), count), dtype=np.complex128)
    at = np.array([state.frequency])
    for place, clamp in enumerate(clamps):
        law = clamp.law
        equations = law.structure.equations_without_rig
        cycle = clamp.cycle(state.clamps[place][None], at)
        values, smoothing = law.vector(equations), (law.v_r, law.y_r)
        force = force_of_equations(equations, values, smoothing, cycle, derivatives=True)
        sizes = unknown.sizes(place, state.beyond[place], conditions_at(clamp, state, place), state.truncated)
        own = np.flatnonzero(sizes)
        names = [unknown.quantities[index].parameter for index in own]
        parameters = np.array([equations.names.index(name) for name in names], dtype=np.intp)
        courses = known_jacobian(force).of(parameters)[:, 0]
        found[own, place] = sizes[own, None] * harmonics_of(courses, count)
    return found


def conditions_at(clamp: SteadyClamp, state: SteadyState, place: int) -> dict[str, float]:
    """Give the conditions that a clamp's law is taken for: A (mm), f (Hz), T (K) and further ones, by name.

    Those of which the law's data tell the range are held inside it.
    """
    A, f = state.conditions[place].tolist()
    values = {"A": A, "f": f, "T": clamp.temperature, **clamp.further}
    ranges = {"A": clamp.range_A, "f": clamp.range_f, **clamp.ranges}
    return {
        name: min(max(value, ranges[name][0]), ranges[name][1]) if name in ranges else value
        for name, value in values.items()
    }


def with_laws(clamps: Sequence[SteadyClamp], unknown: Unknown) -> tuple[SteadyClamp, ...]:
    """Give clamps with the laws of what isn't known, which have a parameter for each quantity."""
    return tuple(replace(clamp, law=law_of(law.file)) for clamp, law in zip(clamps, unknown.laws, strict=True))


def of_half_range(motion: ComplexArray, changes: ComplexArray) -> Array:
    """Give the change of half the peak-to-peak value: by that at the ends of the motion.

    Args:
        motion: harmonics, (points, h).
        changes: of them, (Q, points, h).

    Returns:
        shape (Q, points).
    """
    cycle = sampled(motion, SAMPLES_PER_CYCLE)
    points = np.arange(len(motion))
    moved = (
        np.stack([sampled(one, SAMPLES_PER_CYCLE) for one in changes]) if len(changes) else np.zeros((0, *cycle.shape))
    )
    return np.asarray((moved[:, points, cycle.argmax(axis=1)] - moved[:, points, cycle.argmin(axis=1)]) / 2)
