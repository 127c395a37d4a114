"""What changes between two levels tested: nothing tells where, so the midst of them is meant, and gradually."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import judge, prepare
from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_identification.discovery.guards import changes_untested
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Law, Structure, with_effect

PLAN = replace(Plan((0.3, 1.0), (1.0, 4.0), (20.0, 100.0, 200.0, 300.0), seed=4), rate=400.0, repeats=1)
SOFTER = {
    "id": "softer", "title": "softer when hot", "looks_like": "softer when hot",
    "scales": [{"coefficient": "stiffness", "factor": "1 - s*(1 + tanh((T - l)/4))/2"}],
    "parameters": [
        {"symbol": "s", "unit": "-", "meaning": "share that is lost", "start": 0.1},
        {"symbol": "l", "unit": "K", "meaning": "where it is lost", "start": 400.0},
    ],
}  # fmt: skip
COLUMN = "field_mT"
BY_ID = {term.declaration.id: term for term in terms(("A", "f", "T"), {COLUMN: 30.0})}


@pytest.mark.parametrize("lost_at", [115.0, 150.0, 185.0])
def test_a_step_between_two_temperatures_is_told_midway_and_gradual(lost_at, tmp_path):
    """It had been told where its fit began, at 188 °C within 3 K and ± 3 K, of a stiffness that was lost at 146 °C."""
    whole, bare = law_of(open_law("emwm2")), Structure("power", ())
    softer = with_effect(bare.with_declared([Declaration.model_validate(SOFTER)]), "softer")
    values = {**whole.values, "s": 0.1, "l": 273.15 + lost_at}
    write_campaign(
        tmp_path / "campaign", virtual_runs(Law(softer, softer.own(values), whole.v_r, whole.y_r), PLAN),
        name="softer", notes="",
    )  # fmt: skip
    problem, plain = prepare(bare, loops_of(read_campaign(tmp_path / "campaign")), bare.own(whole.values))
    step = BY_ID["found_stiffness_step_t"]
    structure = with_effect(bare.with_declared([step.declaration]), step.declaration.id)
    for level in (400.0, 460.0):
        start = {**plain.law.values, "s_x": -0.1, "l_x": level, "a_x": 100 / 8.0}
        found = judge((step.declaration.id,), structure, [start], problem).result.law.values
        assert found["l_x"] - 273.15 == pytest.approx(150.0, abs=10.0)
        assert 12.0 < 100 / abs(found["a_x"]) < 60.0  # K


@pytest.mark.parametrize(
    ("name", "level", "steepness", "told"),
    [
        ("stiffness_step_t", 420.0, 5.0, "between 100 °C and 200 °C"),
        ("stiffness_step_t", 420.0, 1.0, ""),  # within 100 K: the tests show it
        ("stiffness_step_t", 470.0, 5.0, ""),  # the tests at 200 °C do
        ("damping_step_f", 3.0, 4.0, "between 1 Hz and 4 Hz"),
        (f"slip_step_{COLUMN}", 20.0, 9.0, "between 10 and 30"),
        ("stiffness_beyond_t", 420.0, 5.0, ""),
    ],
)
def test_it_is_said_where_no_test_shows_the_place_of_a_change(name, level, steepness, told):
    slow = {"T": [293.15, 373.15, 473.15], "f": [1.0, 4.0, 8.0], "u_" + COLUMN: [-10.0, 10.0, 30.0]}
    motion = SimpleNamespace(slow={key: np.repeat(values, 3)[:, None] for key, values in slow.items()})
    problem = SimpleNamespace(observations=SimpleNamespace(motion=motion))
    law = SimpleNamespace(values={"s_x": 0.1, "l_x": level, "a_x": steepness})
    words = changes_untested(BY_ID[f"found_{name.lower()}"], law, problem)
    assert words.startswith(told)
    assert bool(words) == bool(told)
