"""What a balanced motion is off by because harmonics are left out."""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray
from pipeclamp_system.steady.driven import DrivenPipe
from pipeclamp_system.steady.harmonics import STILL_SHARE, left_out, packed
from pipeclamp_system.steady.tangents import NUDGE

STEEP = 100.0
"""Change of a motion over that of the frequency, both as shares, beyond which the path turns: what a motion is off by
is told along the path there, not at the frequency."""


def truncated(pipe: DrivenPipe, unknowns: Array, at: Array, drive: Array, forces: ComplexArray) -> float:
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
    H = pipe.up_to(unknowns)
    responses = pipe.responses(at, forces.shape[2] - 1)
    first = pipe.under_forces(forces, drive, responses)
    whole = first[:, : pipe.clamps].copy()
    whole[:, :, : H + 1] = pipe.unpacked(unknowns[None])
    if pipe.rubs(unknowns, float(at[0])):
        answering = pipe.rubbed(whole[0], float(at[0]), H).forces[None, :, : H + 1]
    else:
        answering = pipe.forces(whole, at)
    again = pipe.under_forces(answering, drive, responses)[:, : pipe.clamps, : H + 1]
    two = float(at[0]) * np.array([1.0, 1 + NUDGE])
    stated = pipe.excitation(float(at[0]))
    drives = (float(drive[0]) / stated if stated else 1.0) * np.array([pipe.excitation(one) for one in two.tolist()])
    residual, by_unknowns, ahead = pipe.linearised(unknowns, two, drives, pipe.responses(two, H))
    missing, size = packed(again)[0] - unknowns, pipe.sizes(unknowns[None])[0]
    change = np.linalg.lstsq(by_unknowns, missing, rcond=None)[0]
    along = np.linalg.lstsq(
        np.column_stack([by_unknowns, (ahead[0] - residual) / (NUDGE * size)]), missing, rcond=None
    )[0]
    if np.linalg.norm(change) > STEEP * np.linalg.norm(along):
        change = along[:-1]
    moved = np.abs(pipe.unpacked(change[None])[0, :, 1:]) ** 2
    squares = (np.abs(first[0, :, 1:]) ** 2).sum(axis=1)
    held = np.maximum(squares[: pipe.clamps], STILL_SHARE**2 * squares.max(initial=0.0))
    answered = float(np.sqrt((moved.sum(axis=1) / np.where(held > 0, held, 1.0)).max(initial=0.0)))
    rest = 1 - H / forces.shape[2]
    return float(max(answered / rest, left_out(first[0])[H]))


def truncated_at(pipe: DrivenPipe, unknowns: Array, frequency: float, drive: float) -> float:
    """Give what a balanced motion is off by because harmonics are left out, as a share of it.

    Args:
        unknowns: of the clamps' motion, (m,).
        frequency: Hz.
        drive: amplitude of the excitation, m/s2 or N.
    """
    if not pipe.clamps:
        return 0.0
    forces = pipe.all_forces(unknowns, frequency, rubbing=True)
    return truncated(pipe, unknowns, np.array([frequency]), np.array([drive]), forces)
