"""Campaigns with runs of free motion: which are read, which are left out, and who takes them."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.free_motion import fundamental_of_motion
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import joined_runs
from pipeclamp_identification.signals.smooth_motion import SmoothMotion
from pipeclamp_models.base.errors import UserError


def record(change=None):
    """A motion that is no sine, from rest, of a spring with damping, with some noise."""
    time = np.arange(4000) / 200.0
    window = np.sin(np.pi * time / 20) ** 2
    y = window * (2 * np.sin(2 * np.pi * 0.7 * time) + np.sin(2 * np.pi * 1.9 * time + 1))
    force = 1000 * y + 20 * np.gradient(y, time)
    noise = np.random.default_rng(3)
    samples = {
        "time_s": time,
        "displacement_mm": y + 0.001 * noise.standard_normal(len(y)),
        "force_N": force + 3 * noise.standard_normal(len(y)),
    }
    if change:
        change(samples)
    return Record(**samples)


def clip(channel, share):
    def change(samples):
        limit = share * np.max(np.abs(samples[channel]))
        samples[channel] = np.clip(samples[channel], -limit, limit)

    return change


def setting(channel, value):
    def change(samples):
        samples[channel] = value(samples[channel])

    return change


def dwelling(samples):
    """A block program that waits at its largest displacement while the force relaxes."""
    time = samples["time_s"]
    y = 2.0 * np.clip(np.minimum(time - 2, 18 - time) / 4, 0, 1)
    samples["displacement_mm"] = np.round(y, 3)
    samples["force_N"] = 1000 * y - 50 * (y == 2) * (1 - np.exp(-(time - 6) / 3))


def damper(change):
    """A damper's force, which stands all along a way at speed, with something done to it."""

    def changed(samples):
        velocity = np.gradient(samples["displacement_mm"], samples["time_s"])
        noise = np.random.default_rng(5)
        samples["force_N"] = 300 * np.tanh(velocity / 15) + 3 * noise.standard_normal(len(velocity))
        change(samples)

    return changed


def stuck(samples):
    samples["force_N"][1200:2900] = samples["force_N"][1200]


ALONE = "run,file,motion\nB,runs/B.csv,free\n"


@pytest.fixture
def write(campaign_folder, csv_text, harmonic_record):
    """Give a function that writes a campaign: a sine, and a free run whose record is changed."""

    def written(
        change=None,
        table="run,file,motion\nA,runs/A.csv,\nB,runs/B.csv,free\n",
        description='name = "t"\n',
        folder="campaign",
    ):
        records = {"runs/A.csv": csv_text(harmonic_record()), "runs/B.csv": csv_text(record(change))}
        return campaign_folder(description=description, table=table, records=records, folder=folder)

    return written


def test_sines_and_free_motions_stand_apart(write):
    campaign = read_campaign(write())
    assert [run.name for run in campaign.runs] == ["A"]
    (free,) = campaign.free
    assert free.name == "B"
    assert free.begins_at_rest
    assert campaign.left_out == campaign.remarks == ()


@pytest.mark.parametrize(
    ("defaults", "table"),
    [
        ('motion = "free"', "run,file,motion,frequency_Hz\nA,runs/A.csv,sine,3\nB,runs/B.csv,,\n"),
        ("frequency_Hz = 3", "run,file,motion\nA,runs/A.csv,\nB,runs/B.csv,free\n"),
    ],
)
def test_defaults_say_it_too_and_a_default_sine_is_not_for_free_motions(write, defaults, table):
    campaign = read_campaign(write(table=table, description=f'name = "t"\n[defaults]\n{defaults}\n'))
    assert [run.frequency_Hz for run in campaign.runs] == [3.0]
    assert [run.name for run in campaign.free] == ["B"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("run,file,motion\nA,runs/A.csv,sin\n", ("row 2, column 'motion': got 'sin'", "did you mean 'sine'", "free")),
        ("run,file,motion,frequency_Hz\nA,runs/A.csv,free,3\n", ("row 2, column 'frequency_Hz': got '3'", "blank")),
        ("run,Motion,file\nA,free,runs/A.csv\n", ("column 'Motion' is not known; expected 'motion'",)),
        ("run,motion,dissipated_energy_J,max_elastic_energy_J\nA,free,1,2\n", ("got 'free' without a record",)),
    ],
)
def test_what_is_no_motion_is_an_error(write, table, words):
    with pytest.raises(UserError) as refused:
        read_campaign(write(table=table))
    for one in words:
        assert one in str(refused.value)


def test_the_name_of_a_motion_is_a_column_of_its_own(write):
    table = "run,file,motion,motion_name\nA,runs/A.csv,,\nB,runs/B.csv,free,El Centro\n"
    assert read_campaign(write(table=table)).condition_columns == ()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (setting("displacement_mm", lambda y: 0 * y), "constant displacement: 0 mm in every row"),
        (setting("displacement_mm", lambda y: y - y + np.arange(len(y)) % 2), "constant displacement but for noise"),
        (setting("force_N", lambda F: np.where(np.arange(len(F)) == 7, np.nan, F)), "non-finite samples: 1 in force_N"),
        (setting("time_s", lambda t: np.where(np.arange(len(t)) == 99, 0, t)), "time goes back in row 101"),
        (setting("time_s", lambda t: t + 5.0 * (t > 9)), "a gap of 5"),
        (setting("force_N", np.negative), "its force has the wrong sign"),
        (setting("force_N", lambda F: 0 * F + 3), "stuck sensor: force_N stands at 3 all through the record"),
        (clip("force_N", 0.6), "clipped sensor: force_N stands at"),
        (clip("displacement_mm", 0.6), "clipped sensor: displacement_mm stands at"),
        (damper(clip("force_N", 0.6)), "clipped sensor: force_N stands at"),
        (stuck, "stuck sensor: force_N stands at"),
        (damper(stuck), "stuck sensor: force_N stands at"),
    ],
)
def test_a_record_that_cannot_be_used_is_left_out_with_its_reason(write, change, reason):
    folder = write(change)
    campaign = read_campaign(folder)
    (left_out,) = campaign.left_out
    assert (left_out.run, campaign.free) == ("B", ())
    assert left_out.reason.startswith(reason)
    with pytest.raises(UserError, match="1 of 2 runs can't be used"):
        read_campaign(folder, strict=True)


def noiseless_friction(samples):
    """Dry friction in a record without noise: it stands as long as the motion goes one way."""
    samples["force_N"] = 300.0 * np.sign(np.gradient(samples["displacement_mm"].round(1).cumsum()))


def rounded_force(samples):
    """A reading whose last digit hides the noise, within a clearance, in which no force is."""
    samples["force_N"] = np.round(1000 * np.sign(samples["displacement_mm"]) * np.maximum(
        np.abs(samples["displacement_mm"]) - 1.0, 0.0), -1)  # fmt: skip


@pytest.mark.parametrize(
    "change",
    [
        dwelling,
        setting("displacement_mm", lambda y: np.round(y, 2)),
        noiseless_friction,
        rounded_force,
        damper(lambda s: None),
    ],
)
def test_a_dwell_and_quantised_readings_are_no_clipped_sensor(write, change):
    assert read_campaign(write(change)).left_out == ()


def test_a_free_motion_that_makes_energy_is_told(write):
    """A damper's force with its sign reversed shows no stiffness that would tell: it had been used without a word."""
    campaign = read_campaign(write(damper(setting("force_N", np.negative))))
    assert any("makes energy" in words and "'B'" in words for words in campaign.remarks)
    assert not any(
        "makes energy" in words for words in read_campaign(write(damper(lambda s: None), folder="d")).remarks
    )


def test_a_run_that_begins_in_motion_is_told(write):
    def late(samples):
        for name in samples:
            samples[name] = samples[name][2000:]

    (remark,) = read_campaign(write(late)).remarks
    assert "1 of 1 runs of free motion begins in motion (B)" in remark


def test_fits_leave_free_motions_out_and_name_them(write):
    campaign = read_campaign(write())
    (remark,) = campaign.of_sines().remarks
    assert remark.startswith("1 run of free motion is left out (B)")
    assert campaign.of_sines().runs == campaign.runs
    assert campaign.of_sines().free == ()


def test_a_campaign_of_free_motions_alone_serves_comparisons_only(write):
    campaign = read_campaign(write(table="run,file,motion\nB,runs/B.csv,free\n"))
    assert campaign.runs == ()
    with pytest.raises(UserError, match=r"its only run has free motion \(B\); expected sines.*pipeclamp compare"):
        campaign.of_sines()


def test_joined_campaigns_keep_their_free_motions(write):
    rows = [run.row for run in joined_runs([read_campaign(write())])]
    assert [(row["run"], row["motion"], row["frequency_Hz"]) for row in rows] == [
        ("A", "sine", None),
        ("B", "free", None),
    ]


@pytest.mark.parametrize("begin", [0, 2000], ids=["from rest", "in motion"])
def test_a_displacement_from_far_off_is_told_and_taken_off(write, begin):
    """A crosshead's position, and a force sensor that was set to zero there."""

    def elsewhere(by):
        def change(samples):
            for name in samples:
                samples[name] = samples[name][begin:] + (by if name == "displacement_mm" else 0.0)

        return change

    (as_it_is,) = read_campaign(write(elsewhere(0.0), table=ALONE)).free
    campaign = read_campaign(write(elsewhere(350.0), table=ALONE, folder="far"))
    (run,) = campaign.free
    told = campaign.remarks[0]
    assert told.startswith("the displacement's zero is not where the clamp rests: a mean of 35")
    assert told.endswith("no mean force answers it")
    off = run.record.displacement_mm - as_it_is.record.displacement_mm
    # where it begins at rest, that is its zero, but for the smoothed noise; else nothing says better than its mean
    assert np.ptp(off) < 1e-3
    assert off[0] == pytest.approx(0.0, abs=2e-3 if begin == 0 else 0.1 * as_it_is.motion.amplitude)
    assert run.motion.y - run.record.displacement_mm == pytest.approx(
        as_it_is.motion.y - as_it_is.record.displacement_mm, abs=1e-9
    )


def test_sines_say_where_the_zero_of_a_free_motion_is(campaign_folder, csv_text, harmonic_record):
    """The free motion rests 0.3 mm beside it, as a clamp may after a slip."""
    sine, moved = harmonic_record(), record(setting("displacement_mm", lambda y: y + 350.3))
    records = {
        "runs/A.csv": csv_text(replace(sine, displacement_mm=sine.displacement_mm + 350.0)),
        "runs/B.csv": csv_text(moved),
    }
    table = "run,file,motion\nA,runs/A.csv,\nB,runs/B.csv,free\n"
    campaign = read_campaign(campaign_folder(table=table, records=records))
    assert "a mean of 350 mm is taken off, for" in campaign.remarks[0]
    assert campaign.runs[0].record.displacement_mm == pytest.approx(sine.displacement_mm, abs=1e-3)
    assert campaign.free[0].record.displacement_mm == pytest.approx(moved.displacement_mm - 350.0, abs=1e-3)


def test_a_displacement_that_the_force_answers_is_the_clamps_own(write):
    def held(samples):
        samples["displacement_mm"] = samples["displacement_mm"] + 10.0
        samples["force_N"] = samples["force_N"] + 10000.0

    campaign = read_campaign(write(held, table=ALONE))
    assert np.mean(campaign.free[0].record.displacement_mm) == pytest.approx(10.0, abs=0.2)
    assert not any("rests" in remark for remark in campaign.remarks)


def test_a_force_that_stands_far_off_is_told_and_kept(write):
    (told,) = read_campaign(write(setting("force_N", lambda F: F + 20000.0), table=ALONE)).remarks
    assert told.startswith("a mean force of 20000 N stands in all runs of free motion")
    assert read_campaign(write(setting("force_N", lambda F: F + 1000.0), table=ALONE, folder="near")).remarks == ()


def test_a_way_at_constant_speed_tells_a_spring_and_no_dashpot():
    """Its velocity varies by nothing: the fit ended in a traceback ("SVD did not converge")."""
    time = np.arange(400) / 100.0
    noise = np.random.default_rng(3).standard_normal(len(time))
    motion = SmoothMotion(time, 0.5 * time, np.full(len(time), 0.5), np.zeros(len(time)), 0.0)
    ramp = Record(time_s=time, displacement_mm=motion.y, force_N=800 * motion.y + noise)
    found = fundamental_of_motion(ramp, motion)
    assert found.stiffness.real == pytest.approx(800, rel=1e-3)
    assert found.stiffness.imag == 0.0
