"""Groups of conditions that are left out: drives that miss their set points, sweeps, one amplitude and frequency."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.fitting import heldout
from pipeclamp_identification.fitting.heldout import (
    amplitude_and_frequency_groups,
    condition_groups,
    folds,
    further_groups,
    left_out_at_once,
    refitted_nrmse,
    share_of_force,
)
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import with_effect


def _loops(tmp_path, plan):
    write_campaign(tmp_path / "c", virtual_runs(law_of(open_law("emwm2")), plan), name="c", notes="")
    return loops_of(read_campaign(tmp_path / "c"))


def test_set_points_that_the_drive_misses_are_one_group(tmp_path):
    plan = Plan((0.3, 0.9), (2.0, 4.0), (20.0, 100.0, 200.0), cycles=3, rate=200, amplitude_error=0.01)
    groups = condition_groups(_loops(tmp_path, plan))
    assert sorted(np.bincount(groups)) == [3, 3, 3, 3]


def test_a_sweep_in_small_steps_is_left_out_in_classes(tmp_path):
    plan = Plan((0.5,), tuple(np.round(np.geomspace(1.0, 2.0, 24), 4)), (20.0,), cycles=3, rate=200)
    for used, left_out in folds(condition_groups(_loops(tmp_path, plan)), 8):
        assert len(left_out) < len(used)


def test_at_one_amplitude_and_frequency_runs_are_left_out(tmp_path):
    loops = _loops(tmp_path, Plan((0.5,), (3.0,), (20.0, 100.0, 200.0, 300.0), cycles=3, rate=200))
    assert sorted(condition_groups(loops)) == [0, 1, 2, 3]
    assert left_out_at_once(loops) == "runs"
    assert 0 < refitted_nrmse(law_of(open_law("emwm2")), loops, loop_observations(loops)) < 0.2


def test_without_one_of_two_amplitudes_and_frequencies_nothing_would_show_what_these_do(tmp_path):
    """A damper over current had been tried at two: left-out error rose by what explains nine tenths of its force."""
    plan = Plan((0.3, 0.9), (2.0,), (20.0, 100.0, 200.0), cycles=3, rate=200, repeats=2, amplitude_error=0.01)
    loops = _loops(tmp_path, plan)
    assert sorted(np.bincount(condition_groups(loops))) == [2] * 6
    assert left_out_at_once(loops) == "settings"
    assert sorted(np.bincount(amplitude_and_frequency_groups(loops))) == [6, 6]


def test_of_one_test_nothing_can_be_left_out(tmp_path):
    loops = _loops(tmp_path, Plan((0.5,), (3.0,), (20.0,), cycles=3, rate=200))
    with pytest.raises(UserError, match="expected two tests"):
        list(folds(condition_groups(loops), 8))


@pytest.mark.parametrize(
    ("currents", "groups"),
    [
        ((0.0, 1.0, 2.0), None),
        ((0.0, 0.5, 1.0, 2.0), [-1, 0, 1, -1]),
        ((2.0, 0.5, 1.0, 0.0, 4.0), [2, 0, 1, -1, -1]),
        # runs of which it isn't known are no level of it
        ((0.0, 1.0, 2.0, np.nan), None),
        ((0.0, np.nan, 0.5, 1.0, 2.0, np.nan), [-1, -1, 0, 1, -1, -1]),
    ],
)
def test_of_a_further_condition_what_lies_between_is_left_out(currents, groups, run_of, campaign_of, harmonic_record):
    runs = [run_of(harmonic_record(), f"{place}", conditions={"i": each}) for place, each in enumerate(currents)]
    found = further_groups(loops_of(campaign_of(*runs)))
    assert (found["i"].tolist() if "i" in found else None) == groups


@pytest.mark.parametrize(
    ("specimens", "groups"),
    [
        (("m12", None, "m12", None), None),
        (("m12", "m13", "m12", "m13"), [0, 1, 0, 1]),
        ((None, "m13", "m12", "m13"), [-1, 1, 0, 1]),
    ],
)
def test_runs_whose_specimen_is_not_known_are_no_specimen(specimens, groups, run_of, campaign_of, harmonic_record):
    runs = [run_of(harmonic_record(), f"{place}", specimen=each) for place, each in enumerate(specimens)]
    found = further_groups(loops_of(campaign_of(*runs)))
    assert (found["specimen"].tolist() if "specimen" in found else None) == groups


def test_a_state_that_creeps_is_left_out_as_all_points_of_the_cycle_show_it(tmp_path, monkeypatch):
    """Between a quarter of them it lags, which is no error of the law (of a creeping arm 1.70 for 1.36 %)."""
    creeping = Declaration.model_validate(
        {
            "id": "creeping", "part": "clamp", "title": "a spring that creeps", "looks_like": "a spring that gives way",
            "force": "F_c * z_c", "energy": "F_c * A_0 * z_c**2 / 2",
            "parameters": [
                {"symbol": "F_c", "unit": "N", "meaning": "force of the arm", "start": 1000.0, "lower": 0.0},
                {"symbol": "t_c", "unit": "s", "meaning": "time in which it creeps", "start": 1e-3, "lower": 1e-6},
            ],
            "states": [
                {
                    "symbol": "z_c", "unit": "-", "meaning": "strain of the arm",
                    "update": "(z_c + (y - y_previous) / A_0)"
                    " / (1 + h / t_c * abs(z_c + (y - y_previous) / A_0)**2)",
                }
            ],
        }
    )  # fmt: skip
    bare = law_of(open_law("emwm2"))
    structure = with_effect(bare.structure.with_declared([creeping]), "creeping")
    law = replace(bare, structure=structure, values={**bare.values, "F_c": 1000.0, "t_c": 1e-3})
    plan = Plan((0.3, 0.6, 0.9), (1.0, 4.0), (20.0,), cycles=3, rate=1000, force_noise=0.5)
    write_campaign(tmp_path / "c", virtual_runs(law, plan), name="c", notes="")
    loops = loops_of(read_campaign(tmp_path / "c"))
    found = refitted_nrmse(law, loops, loop_observations(loops))
    monkeypatch.setattr(heldout, "coarser", lambda loops, observations: observations)
    assert found == pytest.approx(refitted_nrmse(law, loops, loop_observations(loops)), rel=0.03)


@pytest.mark.parametrize("wild", [1e30, np.inf, np.nan])
def test_what_only_extrapolation_could_tell_errs_by_the_largest_force(wild, tmp_path):
    """Of an effect with an exponent an error of 150988900757 % was told where one current was left out."""
    loops = _loops(tmp_path, Plan((0.3, 0.9), (2.0, 4.0), (20.0,), cycles=3, rate=200))
    force = loops.force_rms_N
    every = np.ones(len(force), dtype=bool)
    large = np.full(len(force), np.max(force) ** 2 / 2)  # more than all of the smallest loop's force
    known = np.sqrt(np.sum(large + loops.noise_rms_N**2) / np.sum(force**2))
    assert share_of_force(large, loops, every) == pytest.approx(known)
    smallest, largest = np.arange(len(force)) == np.argmin(force), np.arange(len(force)) == np.argmax(force)
    assert share_of_force(np.where(largest, wild, 4.0), loops, largest) == 1.0
    assert share_of_force(np.where(smallest, wild, 4.0), loops, smallest) == pytest.approx(max(force) / min(force))
    assert share_of_force(np.where(smallest, wild, 4.0), loops, ~smallest) < 0.1
