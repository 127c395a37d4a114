"""Harmonics of the clamps' motion as unknowns, and how many of them a motion asks for.

What is left out beyond H is known to first order: the force of the motion has higher harmonics too, and the pipe's
frequency response gives what they would move. Where that is too much, more harmonics are balanced; where they move next
to nothing, fewer.
"""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray

SMALLEST_MOTION_MM = 1e-6
"""mm: no motion is taken for smaller."""

FEWEST_HARMONICS = 3
"""Harmonics that are balanced at least, unless told."""

A_HARMONIC = 4
"""Samples of a cycle that its highest balanced harmonic needs."""

TRUNCATED = 1e-3
"""Share of a motion's rms that the harmonics which are left out may have."""

DOUBTFUL_SHARE = 0.01
"""Share from which on a response isn't to be trusted."""

SPARE = 0.5
"""Of that share, which is left when harmonics are added: the next states need no more at once."""

NEEDLESS = 0.25
"""Of that share: harmonics that have less are left out again."""

STILL_SHARE = 1e-3
"""A point that moves less than this share of the farthest moving one is held against that."""


def unpacked(unknowns: Array, clamps: int) -> ComplexArray:
    """Give harmonics (rows, clamps, H + 1) of unknowns (rows, clamps (2 H + 1))."""
    parts = unknowns.reshape(len(unknowns), clamps, -1)
    H = (parts.shape[2] - 1) // 2
    return np.concatenate([parts[:, :, :1] + 0j, parts[:, :, 1 : H + 1] + 1j * parts[:, :, H + 1 :]], axis=2)


def packed(harmonics: ComplexArray) -> Array:
    """Give unknowns (rows, m) of harmonics (rows, clamps, H + 1)."""
    parts = [harmonics[:, :, :1].real, harmonics[:, :, 1:].real, harmonics[:, :, 1:].imag]
    return np.concatenate(parts, axis=2).reshape(len(harmonics), -1)


def resized(harmonics: ComplexArray, count: int) -> ComplexArray:
    """Give the first `count` harmonics, from 0, of the last axis; those that aren't there are 0."""
    kept = min(count, harmonics.shape[-1])
    found = np.zeros((*harmonics.shape[:-1], count), dtype=harmonics.dtype)  # np.pad takes ten times as long for so few
    found[..., :kept] = harmonics[..., :kept]
    return found


def left_out(moved: ComplexArray) -> Array:
    """Give what motions (points, h) lose when harmonics are left out.

    Returns:
        for each H the rms of what is beyond it as a share of the motion's, of the point that loses most, (h,).
    """
    squares = np.abs(moved[:, 1:]) ** 2
    whole = squares.sum(axis=1)
    whole = np.maximum(whole, STILL_SHARE**2 * whole.max(initial=0.0))
    beyond = np.cumsum(squares[:, ::-1], axis=1)[:, ::-1]
    shares = np.sqrt(beyond / np.where(whole > 0, whole, 1.0)[:, None]).max(axis=0, initial=0.0)
    return np.append(shares, 0.0)


def wanted(shares: Array, now: int, most: int) -> int:
    """Give the H that a motion asks for.

    Args:
        shares: of the motion that are left out, by H, as of `left_out`.
        now: H so far.
        most: largest H.
    """
    if shares[now] > TRUNCATED:
        enough = int(np.argmax(shares <= SPARE * TRUNCATED))
        return min(most, max(enough, now + 2))
    fewer = max(FEWEST_HARMONICS, int(np.argmax(shares <= NEEDLESS * TRUNCATED)))
    return fewer if fewer < now - 1 else now
