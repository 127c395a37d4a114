"""Files with many runs, and what raw records need: where runs begin, what is cut, what is repaired, what is stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from exports import RATE, Loop, loop, text

import pipeclamp as pc
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.drive import DrivePlan, Profile
from pipeclamp_identification.campaign.records import Record, UnusableRecord
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, RIDDEN
from pipeclamp_identification.importing.conditions import Pattern, guessed_pattern
from pipeclamp_identification.importing.records import taking
from pipeclamp_identification.importing.samples.blanks import without_blanks
from pipeclamp_identification.importing.samples.repair import evened, without_spikes
from pipeclamp_identification.importing.samples.split import irregular, split, unsteady
from pipeclamp_models.base.errors import UsageError, UserError


def sine(amplitude, frequency, cycles, end=None):
    time = np.arange(round(cycles * RATE / frequency)) / RATE
    return np.linspace(amplitude, amplitude if end is None else end, len(time)) * np.sin(2 * np.pi * frequency * time)


def parts(*pieces, segment=None):
    rng = np.random.default_rng(1)
    y = np.concatenate(pieces)
    y = np.round(y + rng.normal(0, 2e-4, len(y)), 4)
    return split(np.arange(len(y)) / RATE, y, segment)


def test_one_steady_motion_stays_whole():
    cut = parts(sine(0.5, 2, 6.3))
    assert [(part.first, part.last) for part in cut.runs] == [(0, 630)]
    assert not cut.left


def test_rests_and_ramps_are_told_from_steady_parts():
    rest = np.zeros(800)
    cut = parts(rest, sine(0.0, 2, 4, end=0.5), sine(0.5, 2, 10), sine(0.5, 2, 3, end=0), rest, sine(1, 1, 8))
    assert len(cut.runs) == 2
    first, second = cut.runs
    assert 1200 - 120 <= first.first <= 1200 + 60
    assert 2200 - 60 <= first.last <= 2200 + 60
    assert 3300 - 210 <= second.first <= 3300 + 210
    assert second.last == 4900
    assert all("rest" in part.why for part in cut.left)


def test_steps_of_amplitude_and_frequency_part_runs():
    cut = parts(sine(0.2, 1, 8), sine(0.5, 1, 8), sine(0.5, 4, 12), sine(1, 4, 12))
    assert len(cut.runs) == 4


def program(*steps, slow=False):
    """Steps of (amplitude, cycles), as sines of 1 Hz or, as of a quasi-static test, at one speed."""
    pieces = []
    for amplitude, cycles in steps:
        period = round(4 * amplitude * RATE if slow else RATE)
        turn = np.sin(2 * np.pi * np.arange(period) / period)
        pieces += cycles * [amplitude * (2 / np.pi * np.arcsin(turn) if slow else turn)]
    return pieces


@pytest.mark.parametrize("slow", [False, True])
@pytest.mark.parametrize(
    "steps",
    [
        [(a, 3) for a in (0.2, 0.3, 0.45, 0.7)],
        [(a, 2) for a in (0.2, 0.3, 0.45, 0.7)],
        [(0.2, 6), (0.3, 6), (0.4, 6), (0.8, 3), (1.2, 3), (1.6, 2), (2.0, 2)],
    ],
)
def test_a_program_of_few_cycles_a_step_is_parted(steps, slow):
    pieces = program(*steps, slow=slow)
    cut = parts(*pieces)
    assert len(cut.runs) == len(steps)
    y = np.concatenate(pieces)
    held = [np.abs(y[part.first : part.last]) for part in cut.runs]
    assert [np.max(one) for one in held] == pytest.approx([amplitude for amplitude, _ in steps], rel=0.01)


def test_a_program_that_was_driven_by_hand_is_parted():
    rng = np.random.default_rng(3)
    pieces = []
    for amplitude in (0.2, 0.3, 0.45, 0.7, 1.0):
        for _ in range(4):
            period = round(RATE * (1 + rng.normal(0, 0.05)))
            pieces.append(amplitude * (1 + rng.normal(0, 0.01)) * np.sin(2 * np.pi * np.arange(period) / period))
    assert len(parts(*pieces).runs) == 5


def test_half_cycles_of_two_that_scatter_are_one_level():
    """A wall's two ways of a cycle had differed by 5.4 %, and steps of two cycles had stayed one run."""
    pieces = [
        amplitude * side * np.sin(2 * np.pi * np.arange(RATE) / RATE)
        for amplitude in (0.44, 0.83, 1.6)
        for side in (1.0, 0.94)
    ]
    assert len(parts(*pieces).runs) == 3


def test_a_way_to_the_next_level_that_turns_once_is_no_rest():
    """The program goes on about another place, so that the way there turns, and turns back, within a moment."""
    cut = parts(sine(1, 1, 4), -0.15 + sine(0.6, 1, 4))
    assert len(cut.runs) == 2
    assert {part.why for part in cut.left} == {"ramp or change of level"}


def test_pieces_of_a_slow_ramp_are_no_levels():
    cut = parts(sine(0, 1, 15, 0.5), sine(0.5, 1, 10), sine(0.5, 1, 15, 1), sine(1, 1, 10))
    assert len(cut.runs) == 2
    assert [part.first for part in cut.runs] == pytest.approx([3000, 8000], abs=400)


def test_a_ramp_of_one_cycle_is_no_rest():
    cut = parts(sine(0.0, 4, 1, 0.5), sine(0.5, 4, 6))
    assert [part.why for part in cut.left] == ["ramp or change of level"]


@pytest.mark.parametrize("order", [7, 12])
@pytest.mark.parametrize("rests", [False, True])
def test_cycles_that_ride_on_a_large_one_are_one_motion(order, rests):
    """As of the test that a diagnosis asks for: it stays whole, each repeat for itself, rests beside it or not."""
    drive = DrivePlan(Profile("riding", ((1, 1.0), (order, 0.25))), 0.5, 1.0).signal()
    time = np.arange(int(drive.time_s[-1] * RATE)) / RATE
    once = np.interp(time, drive.time_s, drive.displacement_mm)
    rest = np.zeros(round(3 * RATE))
    cut = parts(rest, once, rest, once, rest) if rests else parts(once)
    assert len(cut.runs) == (2 if rests else 1)
    assert all(part.last - part.first >= len(once) for part in cut.runs)


def test_a_test_that_was_asked_for_is_imported_as_it_was_driven(tmp_path):
    drive = DrivePlan(PROFILES[RIDDEN], 0.5, 2.0).signal()
    force = 300 * drive.displacement_mm + 20 * np.sign(np.gradient(drive.displacement_mm))
    (tmp_path / "next.csv").write_text(text(Loop("next", 0.5, 2.0, 20.0, drive.time_s, drive.displacement_mm, force)))
    (run,) = pc.import_files([tmp_path / "next.csv"], tmp_path / "c").to_dict()["runs"]
    assert (run["amplitude_mm"], run["frequency_Hz"]) == (pytest.approx(0.5, rel=1e-3), pytest.approx(2.0, rel=1e-3))


def test_a_segment_channel_parts_runs_and_a_counter_of_cycles_does_not():
    y = [sine(0.5, 2, 8), sine(0.5, 2, 8)]
    assert len(parts(*y, segment=np.repeat([1.0, 2.0], 800)).runs) == 2
    assert len(parts(*y, segment=np.arange(1600) // 100.0).runs) == 1


@pytest.mark.parametrize(
    "motion",
    [
        lambda t: np.sin(2 * np.pi * (1 + 0.15 * t) * t),
        lambda t: np.sin(2 * np.pi * np.log(1 + 0.012 * t) / 0.04),
        lambda t: 0.01 * np.exp(0.04 * t) * np.sin(2 * np.pi * t),
    ],
    ids=["frequency", "period", "amplitude"],
)
def test_a_sweep_is_no_row_of_levels(motion):
    time = np.arange(60 * RATE) / RATE
    cut = parts(motion(time))
    assert [(part.first, part.last) for part in cut.runs] == [(0, len(time))]


def test_a_run_that_changes_all_along_says_how_little_of_it_is_used(tmp_path):
    time = np.arange(1200) / RATE
    y = (0.1 + 0.2 * time) * np.sin(4 * np.pi * time)
    (tmp_path / "grows.csv").write_text(text(Loop("grows", 0.5, 2.0, 20.0, time, y, 300 * y)))
    (run,) = pc.import_files([tmp_path / "grows.csv"], tmp_path / "c").to_dict()["runs"]
    assert any("1 of some 12 cycles is steady, and alone is used" in words for words in run["done"])


def test_a_rest_beside_the_cycles_is_no_change_along_a_run():
    """Five cycles between ramps of one and rests as long as five: most of what moves is steady."""
    at = np.arange(0.0, 17.0, 0.02)
    ramp = np.clip(np.minimum(at - 5.0, 12.0 - at), 0.0, 1.0)
    y = np.sin(np.pi / 2 * ramp) ** 2 * np.sin(2 * np.pi * at) + np.random.default_rng(2).normal(0.0, 1e-3, len(at))
    assert unsteady(at, y, slice(300, 550), 5) == ""
    assert "1 of some 8 cycles is steady" in unsteady(at, y, slice(300, 350), 1)


def test_a_sweep_says_its_frequencies_and_how_many_cycles_it_has():
    """From 1 Hz on, e times in 20 s, for 60 s: 382 cycles, a tenth of them below 2.9, another above 18.2 Hz."""
    at = np.arange(0.0, 60.0, 1e-4)
    y = 2.0 * np.sin(2 * np.pi * 20.0 * np.expm1(at / 20.0))
    said = unsteady(at, y, slice(200000, 202000), 6)
    assert "2 to 2 mm, 2.91 to 18.2 Hz): 6 of some 382 cycles are steady" in said


def test_time_that_begins_anew_and_gaps_part_runs():
    one, other = loop(0.3), loop(0.9)
    y = np.concatenate([one.y, other.y])
    assert len(split(np.concatenate([one.time, other.time]), y).runs) == 2
    assert len(split(np.concatenate([one.time, other.time + 100]), y).runs) == 2


def record(run: Loop) -> Record:
    return Record(run.time, run.y, run.force)


def blank(run: Loop, *rows: tuple[int, int]) -> Record:
    force = run.force.copy()
    for first, last in rows:
        force[first:last] = np.nan
    return Record(run.time, run.y, force)


def test_short_rows_of_blanks_are_bridged_and_long_ones_cut_off():
    run = loop(0.5, 2.0, cycles=20)

    def whole(*rows):
        return without_blanks(blank(run, *rows), lambda sample: sample + 8)

    assert without_blanks(record(run), int).record.force_N is run.force
    short = whole((500, 503))
    assert (short.first, short.last) == (0, len(run.time))
    assert np.max(np.abs(short.record.force_N - run.force)) < 30
    assert short.done == ("3 blank samples in force_N: replaced by straight lines",)
    # many, but each row far shorter than a cycle: a channel of half the rate
    assert whole(*((place, place + 1) for place in range(1, 1999, 2))).last == len(run.time)
    # no cycle is made of a straight line, though the share of blanks is small
    assert (whole((500, 560)).first, whole((500, 560)).last) == (560, len(run.time))
    assert "60 samples are blank in force_N, the first in row 508" in whole((500, 560)).done[0]
    # nor is what lies beyond the first sample made up
    assert (whole((0, 3)).first, whole((0, 3)).last) == (3, len(run.time))
    with pytest.raises(UnusableRecord, match="the first in row 18"):
        whole(*((place, place + 15) for place in range(10, 2000, 50)))


def held(first, last, value=None, digits=3, play=0.0, channel="force"):
    """Give a run whose channel repeats a number, its last one by default, with coarser digits or with play."""
    run = loop(0.5, 2.0, cycles=20)
    samples = np.round(run.force if channel == "force" else run.y, digits)
    samples = np.where(np.abs(run.y) < play, 0.0, samples)
    samples[first:last] = samples[first] if value is None else value
    named = {"displacement_mm": run.y, "force_N": run.force} | {
        f"{channel}_{'N' if channel == 'force' else 'mm'}": samples
    }
    return without_blanks(Record(run.time, **named), lambda sample: sample + 2)


def test_a_channel_that_a_logger_held_is_blank():
    assert "force_N stands at 0 for 40 samples from row 702 on" in held(700, 740, 0.0).done[0]
    assert (held(700, 740, 0.0).first, held(700, 740, 0.0).last) == (740, 2000)
    assert "force_N stands at" in held(710, 760).done[0]
    assert "displacement_mm stands at" in held(710, 760, channel="displacement", digits=6).done[0]
    # a few digits that stand at the turn, and play, are what was measured
    assert not held(0, 0, digits=-1).done
    assert not held(0, 0, digits=1, channel="displacement").done
    assert not held(0, 0, play=0.2).done


def test_a_temperature_that_is_written_now_and_then_counts():
    run = loop(0.5, 2.0)
    temperature = np.where(np.arange(len(run.time)) % 100 == 0, 80.0, np.nan)
    found = without_blanks(replace(record(run), temperature_C=temperature), int).record
    assert np.all(found.temperature_C == 80)
    none = without_blanks(replace(record(run), temperature_C=np.full(len(run.time), np.nan)), int).record
    assert none.temperature_C is None


def test_spikes_are_replaced_and_told_and_loops_left_alone():
    clean = record(loop(0.5, 2.0))
    assert without_spikes(clean).record is clean
    force = clean.force_N.copy()
    force[[101, 333, 334]] += [4000, -3000, -3000]
    force[[501, 502]] += [2500, 1500]  # one, as a filter leaves it
    repaired = without_spikes(replace(clean, force_N=force))
    assert np.max(np.abs(repaired.record.force_N - clean.force_N)) < 60
    assert "5 spikes in force_N" in repaired.done[0]


def test_a_peak_of_a_small_loop_of_few_samples_is_no_spike():
    """As of a curve that was read off a picture: first a small loop of a few samples, larger ones of more behind it."""
    t = np.arange(800) / 40
    y, force = 10 * np.sin(2 * np.pi * t), 20 * np.sin(2 * np.pi * t + 0.2)
    y[:8], force[:8] = [0, 0.9, -1, -0.1, 0.9, 1.3, 0, -1], [0, 8.9, -7.8, 2, 10.3, 12.6, 0, -7]
    assert not without_spikes(Record(t, y, force)).done
    force[401] += 60
    assert "1 spike in force_N" in without_spikes(Record(t, y, force)).done[0]


@pytest.mark.parametrize("late", [0, 1])
def test_a_peak_where_a_triangle_turns_is_no_spike(late):
    """As a rubber's force peaks there; the motion may turn a sample later. One against the motion's way is a spike."""
    t = np.arange(400) / 40
    y = 10 * np.abs(2 * ((t + 0.5) % 1) - 1)
    force = 2 * y + 0.5 * np.sin(3 * y)
    turn = int(np.argmax(y[20:60])) + 20
    y[turn + late] = 10.05
    peak, dip = force.copy(), force.copy()
    peak[turn] += 6
    dip[turn] -= 26
    assert not without_spikes(Record(t, y, peak)).done
    assert "1 spike in force_N" in without_spikes(Record(t, y, dip)).done[0]


@pytest.mark.parametrize("step", [0.19, 0.25, 0.3, 0.35, 0.55])
@pytest.mark.parametrize("backwards", [False, True])
def test_an_upper_yield_point_is_no_spike(step, backwards):
    """As of steel: the force rises to it along the elastic line, and drops to a level that it passed just before."""
    y = np.concatenate([np.arange(0, 8, step), np.arange(8, 5, -step)])
    force = np.minimum(y, 1.0)
    peak = int(np.argmax(y >= 1.35))
    force[: peak + 1] = y[: peak + 1]
    force[-int(3 / step) :] = force[-int(3 / step) - 1] - 0.5 * (8 - y[-int(3 / step) :])
    force = (force[::-1] if backwards else force) * 1800
    y = y[::-1] if backwards else y
    record = Record(np.arange(len(y)) / 10, y, force)
    assert not without_spikes(record).done
    # a glitch on the elastic line, or on the plateau, still is one
    for at in (1, peak + 6):
        glitch = force.copy()
        glitch[len(y) - 1 - at if backwards else at] += 6000
        assert "1 spike in force_N" in without_spikes(replace(record, force_N=glitch)).done[0]


@pytest.mark.parametrize("per_cycle", [16, 50, 400])
@pytest.mark.parametrize("loops", ["friction", "viscous", "impact", "noise"])
def test_no_loop_is_taken_for_spikes(per_cycle, loops):
    t = np.arange(20 * per_cycle) / per_cycle
    y, v = np.sin(2 * np.pi * t + 0.1), np.cos(2 * np.pi * t + 0.1)
    shapes = {
        "friction": y + np.sign(v), "viscous": y + v, "impact": y + 50 * np.maximum(y - 0.9, 0),
        "noise": y + v + np.random.default_rng(0).normal(0, 0.1, len(t)),
    }  # fmt: skip
    assert not without_spikes(Record(t, y, shapes[loops])).done


def test_rounded_stamps_are_counted_out_and_uneven_ones_put_on_a_grid():
    run = loop(0.5, 2.0)
    rounded = evened(Record(np.floor(run.time * 20) / 20, run.y, run.force))
    np.testing.assert_allclose(np.diff(rounded.record.time_s), 1 / RATE, rtol=0.02)
    assert rounded.record.force_N is run.force
    assert "rounded to 0.05 s" in rounded.done[0]
    kept = np.flatnonzero(np.random.default_rng(0).random(len(run.time)) > 0.3)
    uneven = evened(Record(run.time[kept], run.y[kept], run.force[kept]))
    assert "straight lines" in uneven.done[0]
    assert np.ptp(np.diff(uneven.record.time_s)) < 1e-6


@pytest.mark.parametrize(
    ("stems", "pattern", "first"),
    [
        (["A0.5_f3_T20", "A1_f1_T300"], "A{amplitude_mm}_f{frequency_Hz}_T{temperature_C}",
         {"amplitude_mm": 0.5, "frequency_Hz": 3.0, "temperature_C": 20.0}),
        (["c7 0,5mm 3Hz", "c7 1mm 1Hz"], "{amplitude_mm}mm {frequency_Hz}Hz", {"amplitude_mm": 0.5,
         "frequency_Hz": 3.0}),
        (["rod1_s1_n10_100psi", "rod1_s2_n10_50psi"], "_{pressure_psi}psi", {"pressure_psi": 100.0}),
        (["d_5mm_0.5A", "d_5mm_1A"], "d_{amplitude_mm}mm_{current_A}A", {"amplitude_mm": 5.0, "current_A": 0.5}),
        (["bush_01_A0.5_f3", "bush_02_A1_f1"], "A{amplitude_mm}_f{frequency_Hz}", {"amplitude_mm": 0.5,
         "frequency_Hz": 3.0}),
        (["1 C7 0.5 mm", "2 C7 1 mm"], "{amplitude_mm} mm", {"amplitude_mm": 0.5}),
        (["test_100psi_1", "test_100psi_2"], "", {}),
        (["joint_2c"], "", {}),
        (["joint_20C"], "joint_{temperature_C}C", {"temperature_C": 20.0}),
        (["joint_20c", "joint_40c"], "joint_{temperature_C}c", {"temperature_C": 20.0}),
        (["test_001", "test_002"], "", {}),
        (["A1_f1", "B1_f1"], "", {}),
        (["A1_f3", "A2_f3", "A1_f3_rep2"], "A{amplitude_mm}_f{frequency_Hz}", {"amplitude_mm": 1.0,
         "frequency_Hz": 3.0}),
        (["A1mm_5Hz W2", "A2mm_5Hz"], "A{amplitude_mm}mm_{frequency_Hz}Hz", {"amplitude_mm": 1.0,
         "frequency_Hz": 5.0}),
        (["T20_A1", "T40_sweep"], "T{temperature_C}", {"temperature_C": 20.0}),
        (["A1", "A1_f3", ""], "", {}),
    ],
)  # fmt: skip
def test_patterns_are_guessed(stems, pattern, first):
    assert guessed_pattern(stems) == pattern
    assert not pattern or Pattern(pattern).settings(stems[0]) == first


@pytest.mark.parametrize("stem", ["f{}_A{}", "f{}_A{}_T20", "f{} A{}in"])
def test_a_proposed_pattern_ends_with_its_last_field_where_the_next_number_means_nothing(stem):
    stems = [stem.format(1, 0.5), stem.format(3, 0.2)]
    pattern = guessed_pattern(stems, lambda column, values: column == "amplitude_mm")
    assert pattern == "f{frequency_Hz}"
    assert [Pattern(pattern).settings(one) for one in stems] == [{"frequency_Hz": 1.0}, {"frequency_Hz": 3.0}]


def test_a_proposed_pattern_ends_with_its_unit_and_not_with_what_only_counts():
    assert guessed_pattern(["A0.5_3Hz_rep1", "A0.2_5Hz_rep2"]) == "A{amplitude_mm}_{frequency_Hz}Hz"
    assert guessed_pattern(["f1_A0.5_rep1", "f3_A0.2_rep2"]) == "f{frequency_Hz}_A{amplitude_mm}"


def test_numbers_that_what_was_measured_contradicts_are_no_setting(tmp_path):
    """As a damper's dynamometer names its files: t1 is a trial, while a channel has the temperature."""
    for pressure in (50, 100):
        run = loop(0.005 * pressure, 2.0)
        rows = zip(run.time, run.y, run.force, strict=True)
        lines = ["Time (s),Displacement (mm),Force (N),Temperature (C)", *(f"{t},{y},{F},25.2" for t, y, F in rows)]
        (tmp_path / f"t1_3_18_s2_n10_{pressure}psi.csv").write_text("\n".join(lines))
    found = pc.import_files(sorted(tmp_path.glob("*.csv")), tmp_path / "c", dry_run=True)
    assert found.to_dict()["pattern"] == "_{pressure_psi}psi"


def test_a_patterns_units_count():
    found = Pattern("A{amplitude_um}_{specimen}_T{temperature_K}_I{current_A}").settings("A500_s1_T293.15_I0.5")
    assert found == {"amplitude_mm": 0.5, "specimen": "s1", "temperature_C": 20.0, "current_A": 0.5}
    for wrong in ("A{amplitude_kg}", "no field", "{temp}", "{amplitude_mm}{amplitude_um}"):
        with pytest.raises(UsageError, match="--pattern"):
            Pattern(wrong)


def export(path, *runs):
    """Runs one after the other in one file, a second of rest between them."""
    rest = np.zeros(round(RATE))
    y = np.concatenate([piece for run in runs for piece in (run.y, rest)])
    force = np.concatenate([piece for run in runs for piece in (run.force, rest)])
    path.write_text(text(Loop("all", 0, 0, 0, np.arange(len(y)) / RATE, y, force)))


def test_a_file_of_many_runs_becomes_runs_with_measured_settings(tmp_path):
    export(tmp_path / "day.csv", *(loop(A, f, cycles=8) for A in (0.3, 0.9) for f in (1.0, 4.0)))
    found = pc.import_files(tmp_path / "day.csv", tmp_path / "c")
    rows = found.to_dict()["runs"]
    assert [row["run"] for row in rows] == ["day_01", "day_02", "day_03", "day_04"]
    assert [row["frequency_Hz"] for row in rows] == pytest.approx([1, 4, 1, 4], rel=0.01)
    assert [row["amplitude_mm"] for row in rows] == pytest.approx([0.3, 0.3, 0.9, 0.9], rel=0.01)
    assert all("rest" in one["why"] for one in found.to_dict()["cut"])


@pytest.mark.parametrize("delay", [0.0, 0.001, -0.002])
def test_a_delay_that_all_runs_share_is_measured_told_and_kept(tmp_path, delay):
    for number, (A, f) in enumerate((A, f) for A in (0.3, 0.9) for f in (1.0, 3.0, 6.0)):
        (tmp_path / f"r{number}.csv").write_text(text(loop(A, f, seed=number, rate=1000.0, delay=delay)))
    found = pc.import_files(tmp_path, tmp_path / "c")
    if not delay:
        assert not found.notes
        return
    known = found.found.imported.delay
    assert known.delay_ms == pytest.approx(1e3 * delay, abs=0.05)
    late = "force" if delay > 0 else "displacement"
    assert f"the {late} is " in found.notes[0]
    assert "not taken off" in (tmp_path / "c" / "import.html").read_text(encoding="utf-8")
    read = pc.read_campaign(tmp_path / "c").tests.campaign.runs[0].record
    np.testing.assert_allclose(read.force_N, loop(0.3, 1.0, seed=0, rate=1000.0, delay=delay).force, atol=1e-3)


def test_clipped_cycles_are_cut_off_and_said(tmp_path):
    run = loop(0.9, 2.0, cycles=12)
    force = np.minimum(run.force + 40 * run.time, 1400.0)
    (tmp_path / "a.csv").write_text(text(replace(run, force=force)))
    found = pc.import_files(tmp_path / "a.csv", tmp_path / "c")
    (row,) = found.to_dict()["runs"]
    assert 4 <= row["cycles"] < 12
    assert "cycles are clipped and cut off" in row["done"][0]


def test_conditions_come_from_a_table_and_from_channels(tmp_path):
    run = loop()
    (tmp_path / "x.csv").write_text(text(run))
    (tmp_path / "set.csv").write_text("file;temperature_C;specimen\nx.csv;21,5;s7\n")
    pc.import_files(tmp_path / "x.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    (read,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert (read.setup.temperature_C, read.setup.specimen) == (21.5, "s7")
    lines = text(run, names="Time [s];Displacement [mm];Force [kN];Oil [K];Current [mA]").splitlines()
    content = "\n".join(line + (";300,15;250" if index > 3 else "") for index, line in enumerate(lines))
    (tmp_path / "y.csv").write_text(content)
    pc.import_files(tmp_path / "y.csv", tmp_path / "d", columns="current_A=Current [mA]")
    (read,) = pc.read_campaign(tmp_path / "d").tests.campaign.runs
    assert read.setup.temperature_C == pytest.approx(27.0)
    assert read.setup.conditions == pytest.approx({"current_A": 0.25})


@pytest.mark.parametrize(
    ("rows", "temperature", "amplitude"),
    [
        ("file,temperature_K,amplitude_um\nx.csv,300.15,500", 27.0, 0.5),
        ("File;Temperatur [°F];Amplitude (mm)\nx;80,6;0,5", 27.0, 0.5),
        ("run\tTemperature\tAmplitude\n\tK\tm\nx\t300.15\t0.0005", 27.0, 0.5),
    ],
)
def test_a_table_of_conditions_states_its_units_by_names_or_a_row(tmp_path, rows, temperature, amplitude):
    (tmp_path / "x.csv").write_text(text(loop()))
    (tmp_path / "set.csv").write_text(rows + "\n")
    pc.import_files(tmp_path / "x.csv", tmp_path / "c", conditions=tmp_path / "set.csv")
    (read,) = pc.read_campaign(tmp_path / "c").tests.campaign.runs
    assert (read.setup.temperature_C, read.amplitude_mm) == pytest.approx((temperature, amplitude))


def test_a_table_of_conditions_that_meets_no_run_is_told(tmp_path):
    (tmp_path / "x.csv").write_text(text(loop()))
    (tmp_path / "set.csv").write_text("file,temperature_C\nX1.csv,20\n")
    notes = pc.import_files(tmp_path / "x.csv", tmp_path / "c", conditions=tmp_path / "set.csv").notes
    assert "no run here is called, nor from a file that is called, 'X1.csv'" in notes[0]
    assert "says nothing of 1 of 1 runs: x" in notes[1]
    (tmp_path / "set.csv").write_text("file,temperature\nx.csv,20\n")
    with pytest.raises(UserError, match="expected 'temperature_C', or its unit behind it in brackets"):
        pc.import_files(tmp_path / "x.csv", tmp_path / "d", conditions=tmp_path / "set.csv")


def test_a_table_of_conditions_that_is_no_table_is_told(tmp_path):
    (tmp_path / "x.csv").write_text(text(loop()))
    (tmp_path / "set.csv").write_text('file,temperature_C\nx.csv,"' + 200_000 * "2")
    with pytest.raises(UserError, match=r"set\.csv, line 2: field larger than .*; expected a table of what was set"):
        pc.import_files(tmp_path / "x.csv", tmp_path / "c", conditions=tmp_path / "set.csv")


@pytest.mark.parametrize("name", ["run", "file", "motion"])
def test_no_channel_names_the_runs(tmp_path, name):
    (tmp_path / "x.csv").write_text(text(loop()))
    with pytest.raises(UsageError, match=f"got '{name}=Force'; expected .* a further condition: {name} is what an"):
        pc.import_files(tmp_path / "x.csv", tmp_path / "c", columns=f"{name}=Force")


def test_a_campaign_isnt_replaced_below_who_stands_in_it(tmp_path, monkeypatch):
    for name in ("x", "y"):
        (tmp_path / f"{name}.csv").write_text(text(loop(0.5 if name == "x" else 0.6)))
    pc.import_files(tmp_path / "x.csv", tmp_path / "c")
    monkeypatch.chdir(tmp_path / "c" / "runs")
    for folder in (tmp_path / "c", ".."):
        with pytest.raises(
            UserError, match=r"the command was called in it; expected it from outside: cd .*, then -o c"
        ):
            pc.import_files(tmp_path / "y.csv", folder)
    monkeypatch.chdir(tmp_path / "c")
    with pytest.raises(UserError, match="called in it"):
        pc.import_files(tmp_path / "y.csv", ".")
    assert (
        "1 run of 1 file (nothing is written)" in pc.import_files(tmp_path / "y.csv", ".", dry_run=True).view().lines[0]
    )
    assert len(pc.read_campaign(".")) == 1


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file() and path.name != "import.html"}


def test_several_processes_and_pieces_of_a_file_make_the_same_campaign(tmp_path, monkeypatch):
    folder = tmp_path / "exports"
    folder.mkdir()
    export(folder / "day.csv", *(loop(A, 4.0, cycles=8) for A in (0.3, 0.9)))
    for number, frequency in enumerate((1.0, 3.0)):
        (folder / f"r{number}.csv").write_text(text(loop(0.5, frequency, seed=number)))
    pc.import_files(folder, tmp_path / "a", name="c")
    monkeypatch.setattr(taking, "cores", lambda: 2)
    monkeypatch.setattr(taking, "WORTH_PROCESSES", 0)
    pc.import_files(folder, tmp_path / "b", name="c")
    monkeypatch.setattr(taking, "LARGE", 0)
    pc.import_files(folder, tmp_path / "d", name="c")
    assert contents(tmp_path / "a") == contents(tmp_path / "b") == contents(tmp_path / "d")
    (folder / "s.csv").write_text("no table")
    with pytest.raises(UserError, match=r"s\.csv: holds no table"):
        pc.import_files(folder, tmp_path / "e")
    assert not (tmp_path / "e").exists()


@pytest.mark.parametrize("format", ["parquet", "csv.gz"])
@pytest.mark.parametrize(
    ("offsets", "answers", "left"),
    [
        # one zero for all: what the means differ by may be real
        ((250.0, 250.3), False, (-0.15, 0.15)),
        ((250.0, 190.0), False, (0.0, 0.0)),
        # a spring that is held off its rest, and a mean within twice the amplitude
        ((5.0, 5.0), True, (5.0, 5.0)),
        ((0.9, 0.9), False, (0.9, 0.9)),
    ],
)
def test_an_absolute_position_is_told_from_a_mean_displacement(tmp_path, offsets, answers, left, format):
    for place, (run, offset) in enumerate(zip((loop(0.5), loop(0.3)), offsets, strict=True)):
        moved = replace(run, y=run.y + offset, force=run.force + (1200 * offset if answers else 40.0))
        (tmp_path / f"{place}.csv").write_text(text(moved))
    found = pc.import_files(sorted(tmp_path.glob("*.csv")), tmp_path / "c", format=format)
    records = [run.record for run in pc.read_campaign(tmp_path / "c").tests.campaign.runs]
    assert [np.mean(one.displacement_mm) for one in records] == pytest.approx(left, abs=1e-3)
    assert any("is taken off, for no mean force answers it" in note for note in found.notes) == (left != offsets)


def test_a_zero_that_was_set_between_two_imports_is_taken_off_the_runs_before(tmp_path):
    for place, (run, offset) in enumerate(((loop(0.5), 250.0), (loop(0.3), 0.0))):
        (tmp_path / f"{place}.csv").write_text(text(replace(run, y=run.y + offset)))
        found = pc.import_files([tmp_path / f"{place}.csv"], tmp_path / "c")
    assert any("a mean of 250 mm is taken off in 1 of 2 runs" in note for note in found.notes)
    records = [run.record for run in pc.read_campaign(tmp_path / "c").tests.campaign.runs]
    assert [np.mean(one.displacement_mm) for one in records] == pytest.approx([0.0, 0.0], abs=1e-3)


def grown(amplitudes, step=0.1, beyond=0.37):
    """A program of one cycle a step, at one speed and sampled coarsely; and a counter of its cycles."""
    way = np.concatenate([[0.0], *[[a, -a, 0.0] for a in amplitudes]])
    gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(way)))])
    path = step * (np.arange(int(gone[-1] / step)) + beyond)
    y = np.interp(path, gone, way)
    rising = np.interp(path + 0.01, gone, way) > y
    return y, 500 * y + np.where(rising, 80.0, -80.0), np.floor(np.searchsorted(gone, path, side="right") - 1) // 3


def test_a_stated_column_parts_a_program_of_one_cycle_a_step(tmp_path):
    """A steel damper's test had stayed one free motion, and the column that was stated had done nothing."""
    y, force, cycle = grown([1.0, 1.4, 2.0, 2.8, 4.0])
    rows = [f"{a:.5f},{b:.3f},{c:g},{row}" for row, (a, b, c) in enumerate(zip(y, force, cycle, strict=True))]
    (tmp_path / "steps.csv").write_text("\n".join(["Displacement [mm],Force [N],Cycle,Row", *rows]))
    whole = pc.import_files(tmp_path / "steps.csv", tmp_path / "whole", rate=10)
    assert not whole.found.judged.sines
    with pytest.raises(UserError, match="segment=each-cycle` makes each cycle of a program a run"):
        pc.identify(pc.read_campaign(tmp_path / "whole"))
    found = pc.import_files(tmp_path / "steps.csv", tmp_path / "c", columns="segment=Cycle", rate="none")
    runs = found.found.judged.sines
    assert len(runs) == 5 and all(run.cycles.count == 1 for run in runs.values())
    with pytest.raises(
        UserError, match=r"steps\.csv.*--columns segment: it changes \d+ times in \d+ samples; expected"
    ):
        pc.import_files(tmp_path / "steps.csv", tmp_path / "f", columns="segment=Row", rate="none")
    # a counter that nobody stated tells none apart, as before
    assert len(parts(*[sine(0.5, 2, 8), sine(0.5, 2, 8)], segment=np.arange(1600) // 100.0).runs) == 1


@pytest.mark.parametrize("seed", range(3))
def test_a_cycle_that_was_cut_out_by_a_counter_is_whole(seed):
    """Of 40 samples at uneven steps, the last of which goes on into the next cycle."""
    steps = np.random.default_rng(seed).uniform(0.3, 1.2, 40)
    steps[[0, 1, -2, -1]] = 2.0
    path = (np.cumsum(steps) - steps[0]) / np.sum(steps) * 4
    y = np.interp(path, [0, 1, 3, 4], [0, 1, -1, 0])
    force = 500 * y + np.where((path < 1) | (path > 3), 80.0, -80.0)
    cycles = find_cycles(Record(0.1 * np.arange(40), y, force))
    assert cycles.count == 1 and cycles.frequency_Hz == pytest.approx(1 / 4.0, rel=0.01)
    with pytest.raises(UnusableRecord, match="no full cycle"):
        find_cycles(Record(0.1 * np.arange(36), y[:36], force[:36]))


@pytest.mark.parametrize(("level", "told"), [("switched", True), ("steady", False), ("off", False)])
def test_a_condition_that_moves_within_a_run_is_told(tmp_path, level, told):
    """A voltage that was switched while the damper moved had become a condition by its mean, without a word."""
    rng = np.random.default_rng(5)
    time = np.arange(1600) / 200
    y = 0.5 * np.sin(2 * np.pi * 2 * time)
    levels = {"switched": 2.25 * (time % 1.3 > 0.7), "steady": np.full(1600, 2.25), "off": np.zeros(1600)}
    voltage = levels[level] + rng.normal(0, 0.01, 1600)
    rows = [
        "t [s],y [mm],F [N],U [V]",
        *(f"{a},{b:.6f},{900 * b:.5f},{u:.5f}" for a, b, u in zip(time, y, voltage, strict=True)),
    ]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    (run,) = pc.import_files(tmp_path / "a.csv", tmp_path / "c", columns="voltage_V=U [V]").to_dict()["runs"]
    assert any("voltage_V moves from" in words for words in run["done"]) is told


@pytest.mark.parametrize("seed", range(6))
def test_a_motion_that_noise_drives_is_free(tmp_path, seed):
    """The one cycle of it that came nearest to a sine had been a run of its own amplitude and frequency."""
    window = np.hanning(60)
    y = np.convolve(np.random.default_rng(seed).normal(size=1059), window, mode="valid") / 5
    rows = ["t [s],y [mm],F [N]", *(f"{n / 200},{b:.6f},{900 * b:.5f}" for n, b in enumerate(y))]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    (run,) = pc.import_files(tmp_path / "a.csv", tmp_path / "c").to_dict()["runs"]
    assert run["cycles"] is None and "it is free" in " ".join(run["done"])


def test_a_program_that_grows_with_each_cycle_is_no_noise():
    time = np.arange(4000) / 200
    assert not irregular(np.repeat(1.5 ** np.arange(20), 200) * np.sin(2 * np.pi * time))
    assert not irregular(np.exp(-time / 3) * np.sin(2 * np.pi * time))
