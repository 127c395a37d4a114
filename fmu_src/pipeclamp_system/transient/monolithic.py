"""The coupled system solved as one set of equations, by SciPy: the reference for every co-simulation scheme."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import ODEintWarning, odeint

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Law
from pipeclamp_models.pipe.modes import ReducedPipe
from pipeclamp_models.realise.scalar_law import scalar_law

RATE_STEP = 1e-5
"""Seconds over which a history state's update is turned into a rate: short beside any motion here, but no shorter.

It is the time constant with which a slipping element reaches its limit; a stiffer one costs the integrator its digits.
"""

NUDGE, LEAST_NUDGE = 1e-6, 1e-9
"""By which share of its size an argument of a law is moved for a derivative, and at least: the integrator's corrections
need no better one."""

SOLVED = "Integration successful."
"""What SciPy says where its integration reached the end."""


@dataclass(frozen=True)
class ClampEquations:
    """A clamp law at its amplitude, frequency and temperature, as plain functions; mm, N.

    Attributes:
        start: the history states at the start.
        coefficients: what the law's step takes first.
        step: the law's step, as `pipeclamp_models.realise.scalar` describes it.
    """

    start: tuple[float, ...]
    coefficients: Any
    step: Callable[..., tuple[float, float, tuple[float, ...]]]

    def force(self, state: Sequence[float], y: float, v: float) -> float:
        """Give the force in N at y (mm), v (mm/s) and the present history states."""
        return self.step(self.coefficients, tuple(state), y, y, v, 0.0)[0]

    def rates(self, state: Sequence[float], y: float, v: float) -> list[float]:
        """Give the rates of the history states: the update over a step so short that it is one."""
        after = self.step(self.coefficients, tuple(state), y - v * RATE_STEP, y, v, RATE_STEP)[2]
        return [(new - old) / RATE_STEP for new, old in zip(after, state, strict=True)]

    def slopes(self, state: Sequence[float], y: float, v: float) -> Array:
        """Give the derivatives of the force, then of the states' rates, by y, v and each state, (1 + J, 2 + J)."""
        place, columns = [y, v, *state], []
        here = [self.force(state, y, v), *self.rates(state, y, v)]
        for index, value in enumerate(place):
            nudge = max(NUDGE * abs(value), LEAST_NUDGE)
            there = [*place[:index], value + nudge, *place[index + 1 :]]
            moved = [self.force(there[2:], *there[:2]), *self.rates(there[2:], *there[:2])]
            columns.append([(after - before) / nudge for after, before in zip(moved, here, strict=True)])
        return np.array(columns).T


def clamp_equations(law: Law, amplitude: float, frequency: float, temperature: float) -> ClampEquations:
    """Give a law's equations at an amplitude (mm), frequency (Hz) and temperature (K): those that its FMU runs."""
    scalar = scalar_law(law)
    start = tuple(float(value) for _, value in scalar.states)
    return ClampEquations(start, scalar.coefficients(amplitude, frequency, temperature), scalar.step)


@dataclass(frozen=True, eq=False)
class MonolithicResult:
    """The reference solution at the asked times.

    Attributes:
        time: s, (n,).
        displacement: of each clamp, m, (n, clamps).
        velocity: m/s, (n, clamps).
        force: into each clamp, N, (n, clamps).
        probes: displacement of each probe, m, (n, probes).
        probe_velocity, probe_acceleration: relative to the base, m/s and m/s2, (n, probes).
    """

    time: Array
    displacement: Array
    velocity: Array
    force: Array
    probes: Array
    probe_velocity: Array
    probe_acceleration: Array


def solve_monolithic(
    pipe: ReducedPipe,
    clamps: Sequence[ClampEquations],
    excitation: Callable[[float], float],
    time: Array,
    relative_tolerance: float = 1e-8,
) -> MonolithicResult:
    """Solve pipe and clamps together, started from rest.

    Args:
        pipe: the reduced pipe.
        clamps: the equations of each of its clamps, in its order.
        excitation: m/s2 or N over s.
        time: when the solution is asked for, s, ascending from 0, (n,).
        relative_tolerance: of the integration.

    Raises:
        ArithmeticError: the integration fails.
    """
    stiffness, damping = pipe.stiffness_matrix, pipe.damping_matrix
    participation = np.array(pipe.excitation_participation)
    shapes = np.array(pipe.clamp_shapes).reshape(len(clamps), len(pipe.omega))
    count = len(pipe.omega)
    ends = 2 * count + np.cumsum([0] + [len(clamp.start) for clamp in clamps])
    remembering = [(i, clamp, slice(ends[i], ends[i + 1])) for i, clamp in enumerate(clamps) if clamp.start]
    # In one product each: the clamps' displacements and velocities in mm and mm/s, and the rates under their forces.
    still, both = np.zeros_like(shapes), slice(0, 2 * count)
    motion = 1e3 * np.block([[shapes, still], [still, shapes]])
    free = np.block([[np.zeros((count, count)), np.eye(count)], [-stiffness, -damping]])
    entering = np.vstack([np.zeros((count, 1 + len(clamps))), np.vstack([participation, -shapes]).T])
    linear = np.hstack([free, entering])
    loaded = np.empty(2 * count + 1 + len(clamps))

    def clamp_forces(state: Array, y: Sequence[float], v: Sequence[float]) -> list[float]:
        return [clamp.force(state[ends[i] : ends[i + 1]].tolist(), y[i], v[i]) for i, clamp in enumerate(clamps)]

    def clamp_motion(state: Array) -> tuple[list[float], list[float]]:
        moved = (motion @ state[both]).tolist()
        return moved[: len(clamps)], moved[len(clamps) :]

    def rates(t: float, state: Array) -> Array:
        y, v = clamp_motion(state)
        loaded[both] = state[both]
        loaded[2 * count :] = [excitation(t), *clamp_forces(state, y, v)]
        change = linear @ loaded
        if not remembering:
            return change
        own = [clamp.rates(state[own].tolist(), y[i], v[i]) for i, clamp, own in remembering]
        return np.concatenate([change, *own])

    def slopes(t: float, state: Array) -> Array:
        y, v = clamp_motion(state)
        found = np.zeros((state.size, state.size))
        found[both, both] = free
        for i, clamp in enumerate(clamps):
            own = slice(ends[i], ends[i + 1])
            by_own = clamp.slopes(state[own].tolist(), y[i], v[i])
            by_motion = by_own[:, :2] @ motion[[i, len(clamps) + i]]
            found[both, both] += np.outer(entering[:, 1 + i], by_motion[0])
            found[both, own] = np.outer(entering[:, 1 + i], by_own[0, 2:])
            found[own, both], found[own, own] = by_motion[1:], by_own[1:, 2:]
        return found

    start = np.concatenate([np.zeros(2 * count), *(np.array(clamp.start) for clamp in clamps)])
    # What counts as nothing: a nanometre of clamp motion in modal measure, a micronewton in the history states.
    largest = float(np.abs(shapes).max(initial=0.0)) or 1.0
    absolute = np.full(start.size, 1e-6)
    absolute[:count] = 1e-12 / largest
    absolute[count : 2 * count] = 1e-12 / largest * np.maximum(pipe.omega, pipe.omega[-1] / 100)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ODEintWarning)  # what failed is in the message
        states, report = odeint(
            rates,
            start,
            time,
            Dfun=slopes,
            tfirst=True,
            full_output=True,
            rtol=relative_tolerance,
            atol=absolute,
            hmax=float(time[-1]) / 200,  # so that a slow start doesn't step over the excitation
            mxstep=10**9,  # between two times: as many as the tolerance takes
        )
    if report["message"] != SOLVED:
        raise ArithmeticError(
            f"the monolithic solution fails after t = {report['tcur'].max():g} s: {report['message']}"
        )
    if not np.isfinite(states).all():
        raise ArithmeticError("the monolithic solution grows beyond all numbers")
    q, p = states[:, :count], states[:, count : 2 * count]
    displacement, velocity = q @ shapes.T, p @ shapes.T
    force = np.array(
        [clamp_forces(*row) for row in zip(states, 1e3 * displacement, 1e3 * velocity, strict=True)]
    ).reshape(time.size, len(clamps))
    loads = np.outer([excitation(t) for t in time], participation) - force @ shapes
    acceleration = loads - p @ damping.T - q @ stiffness.T
    seen = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), count).T
    return MonolithicResult(time, displacement, velocity, force, q @ seen, p @ seen, acceleration @ seen)
