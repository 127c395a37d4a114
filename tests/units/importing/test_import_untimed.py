"""Tests without a time: the mark of their campaign, what it is told by, and that no effect of time is asked."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from exports import loop

import pipeclamp as pc
from pipeclamp.studio.commands import import_task
from pipeclamp_fmu.contents.clamp_of_law import clamp_model
from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.seen import seen_sine
from pipeclamp_identification.campaign.writing import WrittenRun, joined_runs, write_campaign
from pipeclamp_identification.diagnosis.screen import candidate_names
from pipeclamp_identification.discovery.discover import terms_asked
from pipeclamp_identification.importing.samples.untimed import laid_out
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.metrics_only.writing import as_metrics, metric_files
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.files import write_folder
from pipeclamp_models.law.catalogue import find_effect
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.motion import sinusoids

AMPLITUDES = (0.4, 0.8, 1.2, 1.6, 2.0)
OF_TIME = {
    "delay", "inertia", "inner_mass", "oil_damper", "quadratic_damping", "relaxation", "relaxation_spread",
    "rounded_friction", "slip_speed", "stiffness_frequency", "stribeck", "viscous",
}  # fmt: skip


def table(path, amplitude, *, step=0.02, times=None):
    """Write a quasi-static test: steps of equal length, so that large loops take longer, of a spring with friction."""
    count = round(4 * amplitude / step)
    phase = np.arange(4 * count) / count
    y = amplitude * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * phase))
    force = 900 * y + 150 * np.sign(np.gradient(y)) + np.random.default_rng(1).normal(0, 2, len(y))
    columns = {"Displacement [mm]": y, "Force [N]": force}
    if times is not None:
        columns = {"Time [s]": np.arange(len(y)) * times, **columns}
    rows = [",".join(columns), *(",".join(f"{x:.5f}" for x in row) for row in zip(*columns.values(), strict=True))]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.fixture
def files(tmp_path):
    return [table(tmp_path / f"step{number}.csv", a) for number, a in enumerate(AMPLITUDES)]


def test_no_pattern_states_a_frequency_where_time_was_not_measured(tmp_path):
    """It had been proposed beside --rate none, which then said that the frequency isn't used."""
    files = [table(tmp_path / f"F{number}_A{a}.csv", a) for number, a in enumerate(AMPLITUDES, 1)]
    assert pc.import_files(files, tmp_path / "c", rate="none", dry_run=True).to_dict()["pattern"] == "A{amplitude_mm}"
    files = [table(tmp_path / f"F{number}.csv", a) for number, a in enumerate(AMPLITUDES, 1)]
    assert pc.import_files(files, tmp_path / "c", rate="none", dry_run=True).to_dict()["pattern"] == ""


def slip_curve(amplitude, count, seed, close=True):
    """A loop of a spring with friction as a picture has it: so many points, unevenly, from rest upwards and round."""
    steps = np.random.default_rng(seed).uniform(0.2, 1.8, count)
    way = np.cumsum(steps) - steps[0]
    way *= 4 * amplitude / (way[-1] if close else way[-1] + steps[0])
    y = np.interp(way, np.array([0, 1, 3, 4]) * amplitude, np.array([0, 1, -1, 0]) * amplitude)
    rising = (way < amplitude) | (way >= 3 * amplitude)
    return y, 900 * y + np.where(rising, 150.0, -150.0)


@pytest.mark.parametrize("close", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_a_curve_without_a_time_is_laid_out_over_a_sine(seed, close):
    """Points of a picture taken for samples of a motion had given amplitudes a tenth too small, and jagged motions."""
    y, force = slip_curve(2.0, 24, seed, close)
    laid = laid_out(Record(0.01 * np.arange(len(y)), y, force)).record
    cycles = find_cycles(laid)
    assert cycles.count == 1 and cycles.frequency_Hz == pytest.approx(1.0, rel=2e-3)
    shown = seen_sine(laid, cycles).shown
    peak = (np.max(y) - np.min(y)) / 2
    assert shown.amplitude_mm == pytest.approx(peak, rel=5e-3)
    # on the curve, wherever it is drawn as a line
    rising = np.gradient(laid.displacement_mm) > 0
    inner = np.abs(laid.displacement_mm) < 0.7 * peak
    off = laid.force_N - 900 * laid.displacement_mm - np.where(rising, 150.0, -150.0)
    assert np.max(np.abs(off[inner])) < 1e-6 * 900


def test_a_curve_without_a_time_is_the_same_however_close_its_points_lie():
    few, many = (slip_curve(2.0, count, 0) for count in (200, 400))
    found = []
    for y, force in (few, many):
        laid = laid_out(Record(0.01 * np.arange(len(y)), y, force)).record
        found.append(seen_sine(laid, find_cycles(laid)).shown)
    assert found[0].amplitude_mm == pytest.approx(found[1].amplitude_mm, rel=2e-3)
    assert abs(found[0].stiffness - found[1].stiffness) < 2e-2 * abs(found[1].stiffness)


def test_a_level_of_force_in_a_picture_is_no_clipped_sensor(tmp_path):
    y, force = slip_curve(2.0, 40, 1)
    flat = np.clip(force, -1750, 1750)  # two points or three at one force
    rows = [f"{a:.4f},{b:.2f}" for a, b in zip(y, flat, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["Displacement [mm],Force [N]", *rows]))
    pc.import_files(tmp_path / "a.csv", tmp_path / "c", rate="none")
    assert [run.cycles.count for run in read_campaign(tmp_path / "c").runs] == [1]


def up_and_back(path, count, back=0.0):
    """Write a curve of loading and unloading once, with so many points a way, back to a share of the way up."""
    y = np.concatenate([np.linspace(0, 2, count), np.linspace(2, 2 * back, count)[1:]])
    rows = [f"{a:.4f},{900 * a + (150 if i < count else -150):.2f}" for i, a in enumerate(y)]
    path.write_text("\n".join(["Displacement [mm],Force [N]", *rows]))
    return path


def test_loading_and_unloading_once_without_a_time_are_a_cycle_of_one_second(tmp_path):
    """They had been a sine of as many hertz as their samples made, then a free motion that no law is fitted to."""
    found = pc.import_files(up_and_back(tmp_path / "a.csv", 12), tmp_path / "c", rate="none")
    (run,) = found.to_dict()["runs"]
    assert (run["amplitude_mm"], run["frequency_Hz"]) == pytest.approx((1.0, 1.0), rel=1e-6)
    law = pc.identify(found.tests())
    assert pc.compare(law, found.tests()).nrmse < 0.05
    assert law.file.data.about_mm == pytest.approx(1.0, rel=1e-3) and "about 1 mm" in str(law)


def test_a_way_that_doesn_t_come_back_without_a_time_is_no_cycle(tmp_path):
    found = pc.import_files(up_and_back(tmp_path / "a.csv", 12, 0.2), tmp_path / "c", rate="none")
    (run,) = found.to_dict()["runs"]
    assert "its motion is no sine (without a time, it takes two turns within it to tell a cycle" in str(run)
    assert "free" in (tmp_path / "c" / "runs.csv").read_text()


def growing(path, amplitudes, count=24):
    """Write the curve of a spring with friction through cycles from rest, of amplitudes that follow each other."""
    phase = np.arange(count) / count
    y = np.concatenate([a * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * phase)) for a in amplitudes])
    force = 900 * y + 150 * np.sign(np.gradient(y))
    path.write_text("\n".join(["Displacement [mm],Force [N]", *(f"{a},{b}" for a, b in zip(y, force, strict=True))]))
    return path


def test_cycles_without_a_time_have_one_frequency_however_their_amplitudes_follow_each_other(tmp_path):
    """Of a run of unlike cycles 0.97 Hz had been found, beside 1 Hz, and exponents of the frequency been fitted."""
    programs = (0.6, 1.0), (1.4, 2.0), (2.4,)
    files = [growing(tmp_path / f"{number}.csv", amplitudes) for number, amplitudes in enumerate(programs)]
    found = pc.import_files(files, tmp_path / "c", rate="none")
    assert [run["frequency_Hz"] for run in found.to_dict()["runs"]] == pytest.approx([1.0] * 3, rel=1e-9)
    states = pc.identify(found.tests()).file.coefficients
    assert (states["c_f"].state, states["alpha_f"].state) == ("frozen", "frozen")


def test_no_frequency_lies_outside_a_laws_range_where_no_time_was_measured(tmp_path):
    """ "For 99% of the time the tracked f lies outside the law's range, 1 to 1 Hz" had been said of such a motion."""
    files = [growing(tmp_path / f"{a}.csv", (a,)) for a in (0.6, 1.0, 2.0)]
    law = pc.identify(pc.import_files(files, tmp_path / "c", rate="none").tests())
    y = np.cumsum(np.random.default_rng(3).normal(0, 0.1, 300))
    rows = (f"{a},{900 * a}" for a in 1.5 * y / np.max(np.abs(y)))
    (tmp_path / "walk.csv").write_text("\n".join(["Displacement [mm],Force [N]", *rows]))
    free = pc.import_files(tmp_path / "walk.csv", tmp_path / "f", rate="none")
    told = pc.compare(law, free.tests())
    assert "the tracked f" not in str(told) and "f for " not in str(told)


def test_tests_without_a_time_are_marked_and_told(tmp_path, files):
    found = pc.import_files(files, tmp_path / "c", rate="none")
    assert any("time was not measured" in words for words in found.notes)
    assert "frequency_Hz" not in (tmp_path / "c" / "runs.csv").read_text()
    tests = pc.read_campaign(tmp_path / "c")
    assert any("time was not measured" in words for words in tests.remarks)
    campaign = read_campaign(tmp_path / "c")
    assert not campaign.time_measured
    assert [run.cycles.frequency_Hz for run in campaign.runs] == pytest.approx([1.0] * len(AMPLITUDES), rel=1e-3)
    law = pc.identify(tests)
    assert law.file.data.time_measured is False
    assert "time was not measured" in str(law)
    assert any("time of its tests was not measured" in one for one in clamp_model(law.file).notes)
    assert law.file.coefficients["c_f"].state == "frozen"  # there is but one frequency


@pytest.mark.parametrize("rate", [50, "50"])
def test_a_logger_of_known_rate_measures_time(tmp_path, files, rate):
    pc.import_files(files, tmp_path / "c", rate=rate)
    campaign = read_campaign(tmp_path / "c")
    assert campaign.time_measured and "time_measured" not in (tmp_path / "c" / "campaign.toml").read_text()
    frequencies = [run.cycles.frequency_Hz for run in campaign.runs]
    assert frequencies == pytest.approx([50 * 0.02 / (4 * a) for a in AMPLITUDES], rel=1e-2)
    assert pc.identify(pc.read_campaign(tmp_path / "c")).file.data.time_measured is None


def test_who_lacks_a_time_is_told_both_ways(tmp_path, files):
    with pytest.raises(UserError, match=r"--rate 1000.*--rate none where time was not measured"):
        pc.import_files(files, tmp_path / "c")
    with pytest.raises(UsageError, match="got never; expected samples per second, above 0, or none"):
        pc.import_files(files, tmp_path / "c", rate="never")
    with pytest.raises(UsageError, match="--rate none"):
        pc.import_files(files, tmp_path / "c", columns="time=none")


def test_who_has_a_curve_without_names_is_told_both_ways_too(tmp_path):
    path = tmp_path / "curve.txt"
    path.write_text("".join(f"{x:g}, {3 * x:g}\n" for x in [*range(20), *range(20, -1, -1)]))
    with pytest.raises(
        UserError, match=r"force=column 2 \[N\].*--rate 1000[^$]*--rate none where time was not measured"
    ):
        pc.import_files(path, tmp_path / "c")


def test_a_curve_without_a_time_begins_in_no_motion(tmp_path):
    """Of one that isn't closed, and so is free, it had been told that it begins in motion."""
    path = tmp_path / "curve.csv"
    path.write_text("displacement_mm,force_N\n" + "".join(f"{x:g},{3 * x:g}\n" for x in [*range(9), *range(9, 3, -1)]))
    found = pc.import_files(path, tmp_path / "c", rate="none")
    assert "one way up and back, within 2%: of its two ways one is 56% of the other" in str(found.to_dict()["runs"])
    assert not any("in motion" in words for words in read_campaign(tmp_path / "c").remarks)


def test_a_frequency_that_is_stated_beside_no_time_is_not_used(tmp_path, files):
    settings = "file,frequency_Hz\n" + "".join(f"{file.name},0.01\n" for file in files)
    (tmp_path / "set.csv").write_text(settings)
    found = pc.import_files(files, tmp_path / "c", rate="none", conditions=tmp_path / "set.csv")
    assert any("state the samples per second in place of --rate none" in words for words in found.notes)
    assert read_campaign(tmp_path / "c").runs[0].frequency_Hz is None


def test_a_file_with_a_time_keeps_it_and_is_not_marked(tmp_path):
    pc.import_files(table(tmp_path / "a.csv", 0.8, times=0.05), tmp_path / "c", rate="none")
    campaign = read_campaign(tmp_path / "c")
    assert campaign.time_measured
    assert campaign.runs[0].cycles.frequency_Hz == pytest.approx(1 / (160 * 0.05), rel=1e-2)


def test_tests_without_a_time_don_t_join_others(tmp_path, files):
    pc.import_files(table(tmp_path / "a.csv", 0.8, times=0.05), tmp_path / "timed")
    with pytest.raises(UserError, match=r"step0.csv: its time was not measured.*expected another campaign"):
        pc.import_files(files, tmp_path / "timed", rate="none")
    pc.import_files(files[:2], tmp_path / "c", rate="none")
    pc.import_files(files, tmp_path / "c", rate="none")  # one more
    assert not read_campaign(tmp_path / "c").time_measured
    with pytest.raises(UserError, match="the time of c was not measured, that of others was"):
        list(joined_runs([read_campaign(tmp_path / name) for name in ("timed", "c")]))


def test_the_studio_takes_such_tests_too(tmp_path):
    def task(rate):
        return import_task(tmp_path / "files", tmp_path / "c", {"rate": rate}, skip_unusable=False, dry_run=True)

    assert (task("none").given["rate"], task("50").given["rate"]) == ("none", 50.0)
    with pytest.raises(UserError, match="expected a number, such as 1000, or none where time was not measured"):
        task("fast")


def test_the_mark_goes_on_to_metrics(tmp_path, files):
    pc.import_files(files, tmp_path / "c", rate="none")
    campaign = read_campaign(tmp_path / "c")
    write_folder(tmp_path / "m", metric_files(as_metrics(campaign, loops_of(campaign))))
    tests = pc.read_campaign(tmp_path / "m")
    assert any("time was not measured" in words for words in tests.remarks)
    assert pc.identify(tests).file.data.time_measured is False


def test_no_effect_of_time_is_asked_where_none_was_measured():
    timed, untimed = (candidate_names(Structure("power"), (), time_measured=known) for known in (True, False))
    assert set(timed) - set(untimed) == OF_TIME
    # whose time is a part of it alone, or which are of cycles and of a direction, stay
    assert {"unilateral_contact", "loosening", "directional_damping", "memory", "coulomb"} <= set(untimed)
    assert find_effect("relaxation").is_of_time and not find_effect("cubic_stiffness").is_of_time


def test_a_diagnosis_asks_no_effect_of_time(tmp_path):
    """Of viscous loops at one cycle a second `viscous` would be asked; where that second is none, it isn't."""
    asked = {}
    for known in (True, False):
        runs = []
        for number, amplitude in enumerate((0.2, 0.4, 0.8, 1.2, 1.6, 2.0)):
            made = loop(amplitude, 1.0, seed=number)
            record = Record(made.time, made.y, made.force)
            runs.append(WrittenRun({"run": f"A{amplitude}", "temperature_C": 20.0}, record))
        write_campaign(tmp_path / f"c{known}", iter(runs), name="c", notes="", time_measured=known)
        tests = pc.read_campaign(tmp_path / f"c{known}")
        answer = pc.diagnose(pc.identify(tests), tests).to_dict()
        asked[known] = {one["effect"] for one in answer["candidates"]} | set(answer["screened_out"])
    assert asked[True] & OF_TIME
    assert not asked[False] & OF_TIME


def test_no_term_of_time_is_proposed_where_none_was_measured():
    def asked(known):
        loops = SimpleNamespace(time_measured=known, conditions={})
        A = np.array([0.4, 0.8, 1.6])
        motion = sinusoids(A, np.ones_like(A), np.full_like(A, 293.15), 64)
        problem = SimpleNamespace(loops=loops, observations=SimpleNamespace(motion=motion))
        return {term.declaration.id for term in terms_asked(problem)}

    gone = asked(True) - asked(False)
    assert {"found_viscous_damping", "found_square_damping", "found_relaxing_1", "found_slip_by_speed"} <= gone
    of_the_way = {name for name in gone if name.startswith(("found_slip", "found_dry_damping"))}
    assert all(name.endswith("_speed") for name in of_the_way)
    assert {"found_slip", "found_dry_damping"} <= asked(False)
