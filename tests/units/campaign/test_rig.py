"""The virtual rig: what it writes is what was asked for, and the same again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.drive import Drive, DrivePlan, Profile, drive_content, read_drive
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.plan import driven
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.rig.truth import truth_of
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.fitting.misfit import misfits, overall_nrmse
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.catalogue import entries, find_effect
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import bare_for

Plan.__test__ = False  # type: ignore[attr-defined]  # a plan of tests, no test
PLAN = Plan(amplitudes=(0.3, 0.9), frequencies=(2.0,), temperatures=(20.0, 250.0), rate=400.0)
QUIET = replace(
    PLAN, force_noise=0.0, displacement_noise=0.0, force_step=0.0, displacement_step=0.0, distortion=0.0,
    amplitude_error=0.0, temperature_error=0.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def truth():
    return law_of(open_law("emwm2"))


def test_a_fast_drive_is_told_without_powers_of_ten():
    assert DrivePlan(Profile("sine", ((1, 1.0),)), 50.0, 8.0).words().endswith("at most 50 mm, 8 Hz, 2510 mm/s")


def test_the_same_seed_gives_the_same_campaign(truth):
    one, again, other = (list(virtual_runs(truth, replace(PLAN, seed=seed))) for seed in (1, 1, 2))
    for left, right, different in zip(one, again, other, strict=True):
        np.testing.assert_array_equal(left.record.force_N, right.record.force_N)
        assert np.any(left.record.force_N != different.record.force_N)


def test_a_run_doesnt_change_with_what_else_is_run(truth):
    """Its random numbers are its own: a plan with more conditions keeps the runs that it had."""
    more = replace(PLAN, amplitudes=(0.3, 0.6, 0.9), temperatures=(20.0, 100.0, 250.0))
    kept = {run.row["run"]: run for run in virtual_runs(truth, more)}
    for run in virtual_runs(truth, PLAN):
        np.testing.assert_allclose(kept[run.row["run"]].record.force_N, run.record.force_N, rtol=1e-12)


def test_noise_and_quantisation_are_those_asked_for(truth):
    noisy = replace(QUIET, force_noise=5.0, force_step=0.5, displacement_step=0.001, cycles=40.0)
    for run, quiet in zip(virtual_runs(truth, noisy), virtual_runs(truth, replace(QUIET, cycles=40.0)), strict=True):
        np.testing.assert_allclose(run.record.force_N / 0.5, np.round(run.record.force_N / 0.5), atol=1e-6)
        assert np.std(run.record.force_N - quiet.record.force_N) == pytest.approx(5.0, rel=0.05)
        assert np.max(np.abs(run.record.displacement_mm - quiet.record.displacement_mm)) <= 0.0005 * (1 + 1e-9)


def test_the_ramp_grows_into_the_motion(truth):
    (first, *_) = virtual_runs(truth, replace(QUIET, ramp_cycles=2.0))
    per_cycle = round(400.0 / 2.0)
    assert np.max(np.abs(first.record.displacement_mm[: per_cycle // 8])) < 0.02
    assert np.max(np.abs(first.record.displacement_mm[2 * per_cycle :])) == pytest.approx(0.3, rel=1e-3)
    assert len(first.record.time_s) == 7 * per_cycle


def test_the_distortion_is_the_third_harmonic_asked_for(truth, tmp_path):
    write_campaign(tmp_path / "v", virtual_runs(truth, replace(QUIET, distortion=0.02)), name="v", notes="")
    loops = loops_of(read_campaign(tmp_path / "v"))
    np.testing.assert_allclose(np.abs(loops.displacement[:, 3]), 0.02 * loops.amplitude_mm, rtol=1e-3)


@pytest.mark.parametrize("name", ['quotes " and \\ backslash', "several\r\nlines\x07\x7f", "°C, µm, 夹"])
def test_any_name_and_notes_survive(truth, tmp_path, name):
    write_campaign(tmp_path / "v", virtual_runs(truth, QUIET), name=name, notes=name)
    tests = read_campaign(tmp_path / "v")
    assert (tests.name, tests.notes) == (name, name)


def test_a_campaign_that_breaks_off_leaves_nothing(truth, tmp_path):
    def breaking():
        yield next(virtual_runs(truth, QUIET))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_campaign(tmp_path / "v", breaking(), name="v", notes="")
    assert list(tmp_path.iterdir()) == []


FOLLOWED = tuple(f"{letter}_u_current_A{order}" for letter in "kcz" for order in (1, 2))
NEW = {"c1": 1.0, "k_rho": 2.0, "c_rho": 1.0}


@pytest.mark.parametrize(
    ("effects", "values", "words"),
    [
        ([], {"k99": 1.0}, "k99 is no parameter"),
        (["memory"], {"k_S": 1.0}, r"did you mean 'k_s'\? it has .*k_s \(N/mm\), z_s \(N\)"),
        (["viscous", "density"], {**NEW, "current_A": 1.0}, r"it has .*density_g_cm3"),
        (["viscous"], {"c1": -1.0}, r"c1 = -1 N s/mm \(viscous coefficient\); expected at least 0"),
        (["directional_damping"], {"d": 3.0}, r"d = 3 - .*; expected -0.9 to 0.9"),
        (["condition:current_A"], {}, "the law depends on current_A; state a value for each: --set current_A="),
        (["viscus"], {}, "did you mean 'viscous'"),
    ],
)
def test_what_the_law_cant_be_given_is_refused(effects, values, words):
    with pytest.raises(UserError, match=words):
        truth_of(open_law("emwm2"), effects, values, PLAN)


def test_values_that_are_set_are_taken():
    truth = truth_of(open_law("emwm2"), ["viscous", "density"], {**NEW, "density_g_cm3": 2.0}, PLAN)
    assert truth.law.values["c1"] == 1.0
    assert truth.conditions == {"density_g_cm3": 2.0}
    assert truth.whence == dict.fromkeys(NEW, "--set")


SHOWN = [name for name, entry in entries().items() if getattr(entry, "default", "") is not None]


@pytest.mark.parametrize("name", [name for name in SHOWN if find_effect(name).part != "base"])
def test_every_effect_has_a_typical_size_that_shows_and_is_no_other_clamp(name):
    """It changes the force by between 0.05 % and 30 % of its rms value."""
    conditions = {"density_g_cm3": 2.35} if name == "density" else {}
    file = open_law("published_R1")
    plan = replace(QUIET, cycles=20.0)
    bare = bare_for(find_effect(name))
    needs = ["memory"] if bare.base == "memory" else list(bare.effects)
    found = truth_of(file, [*needs, name], conditions, plan)
    assert set(found.whence.values()) == {"typical size"}
    bare = truth_of(file, needs, {}, plan).law if needs else law_of(file)
    pairs = zip(virtual_runs(found.law, plan, conditions), virtual_runs(bare, plan), strict=True)
    forces = [(one.record.force_N, other.record.force_N) for one, other in pairs]
    change = np.sqrt(sum(np.sum((with_effect - without) ** 2) for with_effect, without in forces))
    force = np.sqrt(sum(np.sum(without**2) for _, without in forces))
    assert 5e-4 < change / force < 0.3


def test_a_law_that_needs_a_condition_is_told_so():
    law = truth_of(open_law("emwm2"), ["density"], {"k_rho": 2.0, "c_rho": 1.0}, PLAN).law
    with pytest.raises(UserError, match="density_g_cm3"):
        next(virtual_runs(law, QUIET))


def test_conditions_stand_in_their_columns(tmp_path):
    """A virtual campaign is read back with the conditions that it was run under, under which its law holds."""
    file = open_law("emwm2")
    values = {"k_rho": 3.0, "c_rho": 1.0, "density_g_cm3": 2.5, **dict.fromkeys(FOLLOWED, 0.1), "current_A": 1.5}
    truth = truth_of(file, ["density", "condition:current_A"], values, PLAN)
    law, conditions = truth.law, truth.conditions
    write_campaign(tmp_path / "v", virtual_runs(law, QUIET, conditions), name="v", notes="")
    campaign = read_campaign(tmp_path / "v")
    assert {run.setup.density_g_cm3 for run in campaign.runs} == {2.5}
    assert {run.setup.conditions["current_A"] for run in campaign.runs} == {1.5}
    assert overall_nrmse(misfits(law, campaign, loops_of(campaign))) < 2e-3


SINE = Profile("a sine test", ((1, 1.0),))


def test_a_drive_signal_is_followed(truth, tmp_path):
    """From a file, as a machine would, at another rate: the loops are those of the motion that it states."""
    path = tmp_path / "drive.csv"
    path.write_bytes(drive_content(DrivePlan(SINE, 0.5, 2.0).signal(), path))
    plan = driven(replace(QUIET, temperatures=(20.0,), rate=400.0), read_drive(path))
    (run,) = virtual_runs(truth, plan)
    assert run.row["run"] == "A0p5_f2_T20"
    assert len(run.record.time_s) == 10 * 200
    np.testing.assert_allclose(
        run.record.displacement_mm, np.interp(run.record.time_s, *vars(read_drive(path)).values()), atol=2e-4
    )
    write_campaign(tmp_path / "driven", virtual_runs(truth, plan), name="driven", notes="")
    steady = replace(QUIET, amplitudes=(0.5,), frequencies=(2.0,), temperatures=(20.0,))
    write_campaign(tmp_path / "steady", virtual_runs(truth, steady), name="steady", notes="")
    one, other = (loops_of(read_campaign(tmp_path / name)) for name in ("driven", "steady"))
    np.testing.assert_allclose(one.force[0, :8], other.force[0, :8], atol=0.5)


def test_repeats_differ_and_the_first_is_the_one_run(truth):
    plan = replace(PLAN, amplitudes=(0.3,), temperatures=(20.0,))
    (once,) = virtual_runs(truth, plan)
    first, second = virtual_runs(truth, replace(plan, repeats=2))
    np.testing.assert_array_equal(first.record.force_N, once.record.force_N)
    assert np.any(second.record.force_N != once.record.force_N)
    assert (first.row["run"], second.row["run"]) == ("A0p3_f2_T20_1", "A0p3_f2_T20_2")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time_s,force_N\n0,0\n", "no column 'displacement_mm'"),
        ("time_s,displacement_mm\n0,0\n0.1,1\n", "2 samples; expected at least"),
        ("time_s,displacement_mm\n" + "".join(f"{k},1\n" for k in range(200)), "row 2: begins at 1 mm"),
        ("time_s,displacement_mm\n" + "".join(f"{k * k},{k}\n" for k in range(200)), "expected equal steps"),
        ("time_s,displacement_mm\n0,0\n1,\n", "row 3, column 'displacement_mm': no finite number"),
    ],
)
def test_drive_signals_that_cant_serve(tmp_path, text, expected):
    path = tmp_path / "drive.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=expected):
        read_drive(path)


def test_a_drive_of_no_cycle_is_refused():
    time = np.arange(500) / 100.0
    with pytest.raises(UserError, match="expected whole cycles of one frequency"):
        driven(PLAN, Drive(time, np.random.default_rng(1).standard_normal(500) * (time > 0)))
