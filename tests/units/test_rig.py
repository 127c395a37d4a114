"""The virtual rig: what it writes is what was asked for, and the same again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp.bundled import open_law
from pipeclamp.errors import UserError
from pipeclamp.parameter_file import law_of
from pipeclamp_identification.campaign import read_campaign
from pipeclamp_identification.campaign_writing import write_campaign
from pipeclamp_identification.loops import loops_of
from pipeclamp_identification.misfit import misfits, overall_nrmse
from pipeclamp_identification.rig import TestPlan, truth_law, virtual_runs

TestPlan.__test__ = False  # type: ignore[attr-defined]  # a plan of tests, no test
PLAN = TestPlan(amplitudes=(0.3, 0.9), frequencies=(2.0,), temperatures=(20.0, 250.0), rate=400.0)
QUIET = replace(
    PLAN, force_noise=0.0, displacement_noise=0.0, force_step=0.0, displacement_step=0.0, distortion=0.0,
    amplitude_error=0.0, temperature_error=0.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def truth():
    return law_of(open_law("emwm2"))


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


def test_further_effects_need_their_values():
    file = open_law("emwm2")
    with pytest.raises(UserError, match="give c1 with --set"):
        truth_law(file, ["viscous"], {})
    with pytest.raises(UserError, match="k99 is no parameter"):
        truth_law(file, [], {"k99": 1.0})
    with pytest.raises(UserError, match=r"it has .*density_g_cm3"):
        truth_law(file, ["viscous", "density"], {**NEW, "current_A": 1.0})
    law, conditions = truth_law(file, ["viscous", "density"], {**NEW, "density_g_cm3": 2.0})
    assert law.values["c1"] == 1.0
    assert conditions == {"density_g_cm3": 2.0}


def test_a_law_that_needs_a_condition_is_told_so():
    law, _ = truth_law(open_law("emwm2"), ["density"], {"k_rho": 2.0, "c_rho": 1.0})
    with pytest.raises(UserError, match="density_g_cm3"):
        next(virtual_runs(law, QUIET))


def test_conditions_stand_in_their_columns(tmp_path):
    """A virtual campaign is read back with the conditions that it was run under, under which its law holds."""
    file = open_law("emwm2")
    values = {"k_rho": 3.0, "c_rho": 1.0, "density_g_cm3": 2.5, **dict.fromkeys(FOLLOWED, 0.1), "current_A": 1.5}
    law, conditions = truth_law(file, ["density", "condition:current_A"], values)
    write_campaign(tmp_path / "v", virtual_runs(law, QUIET, conditions), name="v", notes="")
    campaign = read_campaign(tmp_path / "v")
    assert {run.density_g_cm3 for run in campaign.runs} == {2.5}
    assert {run.conditions["current_A"] for run in campaign.runs} == {1.5}
    assert overall_nrmse(misfits(law, campaign, loops_of(campaign))) < 2e-3
