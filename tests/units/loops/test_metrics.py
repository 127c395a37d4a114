"""Loop metrics against closed forms, and what `metrics --json` holds."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

from pipeclamp_identification.loops.answer import metrics_answer
from pipeclamp_identification.loops.loops import loops_of, per_cycle
from pipeclamp_identification.loops.metrics import metrics_of, scatter_of

A, f = 0.8, 3.0
OMEGA = 2 * math.pi * f


@pytest.fixture
def loops_with(harmonic_record, run_of, campaign_of):
    """Give the loops of a force law F(y, v) on a sinusoid."""

    def make(law, **options):
        record = harmonic_record(displacement=(0.0, A), frequency=f, rate=3000.0, **options)
        theta = OMEGA * record.time_s + options.get("phase", 0.0)
        force = law(A * np.cos(theta), -A * OMEGA * np.sin(theta))
        return loops_of(campaign_of(run_of(dataclasses.replace(record, force_N=force))))

    return make


def test_a_viscous_damper_dissipates_pi_times_c_omega_and_amplitude_squared(loops_with):
    metrics = metrics_of(loops_with(lambda y, v: 12.0 * v))
    assert metrics.dissipated_energy_J[0] == pytest.approx(math.pi * 12.0 * OMEGA * A**2 / 1e3, rel=1e-6)


def test_friction_dissipates_four_times_force_times_amplitude(loops_with):
    metrics = metrics_of(loops_with(lambda y, v: 1500.0 * y + 300.0 * np.sign(v), phase=0.3))
    assert metrics.dissipated_energy_J[0] == pytest.approx(4 * 300.0 * A / 1e3, rel=2e-3)


def test_a_spring_stores_half_of_k_amplitude_squared(loops_with):
    metrics = metrics_of(loops_with(lambda y, v: 1500.0 * y))
    assert metrics.max_elastic_energy_J[0] == pytest.approx(1500.0 * A**2 / 2 / 1e3, rel=1e-6)
    assert metrics.stiffness_N_mm[0] == pytest.approx(1500.0, rel=1e-6)
    assert metrics.loss_factor[0] == pytest.approx(0.0, abs=1e-6)


def test_the_loss_factor_is_that_of_a_complex_stiffness(loops_with):
    k, eta = 2000.0, 0.25
    metrics = metrics_of(loops_with(lambda y, v: k * y + k * eta * v / OMEGA))
    # W holds the loop's largest force, which is k A sqrt(1 + eta^2)
    assert metrics.loss_factor[0] == pytest.approx(eta / math.sqrt(1 + eta**2), rel=1e-4)


def test_a_mean_force_changes_neither_energy_nor_stiffness(loops_with):
    plain, offset = (metrics_of(loops_with(lambda y, v, F0=F0: F0 + 900.0 * y + 5.0 * v)) for F0 in (0.0, 700.0))
    for name in ("dissipated_energy_J", "max_elastic_energy_J", "stiffness_N_mm"):
        assert getattr(offset, name)[0] == pytest.approx(getattr(plain, name)[0], rel=1e-6)
    assert offset.force_max_N[0] - plain.force_max_N[0] == pytest.approx(700.0, rel=1e-6)


def test_the_extremes_do_not_grow_with_noise(loops_with):
    generator = np.random.default_rng(2)
    noisy = metrics_of(loops_with(lambda y, v: 1500.0 * y + 20.0 * generator.normal(size=len(y)), cycles=20.0))
    # the largest of 10000 samples lies some 70 N above the loop
    assert noisy.force_max_N[0] == pytest.approx(1200.0, abs=10.0)


def test_a_distorted_drive_changes_the_area_as_it_must(harmonic_record, run_of, campaign_of):
    record = harmonic_record(displacement=(0.0, A, 0.0, 0.04 - 0.03j), frequency=f, rate=3000.0)
    velocity = np.gradient(record.displacement_mm, record.time_s, edge_order=2)
    record = dataclasses.replace(record, force_N=12.0 * velocity)
    metrics = metrics_of(loops_of(campaign_of(run_of(record))))
    # each harmonic of y dissipates pi c n^2 omega |Y_n|^2
    area = math.pi * 12.0 * OMEGA * (A**2 + 9 * 0.05**2) / 1e3
    assert metrics.dissipated_energy_J[0] == pytest.approx(area, rel=1e-4)


def test_scatter_is_that_of_the_cycles(loops_with):
    generator = np.random.default_rng(4)
    loops = loops_with(lambda y, v: 1500.0 * y + 5.0 * v + 20.0 * generator.normal(size=len(y)), cycles=40.0)
    scatter, single = scatter_of(loops), metrics_of(per_cycle(loops))
    assert scatter.dissipated_energy_J[0] == pytest.approx(np.std(single.dissipated_energy_J, ddof=1))
    # dW = pi A Im F_1, and Im F_1 scatters by sigma sqrt(2/N)
    assert scatter.dissipated_energy_J[0] == pytest.approx(math.pi * A * 20.0 * math.sqrt(2 / 1000) / 1e3, rel=0.3)


def test_one_cycle_has_no_scatter(loops_with):
    assert math.isnan(scatter_of(loops_with(lambda y, v: 1500.0 * y, cycles=1.0)).loss_factor[0])


def test_the_json_has_the_contracts_fields_and_plain_values(harmonic_record, run_of, campaign_of):
    runs = [
        run_of(harmonic_record(rate=100.0, cycles=1.2), "short", specimen="S1", conditions={"current_A": math.nan}),
        run_of(harmonic_record(), "long", specimen="S1", temperature_C=20.0, conditions={"current_A": 0.5}),
    ]
    campaign = campaign_of(*runs)
    answer = json.loads(metrics_answer(campaign, loops_of(campaign)).json_text())
    short, long = answer["runs"]
    needed = ("dissipated_energy_J", "max_elastic_energy_J", "loss_factor", "stiffness_N_mm", "amplitude_mm")
    for run in (short, long):
        assert all(isinstance(run[name], float) for name in (*needed, "frequency_Hz"))
    assert (short["run"], long["run"]) == ("short", "long")
    assert short["temperature_C"] is None
    assert short["current_A"] is None
    assert long["temperature_C"] == pytest.approx(20.0)
    assert long["cycles"] == len(long["per_cycle"]["loss_factor"]) == 5
    assert long["decomposition"]["elastic"][0]["power"] == 1
