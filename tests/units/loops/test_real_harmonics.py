"""Harmonics as real numbers: against the samples that have them."""

import numpy as np
import pytest

from pipeclamp_identification.signals.real_harmonics import (
    as_complex,
    as_real,
    by_mean_square,
    elastic_and_damping,
    mean_squares_of,
    real_harmonics_of,
)

PHASE = 2 * np.pi * np.arange(64) / 64
ELASTIC = 3.0 * np.cos(PHASE) + 0.5 * np.cos(3 * PHASE)
DAMPING = -2.0 * np.sin(PHASE) + 0.25 * np.sin(2 * PHASE)
FORCE = (ELASTIC + DAMPING + 7.0)[None]


def test_parts_of_a_force_are_those_that_make_it():
    """F = Re sum F_n exp(i n theta): a cosine is a real part, a sine an imaginary part of the opposite sign."""
    found = real_harmonics_of(FORCE, 3)
    assert found == pytest.approx(np.array([[7.0, 3.0, 2.0, 0.0, -0.25, 0.5, 0.0]]), abs=1e-12)
    assert as_real(as_complex(found)) == pytest.approx(found, abs=0)


def test_what_is_elastic_and_what_is_damping_make_the_force_but_for_its_mean():
    both = elastic_and_damping(real_harmonics_of(FORCE, 3))
    for part, samples in zip(both, (ELASTIC, DAMPING), strict=True):
        assert part == pytest.approx(real_harmonics_of(samples[None], 3), abs=1e-12)


def test_the_mean_square_is_that_of_the_samples():
    found = real_harmonics_of(FORCE, 3)
    assert mean_squares_of(found) == pytest.approx(np.mean(FORCE**2, axis=1))
    assert np.sum(by_mean_square(found) ** 2, axis=1) == pytest.approx(np.mean(FORCE**2, axis=1))
