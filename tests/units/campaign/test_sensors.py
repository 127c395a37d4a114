"""Sensors that fail or drift, told before any law is asked; the faults are made here, by plain arithmetic."""

from __future__ import annotations

import gzip
import pickle
import shutil
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_identification.campaign.clipping import check_clipping
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.drifting import Watched, chance_of, drifting
from pipeclamp_identification.campaign.faults import SensorFailure
from pipeclamp_identification.campaign.plausibility import CycleByCycle
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record

FEW = 12
"""Runs of the bundled campaign that the trials take, every fourth."""


def _faulty(source: Path, target: Path, fault, order=None) -> None:
    """Copy a campaign, its records changed: fault(place, share of the record's time, y, F) gives y and F."""
    target.mkdir()
    shutil.copy(source / "campaign.toml", target)
    table = pl.read_csv(source / "runs.csv")
    table = table if order is None else table[order]
    for place, row in enumerate(table.iter_rows(named=True)):
        content = (source / row["file"]).read_bytes()
        record = pl.read_csv(gzip.decompress(content) if row["file"].endswith(".gz") else content)
        t, y, force = (record[name].to_numpy().copy() for name in ("time_s", "displacement_mm", "force_N"))
        y, force = fault(place, (t - t[0]) / (t[-1] - t[0]), y, force)
        changed = record.with_columns(pl.Series("displacement_mm", y), pl.Series("force_N", force))
        changed.write_parquet(target / f"{place}.parquet")
    table.with_columns(pl.Series("file", [f"{place}.parquet" for place in range(len(table))])).write_csv(
        target / "runs.csv"
    )


@pytest.fixture
def faults_of(tmp_path):
    """Give a function that reads clamp_a, a quarter of its runs, with a fault in each third one."""

    def read(fault, every=3, order=None):
        def some(place, share, y, force):
            return fault(share, y, force) if place % every == 0 else (y, force)

        order = np.arange(0, 48, 48 // FEW) + np.arange(FEW) % 4 if order is None else order
        _faulty(bundled_campaign("clamp_a"), tmp_path / "faulty", some, order)
        return read_campaign(tmp_path / "faulty")

    return read


@pytest.mark.parametrize(("slope_Hz_per_s", "drift_N", "told"), [(0.275, 0.0, 0), (-0.275, 0.0, 0), (0.0, 60.0, 1)])
def test_a_mean_that_follows_the_speed_of_a_sweep_is_no_drifting_zero(tmp_path, slope_Hz_per_s, drift_N, told):
    """Of a damper that is harder one way the mean force follows the speed."""
    time = np.arange(0.0, 20.0, 1e-3)
    frequency = 3.25 + slope_Hz_per_s * (time - 10.0)
    phase = 2 * np.pi * (3.25 * time + slope_Hz_per_s * (time - 10.0) ** 2 / 2)
    y, v = 8.0 * np.sin(phase), 2 * np.pi * frequency * 8.0 * np.cos(phase)
    force = 5.0 * y + np.where(v > 0, 450 * np.tanh(v / 60) + v, 900 * np.tanh(v / 45) + 2 * v) + drift_N * time / 20.0
    force += np.random.default_rng(1).normal(0.0, 4.0, len(time))
    pl.DataFrame({"time_s": time, "displacement_mm": y, "force_N": force}).write_csv(tmp_path / "sweep.csv")
    (tmp_path / "campaign.toml").write_text('name = "sweep"\n')
    (tmp_path / "runs.csv").write_text("run,file,amplitude_mm,temperature_C\nsweep,sweep.csv,8,20\n")
    assert len(read_campaign(tmp_path).faults) == told


def _size(force):
    return np.ptp(force) / 2


def _of_one_cell(rng, force_noise=0.2):
    """Runs without faults, of forces that differ widely, all with the noise of one load cell, N."""
    runs = []
    for place, (A, F) in enumerate([(1.0, 12.0), (2.0, 80.0), (3.0, 150.0), (4.0, 400.0)] * 12):
        noise = rng.standard_normal((4, 5))
        y = np.stack([1e-4 * noise[0], A + 1e-3 * noise[1]], axis=1).astype(complex)
        loop = F * np.exp(0.2j) + force_noise * rng.standard_normal(5)
        force = np.stack([force_noise * noise[2], loop + 1j * force_noise * noise[3]], axis=1)
        runs.append(Watched(f"r{place}", 0.0, 1.0, A, {}, CycleByCycle(y, force)))
    return runs


def test_the_noise_of_a_load_cell_is_no_drift_of_the_smallest_loops():
    rng = np.random.default_rng(1)
    alarms = sum(bool(drifting(_of_one_cell(rng))) for _ in range(300))
    assert alarms <= 3  # 5 kinds of 1 in 1000 each; were scatter but a share, one in 20 campaigns


def test_a_campaign_without_faults_has_none():
    campaign = read_campaign(bundled_campaign("clamp_a"))
    assert campaign.faults == campaign.remarks == campaign.left_out == ()


@pytest.mark.parametrize(
    ("drift", "told"),
    [
        (lambda force: 25.0, "the zero of the force channel drifts: by +20"),
        (lambda force: 0.04 * _size(force), "it drifts more at large amplitudes, which no amplifier knows"),
    ],
)
def test_a_drift_that_grows_with_the_amplitude_is_not_put_down_to_the_amplifier(faults_of, drift, told):
    (fault,) = faults_of(lambda share, y, force: (y, force + drift(force) * share), every=1).faults
    assert (fault.channel, fault.fault, fault.done) == ("force", "zero_drift", "corrected")
    assert told in fault.words


def test_a_drifting_zero_of_force_is_told_and_taken_off(faults_of):
    campaign = faults_of(lambda share, y, force: (y, force + 0.04 * _size(force) * share))
    (fault,) = campaign.faults
    assert (fault.channel, fault.fault, fault.over, fault.unit, fault.done) == (
        "force", "zero_drift", "record", "N", "corrected",
    )  # fmt: skip
    assert len(campaign.runs) == FEW
    assert [run.run for run in fault.runs] == [run.name for run in campaign.runs[::3]]
    for named, run in zip(fault.runs, campaign.runs[::3], strict=True):
        # from the middle of the first cycle of five to that of the last
        assert named.size == pytest.approx(0.04 * 0.8 * _size(run.record.force_N), rel=0.25)
        mean = [np.mean(part) for part in np.array_split(run.record.force_N[run.cycles.steady], run.cycles.count)]
        assert np.ptp(mean) < 0.004 * _size(run.record.force_N)
    assert fault.words in campaign.remarks
    assert f"{fault.size:+.3g} N" in fault.words


def test_a_drifting_zero_of_displacement_that_the_force_does_not_follow_is_told(faults_of):
    (fault,) = faults_of(lambda share, y, force: (y + 0.04 * np.max(y) * share, force)).faults
    assert (fault.channel, fault.fault, fault.done, len(fault.runs)) == ("displacement", "zero_drift", "corrected", 4)


def test_a_mean_position_that_the_force_follows_is_no_fault(faults_of):
    def moved(share, y, force):
        return y + 0.04 * np.max(y) * share, force + 0.04 * _size(force) * share

    assert faults_of(moved).faults == ()


def test_a_mean_force_that_dies_away_is_no_drift(faults_of):
    """A Maxwell arm forgets its beginning: a memory, not the sensor's zero."""
    assert faults_of(lambda share, y, force: (y, force + 0.04 * _size(force) * np.exp(-share / 0.15))).faults == ()


def test_a_failing_gain_of_force_is_told_and_its_runs_are_left_out(faults_of):
    campaign = faults_of(lambda share, y, force: (y, force * (1 - 0.1 * share)))
    (fault,) = campaign.faults
    assert (fault.channel, fault.fault, fault.done, len(fault.runs)) == ("force", "gain_drift", "left out", 4)
    assert all(-0.1 < run.size < -0.07 for run in fault.runs)
    assert [entry.run for entry in campaign.left_out] == [run.run for run in fault.runs]


def test_a_force_that_falls_as_a_whole_is_not_put_down_to_the_amplifier_alone(faults_of):
    """Filled rubber softens so in its first cycles; each run tells its own size, and what it may be is said once."""
    campaign = faults_of(lambda share, y, force: (y, force * (1 - 0.1 * share)))
    (fault,) = campaign.faults
    assert "the device softens or stiffens as a whole, as filled rubber does in its first cycles" in fault.words
    assert "left out, so that a law doesn't know how the device runs in" in fault.words
    assert campaign.remarks.count(fault.words) == 1
    for entry, run in zip(campaign.left_out, fault.runs, strict=True):
        assert f"change by {run.size:+.2%}" in entry.reason
        assert "the device changes as a whole" in entry.reason
        assert "to do" not in entry.reason


@pytest.mark.parametrize("part", ["stiffness", "damping"])
def test_stiffness_or_damping_that_changes_alone_is_no_gain(faults_of, part):
    def changed(share, y, force):
        turned = np.gradient(y)
        basis = np.stack([y, turned]) if part == "stiffness" else np.stack([turned, y])
        own = np.linalg.lstsq(basis.T, force, rcond=None)[0][0] * basis[0]
        return y, force - 0.1 * share * own

    assert faults_of(changed).faults == ()


def test_a_failing_gain_of_displacement_is_told(faults_of):
    (fault,) = faults_of(lambda share, y, force: (y * (1 - 0.05 * share), force)).faults
    assert (fault.channel, fault.fault, len(fault.runs)) == ("displacement", "gain_drift", 4)


def test_too_many_failing_runs_are_kept(faults_of):
    campaign = faults_of(lambda share, y, force: (y, force * (1 - 0.1 * share)), every=1)
    (fault,) = campaign.faults
    assert (fault.done, len(campaign.runs)) == ("kept", FEW)


def _over_runs(tmp_path, change):
    order = np.random.default_rng(3).permutation(48)
    _faulty(
        bundled_campaign("clamp_a"), tmp_path / "faulty",
        lambda place, share, y, force: change(place / 47, y, force), order,
    )  # fmt: skip
    return read_campaign(tmp_path / "faulty").faults


def test_a_zero_that_drifts_from_run_to_run_is_told(tmp_path):
    (fault,) = _over_runs(tmp_path, lambda at, y, force: (y, force + 120.0 * at))
    assert (fault.channel, fault.fault, fault.over, fault.done) == ("force", "zero_drift", "campaign", "corrected")
    assert fault.size == pytest.approx(120.0, rel=0.05)


@pytest.mark.parametrize(
    ("zeros", "shown"),
    [
        ((250.0, 250.0, 250.0, 250.0), "a mean of 250 mm is taken off, for"),
        ((250.0, 290.0, 330.0, 370.0), "a mean of 250 to 370 mm, each run's own, is taken off, for"),
        # it was set between the runs
        ((250.0, 250.0, 0.0, 0.0), "a mean of 250 mm is taken off in 2 of 4 runs, for"),
        # some runs may be held off their rest on purpose
        ((1.0, 1.0, 0.0, 0.0), ""),
    ],
)
def test_a_displacement_from_far_off_is_read_as_from_where_the_clamp_rests(tmp_path, zeros, shown):
    """A crosshead's position, in a campaign that was written by hand."""
    as_it_is = read_campaign(bundled_campaign("clamp_a")).runs[:4]
    _faulty(
        bundled_campaign("clamp_a"), tmp_path / "far",
        lambda place, share, y, force: (y + zeros[place], force - np.mean(force)), np.arange(4),
    )  # fmt: skip
    campaign = read_campaign(tmp_path / "far")
    if not shown:
        assert campaign.remarks == ()
        return
    (told,) = campaign.remarks
    assert told == f"the displacement's zero is not where the clamp rests: {shown} no mean force answers it"
    for run, before in zip(campaign.runs, as_it_is, strict=True):
        off = np.mean(run.record.displacement_mm) - np.mean(before.record.displacement_mm)
        assert off == pytest.approx(0.0, abs=2e-2)
        assert run.cycles.count == before.cycles.count


@pytest.mark.parametrize(("follows", "creeps"), [(0.0, True), (0.5, False)])
def test_a_position_that_creeps_under_a_constant_load_is_taken_off(tmp_path, follows, creeps):
    """Pulses that only press, at means 5 to 11 amplitudes off: a law had followed these, a tenth as stiff."""
    amplitude, stiffness = 1.0, 1200.0

    def pressed(place, share, y, force):
        size = amplitude / np.max(np.abs(y - np.mean(y)))
        off = -(5.0 + 2.0 * place) * amplitude
        kept = -stiffness * amplitude + follows * stiffness * off
        return size * (y - np.mean(y)) + off, size * (force - np.mean(force)) + kept

    _faulty(bundled_campaign("clamp_a"), tmp_path / "pressed", pressed, np.arange(4))
    table = pl.read_csv(tmp_path / "pressed" / "runs.csv").drop("amplitude_mm")
    table.write_csv(tmp_path / "pressed" / "runs.csv")
    campaign = read_campaign(tmp_path / "pressed")
    told = [words for words in campaign.remarks if "zero is not where the clamp rests" in words]
    assert bool(told) is creeps
    means = [np.mean(run.record.displacement_mm) for run in campaign.runs]
    assert np.allclose(means, 0.0, atol=0.1) is creeps


def test_a_gain_that_drifts_from_run_to_run_is_told(tmp_path):
    (fault,) = _over_runs(tmp_path, lambda at, y, force: (y, force * (1 - 0.1 * at)))
    assert (fault.channel, fault.fault, fault.over, fault.done) == ("force", "gain_drift", "campaign", "kept")
    assert fault.size == pytest.approx(np.log(0.9), rel=0.2)


def test_a_drift_in_the_order_of_the_conditions_is_not_told(tmp_path):
    """clamp_a's table is sorted by amplitude: what grows along it may be the amplitude's."""
    _faulty(
        bundled_campaign("clamp_a"), tmp_path / "faulty",
        lambda place, share, y, force: (y, force + 120.0 * place / 47),
    )  # fmt: skip
    assert read_campaign(tmp_path / "faulty").faults == ()


@pytest.mark.parametrize("sides", ["both", "one"])
def test_a_saturated_force_is_told_however_shortly(faults_of, sides):
    def clipped(share, y, force):
        force = np.minimum(force, 0.98 * np.max(force))
        return y, force if sides == "one" else np.maximum(force, 0.98 * np.min(force))

    (fault,) = faults_of(clipped).faults
    assert (fault.channel, fault.fault, fault.done, len(fault.runs)) == ("force", "clipped", "left out", 4)


def test_a_quantised_channel_is_not_saturated(faults_of):
    def quantised(share, y, force):
        quantum = _size(force) / 40
        return np.round(y / 0.01) * 0.01, np.round(force / quantum) * quantum

    assert faults_of(quantised, every=1).left_out == ()


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        ("stuck", lambda force: np.where(np.arange(len(force)) < len(force) / 2, force, force[len(force) // 2])),
        ("stuck", lambda force: np.zeros(len(force))),
        ("dead", lambda force: np.random.default_rng(0).normal(0.0, 3.0, len(force))),
    ],
    ids=["stuck", "zero", "noise alone"],
)
def test_a_channel_that_stands_still_or_shows_noise_alone_is_told(faults_of, kind, change):
    campaign = faults_of(lambda share, y, force: (y, change(force)))
    (fault,) = campaign.faults
    assert (fault.channel, fault.fault, len(fault.runs), len(campaign.runs)) == ("force", kind, 4, 8)


@pytest.mark.parametrize("part", ["beginning", "end"])
def test_a_displacement_that_stands_still_in_a_part_of_a_record_is_told(faults_of, part):
    """What stood still had been cut off without a word."""

    def stuck(share, y, force):
        still = share > 0.6 if part == "end" else share < 0.4
        return np.where(still, y[np.argmax(still) if part == "end" else np.argmin(still)], y), force

    campaign = faults_of(stuck)
    (fault,) = campaign.faults
    assert (fault.channel, fault.fault, fault.done, len(fault.runs)) == ("displacement", "stuck", "kept", 4)
    assert len(campaign.runs) == FEW
    assert fault.words in campaign.remarks
    assert "stuck in a part of 4 runs" in fault.words and "that part is cut off" in fault.words
    run = next(run for run in campaign.runs if run.name == fault.runs[0].run)
    assert run.cycles.count < run.record.time_s[-1] * run.cycles.frequency_Hz * 0.65


def test_a_machine_that_rests_before_and_after_a_test_has_no_sensor_stuck(faults_of):
    def resting(share, y, force):
        rests = (share < 0.3) | (share > 0.7)
        return np.where(rests, 0.0, y), np.where(rests, 5.0, force)

    assert faults_of(resting).faults == ()


@pytest.mark.parametrize("noise", [0.0, 2.0])
@pytest.mark.parametrize("stiffness", [0.0, 900.0])
def test_the_plateau_of_friction_is_not_clipping(noise, stiffness):
    """Dry friction, alone and with an end stop's kink, quantised coarsely, with noise and without."""
    t = np.arange(2000) / 400
    y, v = 0.8 * np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)
    force = 700.0 * np.sign(v) + stiffness * np.sign(y) * np.maximum(np.abs(y) - 0.6, 0.0)
    force = np.round((force + np.random.default_rng(0).normal(0.0, noise, len(t))) / 1.0) * 1.0
    record = Record(t, y + 1e-4 * np.random.default_rng(1).normal(size=len(t)), force)
    cycles = find_cycles(record)
    check_clipping(record, cycles)
    with pytest.raises(SensorFailure):
        check_clipping(Record(t, np.minimum(y, 0.7), force), cycles)


def test_chances_are_students():
    """Two-sided tails of Student's t, from tables."""
    for t, freedoms, chance in ((2.228, 10, 0.05), (5.408, 8, 6.4e-4), (4.032, 5, 0.01)):
        assert chance_of(t, 1.0, freedoms) == pytest.approx(chance, rel=0.1)


@pytest.mark.parametrize("name", ["mr_damper", "friction_device"])
def test_measured_campaigns_raise_no_alarm_and_show_what_is_put_in(measured_data, tmp_path, name):
    source = measured_data / name
    assert read_campaign(source).faults == ()

    def clipped(place, share, y, force):
        return y, np.clip(force, *(0.95 * np.percentile(force, (0.5, 99.5)))) if place % 3 == 0 else force

    _faulty(source, tmp_path / "clipped", clipped)
    (fault,) = read_campaign(tmp_path / "clipped").faults
    count = len(pl.read_csv(source / "runs.csv"))
    assert (fault.fault, len(fault.runs)) == ("clipped", len(range(0, count, 3)))


def test_the_drift_of_a_measured_damper_is_found(measured_data, tmp_path):
    _faulty(
        measured_data / "mr_damper", tmp_path / "drift",
        lambda place, share, y, force: (y, force + (0.1 * _size(force) * share if place % 5 == 0 else 0.0)),
    )  # fmt: skip
    (fault,) = read_campaign(tmp_path / "drift").faults
    assert (fault.channel, fault.fault, len(fault.runs)) == ("force", "zero_drift", 6)


def test_a_failure_goes_to_another_process_whole():
    failure = SensorFailure("stands still", "force", "stuck", 3.0, "N")
    copied = pickle.loads(pickle.dumps(failure))
    assert (str(copied), vars(copied)) == (str(failure), vars(failure))
