"""Cycles and loops: exact on records of known harmonics, right about noise, ramps and partial cycles."""

from __future__ import annotations

import dataclasses
import math
import warnings

import numpy as np
import pytest
from scipy import stats

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.drive import DrivePlan, Profile
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import by_stretch, displacement_on_grid, loops_of, on_grid, per_cycle
from pipeclamp_identification.loops.scatter import drift_alike
from pipeclamp_identification.signals.harmonics import cycle_harmonics

Y = np.array([0.03, 0.8, 0.004 + 0.001j, -0.006j, 0.0, 0.002])
F = np.array([-12.0, 2000.0 + 400.0j, 8.0 - 3.0j, 60.0 + 90.0j, 0.5j, 20.0 + 30.0j, 0.0, 9.0j])


@pytest.fixture
def loops_from(run_of, campaign_of):
    return lambda record, **conditions: loops_of(campaign_of(run_of(record, **conditions)))


@pytest.mark.parametrize("cycles", [2.0, 2.7, 5.0, 9.31])
@pytest.mark.parametrize("samples", [83.3, 500.0, 2481.7])
@pytest.mark.parametrize("phase", [0.0, 2.0, 5.5])
def test_harmonics_are_exact_without_noise(harmonic_record, loops_from, cycles, samples, phase):
    loops = loops_from(harmonic_record(Y, F, 1.7, 1.7 * samples, cycles, phase))
    assert loops.frequency_Hz[0] == pytest.approx(1.7, rel=1e-6)
    np.testing.assert_allclose(loops.displacement[0, :6], Y, atol=1e-6 * 0.8)
    np.testing.assert_allclose(loops.force[0, :8], F, atol=1e-6 * 2000)
    assert loops.noise_rms_N[0] < 1e-3


@pytest.mark.parametrize("jitter", [0.0, 0.2])
@pytest.mark.parametrize("samples", [50.31, 481.7])
def test_each_of_many_cycles_has_its_own_harmonics(samples, jitter):
    step = 2 * np.pi / samples
    late = np.random.default_rng(3).uniform(-jitter, jitter, round(40 * samples))
    phase = 0.4 + step * (np.arange(len(late)) + late)
    bounds = np.searchsorted(phase - 0.4, 2 * np.pi * np.arange(40) - step / 2)
    cycle = np.searchsorted(bounds, np.arange(bounds[-1]), side="right") - 1
    harmonics = (1 + 0.1 * cycle[:, None]) * F
    x = np.sum((harmonics * np.exp(1j * np.outer(phase[: bounds[-1]], np.arange(len(F))))).real, axis=1)
    found = cycle_harmonics(phase[: bounds[-1]], bounds, [x, -2 * x], len(F) - 1)
    expected = (1 + 0.1 * np.arange(39))[:, None] * F
    # means of neighbours reach over the edges of cycles, which differ by a tenth here
    tolerance = 1e-9 if samples < 100 or jitter else 0.02
    np.testing.assert_allclose(found, [expected, -2 * expected], atol=tolerance * 2000)


def test_one_cycle_alone_serves(harmonic_record, loops_from):
    loops = loops_from(harmonic_record(force=F, cycles=1.0))
    np.testing.assert_allclose(loops.force[0, :8], F, atol=1e-3 * 2000)
    assert np.all(np.isfinite(loops.force_standard_error))


def test_mean_force_and_mean_displacement_are_kept(harmonic_record, loops_from):
    loops = loops_from(harmonic_record(Y, F))
    assert loops.displacement[0, 0] == pytest.approx(0.03, abs=1e-6)
    assert loops.force[0, 0] == pytest.approx(-12.0, abs=1e-3)


def test_velocity_and_acceleration_are_those_of_the_harmonics(harmonic_record, loops_from):
    loops = loops_from(harmonic_record(Y, F, frequency=2.0))
    y, v, a = displacement_on_grid(loops, 360)
    theta = np.radians(np.arange(360))
    order = np.arange(len(Y))
    turning = np.exp(1j * np.outer(theta, order))
    np.testing.assert_allclose(y[0], (turning @ Y).real, atol=1e-6)
    np.testing.assert_allclose(v[0], (turning @ (4j * np.pi * order * Y)).real, atol=1e-4)
    np.testing.assert_allclose(a[0], (turning @ (-((4 * np.pi * order) ** 2) * Y)).real, atol=1e-2)


def test_noise_and_standard_errors_are_those_of_the_sensor(harmonic_record, run_of, campaign_of):
    sigma, runs = 7.0, []
    generator = np.random.default_rng(3)
    for number in range(40):
        record = harmonic_record(force=F, rate=480.0, phase=0.1 * number, cycles=5.2)
        noisy = record.force_N + sigma * generator.normal(size=len(record.time_s))
        runs.append(run_of(dataclasses.replace(record, force_N=noisy), f"run{number}"))
    loops = loops_of(campaign_of(*runs))
    assert np.median(loops.noise_rms_N) == pytest.approx(sigma, rel=0.02)
    assert loops.noise_nrmse == pytest.approx(sigma / np.sqrt(np.mean(loops.force_rms_N**2)), rel=0.02)
    expected = sigma * math.sqrt(2 / 800)
    assert np.median(loops.force_standard_error[:, 1:]) == pytest.approx(expected, rel=0.1)
    # no run of five cycles gets a weight that is off by more than a factor of two
    assert np.all(np.abs(np.log2(loops.force_standard_error[:, 1:] / expected)) < 1)
    deviation = (loops.force - np.pad(F, (0, 13))) / loops.force_standard_error
    assert np.std(deviation[:, 1:].real) == pytest.approx(1.0, abs=0.15)
    assert np.std(deviation[:, 1:].imag) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("rate", [300.0, 307.3])
def test_friction_is_not_taken_for_noise(harmonic_record, loops_from, rate):
    record = harmonic_record(rate=rate)
    velocity = np.cos(2 * np.pi * 3.0 * record.time_s + np.pi / 2)
    generator = np.random.default_rng(5)
    force = 500.0 * np.sign(velocity) + 1000 * record.displacement_mm + 2.0 * generator.normal(size=len(velocity))
    assert loops_from(dataclasses.replace(record, force_N=force)).noise_rms_N[0] == pytest.approx(2.0, rel=0.1)


def test_insignificant_harmonics_of_the_drive_are_zero(harmonic_record, loops_from):
    record = harmonic_record(displacement=(0.0, 0.8, 0.0, 0.01))
    noise = 1e-3 * np.random.default_rng(1).normal(size=len(record.time_s))
    kept = loops_from(dataclasses.replace(record, displacement_mm=record.displacement_mm + noise)).displacement[0]
    assert kept[3] == pytest.approx(0.01, abs=5e-4)
    assert np.count_nonzero(kept[4:]) <= 2


def test_harmonics_that_the_sampling_cannot_carry_have_no_weight(harmonic_record, loops_from):
    loops = loops_from(harmonic_record(rate=120.0))
    assert np.all(loops.force[0, 11:] == 0)
    assert np.all(np.isinf(loops.force_standard_error[0, 11:]))
    assert np.all(np.isfinite(loops.force_standard_error[0, :11]))


@pytest.mark.parametrize("before", [0.4, 1.3, 3.0])
@pytest.mark.parametrize("after", [0.0, 0.6])
def test_ramps_are_left_aside_and_counted(harmonic_record, loops_from, before, after):
    record = harmonic_record(force=F, cycles=6.0 + before + after, rate=900.0, phase=1.0)
    elapsed = 3.0 * record.time_s
    envelope = np.clip(np.minimum(elapsed / before, 1 + (6.0 + before - elapsed) / max(after, 1e-9)), 0, 1)
    ramped = Record(record.time_s, envelope * record.displacement_mm, envelope * record.force_N)
    loops = loops_from(ramped, first_cycle=100.0)
    cycles = loops.cycles[0]
    assert 4 <= len(cycles) <= 6
    # the cycle that still holds the ramp's last percent may be left aside too
    assert 100.0 + before + 0.3 < cycles[0] < 100.0 + before + 1.7
    assert loops.amplitude_mm[0] == pytest.approx(0.8, rel=2e-3)
    assert loops.force[0, 1] == pytest.approx(F[1], rel=4e-3)


def test_ramps_of_small_cycles_on_a_large_one_are_left_aside(loops_from):
    """What rode on the large cycle had passed for noise, in which ramps were lost: 4 % less amplitude."""
    drive = DrivePlan(Profile("small cycles on a large one", ((1, 1.0), (7, 0.25))), 0.8, 1.5).signal()
    record = Record(drive.time_s, drive.displacement_mm, 1000.0 * drive.displacement_mm)
    loops = loops_from(record)
    assert len(loops.cycles[0]) >= 5
    assert loops.amplitude_mm[0] == pytest.approx(0.8, rel=2e-3)
    assert abs(loops.displacement[0, 7]) == pytest.approx(0.2, rel=1e-2)


def test_rest_before_the_test_is_left_aside(harmonic_record, loops_from):
    record = harmonic_record(force=F, cycles=5.0)
    rest = np.arange(3000) / 500.0
    time = np.concatenate([rest, 6.0 + record.time_s])
    y = np.concatenate([np.zeros(3000), record.displacement_mm])
    force = np.concatenate([np.zeros(3000), record.force_N])
    loops = loops_from(Record(time, y, force))
    assert len(loops.cycles[0]) >= 4
    np.testing.assert_allclose(loops.force[0, :8], F, atol=2.0)


@pytest.mark.parametrize("fresh", [0.3, 0.01])
def test_a_first_cycle_on_the_virgin_curve_is_left_aside(harmonic_record, loops_from, fresh):
    record = harmonic_record(force=F, cycles=5.0)
    virgin = 2000 * fresh * (3.0 * record.time_s < 0.25)
    loops = loops_from(dataclasses.replace(record, force_N=record.force_N + virgin))
    np.testing.assert_allclose(loops.cycles[0], [1.5, 2.5, 3.5, 4.5], atol=0.01)
    np.testing.assert_allclose(loops.force[0, :8], F, atol=1e-3)


@pytest.mark.parametrize("rate", [0.0, 0.02, 0.5])
def test_a_drift_or_noise_costs_no_cycle(harmonic_record, loops_from, rate):
    record = harmonic_record(force=F, cycles=5.0)
    drift = np.exp(-rate * 3.0 * record.time_s)
    noise = 10.0 * np.random.default_rng(0).normal(size=len(drift))
    assert len(loops_from(dataclasses.replace(record, force_N=record.force_N * drift + noise)).cycles[0]) == 5


def test_uneven_sampling_serves(harmonic_record, loops_from):
    record = harmonic_record(Y, F, rate=900.0)
    keep = np.random.default_rng(0).random(len(record.time_s)) > 0.3
    loops = loops_from(Record(record.time_s[keep], record.displacement_mm[keep], record.force_N[keep]))
    np.testing.assert_allclose(loops.force[0, :8], F, atol=1e-2)


def test_rows_per_cycle_follow_a_force_that_drifts(harmonic_record, loops_from):
    record = harmonic_record(force=F, cycles=8.0, rate=600.0)
    drifting = dataclasses.replace(record, force_N=record.force_N * (1 - 0.01 * 3.0 * record.time_s))
    loops = loops_from(drifting, first_cycle=50.0)
    single = per_cycle(loops)
    assert single.run == ("run",) * 8
    np.testing.assert_allclose(single.cycle, 50.5 + np.arange(8), atol=0.01)
    np.testing.assert_allclose(single.force[:, 1].real, 2000 * (1 - 0.01 * (np.arange(8) + 0.5)), rtol=2e-3)
    np.testing.assert_allclose(np.mean(single.force, axis=0), loops.force[0], atol=1e-6)
    np.testing.assert_allclose(
        single.force_standard_error, np.repeat(loops.force_standard_error * math.sqrt(8), 8, axis=0)
    )


def test_cycles_that_begin_at_the_smallest_displacement_are_told_apart(harmonic_record, loops_from):
    record = harmonic_record(force=F, cycles=9.0, rate=600.0, phase=np.pi)
    noise = np.random.default_rng(1).normal(0.0, 1e-3, len(record.time_s))
    loops = loops_from(dataclasses.replace(record, displacement_mm=record.displacement_mm + noise))
    assert [len(phases) for phases in per_cycle(loops).phases] == pytest.approx([200.0] * 9, abs=2)
    assert np.all(np.abs(np.diff(loops.phases[0])) < 2 * np.pi)


@pytest.mark.parametrize("cycles", [(1,), (1, 1), (2, 2, 1), (3, 3, 2)])
def test_stretches_of_a_record_follow_a_force_that_drifts(harmonic_record, loops_from, cycles):
    record = harmonic_record(force=F, cycles=float(sum(cycles)), rate=600.0)
    drifting = dataclasses.replace(record, force_N=record.force_N * (1 - 0.01 * 3.0 * record.time_s))
    loops = loops_from(drifting, first_cycle=50.0)
    parts, single = by_stretch(loops), per_cycle(loops)
    assert tuple(map(len, parts.cycles)) == cycles
    assert by_stretch(parts) is parts or len(cycles) == 1
    weight = np.array(cycles) / sum(cycles)
    np.testing.assert_allclose(weight @ parts.force, loops.force[0], atol=1e-6)
    np.testing.assert_allclose(parts.force[-1], single.force[-cycles[-1] :].mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(parts.cycle[-1], stats.gmean(single.cycle[-cycles[-1] :]))
    np.testing.assert_allclose(parts.force_standard_error, loops.force_standard_error / np.sqrt(weight)[:, None])
    np.testing.assert_allclose([row.samples for row in parts.rows], weight * loops.rows[0].samples)
    assert [len(phases) for phases in parts.phases] == pytest.approx(200.0 * np.array(cycles), abs=2)


def test_a_grid_of_points_holds_the_harmonics():
    values = on_grid(F[None, :], 64)
    back = np.fft.rfft(values[0])[:8] / 32
    back[0] /= 2
    np.testing.assert_allclose(back, F, atol=1e-12 * 2000)


def test_a_frequency_of_the_table_is_not_needed_nor_believed(harmonic_record, loops_from):
    loops = loops_from(harmonic_record(frequency=3.0), frequency_Hz=1.0)
    assert loops.frequency_Hz[0] == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize("speed", [1.0, 10.0])
def test_a_triangle_there_and_back_is_a_cycle(speed):
    """As of a quasi-static test of rubber, loaded and unloaded once; its best sine is 7 % slower."""
    time = np.arange(601) / 600.0 * 40.0 / speed
    y = speed * np.minimum(time, time[-1] - time)
    found = find_cycles(Record(time, y, y + 2.0))
    assert (found.count, found.frequency_Hz) == (1, pytest.approx(speed / 40.0, rel=2e-3))


@pytest.mark.parametrize("phase", [0.0, 0.5, 1.0])
def test_a_part_of_a_cycle_is_none(phase):
    time = np.arange(600) / 600.0
    y = np.sin(2 * np.pi * 0.94 * time + np.pi * phase)
    with pytest.raises(UnusableRecord, match=r"no full cycle: 0\.94 of one"):
        find_cycles(Record(time, y, y))


def test_a_drift_is_no_vibration():
    time = np.arange(500) / 100.0
    with pytest.raises(UnusableRecord):
        find_cycles(Record(time, 0.1 * time, time))


@pytest.mark.parametrize("decay", [0.05, 0.3])
def test_what_drifts_from_cycle_to_cycle_is_no_scatter(harmonic_record, loops_from, decay):
    """A clamp that loosens by a fifth, or quickly at first: a law of the cycle number can explain that."""
    rng = np.random.default_rng(5)
    record = harmonic_record(cycles=12)
    loosened = 1 - 0.2 * (1 - np.exp(-decay * 3.0 * record.time_s)) / (1 - np.exp(-decay * 12))
    record.force_N[:] = loosened * record.force_N + 3.0 * rng.standard_normal(len(record.force_N))
    loops = loops_from(record)
    assert loops.noise_rms_N[0] > 50
    assert 2.5 < loops.scatter_rms_N[0] < 8


def test_heat_that_dies_away_is_no_scatter_where_all_runs_show_it(harmonic_record, run_of, campaign_of):
    """Four cycles of one run don't lie on a line: 10 % of a bearing's force was told as what no law can explain."""

    def heating(frequency: float) -> Record:
        record = harmonic_record(Y, F, frequency, 400 * frequency, 4.0, 0.0)
        course = 0.8 + 0.2 * np.exp(-0.5 * frequency * record.time_s)
        noise = 10.0 * np.random.default_rng(round(10 * frequency)).normal(size=len(course))
        return dataclasses.replace(record, force_N=record.force_N * course + noise)

    records = [heating(frequency) for frequency in (0.5, 0.7, 1.0, 1.4, 2.0)]
    alone = loops_of(campaign_of(run_of(records[0])))
    assert alone.scatter_rms_N[0] > 50.0  # one run alone may scatter so
    together = loops_of(campaign_of(*(run_of(record, name=f"r{row}") for row, record in enumerate(records))))
    assert np.all(together.scatter_rms_N < 20.0)
    assert np.all(together.noise_rms_N > 50.0)


@pytest.mark.parametrize("seed", range(5))
def test_cycles_that_scatter_at_random_drift_in_no_campaign(seed):
    random = np.random.default_rng(seed)
    runs = [F * (1 + 0.05 * random.normal(size=(cycles, 1))) for cycles in random.integers(3, 8, size=40)]
    assert not drift_alike(runs)
    assert drift_alike([F * np.exp(-0.4 * np.arange(4))[:, None] for _ in range(4)])
    assert not drift_alike([F * np.exp(-0.4 * np.arange(cycles))[:, None] for cycles in (1, 2)])


def test_without_a_drift_all_noise_is_scatter(harmonic_record, run_of, campaign_of):
    rng = np.random.default_rng(6)
    runs = []
    for number in range(30):
        record = harmonic_record(cycles=6)
        # the amplitude of the force scatters from cycle to cycle too, which is no drift
        size = 1 + 0.005 * rng.standard_normal(6)[np.minimum((3.0 * record.time_s).astype(int), 5)]
        record.force_N[:] = size * record.force_N + 3.0 * rng.standard_normal(len(record.force_N))
        runs.append(run_of(record, f"run{number}"))
    loops = loops_of(campaign_of(*runs))
    assert np.count_nonzero(loops.scatter_rms_N != loops.noise_rms_N) <= 1


def test_last_digits_that_alternate_are_no_motion():
    """The strongest line is then the last of the spectrum, with no neighbour on its far side."""
    time = np.arange(400) / 400.0
    with pytest.raises(UnusableRecord):
        find_cycles(Record(time, 1e-4 * (-1.0) ** np.arange(400), time))


def test_a_force_beyond_all_numbers_has_no_harmonics_and_says_nothing(harmonic_record, loops_from):
    """Fits try such forces and refuse them; numpy's warning of it stood on the terminal."""
    observations = loop_observations(loops_from(harmonic_record(Y, F, 1.7, 1.7 * 40, 5.0)))
    assert observations.transforms is not None
    force = np.zeros_like(observations.motion.y)
    force[0, 3:5] = np.inf, -np.inf
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = observations.transformed(force)
    assert not np.all(np.isfinite(found))


def test_a_way_without_return_is_told_as_one():
    """A compression test's only ramp had been "0.04 of a cycle at 0.004 Hz"."""
    y = np.linspace(0.4, 9.7, 60)
    with pytest.raises(UnusableRecord, match=r"no full cycle: it goes from 0\.4 to 9\.7 mm and never turns back"):
        find_cycles(Record(0.26 * np.arange(60), y, 10 * y))


@pytest.mark.parametrize("seed", range(4))
def test_a_noisy_cycle_that_a_machine_caught_is_whole(seed):
    """A pulse of 51 samples at 51.2 a cycle, of which noise hides that it is back: 0.92 of a cycle had been told."""
    rng = np.random.default_rng(seed)
    time = np.arange(51) / 512.0
    pulse = (1 - np.cos(2 * np.pi * 10 * time)) / 2
    late = (1 - np.cos(2 * np.pi * 10 * (time - 0.004))) / 2
    y = -0.1 - 0.045 * late + rng.normal(0, 0.0012, 51)
    force = -40 - 550 * pulse + rng.normal(0, 1.7, 51)
    found = find_cycles(Record(time, y, force))
    assert (found.count, found.frequency_Hz) == (1, pytest.approx(10.0, rel=0.03))
    # noise hides no more than itself
    with pytest.raises(UnusableRecord, match="no full cycle"):
        find_cycles(Record(time[:42], y[:42], force[:42]))


def test_a_random_motion_is_not_told_as_constant():
    """As of a damper that white noise drives."""
    y = np.convolve(np.random.default_rng(5).normal(size=459), np.hanning(60), mode="valid") / 5
    with pytest.raises(UnusableRecord, match=r"^no sine in it: it stays within"):
        find_cycles(Record(np.arange(len(y)) / 200.0, y, y))
