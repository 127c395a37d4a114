"""What must hold for the loops of any record."""

from __future__ import annotations

import dataclasses

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.loops.metrics import metrics_of

F = np.array([-30.0, 1500.0 + 300.0j, 10.0 + 5.0j, 80.0 + 60.0j, 0.0, -10.0 + 40.0j])

phases = st.floats(0.0, 2 * np.pi)
frequencies = st.floats(0.1, 40.0)
cycles = st.floats(2.02, 12.0)
samples_per_cycle = st.floats(60.0, 900.0)
seeds = st.integers(0, 2**32 - 1)

# a record's arithmetic takes milliseconds, but a first call may load libraries
relaxed = settings(deadline=None, max_examples=60)


@relaxed
@given(phase=phases, f=frequencies, held=cycles, samples=samples_per_cycle)
def test_a_record_may_start_anywhere_and_end_mid_cycle(harmonic_record, run_of, campaign_of, phase, f, held, samples):
    record = harmonic_record((0.1, 0.8, 0.004j), F, f, f * samples, held, phase, start=17.0)
    run = run_of(record)
    loops = loops_of(campaign_of(run))
    assert run.cycles.count in (int(held), int(held + 0.05))
    np.testing.assert_allclose(loops.frequency_Hz, f, rtol=1e-6)
    np.testing.assert_allclose(loops.force[0, :6], F, atol=1e-5 * 1500)


@relaxed
@given(phase=phases, held=cycles, samples=samples_per_cycle, seed=seeds)
def test_noise_moves_harmonics_by_their_standard_error(
    harmonic_record, run_of, campaign_of, phase, held, samples, seed
):
    record = harmonic_record((0.0, 0.8), F, 3.0, 3.0 * samples, held, phase)
    generator = np.random.default_rng(seed)
    size = len(record.time_s)
    noisy = dataclasses.replace(
        record,
        force_N=record.force_N + 8.0 * generator.normal(size=size),
        displacement_mm=record.displacement_mm + 4e-4 * generator.normal(size=size),
    )
    loops = loops_of(campaign_of(run_of(noisy)))
    # the displacement's noise turns the loop by its share of the fundamental's phase error
    turned = 4e-4 / 0.8 * np.sqrt(2 / samples / int(held)) * np.arange(6) * np.abs(F)
    # beyond any search for unlucky noise
    allowed = 10 * np.hypot(loops.force_standard_error[0, :6], turned)
    assert np.all(np.abs(loops.force[0, :6] - F) < allowed)


@relaxed
@given(seed=seeds, share=st.floats(0.0, 0.03))
def test_cycles_may_be_unequal(harmonic_record, run_of, campaign_of, seed, share):
    record = harmonic_record((0.0, 0.8), F, 3.0, 1200.0, 8.0)
    wander = share * np.sin(2 * np.pi * 0.4 * record.time_s + seed)
    theta = 2 * np.pi * 3.0 * record.time_s + wander
    harmonics = np.exp(1j * np.outer(theta, np.arange(6)))
    wandering = Record(record.time_s, 0.8 * np.cos(theta), (harmonics @ F).real)
    loops = loops_of(campaign_of(run_of(wandering)))
    # each cycle is measured against its own phase
    assert np.all(np.abs(loops.force[0, :6] - F) < 1e-3 * 1500 + 0.02 * share * 1500)


@relaxed
@given(factor=st.floats(1e-3, 1e4), seed=seeds)
def test_metrics_scale_with_the_force(harmonic_record, run_of, campaign_of, factor, seed):
    record = harmonic_record((0.0, 0.8), F, phase=seed % 7)
    noisy = record.force_N + np.random.default_rng(seed).normal(size=len(record.time_s))
    plain, scaled = (
        metrics_of(loops_of(campaign_of(run_of(dataclasses.replace(record, force_N=k * noisy))))) for k in (1.0, factor)
    )
    np.testing.assert_allclose(scaled.dissipated_energy_J, factor * plain.dissipated_energy_J, rtol=1e-9)
    np.testing.assert_allclose(scaled.stiffness_N_mm, factor * plain.stiffness_N_mm, rtol=1e-9)
    np.testing.assert_allclose(scaled.loss_factor, plain.loss_factor, rtol=1e-9)


@relaxed
@given(phase=phases, f=frequencies)
def test_velocity_lags_nothing_behind_the_force(harmonic_record, run_of, campaign_of, phase, f):
    # a pure damper's dissipation would fall with the cosine of any delay
    harmonics = (0.0, 2j * np.pi * f * 0.8 * 5.0)
    loops = loops_of(campaign_of(run_of(harmonic_record((0.0, 0.8), harmonics, f, 200.0 * f, 4.3, phase))))
    expected = np.pi * 5.0 * 2 * np.pi * f * 0.8**2 / 1e3
    np.testing.assert_allclose(metrics_of(loops).dissipated_energy_J, expected, rtol=1e-6)
