"""How a record's own sampling turns a force into harmonics."""

from __future__ import annotations

from functools import cache

import numpy as np

from pipeclamp_identification.signals.harmonics import phasor_powers, solved
from pipeclamp_identification.signals.real_harmonics import as_real
from pipeclamp_identification.signals.reversals import Bridged
from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray

SERIES_ERROR = 1e-13
"""Of a power series, at its end."""


def sampled_transform(phase: Array, at_reversals: Bridged, samples: int, count: int) -> Array:
    """Give the matrix that turns a force on the grid into harmonics as a record's own sampling would show them.

    A force with a step at its reversals has harmonics far beyond those that are kept; where a record has few samples a
    cycle, always at the same phases, they fold down onto the low ones. A law must be seen through the same sampling.

    Args:
        phase: of each sample within the cycle, rad, shape (N,).
        at_reversals: the samples that were bridged in the record.
        samples: points of the grid, n.
        count: highest harmonic.

    Returns:
        shape (n, 2 count + 1), ordered as by `as_real`.
    """
    place = (phase % (2 * np.pi)) * (samples / (2 * np.pi))
    left = np.floor(place).astype(np.intp)
    off, left = place - left - 0.5, left % samples
    transform = _through_lines(left, off, samples, count)
    basis = _basis(phase[at_reversals.places.ravel()], count)
    sums = np.where(np.arange(basis.shape[1]) > 0, 2.0, 1.0) * _basis(phase[at_reversals.sample], count) / len(phase)
    # what bridging changes is linear in what the harmonics leave over, of each grid point's own samples and of the fit
    near = at_reversals.places.ravel()
    weighted = (at_reversals.weights[:, :, None] * sums).reshape(len(near), basis.shape[1])
    followed = at_reversals.change(basis.T.reshape(basis.shape[1], 3, len(near) // 3)) @ sums
    bridged = _at_rows(left[near], (0.5 - off[near])[:, None] * weighted, samples)
    bridged += _at_rows((left[near] + 1) % samples, (0.5 + off[near])[:, None] * weighted, samples)
    return np.asarray(transform + bridged - transform @ followed)


def _through_lines(left: IntArray, off: Array, samples: int, count: int) -> Array:
    """Give the transform of forces that go straight from point to point of the grid, seen by least squares.

    Between two points the harmonics are power series about the middle. So all sums over samples follow from few moments
    of where they lie there.

    Args:
        left: the grid's point before each sample, shape (N,).
        off: how far it lies behind the middle between this point and the next, as a share of their distance, (N,).
        samples: points of the grid, n.
        count: highest harmonic.

    Returns:
        shape (n, 2 count + 1), ordered as by `as_real`.
    """
    middles, factors = _series(samples, 2 * count)
    moments, power = np.empty((factors.shape[1] + 1, samples)), np.ones_like(off)
    for row in moments:
        row[:] = np.bincount(left, power, samples)
        power *= off
    sums = np.sum(factors * (middles @ moments[:-1].T), axis=1)
    from_left, from_right = (
        (middles[: count + 1] * (factors[: count + 1] @ (0.5 * moments[:-1] + sign * moments[1:]))).T
        for sign in (-1, 1)
    )
    return as_real(solved(sums[None], (from_left + np.roll(from_right, 1, axis=0))[:, None], count)[:, 0])


@cache
def _series(samples: int, highest: int) -> tuple[ComplexArray, ComplexArray]:
    """Give exp(i k theta), k = 0..highest, in the middles between points of the grid, and its power series about them.

    Returns:
        values, (highest + 1, n), and the factors by powers of the share of a step, (highest + 1, powers).
    """
    step, order = 2 * np.pi / samples, np.arange(highest + 1)
    powers, last = 1, 1.0
    while last > SERIES_ERROR:
        last *= step * highest / 2 / powers
        powers += 1
    factors = np.ones((len(order), powers), dtype=np.complex128)
    factors[:, 1:] = np.cumprod(1j * step * order[:, None] / np.arange(1, powers), axis=1)
    return np.exp(1j * step * np.outer(order, np.arange(samples) + 0.5)), factors


def _basis(phase: Array, count: int) -> Array:
    """Give what each part of the harmonics, in the transform's order, is at phases, shape (N, 2 count + 1)."""
    powers = phasor_powers(phase, count)
    return as_real(np.concatenate([np.ones((1, len(phase))), np.conj(powers)]).T)


def _at_rows(rows: IntArray, values: Array, count: int) -> Array:
    """Give the sums of values, shape (N, m), that belong to the same of so many rows, shape (count, m)."""
    width = values.shape[1]
    places = rows[:, None] * width + np.arange(width)
    sums = np.bincount(places.ravel(), values.ravel(), count * width).astype(np.float64)
    return sums.reshape(count, width)
