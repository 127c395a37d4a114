"""The same tests give the same proposal: on one core and on two, in any order of runs, in newtons and millinewtons."""

from dataclasses import replace

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.discovery.discover import search
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.base import processes
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Law, Structure

HIDDEN = Declaration.model_validate(
    {
        "id": "hidden", "title": "damping that grows off the middle",
        "looks_like": "a loop that is wide where it is high",
        "force": "c_h * v * (y / A_0)**2",
        "parameters": [{"symbol": "c_h", "unit": "N s/mm", "meaning": "its size", "start": 1.0, "lower": 0}],
    }
)  # fmt: skip
BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": 0.0, "k30": 250.0, "k3_A": -0.9, "k3_T": 0.0,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = replace(Plan((0.3, 0.5, 0.7, 1.0), (1.0, 2.0, 4.0), (20.0,), seed=4), rate=400.0, repeats=1)
RIVALS = ("directional_damping", "quadratic_damping", "viscous", "displacement_friction", "asymmetry", "memory", "gap")
SMALLEST = 1e-4
"""What figures may differ by, as a share: rounding, after fits that end within 1e-5."""


@pytest.fixture(scope="module")
def tests(tmp_path_factory):
    folder = tmp_path_factory.mktemp("same") / "campaign"
    law = Law(Structure("power", ("hidden",), declared=(HIDDEN,)), {**BASE, "c_h": 3.0}, 0.0126, 0.002)
    write_campaign(folder, virtual_runs(law, PLAN), name="same", notes="")
    return read_campaign(folder)


def found_in(campaign, jobs=1):
    law = law_file(identify(campaign), campaign, name="law", provenance=Provenance("same"))
    with few_effects(*RIVALS):  # what a term has to better, of all kinds
        return search(law, campaign, workers=Workers(jobs))


@pytest.fixture(scope="module")
def once(tests):
    result = found_in(tests)
    assert result.found is not None
    assert result.found.term.family == "damper"
    return result


def other_order(campaign):
    return replace(campaign, runs=tuple(np.random.default_rng(2).permutation(np.array(campaign.runs, dtype=object))))


def in_millinewtons(campaign):
    runs = [
        replace(run, record=replace(run.record, force_N=1000 * run.record.force_N)) for run in campaign.runs
    ]  # fmt: skip
    return replace(campaign, runs=tuple(runs))


def test_the_answer_is_the_same_on_two_cores_in_another_order_and_in_millinewtons(tests, once, monkeypatch):
    monkeypatch.setattr(processes, "BEGINNING_S", 0.0)
    again = found_in(in_millinewtons(other_order(tests)), jobs=2)
    assert again.found is not None
    assert again.found.term.declaration.id == once.found.term.declaration.id
    # The nearest rival; where fits of the farther ones end, rounding decides.
    assert [rival.declaration.id for rival in again.found.rivals[:1]] == [
        one.declaration.id for one in once.found.rivals[:1]
    ]
    assert [(one.name, one.passed, one.words) for one in again.found.guards] == [
        (one.name, one.passed, one.words) for one in once.found.guards
    ]
    # what is drawn for a run is drawn for the same one
    ours, others = (one.found.judged.fitted.residual for one in (again, once))
    assert ours == pytest.approx(others, abs=0.01 * np.max(np.abs(others)))
    own = once.found.judged.result.law.values
    for table in once.found.term.declaration.parameters:
        value = again.found.judged.result.law.values[table.symbol] / (1000 if table.unit == "N" else 1)
        assert value == pytest.approx(own[table.symbol], rel=SMALLEST)
