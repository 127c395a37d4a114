"""The decomposition of a loop into a single-valued elastic and a double-valued damping part, Eq. 11-13.

On the half loop with v > 0 and the one with v < 0, F = sum a_i y^i sgn(v)^(i + 1): the odd powers are the same on both
and store energy, the even ones change sign and dissipate it (Symmetry 2020, 12(8), 1283).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial, chebyshev

from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.arrays import Array, ComplexArray, IntArray

MOST_POWERS = 8
"""The most powers of each part that are tried: up to y^15 and y^14."""
NODES = 64
"""Gauss nodes on each half loop: exact far beyond the harmonics that a loop keeps."""


@dataclass(frozen=True)
class PowerSeries:
    """A sum of powers of the displacement."""

    powers: tuple[int, ...]
    coefficients: tuple[float, ...]
    """N/mm^power."""
    standard_errors: tuple[float, ...]

    def force(self, y: Array) -> Array:
        """Return sum a_i y^i.

        Args:
            y: mm, measured from the mean displacement.

        Returns:
            N, in y's shape.
        """
        dense = np.zeros(max(self.powers) + 1)
        dense[list(self.powers)] = self.coefficients
        return np.asarray(Polynomial(dense)(y), dtype=np.float64)


@dataclass(frozen=True)
class Decomposition:
    """One loop's parts: F = mean_force_N + elastic(y - mean) + sgn(v) damping(y - mean)."""

    run: str
    mean_displacement_mm: float
    mean_force_N: float
    elastic: PowerSeries
    damping: PowerSeries
    misfit: float
    """Rms of the loop's harmonics that the series leave over, as a share of those of the force."""

    @property
    def order(self) -> int:
        """Return n, the highest power."""
        return max(*self.elastic.powers, *self.damping.powers)


def decompose(loops: Loops) -> tuple[Decomposition, ...]:
    """Decompose each loop into its elastic and its damping part.

    The series are fitted to the force's harmonics, each in units of its standard error. How many powers either part has
    is chosen by the accuracy of the fit: the number that Schwarz's criterion (BIC) finds best. A misfit below the
    measured noise counts as the noise, so that powers that only follow noise don't join.

    Args:
        loops: R rows.

    Returns:
        R decompositions.
    """
    return tuple(_decompose(loops, row) for row in range(len(loops.run)))


def _decompose(loops: Loops, row: int) -> Decomposition:
    displacement, force = loops.displacement[row], loops.force[row]
    error = loops.force_standard_error[row]
    order = np.flatnonzero(np.isfinite(error[1:])) + 1
    most = min(MOST_POWERS, max(1, len(order) // 2))
    weight = np.tile(1.0 / error[order], 2)
    amplitude = float(loops.amplitude_mm[row])
    elastic, damping = (part * weight[:, None] for part in _basis(displacement, amplitude, order, most))
    target = np.concatenate([force[order].real, force[order].imag]) * weight
    elastic_count = _best_count(damping, elastic, target)
    damping_count = _best_count(elastic, damping, target)
    chosen = np.column_stack([elastic[:, :elastic_count], damping[:, :damping_count]])
    solution, covariance = _weighted_least_squares(chosen, target)
    left = (target - chosen @ solution) / weight
    cut = elastic_count
    return Decomposition(
        run=loops.run[row],
        mean_displacement_mm=float(displacement[0].real),
        mean_force_N=float(force[0].real),
        elastic=_in_powers(solution[:cut], covariance[:cut, :cut], 1, amplitude),
        damping=_in_powers(solution[cut:], covariance[cut:, cut:], 0, amplitude),
        misfit=float(np.linalg.norm(left) / np.linalg.norm(target / weight)),
    )


def _basis(displacement: ComplexArray, amplitude: float, order: IntArray, most: int) -> tuple[Array, Array]:
    """Return the harmonics of T_1, T_3, ... and of sgn(v) T_0, sgn(v) T_2, ..., T_i(y/A) Chebyshev's polynomials.

    They span the same as the powers, and stay independent of each other where high powers all look alike. Each half
    loop is integrated by itself, from one reversal to the next, so that the jumps of sgn(v) cost no accuracy.

    Returns:
        two arrays (2 harmonics, most): real parts above imaginary parts.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    top = _reversal(displacement, 0.0)
    bottom = _reversal(displacement, math.pi)
    half_down, half_up = (bottom - top) / 2, (top + 2 * math.pi - bottom) / 2
    theta = np.concatenate([top + half_down * (nodes + 1), bottom + half_up * (nodes + 1)])
    measure = np.concatenate([half_down * weights, half_up * weights])
    direction = np.repeat([-1.0, 1.0], NODES)
    all_orders = np.arange(1, len(displacement))
    y = (np.exp(1j * np.outer(theta, all_orders)) @ displacement[1:]).real / amplitude
    polynomials = chebyshev.chebvander(y, 2 * most - 1)
    transform = np.exp(-1j * np.outer(order, theta)) * measure / np.pi
    parts = (transform @ polynomials[:, 1::2], transform @ (polynomials[:, ::2] * direction[:, None]))
    elastic, damping = (np.concatenate([part.real, part.imag]) for part in parts)
    return elastic, damping


def _reversal(displacement: ComplexArray, phase: float) -> float:
    """Return the phase near `phase` at which the velocity changes sign, by Newton's method."""
    order = np.arange(len(displacement))
    for _ in range(8):
        terms = displacement * np.exp(1j * order * phase)
        slope, curvature = (1j * order @ terms).real, -(order**2 @ terms).real
        # a drive so distorted that it hesitates there has no better reversal than the fundamental's
        phase -= float(np.clip(slope / curvature, -0.1, 0.1)) if curvature != 0.0 else 0.0
    return phase


def _best_count(others: Array, family: Array, target: Array) -> int:
    """Return how many columns of `family` to keep, all `others` being there, by Schwarz's criterion."""
    data, most = family.shape
    orthogonal = np.linalg.qr(np.column_stack([others, family]))[0]
    explained = (orthogonal.T @ target) ** 2
    # what the first k columns of the family leave over, k = 1..most
    left = target @ target - np.sum(explained[: others.shape[1]]) - np.cumsum(explained[others.shape[1] :])
    columns = others.shape[1] + np.arange(1, most + 1)
    criterion = data * np.log(np.maximum(left / data, 1.0)) + columns * np.log(data)
    return int(np.argmin(criterion)) + 1


def _weighted_least_squares(columns: Array, target: Array) -> tuple[Array, Array]:
    orthogonal, triangle = np.linalg.qr(columns)
    solution = np.linalg.solve(triangle, orthogonal.T @ target)
    inverse = np.linalg.inv(triangle)
    left = target - columns @ solution
    # a misfit beyond the noise makes the coefficients as uncertain as it is large
    inflation = max(1.0, float(left @ left) / max(len(target) - len(solution), 1))
    return np.asarray(solution), inflation * inverse @ inverse.T


def _in_powers(chebyshev_part: Array, covariance: Array, lowest: int, amplitude: float) -> PowerSeries:
    """Turn coefficients of T_i(y/A), i = lowest, lowest + 2, ..., into those of y^i, with their standard errors."""
    powers = lowest + 2 * np.arange(len(chebyshev_part))
    unit = np.eye(powers[-1] + 1)
    rows = [chebyshev.cheb2poly(unit[i]) for i in powers]
    conversion = np.array([np.pad(row, (0, powers[-1] + 1 - len(row))) for row in rows])[:, powers]
    scale = amplitude ** -powers.astype(np.float64)
    variances = np.diag(conversion.T @ covariance @ conversion)
    return PowerSeries(
        powers=tuple(int(power) for power in powers),
        coefficients=tuple(float(a) for a in scale * (chebyshev_part @ conversion)),
        standard_errors=tuple(float(a) for a in scale * np.sqrt(variances)),
    )
