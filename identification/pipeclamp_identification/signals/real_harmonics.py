"""Harmonics as real numbers: F_0, Re F_1, Im F_1, Re F_2, ..., where F = Re sum F_n exp(i n theta).

With the displacement a cosine, what loading and unloading share is in the real parts (elastic), the rest in the
imaginary ones (damping).
"""

from __future__ import annotations

import numpy as np

from pipeclamp_models.base.arrays import Array, ComplexArray


def real_harmonics_of(samples: Array, count: int) -> Array:
    """Give harmonics 0..count of periodic rows as real numbers.

    Args:
        samples: shape (..., n), equally spaced over one cycle.
        count: highest harmonic.

    Returns:
        shape (..., 2 count + 1).
    """
    harmonics = np.fft.rfft(samples, axis=-1)[..., : count + 1] * (2.0 / samples.shape[-1])
    harmonics[..., 0] /= 2
    return as_real(harmonics)


def as_real(harmonics: ComplexArray) -> Array:
    """Give complex harmonics 0..H, shape (..., H + 1), as real numbers, shape (..., 2 H + 1)."""
    parts = np.empty((*harmonics.shape[:-1], 2 * harmonics.shape[-1] - 1))
    parts[..., 0] = harmonics[..., 0].real
    parts[..., 1::2] = harmonics[..., 1:].real
    parts[..., 2::2] = harmonics[..., 1:].imag
    return parts


def as_complex(parts: Array) -> ComplexArray:
    """Give harmonics as complex numbers again, shape (..., H + 1); see `as_real`."""
    harmonics = np.zeros((*parts.shape[:-1], (parts.shape[-1] + 1) // 2), dtype=np.complex128)
    harmonics[..., 0] = parts[..., 0]
    harmonics[..., 1:] = parts[..., 1::2] + 1j * parts[..., 2::2]
    return harmonics


def for_both_parts(per_harmonic: Array) -> Array:
    """Give what each of harmonics 0..H has, shape (..., H + 1), to its real and its imaginary part, (..., 2 H + 1)."""
    return np.concatenate([per_harmonic[..., :1], np.repeat(per_harmonic[..., 1:], 2, axis=-1)], axis=-1)


def elastic_and_damping(harmonics: Array) -> tuple[Array, Array]:
    """Part harmonics of a force, shape (..., m), in phase with the displacement, into what is elastic and damping."""
    elastic, damping = np.zeros_like(harmonics), np.zeros_like(harmonics)
    elastic[..., 1::2] = harmonics[..., 1::2]
    damping[..., 2::2] = harmonics[..., 2::2]
    return elastic, damping


def mean_squares_of(harmonics: Array) -> Array:
    """Give the mean square over the cycle of what has these harmonics, shape (R, m), by Parseval: shape (R,)."""
    return np.asarray(harmonics[:, 0] ** 2 + np.sum(harmonics[:, 1:] ** 2, axis=1) / 2)


def by_mean_square(harmonics: Array) -> Array:
    """Scale harmonics, shape (..., m), so that their plain sum of squares is that mean square over the cycle."""
    scaled = harmonics * np.sqrt(0.5)
    scaled[..., 0] = harmonics[..., 0]
    return np.asarray(scaled)
