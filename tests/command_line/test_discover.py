"""A term that no catalogue has is proposed where one is missing, and none where nothing is, through the command."""

import json
from dataclasses import replace

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import Law, Structure

HIDDEN = Declaration.model_validate(
    {
        "id": "hidden",
        "title": "damping that grows off the middle",
        "looks_like": "a loop that is wide where it is high",
        "force": "c_h * v * (y / A_0)**2",
        "parameters": [{"symbol": "c_h", "unit": "N s/mm", "meaning": "its size", "start": 1.0, "lower": 0}],
    }
)
SPRING = Declaration.model_validate(
    {
        "id": "hidden",
        "title": "a spring that softens for ever",
        "looks_like": "a loop that is steeper in the middle",
        "force": "F_h * y / sqrt(y**2 + y_r**2) * log(1 + sqrt(y**2 + y_r**2) / l_h)",
        "parameters": [
            {"symbol": "F_h", "unit": "N", "meaning": "its size", "start": 50.0, "lower": 0},
            {"symbol": "l_h", "unit": "mm", "meaning": "displacement by which it softens", "start": 0.2, "lower": 0.01},
        ],
    }
)
BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = replace(Plan(seed=11), rate=500.0, frequencies=(1.0, 5.0), temperatures=(20.0,), repeats=1)


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory):
    """The same tests of a clamp with something hidden, and without."""
    folder = tmp_path_factory.mktemp("discover")
    for name, size in (("with", 3.0), ("without", 0.0)):
        law = Law(Structure("power", ("hidden",), declared=(HIDDEN,)), {**BASE, "c_h": size}, 0.0126, 0.002)
        write_campaign(folder / name, virtual_runs(law, PLAN), name=name, notes="")
    law = Law(Structure("power", ("hidden",), declared=(SPRING,)), {**BASE, "F_h": 60.0, "l_h": 0.2}, 0.0126, 0.002)
    write_campaign(folder / "spring", virtual_runs(law, PLAN), name="spring", notes="")
    return folder


def test_the_hidden_term_is_found_and_can_be_added(campaigns, pipeclamp, tmp_path):
    tests = campaigns / "with"
    law = pc.identify(tests).save(tmp_path / "law.json")
    words = ("discover", law, tests, "-o", tmp_path / "term.toml", "--auto", tmp_path / "law2.json")
    done = pipeclamp(*words, "--json", tmp_path / "answer.json", "--report", tmp_path / "page.html")
    answer = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert answer["proposed"], answer["reason"]
    assert answer["family"] == "damper"
    assert answer["heldout_after"] < 1.1 * answer["noise_nrmse"] < 0.6 * answer["heldout_before"]
    assert all(guard["passed"] for guard in answer["guards"])
    found, without = pc.open_law(tmp_path / "law2.json"), pc.open_law(law)
    y = np.linspace(-0.9, 0.9, 7)
    for v in (3.0, 12.0):
        before, after = (one.force(y, np.full(7, v), A=0.9, f=3.0, T=20.0) for one in (without, found))
        added = after - before
        truth = 3.0 * v * y**2
        assert np.corrcoef(added, truth)[0, 1] > 0.95
    assert answer["acts_like"].split(",")[0] in done.stdout
    assert "Its numbers: force of the term" in done.stdout
    assert "sqrt(" not in done.stdout
    assert "<h2>Difference</h2>" in (tmp_path / "page.html").read_text(encoding="utf-8")
    again = pc.add(law, tmp_path / "term.toml", tests)
    assert again.nrmse == pytest.approx(found.nrmse, rel=0.01)


def test_where_nothing_can_be_named_the_search_for_a_term_comes_next(campaigns, pipeclamp, tmp_path):
    tests = campaigns / "with"
    law = pc.identify(tests, effects=["bouc_wen"]).save(tmp_path / "law.json")  # an effect that takes a part of it
    told = pipeclamp("diagnose", law, tests).stdout
    line = f"pipeclamp discover {law} {tests} -o {tmp_path / 'law_term.toml'} --auto {tmp_path / 'law_2.json'}"
    assert "".join(line.split()) in "".join(told.split())


def test_a_term_takes_the_place_of_the_parts_that_stood_for_it(campaigns, pipeclamp, tmp_path):
    """Beside parts, which leave another form over, a term isn't what is hidden; in their place it is, and they go."""
    tests, parts = campaigns / "spring", ["self_centring", "hardening"]
    law, law2 = pc.identify(tests, effects=parts).save(tmp_path / "law.json"), tmp_path / "law_2.json"
    outputs = ("-o", tmp_path / "law_term.toml", "--auto", law2, "--json", tmp_path / "answer.json")
    told = pipeclamp("discover", law, tests, *outputs).stdout
    answer, found = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8")), pc.open_law(law2)
    assert set(answer["spare"]) == set(parts)
    assert all(f"The law does as well without {name}, now" in " ".join(told.split()) for name in parts)
    assert answer["family"] == "spring"
    assert found.effects == (answer["effect"],)
    assert answer["heldout_after"] < 1.1 * answer["noise_nrmse"]
    assert pc.compare(found, tests).nrmse < 1.1 * answer["noise_nrmse"]
    y = np.linspace(-0.9, 0.9, 19)
    without = pc.identify(tests)
    before, after = (one.force(y, np.zeros(19), A=0.9, f=3.0, T=20.0) for one in (without, found))
    odd = np.stack([y, y**3]).T
    added, hidden = (
        force - odd @ np.linalg.lstsq(odd, force, rcond=None)[0]
        for force in (after - before, np.sign(y) * np.log1p(np.abs(y) / 0.2))
    )
    assert np.corrcoef(added, hidden)[0, 1] > 0.99


def test_nothing_is_proposed_where_nothing_is_missing(campaigns, pipeclamp, tmp_path):
    tests = campaigns / "without"
    law = pc.identify(tests).save(tmp_path / "law.json")
    done = pipeclamp("discover", law, tests, "-o", tmp_path / "term.toml", "--auto", tmp_path / "law2.json")
    assert "Nothing is proposed" in done.stdout
    assert not (tmp_path / "term.toml").exists()
    assert not (tmp_path / "law2.json").exists()
    answer = pc.discover(law, tests)
    assert not answer.proposed
    assert answer.law is None
