"""What a law's file tells of the scatter of its tests: tests of known scatter, and of a known lack of the law."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from pipeclamp_identification.fitting.identify import identify
from pipeclamp_identification.fitting.spread import spread_of
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure
from pipeclamp_models.law.local_form import Kriged

LEVELS = tuple(itertools.product((0.2, 0.4, 0.7, 1.0), (1.0, 3.0, 6.0, 10.0), (20.0, 100.0, 180.0)))


@pytest.fixture
def spread(harmonic_record, run_of, campaign_of):
    """Give the spread of tests whose stiffness and damping scatter by shares, beside a lack that bends with A."""

    def of(stiffness, damping, lack=0.0):
        random = np.random.default_rng(3)
        runs = []
        for number, (A, f, celsius) in enumerate(LEVELS):
            off_k, off_c = 1 + stiffness * random.standard_normal(), 1 + damping * random.standard_normal()
            bent = 1 + lack * np.sin(9 * np.log(A))
            force = off_k * 1500 * A + 1j * off_c * bent * 40 * (2 * np.pi * f * A) ** 0.3
            made = harmonic_record((0.0, A), (0.0, force), frequency=f, rate=100 * f, cycles=3.0)
            noise = 0.5 * random.standard_normal(len(made.force_N))
            made = type(made)(made.time_s, made.displacement_mm, made.force_N + noise)
            settings = {"amplitude_mm": A, "frequency_Hz": f, "temperature_C": celsius}
            runs.append(run_of(made, str(number), **settings))
        tests = campaign_of(*runs)
        found = identify(tests)
        assert len(loops_of(tests).run) == len(LEVELS)
        return spread_of(found.fit, found.loops, found.observations)

    return of


def test_scatter_between_runs_comes_back(spread):
    found = spread(0.01, 0.03)
    assert found.runs.stiffness == pytest.approx(0.01, rel=0.35)
    assert found.runs.damping == pytest.approx(0.03, rel=0.35)
    assert found.form.stiffness < 0.006
    assert found.form.damping < 0.018


def test_what_a_law_has_no_form_for_is_told_apart(spread):
    found = spread(0.0, 0.0, lack=0.2)
    assert found.form.stiffness < 0.003
    assert 0.03 < found.form.damping < 0.2
    assert found.runs.damping < found.form.damping
    assert found.beyond["A"].error.damping >= found.form.damping
    assert found.beyond["A"].step == pytest.approx(np.hypot(np.log(2), np.log(1 / 0.7)) / np.sqrt(2), rel=1e-2)


def test_a_lack_that_follows_the_conditions_is_foretold_between_the_tests(spread):
    """It bends with A: between the levels that were tested it is known better than as likely up as down."""
    found = spread(0.0, 0.003, lack=0.2)
    off = []
    for A in (0.25, 0.3, 0.5, 0.6, 0.85):
        mean, left = Kriged.of(found.local, found.local.damping).at({"A": A, "f": 4.0, "T": 373.15})
        assert left < found.local.damping.deviation
        off.append((mean, left))
    assert np.ptp([mean for mean, _ in off]) > found.form.damping


def test_a_law_that_ages_knows_the_runs_of_its_stretches(harmonic_record, run_of, campaign_of):
    """Stretches of one run are off alike: as runs of their own they had made what scatters between runs look small."""
    random = np.random.default_rng(8)
    runs = []
    for number, (A, f) in enumerate(itertools.product((0.2, 0.5, 1.0), (1.0, 2.0, 4.0))):
        force = (1 + 0.02 * random.standard_normal()) * 1500 * A + 40j * (2 * np.pi * f * A) ** 0.3
        made = harmonic_record((0.0, A), (0.0, force), frequency=f, rate=100 * f, cycles=6.0)
        noise = 0.5 * random.standard_normal(len(made.force_N))
        record = type(made)(made.time_s, made.displacement_mm, made.force_N + noise)
        runs.append(run_of(record, f"r{number}", temperature_C=20.0, first_cycle=8.0 * number))
    tests = campaign_of(*runs)
    found = identify(tests, Structure("power", ("loosening",)))
    aged = spread_of(found.fit, found.loops, found.observations)
    plain = identify(tests)
    whole = spread_of(plain.fit, plain.loops, plain.observations)
    assert len(found.fit.law_force.force) == 3 * len(runs)
    assert len(aged.local.stiffness.shares) == len(runs)
    assert aged.runs.stiffness == pytest.approx(whole.runs.stiffness, rel=0.5)
    assert found.fit.standard_errors()["k10"] > 0.8 * plain.fit.standard_errors()["k10"]
