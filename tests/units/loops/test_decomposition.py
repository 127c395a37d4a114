"""The decomposition into elastic and damping series."""

from __future__ import annotations

import dataclasses
from collections import Counter

import numpy as np
import pytest

from pipeclamp_identification.loops.decomposition import decompose
from pipeclamp_identification.loops.loops import loops_of

ELASTIC = {1: 1800.0, 3: 900.0}
# vanishes at the reversals, so that no sample lies beside a jump
DAMPING = {0: 256.0, 2: -400.0}
GENERATOR = np.random.default_rng(8)


@pytest.fixture
def parts_of(harmonic_record, run_of, campaign_of):
    def make(elastic, damping, noise=0.0, distortion=0.0, mean=0.0):
        displacement = (mean, 0.8, 0.0, distortion * (1 + 0.5j))
        record = harmonic_record(displacement, rate=2000.0, cycles=6.0)
        theta = 2 * np.pi * 3.0 * record.time_s
        y = record.displacement_mm - mean
        direction = np.sign(-0.8 * np.sin(theta) + (3j * displacement[3] * np.exp(3j * theta)).real)
        force = sum(a * y**i for i, a in elastic.items()) + direction * sum(a * y**i for i, a in damping.items())
        force = force + noise * GENERATOR.normal(size=len(y))
        return decompose(loops_of(campaign_of(run_of(dataclasses.replace(record, force_N=force)))))[0]

    return make


@pytest.mark.parametrize("distortion", [0.0, 0.01])
def test_a_series_comes_back(parts_of, distortion):
    parts = parts_of(ELASTIC, DAMPING, noise=2.0, distortion=distortion)
    for series, truth in ((parts.elastic, ELASTIC), (parts.damping, DAMPING)):
        y = np.linspace(-0.75, 0.75, 61)
        expected = sum(a * y**i for i, a in truth.items())
        np.testing.assert_allclose(series.force(y), expected, atol=8.0)
    assert parts.misfit < 3e-3


def test_the_order_is_chosen_by_the_fit_and_not_fixed(parts_of):
    def most_often(elastic, damping, noise):
        parts = [parts_of(elastic, damping, noise) for _ in range(25)]
        return Counter((part.elastic.powers, part.damping.powers) for part in parts).most_common(1)[0][0]

    assert most_often({1: 1800.0}, {0: 256.0, 2: -400.0}, 2.0) == ((1,), (0, 2))
    assert most_often({1: 1800.0, 5: 700.0}, {0: 256.0, 4: -625.0}, 2.0) == ((1, 3, 5), (0, 2, 4))
    # what noise hides is left out
    assert most_often({1: 1800.0, 5: 7.0}, {0: 256.0, 2: -400.0}, 40.0) == ((1,), (0, 2))


def test_standard_errors_tell_the_scatter(parts_of):
    found = [parts_of({1: 1800.0, 3: 900.0}, {0: 1e-9}, noise=10.0).elastic for _ in range(40)]
    chosen = [series for series in found if series.powers == (1, 3)]
    assert len(chosen) > 20
    deviations = [(series.coefficients[1] - 900.0) / series.standard_errors[1] for series in chosen]
    assert 0.6 < np.std(deviations) < 1.5


def test_elastic_and_damping_parts_are_seen_from_the_mean(parts_of):
    parts = parts_of(ELASTIC, DAMPING, mean=0.4)
    assert parts.mean_displacement_mm == pytest.approx(0.4, abs=1e-6)
    assert parts.elastic.force(np.array([0.5]))[0] == pytest.approx(1800 * 0.5 + 900 * 0.125, rel=0.01)
