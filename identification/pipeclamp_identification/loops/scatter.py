"""Scatter: what of a run's force and displacement is not periodic, and what of it drifts from cycle to cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

import numpy as np

from pipeclamp_identification.signals.between_cycles import between_cycles
from pipeclamp_identification.signals.harmonics import unit_phasor
from pipeclamp_models.base.arrays import Array, BoolArray, ComplexArray, IntArray

NOISE_FREEDOMS = 4.0
"""The weight, in degrees of freedom, of the noise level as a first estimate of each harmonic's own scatter: keeps five
cycles that agree by chance from weighing far too much."""
JUMP_STANDARD_DEVIATIONS = 6.0
"""Deviations beyond this many robust standard deviations are jumps of the loop itself."""
FEWEST_CYCLES_THAT_SCATTER = 3
"""Two show no scatter beside a line through them."""
PHASE_BINS = 24
"""Parts of the cycle, of equal phase, over which the scatter is told."""
DRIFT_BY_CHANCE = 1e-4
"""A harmonic drifts when scatter alone would make so steady a change from cycle to cycle less often than this."""
DRIFT_AMONG_DRIFTS_BY_CHANCE = 1e-2
"""Likewise where the runs of a campaign drift: heat and running in slow down from cycle to cycle, and few cycles of one
run don't lie on a line then."""


def drifting_force(per_cycle: ComplexArray, elapsed: Array, phase: Array, by_chance: float) -> Array | None:
    """Return the force that steadily changes from cycle to cycle, less its mean loop; None where none does.

    Args:
        per_cycle: harmonics of the force, (cycles, H + 1).
        elapsed: cycles since the first sample, (N,).
        phase: (N,) rad.
        by_chance: a harmonic drifts when scatter makes so steady a change less often than this.
    """
    drifting = np.flatnonzero(_chance_of_steady_change(per_cycle) < by_chance)
    if len(drifting) == 0:
        return None
    deviation = per_cycle - np.mean(per_cycle, axis=0)
    force = np.zeros(len(phase))
    for order in drifting:
        force += (between_cycles(deviation[:, order], elapsed) * unit_phasor(order * phase)).real
    return force


def drift_alike(force_per_cycle: Sequence[ComplexArray]) -> bool:
    """Tell whether the runs of a campaign drift: steady changes of the first harmonic in more of them than by chance.

    Args:
        force_per_cycle: harmonics of the force of each run, (cycles, H + 1).
    """
    able = [per_cycle[:, :2] for per_cycle in force_per_cycle if len(per_cycle) >= FEWEST_CYCLES_THAT_SCATTER]
    steady = sum(_chance_of_steady_change(each)[1] < DRIFT_AMONG_DRIFTS_BY_CHANCE for each in able)
    chance = [
        math.comb(len(able), count) * DRIFT_AMONG_DRIFTS_BY_CHANCE**count
        * (1 - DRIFT_AMONG_DRIFTS_BY_CHANCE) ** (len(able) - count)
        for count in range(steady, len(able) + 1)
    ]  # fmt: skip
    return sum(chance) < DRIFT_BY_CHANCE


def _chance_of_steady_change(per_cycle: ComplexArray) -> Array:
    """Return how often scatter alone makes each harmonic change as steadily from cycle to cycle, (H + 1,).

    What a line through the cycles explains is held against what it leaves over: with two freedoms for the line's slope
    and 2 (cycles - 2) for the rest, the F distribution's tail is a power.
    """
    cycles = len(per_cycle)
    if cycles < FEWEST_CYCLES_THAT_SCATTER:
        return np.ones(per_cycle.shape[1])
    along = np.arange(cycles) - (cycles - 1) / 2
    deviation = per_cycle - np.mean(per_cycle, axis=0)
    slope = along @ deviation / (along @ along)
    explained = np.abs(slope) ** 2 * (along @ along)
    rest = np.sum(np.abs(deviation - along[:, None] * slope) ** 2, axis=0)
    left = np.divide(rest, explained + rest, out=np.ones_like(rest), where=explained > 0.0)
    return np.asarray(left ** (cycles - 2))


def phase_bin(phase: Array) -> IntArray:
    """Return the part of the cycle, 0 to PHASE_BINS - 1, in which each phase in rad lies."""
    place = np.floor(phase * (PHASE_BINS / (2 * np.pi))).astype(np.intp)
    return np.asarray(place % PHASE_BINS)


def off_neighbours(at: Array, residual: Array) -> tuple[Array, BoolArray]:
    """Return what each sample but the first and last differs by from the line through its two neighbours.

    Its mean square is the noise variance, where the residual is smooth but for noise; see `noise_by_phase`.

    Args:
        at: (N,) phase in rad or time in s, ascending.
        residual: (N,) force in N.

    Returns:
        the differences in N, scaled to the noise of one sample, and whether each is one of noise and no jump; (N - 2,).
    """
    spacing = np.maximum(np.diff(at), 1e-12)
    before = spacing[1:] / (spacing[1:] + spacing[:-1])
    off = residual[1:-1] - before * residual[:-2] - (1 - before) * residual[2:]
    off /= np.sqrt(1 + before**2 + (1 - before) ** 2)
    size = np.abs(off)
    typical = float(np.median(size)) / 0.6745
    # quantised readings at one place may agree exactly more often than not
    usual = size <= JUMP_STANDARD_DEVIATIONS * typical if typical > 0.0 else np.ones(len(off), dtype=np.bool_)
    return off, usual


def noise_by_phase(phase: Array, residual: Array) -> tuple[float, Array]:
    """Return the rms of what is not periodic, and how its power spreads over the cycle, from neighbours in phase.

    Neighbours in phase come from different cycles. What a sample differs by from the line through the one before and
    the one after holds the noise of all three and next to nothing of the loop: its mean square gives the noise
    variance (Gasser, Sroka and Jennen-Steinmetz, Biometrika 1986) and needs no count of fitted parameters. A jump of
    the loop, such as friction makes at a reversal, shows in a few samples among hundreds, far beyond the others.

    Args:
        phase: (N,) rad, ascending.
        residual: (N,) force without its harmonics.
    """
    off, usual = off_neighbours(phase, residual)
    squares = off[usual] ** 2
    power = np.bincount(phase_bin(phase[1:-1][usual]), squares, PHASE_BINS)
    whole = float(np.sum(power))
    shares = power / whole if whole > 0.0 else np.full(PHASE_BINS, 1 / PHASE_BINS)
    return math.sqrt(np.mean(squares)), shares


def displacement_noise(per_cycle_harmonics: ComplexArray) -> float:
    """Return the noise level of a cycle's harmonics of displacement: most of them hold nothing else.

    Args:
        per_cycle_harmonics: (cycles, H + 1).

    Returns:
        The variance of the real part, in the harmonics' unit squared.
    """
    cycles = len(per_cycle_harmonics)
    if cycles > 1:
        spread = np.sum(np.abs(per_cycle_harmonics - np.mean(per_cycle_harmonics, axis=0)) ** 2, axis=0)
        return float(median(spread[1:].tolist())) / (2 * (cycles - 1))
    # one cycle has no scatter: the upper half of its harmonics is the best that is known of the noise
    upper = np.abs(per_cycle_harmonics[0, per_cycle_harmonics.shape[1] // 2 + 1 :]) ** 2
    return float(np.median(upper)) / 2 if len(upper) else 0.0


def harmonic_variance(per_cycle_harmonics: ComplexArray, noise: float) -> Array:
    """Return each harmonic's variance from cycle to cycle, of the real and of the imaginary part each.

    Args:
        per_cycle_harmonics: (cycles, H + 1).
        noise: the variance that noise alone gives the real part of a harmonic above 0.

    Returns:
        (H + 1,), a mean of the scatter and the noise level, weighted by their degrees of freedom.
    """
    cycles, count = per_cycle_harmonics.shape
    parts = np.where(np.arange(count) > 0, 2.0, 1.0)
    freedoms = parts * (cycles - 1)
    spread = np.sum(np.abs(per_cycle_harmonics - np.mean(per_cycle_harmonics, axis=0)) ** 2, axis=0)
    # the mean has half the variance of a harmonic's part
    return np.asarray((NOISE_FREEDOMS * noise * parts / 2 + spread) / (NOISE_FREEDOMS + freedoms))
