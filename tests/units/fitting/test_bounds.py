"""Which parameters a bound holds: it isn't for the fit's tolerance to say."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.fitting.joint.beforehand import close_to_a_bound, steps_over_a_bound
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Structure


def test_a_bound_holds_a_parameter_however_closely_the_fit_came_to_it(tmp_path):
    law = law_of(open_law("emwm2"))
    plan = Plan((0.2, 0.5, 0.9), (1.0, 4.0), (20.0, 150.0, 300.0), cycles=3, rate=200)
    write_campaign(tmp_path / "c", virtual_runs(law, plan), name="c", notes="")
    observations = loop_observations(loops_of(read_campaign(tmp_path / "c")))
    structure = replace(law.structure, effects=(*law.structure.effects, "exponential_stiffening"))
    held = {tolerance: fit(structure, observations, tolerance=tolerance).at_bound for tolerance in (1e-10, 1e-7)}
    assert "k_x" in held[1e-10]
    assert held[1e-7] == held[1e-10]


def test_a_mean_force_follows_a_condition_however_little_moves_about_it(tmp_path):
    """A cylinder under 1 to 5 bar holds 52 to 260 N and rubs with 8 N: the slope of the mean had a bound at that."""
    t, runs = np.arange(300) / 100, []
    y, v = 5 * np.sin(2 * np.pi * t), 10 * np.pi * np.cos(2 * np.pi * t)
    for pressure in (1.0, 2.0, 3.0, 5.0):
        conditions = {"run": f"p{pressure:g}", "temperature_C": 20.0, "pressure_bar": pressure}
        runs.append(WrittenRun(conditions, Record(t, y, 52 * pressure + 2 * y + 8 * np.tanh(v))))
    write_campaign(tmp_path / "c", iter(runs), name="c", notes="")
    observations = loop_observations(loops_of(read_campaign(tmp_path / "c")))
    found = fit(Structure("power", ("condition:pressure_bar",)), observations)
    assert found.law.values["F_u_pressure_bar1"] == pytest.approx(52.0, rel=0.01)
    assert not found.at_bound.keys() & {"F_u_pressure_bar1"}


@pytest.mark.parametrize(
    ("optimum", "value", "over"),
    [(1.2, 0.9999, True), (0.9999, 0.9999, False), (0.99995, 0.9999, False), (-3.0, 1e-4, True), (2e-4, 1e-4, False)],
)
def test_only_what_would_go_on_over_a_bound_is_held_by_it(optimum, value, over):
    values, slope = np.array([value]), np.array([[2.0], [0.0]])
    residual = slope[:, 0] * (value - optimum) + np.array([0.0, 5.0])
    assert steps_over_a_bound(values, np.array([0.0]), np.array([1.0]), residual, slope).tolist() == [over]


def test_how_close_is_meant_of_the_allowed_range_or_of_the_value_where_there_is_none():
    values, lower = np.array([9.995, 9.95, 1e-5, 0.01]), np.zeros(4)
    upper = np.array([10.0, 10.0, np.inf, np.inf])
    assert close_to_a_bound(values, lower, upper, 1e-3).tolist() == [True, False, False, False]
    assert close_to_a_bound(np.array([1e-7]), lower[:1], upper[2:3], 1e-3).tolist() == [True]


def test_a_range_over_decades_has_no_wide_strip_at_its_lower_end():
    values, lower, upper = np.array([2.6e-5, 1.601e-7]), np.full(2, 1.6e-7), np.full(2, 1e3)
    assert close_to_a_bound(values, lower, upper, 1e-6).tolist() == [False, True]
