"""Steady states at many frequencies and levels at once: Newton's method on all of them together.

What costs time is the clamps' force, and evaluating it for a hundred rows costs little more than for one. The
derivatives are kept from one correction to the next, and from one system to a neighbouring one, as long as they serve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_models.base.arrays import Array, BoolArray, ComplexArray, IntArray
from pipeclamp_system.steady.driven import DrivenPipe
from pipeclamp_system.steady.tangents import NUDGE

MOST_CORRECTIONS = 40
MOTION_TOLERANCE = 1e-7
"""Of the motion: a derivative by differences of 1e-3 is then good to 1e-4."""
SERVES = 0.25
"""Derivatives serve while each correction is smaller than this share of the one before."""


@dataclass(frozen=True, eq=False)
class Operation:
    """Sines that a system is under.

    Attributes:
        frequency: Hz, (P,).
        drive: amplitude of the excitation, m/s2 or N, (P,).
    """

    frequency: Array
    drive: Array

    def rows(self, chosen: IntArray) -> Operation:
        """Give some of the sines."""
        return Operation(self.frequency[chosen], self.drive[chosen])


@dataclass(frozen=True, eq=False)
class Balanced:
    """Steady states.

    Attributes:
        unknowns: of the clamps' motion, mm, (P, m).
        slopes: derivatives of the residual near there, (P, m, m).
        found: whether the motion is balanced, (P,).
        responses: of the pipe at the sines, as of `DrivenPipe`.
        forces: harmonics of the clamps' forces on their motion, N, (P, clamps, H + 1).
    """

    unknowns: Array
    slopes: Array
    found: BoolArray
    responses: ComplexArray
    forces: ComplexArray


def balance(system: DrivenPipe, operation: Operation, guess: Array, slopes: Array | None = None) -> Balanced:
    """Balance the clamps' motion from a guess.

    Args:
        system: pipe and clamps.
        operation: the sines, P of them.
        guess: unknowns, mm, (P, m).
        slopes: derivatives of the residual that may still serve, (P, m, m).
    """
    unknowns = guess.copy()
    count, size = guess.shape
    responses = system.responses(operation.frequency)
    found = np.full(count, size == 0)
    kept = np.zeros((count, size, size)) if slopes is None else slopes.copy()
    stale = np.full(count, slopes is None)
    last = np.full(count, np.inf)
    for _ in range(MOST_CORRECTIONS if size else 0):
        fresh = np.flatnonzero(stale & ~found)
        if fresh.size:
            kept[fresh] = _slopes(system, operation.rows(fresh), unknowns[fresh], responses[fresh])
            stale[fresh], last[fresh] = False, np.inf
        open_rows = np.flatnonzero(~found)
        at = operation.rows(open_rows)
        residual = system.residuals(unknowns[open_rows], at.frequency, at.drive, responses[open_rows])
        change = -_solved(kept[open_rows], residual)
        moved = np.abs(change).max(axis=1) / system.sizes(unknowns[open_rows])
        # A first correction that is larger than the motion goes too far.
        change *= np.minimum(1.0, 1.0 / np.maximum(moved, 1e-300))[:, None]
        unknowns[open_rows] += change
        stale[open_rows] = moved > SERVES * last[open_rows]
        last[open_rows] = moved
        found[open_rows] = moved <= MOTION_TOLERANCE
        if not np.all(np.isfinite(unknowns)) or found.all():
            break
    forces = system.forces(system.unpacked(unknowns), operation.frequency)
    return Balanced(unknowns, kept, found & np.all(np.isfinite(unknowns), axis=1), responses, forces)


def _solved(slopes: Array, residual: Array) -> Array:
    """Solve each row's linear equations; a singular row becomes nan."""
    try:
        return np.asarray(np.linalg.solve(slopes, residual[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        singular = np.abs(np.linalg.det(slopes)) == 0.0
        solved = np.full(residual.shape, np.nan)
        solved[~singular] = np.linalg.solve(slopes[~singular], residual[~singular][:, :, None])[:, :, 0]
        return solved


def _slopes(system: DrivenPipe, operation: Operation, unknowns: Array, responses: ComplexArray) -> Array:
    """Give the derivatives of the residual by the unknowns, (P, m, m)."""
    count, size = unknowns.shape
    nudge = NUDGE * system.sizes(unknowns)
    moved = unknowns[:, None, :] + nudge[:, None, None] * np.vstack([np.zeros(size), np.eye(size)])
    which = np.repeat(np.arange(count), size + 1)
    residuals = system.residuals(
        moved.reshape(-1, size), operation.frequency[which], operation.drive[which], responses[which]
    ).reshape(count, size + 1, size)
    return np.asarray(np.swapaxes((residuals[:, 1:] - residuals[:, :1]) / nudge[:, None, None], 1, 2))


def fundamentals(system: DrivenPipe, operation: Operation, balanced: Balanced) -> ComplexArray:
    """Give the fundamentals of all clamps and probes over that of the excitation, m per m/s2 or N, (P, points).

    The excitation is drive sin(2 pi f t); nan where no steady state was found.
    """
    moved = system.under_forces(balanced.forces, operation.drive, balanced.responses)[:, :, 1]
    ratio = 1e-3 * moved / (-1j * operation.drive[:, None])
    return np.where(balanced.found[:, None], ratio, np.nan)
