"""Stick and slip located as events: an independent integrator for pipes whose clamps rub, shaken by a sine.

In modes of unit mass q'' + C q' + omega^2 q = participation a sin(w t) - sum over clamps of shape f, with
f = k s + c v + F_c sgn v. A clamp slides to one side, or the other, or sticks, held by the force that keeps v at 0.
Between events (v = 0 while sliding; the holding force at F_c) all is linear, and exact by matrix exponentials: no step,
no order, no tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from pipeclamp_models.pipe.modes import ReducedPipe

LOOKED_AT = 2e-4
"""s between the times at which events are looked for."""


@dataclass(frozen=True)
class Rubbing:
    """A clamp's force: k s + c v + friction sgn v, in N/m, N s/m and N."""

    stiffness: float
    damping: float
    friction: float


@dataclass(frozen=True)
class Modal:
    """A pipe in modes: rad/s, 1/s, what excites them (modes,), and the displacement at each clamp (clamps, modes)."""

    omega: np.ndarray
    damping: np.ndarray
    participation: np.ndarray
    clamps: np.ndarray

    @classmethod
    def of(cls, pipe: ReducedPipe) -> Modal:
        """Take over a reduced pipe's."""
        parts = (pipe.omega, pipe.damping, pipe.excitation_participation, pipe.clamp_shapes)
        return cls(*(np.array(part) for part in parts))


class Sliding:
    """The motion while clamps slide (1, -1) or stick (0), z = (q, q', sin, cos, 1): z' = A z, holding forces H z."""

    def __init__(
        self, pipe: Modal, clamps: Sequence[Rubbing], slides: tuple[int, ...], sine: tuple[float, float]
    ) -> None:
        """Compose the matrices; `sine` is amplitude and rad/s."""
        size, shapes, stuck = pipe.omega.size, pipe.clamps, np.array(slides) == 0
        stiffness, damping, friction = np.array([(one.stiffness, one.damping, one.friction) for one in clamps]).T
        free = np.hstack(
            [
                -np.diag(pipe.omega**2) - (shapes.T * stiffness) @ shapes,
                -np.diag(pipe.damping) - (shapes.T * damping) @ shapes,
                sine[0] * pipe.participation[:, None],
                np.zeros((size, 1)),
                -(shapes.T @ (friction * slides))[:, None],
            ]
        )
        holds = np.zeros((len(clamps), size))
        if stuck.any():
            holds[stuck] = np.linalg.solve(shapes[stuck] @ shapes[stuck].T, shapes[stuck])
        self.H = holds @ free
        self.A = np.zeros((2 * size + 3, 2 * size + 3))
        self.A[:size, size : 2 * size] = np.eye(size)
        self.A[size : 2 * size] = free - shapes.T @ self.H
        self.A[2 * size, 2 * size + 1], self.A[2 * size + 1, 2 * size] = sine[1], -sine[1]
        self.onward = expm(self.A * LOOKED_AT)
        self.slides, self.friction = np.array(slides), friction
        self.speed = np.zeros((len(clamps), 2 * size + 3))
        self.speed[:, size : 2 * size] = shapes

    def left(self, z: np.ndarray) -> np.ndarray:
        """Give for each clamp what must not fall below 0: its speed while it slides, else what friction can add."""
        return np.where(self.slides == 0, self.friction - np.abs(self.H @ z), self.slides * (self.speed @ z))

    def end(self, z: np.ndarray, index: int) -> float:
        """Give the time, s, after which that of a clamp falls below 0; 0 where it has just been let go."""
        if self.left(z)[index] <= 0:
            return 0.0
        return float(brentq(lambda t: self.left(expm(self.A * t) @ z)[index], 0.0, LOOKED_AT, xtol=1e-15))


def integrate(
    pipe: Modal, clamps: Sequence[Rubbing], amplitude: float, frequency: float, times: np.ndarray
) -> np.ndarray:
    """Give q, then q' at the times, (2 m, n), from rest at time 0, under a sine of an amplitude, m/s2 or N, and Hz."""
    size, known, answer = pipe.omega.size, {}, []
    friction = np.array([clamp.friction for clamp in clamps])

    def under(slides: Sequence[int]) -> Sliding:
        key = tuple(int(one) for one in slides)
        if key not in known:
            known[key] = Sliding(pipe, clamps, key, (amplitude, 2 * np.pi * frequency))
        return known[key]

    def let_go(z: np.ndarray, now: Sliding) -> Sliding:
        """Let slide what is at rest and friction doesn't hold."""
        force = now.H @ z
        beyond = (now.slides == 0) & (np.abs(force) >= friction * (1 - 1e-12))
        return let_go(z, under(np.where(beyond, np.sign(force), now.slides))) if beyond.any() else now

    z, time = np.concatenate([np.zeros(2 * size), [0.0, 1.0, 1.0]]), 0.0
    now = let_go(z, under(np.where(friction > 0, 0, 1)))
    while len(answer) < times.size:
        after = now.onward @ z
        fallen = (now.left(after) < 0) & (friction > 0)
        length = LOOKED_AT
        if fallen.any():
            # A clamp that has just been let go begins at 0.
            ends = [now.end(z, int(index)) for index in np.flatnonzero(fallen)]
            length = min(ends)
        while len(answer) < times.size and times[len(answer)] <= time + length:
            answer.append(expm(now.A * (times[len(answer)] - time)) @ z)
        if not fallen.any():
            z, time = after, time + length
            continue
        z, time = expm(now.A * length) @ z, time + length
        index = int(np.flatnonzero(fallen)[int(np.argmin(ends))])
        slides = now.slides.copy()
        if slides[index]:
            slides[index] = 0
            shape = pipe.clamps[index]  # exactly at rest
            z[size : 2 * size] -= shape * (shape @ z[size : 2 * size]) / (shape @ shape)
        else:
            slides[index] = np.sign((now.H @ z)[index])
        now = let_go(z, under(slides))
    return np.array(answer)[:, : 2 * size].T
