"""Springs and dashpots that act as clamps do on the motion that they make, and what a motion loses in a cycle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray

MOST_ROUNDS = 200
SETTLED_SHARE = 1e-3
"""How often springs are told anew, at most, and the change of the motion, as a share, from which on they are near
enough: whoever takes them goes on from there."""
LEAST_LOSS_FACTOR = 2e-5
"""Of steel by itself at least, without welds, supports or fluid (0.2e-4 to 3e-4: Cremer and Heckl, Structure-Borne
Sound, Springer 1988): what loses less is no pipe."""
TAKEN = 0.5
"""Share of a new stiffness that is taken in a round: a whole one goes back and forth where a clamp takes hold."""


def equivalent(
    forces: Callable[[ComplexArray, Array], ComplexArray], responses: ComplexArray, sine: complex, frequency: Array
) -> tuple[ComplexArray, ComplexArray] | None:
    """Give the motion of the fundamental, and the complex stiffness of each clamp on it.

    Args:
        forces: of the clamps, N, for motions (rows, clamps, h) in mm at frequencies (rows,).
        responses: of the clamps' motion to the excitation and to their forces, mm per unit, (clamps, inputs, h).
        sine: the excitation's fundamental.
        frequency: Hz, (1,).

    Returns:
        harmonics, mm, (clamps, h), all 0 but the fundamental; and N/mm, (clamps,). None without a motion.

    Source: Gelb and Vander Velde, Multiple-Input Describing Functions, McGraw-Hill (1968).
    """
    count = len(responses)
    free, mobility = sine * responses[:, 0, 1], responses[:, 1:, 1]
    motion = np.zeros((1, count, responses.shape[2]), dtype=np.complex128)
    motion[0, :, 1] = free
    stiffness = np.zeros(count, dtype=np.complex128)
    if not np.all(np.abs(free) > 0):
        return None
    for round_ in range(MOST_ROUNDS):
        secant = forces(motion, frequency)[0, :, 1] / motion[0, :, 1]
        stiffness = secant if round_ == 0 else (1 - TAKEN) * stiffness + TAKEN * secant
        try:
            moved = np.linalg.solve(np.eye(count) - mobility * stiffness, free)
        except np.linalg.LinAlgError:
            return None
        if not (np.all(np.isfinite(moved)) and np.all(np.abs(moved) > 0)):
            return None
        change = float(np.abs(moved - motion[0, :, 1]).max() / np.abs(moved).max())
        motion[0, :, 1] = (1 - TAKEN) * motion[0, :, 1] + TAKEN * moved
        if change < SETTLED_SHARE:
            break
    return motion[0], stiffness


def loss_factor(modal: ComplexArray, damping: Array, motion: ComplexArray, forces: ComplexArray, omega: float) -> float:
    """Give what a pipe and its clamps take up in a cycle over 2 pi times the energy that moves to and fro.

    Args:
        modal: harmonics of the modes' displacement, (m, h).
        damping: of the modes, 1/s, (m, m).
        motion: harmonics of the clamps' displacement, m, (clamps, h).
        forces: of the forces into them, N, (clamps, h).
        omega: of the fundamental, rad/s.
    """
    turn = 1j * omega * np.arange(modal.shape[1])
    speeds, of_clamps = turn * modal, turn * motion
    power = np.sum(speeds.conj() * (damping @ speeds)).real + np.sum(of_clamps.conj() * forces).real
    return float(power / max(omega * np.sum(np.abs(speeds) ** 2), 1e-300))
