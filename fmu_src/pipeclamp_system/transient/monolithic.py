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


class _Coupled:
    """Pipe and clamps as one set of equations, in modal displacements and velocities and the clamps' history states."""

    def __init__(
        self, pipe: ReducedPipe, clamps: Sequence[ClampEquations], excitation: Callable[[float], float]
    ) -> None:
        self.pipe, self.clamps, self.excitation = pipe, clamps, excitation
        self.count = count = len(pipe.omega)
        self.participation = np.array(pipe.excitation_participation)
        self.shapes = np.array(pipe.clamp_shapes).reshape(len(clamps), count)
        ends = 2 * count + np.cumsum([0] + [len(clamp.start) for clamp in clamps])
        self.own = [slice(ends[i], ends[i + 1]) for i in range(len(clamps))]
        """Where each clamp's history states stand."""
        self.remembering = [(i, clamp, self.own[i]) for i, clamp in enumerate(clamps) if clamp.start]
        self.both = slice(0, 2 * count)
        """Where the modal displacements and velocities stand."""
        # In one product each: the clamps' motion in mm and mm/s, and the rates under their forces.
        still = np.zeros_like(self.shapes)
        self.motion = 1e3 * np.block([[self.shapes, still], [still, self.shapes]])
        self.free = np.block(
            [[np.zeros((count, count)), np.eye(count)], [-pipe.stiffness_matrix, -pipe.damping_matrix]]
        )
        self.entering = np.vstack([np.zeros((count, 1 + len(clamps))), np.vstack([self.participation, -self.shapes]).T])
        self.linear = np.hstack([self.free, self.entering])
        self.loaded = np.empty(2 * count + 1 + len(clamps))

    def start(self) -> Array:
        """Give the state at rest, (2 modes + history states,)."""
        return np.concatenate([np.zeros(2 * self.count), *(np.array(clamp.start) for clamp in self.clamps)])

    def nothing(self) -> Array:
        """Give what counts as nothing of each part of the state.

        A nanometre of clamp motion in modal measure, a micronewton in the history states.
        """
        largest = float(np.abs(self.shapes).max(initial=0.0)) or 1.0
        absolute = np.full(self.start().size, 1e-6)
        absolute[: self.count] = 1e-12 / largest
        absolute[self.count : 2 * self.count] = 1e-12 / largest * np.maximum(self.pipe.omega, self.pipe.omega[-1] / 100)
        return absolute

    def rates(self, t: float, state: Array) -> Array:
        """Give the state's rates at a time in s."""
        y, v = self._clamp_motion(state)
        self.loaded[self.both] = state[self.both]
        self.loaded[2 * self.count :] = [self.excitation(t), *self._clamp_forces(state, y, v)]
        change = self.linear @ self.loaded
        if not self.remembering:
            return change
        own = [clamp.rates(state[own].tolist(), y[i], v[i]) for i, clamp, own in self.remembering]
        return np.concatenate([change, *own])

    def slopes(self, t: float, state: Array) -> Array:
        """Give the derivatives of the rates by the state."""
        y, v = self._clamp_motion(state)
        found, both = np.zeros((state.size, state.size)), self.both
        found[both, both] = self.free
        for i, clamp in enumerate(self.clamps):
            own, entering = self.own[i], self.entering[:, 1 + i]
            by_own = clamp.slopes(state[own].tolist(), y[i], v[i])
            by_motion = by_own[:, :2] @ self.motion[[i, len(self.clamps) + i]]
            found[both, both] += np.outer(entering, by_motion[0])
            found[both, own] = np.outer(entering, by_own[0, 2:])
            found[own, both], found[own, own] = by_motion[1:], by_own[1:, 2:]
        return found

    def result(self, time: Array, states: Array) -> MonolithicResult:
        """Give what a solution, (n, states) at times (n,), is in the clamps and probes."""
        pipe, count = self.pipe, self.count
        q, p = states[:, :count], states[:, count : 2 * count]
        displacement, velocity = q @ self.shapes.T, p @ self.shapes.T
        force = np.array(
            [self._clamp_forces(*row) for row in zip(states, 1e3 * displacement, 1e3 * velocity, strict=True)]
        ).reshape(time.size, len(self.clamps))
        loads = np.outer([self.excitation(t) for t in time], self.participation) - force @ self.shapes
        acceleration = loads - p @ pipe.damping_matrix.T - q @ pipe.stiffness_matrix.T
        seen = np.array(pipe.probe_shapes).reshape(len(pipe.probe_names), count).T
        return MonolithicResult(time, displacement, velocity, force, q @ seen, p @ seen, acceleration @ seen)

    def _clamp_forces(self, state: Array, y: Sequence[float], v: Sequence[float]) -> list[float]:
        return [clamp.force(state[self.own[i]].tolist(), y[i], v[i]) for i, clamp in enumerate(self.clamps)]

    def _clamp_motion(self, state: Array) -> tuple[list[float], list[float]]:
        moved = (self.motion @ state[self.both]).tolist()
        return moved[: len(self.clamps)], moved[len(self.clamps) :]


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
    coupled = _Coupled(pipe, clamps, excitation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ODEintWarning)  # what failed is in the message
        states, report = odeint(
            coupled.rates,
            coupled.start(),
            time,
            Dfun=coupled.slopes,
            tfirst=True,
            full_output=True,
            rtol=relative_tolerance,
            atol=coupled.nothing(),
            hmax=float(time[-1]) / 200,  # so that a slow start doesn't step over the excitation
            mxstep=10**9,  # between two times: as many as the tolerance takes
        )
    if report["message"] != SOLVED:
        raise ArithmeticError(
            f"the monolithic solution fails after t = {report['tcur'].max():g} s: {report['message']}"
        )
    if not np.isfinite(states).all():
        raise ArithmeticError("the monolithic solution grows beyond all numbers")
    return coupled.result(time, states)
