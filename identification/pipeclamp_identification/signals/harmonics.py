"""Harmonics of whole cycles by least squares, exact for samples that lie anywhere in the cycle.

A sum over samples, as in a discrete Fourier transform, is exact only where a cycle holds a whole number of
equally spaced samples. Here the normal equations are solved, so that a cycle of 83.3 samples serves as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray

POINTS_PER_CYCLE, POINTS_PER_PERIOD = 160, 8
"""Points in a cycle, and in a period of the highest harmonic, with which a fit is as good as with more."""
EVEN_SHARE = 0.01
"""Neighbours are equally spaced when no spacing differs by more than this share."""
MANY_CYCLES, MANY_HARMONICS = 16, 4
"""Cycles and harmonics from which on one basis for all cycles takes less time than sums over each."""
ON_A_LINE = 1e-3
"""Samples lie on a line when none is off it by more than this share of a step, as times printed with few digits
do."""


def unit_phasor(phase: Array) -> ComplexArray:
    """Return exp(i phase) from the tangent of the half angle.

    That is one vectorised function and some arithmetic: about a third of the time of cosine and sine, to
    the same 1e-16, since 2/(1 + t^2) stays accurate where t grows without bound.

    Args:
        phase: (N,) rad.

    Returns:
        (N,) on the unit circle.
    """
    tangent = np.tan(phase / 2)
    twice_cosine_squared = 2 / (1 + tangent * tangent)
    phasor = np.empty(phase.shape, dtype=np.complex128)
    np.subtract(twice_cosine_squared, 1, out=phasor.real)
    np.multiply(tangent, twice_cosine_squared, out=phasor.imag)
    return phasor


def phasor_powers(phase: Array, count: int) -> ComplexArray:
    """Return exp(i n phase), n = 1..count, each from multiplying those that are known by the highest of them.

    Args:
        phase: (N,) rad.
        count: the highest power.

    Returns:
        (count, N).
    """
    powers = np.empty((count, len(phase)), dtype=np.complex128)
    powers[0] = unit_phasor(phase)
    known = 1
    while known < count:
        more = min(known, count - known)
        np.multiply(powers[:more], powers[known - 1], out=powers[known : known + more])
        known += more
    return powers


def carried_harmonics(phase: Array, bounds: IntArray) -> int:
    """Return how many harmonics the samples of every cycle can carry.

    Args:
        phase: (N,) rad.
        bounds: (cycles + 1,) as for `cycle_harmonics`.

    Returns:
        The highest harmonic with four samples in each of its periods, and two beside the widest gap; at least 1.
    """
    fewest = int(np.min(np.diff(bounds)))
    widest = float(np.max(np.diff(phase))) / (2 * np.pi)
    return max(1, min(fewest // 4, int(1 / (2 * widest))))


def cycle_harmonics(phase: Array, bounds: IntArray, channels: Sequence[Array], count: int) -> ComplexArray:
    """Fit x(phase) = Re sum X_n exp(i n phase), n = 0..count, to each cycle by itself.

    Where equally spaced samples are plenty, means of neighbours are fitted: the mean of exp(i n phase) over m samples
    that lie h apart is the value in their middle times sin(m n h/2)/(m sin(n h/2)), by which the result is divided.
    So all samples count, and few are worked with.

    Args:
        phase: (N,) rad.
        bounds: (cycles + 1,) cycle k holds the samples bounds[k] to bounds[k + 1] - 1; the last bound is N.
        channels: arrays (N,) to fit.
        count: the highest harmonic; every cycle needs more than 2 count + 1 samples.

    Returns:
        (channels, cycles, count + 1) complex; X_0 is real, the mean.
    """
    width = max(1, int(np.min(np.diff(bounds))) // max(POINTS_PER_CYCLE, POINTS_PER_PERIOD * count))
    step = float(phase[-1] - phase[0]) / max(len(phase) - 1, 1)
    if len(bounds) > MANY_CYCLES and count >= MANY_HARMONICS and _on_a_line(phase, step):
        begin = float(phase[0]) + (width - 1) * step / 2
        fitted = _fitted_evenly(begin, width * step, *_in_means(bounds, channels, width), count)
    elif width > 1 and np.max(np.abs(np.diff(phase) - step)) <= EVEN_SHARE * step:
        fitted = _fitted_anywhere(_means(phase, width), *_in_means(bounds, channels, width), count)
    else:
        return _fitted_anywhere(phase, bounds, channels, count)
    if width > 1:
        half_angle = np.arange(1, count + 1) * step / 2
        fitted[:, :, 1:] *= width * np.sin(half_angle) / np.sin(width * half_angle)
    return fitted


def _on_a_line(phase: Array, step: float) -> bool:
    """Tell whether no phase is off the line of this step by more than `ON_A_LINE`."""
    off = phase - (phase[0] + step * np.arange(len(phase)))
    return bool(max(np.max(off), -np.min(off)) <= ON_A_LINE * step)


def _in_means(bounds: IntArray, channels: Sequence[Array], width: int) -> tuple[IntArray, list[Array]]:
    """Return the bounds and channels of means of `width` neighbours each."""
    if width == 1:
        return bounds, list(channels)
    means = [_means(samples, width) for samples in channels]
    return np.minimum((bounds + width // 2) // width, len(means[0])), means


def _means(samples: Array, width: int) -> Array:
    """Return the means of `width` neighbours each; what is over at the end is left out."""
    whole = len(samples) // width
    return np.asarray(samples[: whole * width].reshape(whole, width) @ np.full(width, 1 / width), dtype=np.float64)


def _fitted_evenly(begin: float, step: float, bounds: IntArray, channels: Sequence[Array], count: int) -> ComplexArray:
    """Fit each cycle's harmonics to samples at the phases begin, begin + step, ...

    About the middle of a cycle its samples lie the same way as those of any other cycle with as many. So one basis
    serves them all, in which cosines and sines are orthogonal to each other; then each cycle's harmonics are turned to
    its own phase.
    """
    lengths, order = np.diff(bounds), np.arange(count + 1)
    harmonics = np.empty((len(channels), len(lengths), count + 1), dtype=np.complex128)
    for length in set(lengths.tolist()):
        alike = np.flatnonzero(lengths == length)
        powers = phasor_powers(step * (np.arange(length) - (length - 1) / 2), count)
        cosines, sines = np.concatenate([np.ones((1, length)), powers.real]), powers.imag
        samples = np.stack(channels)[:, bounds[alike, None] + np.arange(length)].reshape(-1, length).T
        found = np.zeros((count + 1, samples.shape[1]), dtype=np.complex128)
        found.real = np.linalg.solve(cosines @ cosines.T, cosines @ samples)
        found.imag[1:] = -np.linalg.solve(sines @ sines.T, sines @ samples)
        harmonics[:, alike] = found.T.reshape(len(channels), len(alike), count + 1)
    middle = begin + step * (bounds[:-1] + (lengths - 1) / 2)
    harmonics *= np.exp(-1j * np.outer(middle, order))
    return harmonics


def _fitted_anywhere(phase: Array, bounds: IntArray, channels: Sequence[Array], count: int) -> ComplexArray:
    """Fit each cycle's harmonics to samples that lie anywhere.

    The normal equations of all harmonics need only the sums of exp(i k phase), k = 0..2 count, because a product of two
    harmonics is a sum of two others.
    """
    starts = bounds[:-1]
    powers = phasor_powers(phase, 2 * count)
    sums = np.empty((len(starts), 2 * count + 1), dtype=np.complex128)
    sums[:, 0] = np.diff(np.append(starts, len(phase)))
    sums[:, 1:] = np.add.reduceat(powers, starts, axis=1).T
    moments = np.empty((len(channels), len(starts), count + 1), dtype=np.complex128)
    for c, samples in enumerate(channels):
        moments[c, :, 0] = np.add.reduceat(samples, starts)
        moments[c, :, 1:] = np.add.reduceat(samples * powers[:count], starts, axis=1).T
    return solved(sums, moments, count)


def solved(sums: ComplexArray, moments: ComplexArray, count: int) -> ComplexArray:
    """Solve the normal equations of harmonics, in the real basis 1, cos n phase, -sin n phase.

    Args:
        sums: of exp(i k phase) over each cycle's samples, k = 0..2 count, (cycles, 2 count + 1).
        moments: sums of channels times exp(i n phase), n = 0..count, (channels, cycles, count + 1).
        count: the highest harmonic.

    Returns:
        (channels, cycles, count + 1) complex, as of `cycle_harmonics`.
    """
    difference, total = _products(count)
    parts = np.concatenate([sums.real, sums.imag, -sums.real, -sums.imag], axis=1)
    gram = parts.take(difference, axis=1) + parts.take(total, axis=1)
    right = np.concatenate([moments.real, -moments.imag[:, :, 1:]], axis=2)
    solution = np.linalg.solve(gram, 2 * right.transpose(1, 2, 0)).transpose(2, 0, 1)
    harmonics = solution[:, :, : count + 1].astype(np.complex128)
    harmonics[:, :, 1:] += 1j * solution[:, :, count + 1 :]
    return harmonics


@cache
def _products(count: int) -> tuple[IntArray, IntArray]:
    """Return where the two halves of twice the product of each pair of the basis stand, (2 count + 1, 2 count + 1).

    They stand among the sums C_k of cos k phase and S_k of sin k phase, k = 0..2 count, in the order C, S, -C, -S:
    cos m cos n is half of C_|m - n| + C_(m + n), sin m sin n half of C_|m - n| - C_(m + n), and cos m times -sin n
    half of S_(m - n) - S_(m + n).
    """
    order = np.arange(count + 1)
    apart, together = order[:, None] - order, order[:, None] + order
    sine, less_cosine, less_sine = np.arange(1, 4) * (2 * count + 1)
    crossed = (np.where(apart < 0, less_sine, sine) + np.abs(apart))[:, 1:]
    difference = np.block([[np.abs(apart), crossed], [crossed.T, np.abs(apart)[1:, 1:]]])
    crossed = less_sine + together[:, 1:]
    total = np.block([[together, crossed], [crossed.T, less_cosine + together[1:, 1:]]])
    return difference, total


def evaluate(harmonics: ComplexArray, phase: Array) -> Array:
    """Return x(phase) = Re sum X_n exp(i n phase) by Horner's rule.

    Args:
        harmonics: (H + 1,).
        phase: (N,) rad.

    Returns:
        (N,) in the harmonics' unit.
    """
    unit = unit_phasor(phase)
    value = np.full(phase.shape, harmonics[-1])
    for coefficient in harmonics[-2::-1]:
        value *= unit
        value += coefficient
    return np.ascontiguousarray(value.real)
