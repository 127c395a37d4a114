"""Is a pipe with flow and axial force stable: divergence, flutter, and where they begin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from scipy.linalg import eigh, eigvals

from pipeclamp_models.base.arrays import Array, ComplexArray

GROWTH = 1e-7
"""Of the highest frequency: growth slower than this is rounding (a double eigenvalue scatters by 1e-8)."""

SCAN = 240
"""Velocities that are tried before the first instability is pinned down; two of them may miss what lies between."""

StabilityKind = Literal["stable", "divergence", "flutter"]


@dataclass(frozen=True)
class Stability:
    """What a pipe does by itself, without clamps, after a small push.

    Attributes:
        kind: "stable", "divergence" (it moves away), or "flutter" (it swings up).
        growth: of what grows fastest, 1/s; below 0 where all dies out.
        frequency: of that motion, Hz.
    """

    kind: StabilityKind
    growth: float
    frequency: float


@dataclass(frozen=True)
class Onset:
    """Where a growing velocity makes a pipe unstable: velocity in m/s, and how."""

    velocity: float
    kind: StabilityKind


def eigenvalues(stiffness: Array, damping: Array) -> ComplexArray:
    """Give the eigenvalues in 1/s of q'' + damping q' + stiffness q = 0, ascending in their absolute value, (2 n,)."""
    n = stiffness.shape[0]
    values = eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]))
    return np.asarray(values[np.argsort(np.abs(values))], dtype=np.complex128)


def natural_frequencies(stiffness: Array, damping: Array) -> tuple[float, ...]:
    """Give the frequencies in Hz of all motions that swing, ascending."""
    values = eigenvalues(stiffness, damping)
    return tuple(sorted(float(value.imag) / (2 * pi) for value in values if value.imag > GROWTH * abs(values[-1])))


def stability(stiffness: Array, damping: Array) -> Stability:
    """Judge q'' + damping q' + stiffness q = 0, each (n, n)."""
    values = eigenvalues(stiffness, damping)
    fastest = values[np.argmax(values.real)]
    limit = GROWTH * float(np.abs(values[-1]))
    kind: StabilityKind = "stable"
    if fastest.real > limit:
        kind = "divergence" if abs(fastest.imag) < limit else "flutter"
    return Stability(kind, float(fastest.real), abs(float(fastest.imag)) / (2 * pi))


def onset(matrices: Callable[[float], tuple[Array, Array]], highest: float) -> Onset | None:
    """Find the lowest velocity at which a pipe is unstable; None up to the highest.

    Args:
        matrices: gives stiffness and damping at a velocity in m/s.
        highest: m/s.
    """
    below = 0.0
    for velocity in np.linspace(0.0, highest, SCAN + 1).tolist():
        if stability(*matrices(velocity)).kind == "stable":
            below = velocity
            continue
        above = velocity
        while above - below > 1e-6 * highest:
            middle = (above + below) / 2
            if stability(*matrices(middle)).kind == "stable":
                below = middle
            else:
                above = middle
        return Onset(above, stability(*matrices(above)).kind)
    return None


def buckling_load(omega: Array, straightening: Array) -> float | None:
    """Give the axial compression in N at which a pipe at rest buckles; None where it can move as a rigid body.

    Args:
        omega: of its modes, rad/s, (n,).
        straightening: the modal integral of w' w', 1/m, (n, n).
    """
    if omega[0] == 0.0:
        return None
    largest = float(eigh(straightening / np.outer(omega, omega), eigvals_only=True)[-1])
    return 1.0 / largest if largest > 0 else None
