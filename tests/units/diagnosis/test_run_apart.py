"""One run of another specimen, which nothing in runs.csv tells: it is named, for else it passes for physics."""

import dataclasses

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.further_test.run_apart import run_apart
from pipeclamp_identification.diagnosis.problem import prepare, weighed_again
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Law, Structure

VALUES = {
    "k10": 150.0, "k1_A": -0.1, "k1_T": 0.0, "k30": 5.0, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 8.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.6, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip
GRID = Plan((0.3, 0.6, 0.9), (1.0, 2.0, 4.0), (20.0,), rate=400.0, seed=5)


def written(folder, *, odd=None, factor=1.0, dropped=(), effects=(), **more):
    """Write tests of the grid into a folder, of which one run's force is that of a part so many times as strong."""
    runs = list(virtual_runs(Law(Structure("power", effects), {**VALUES, **more}, 0.0126, 0.002), GRID))
    if odd is not None:
        record = runs[odd].record
        runs[odd] = dataclasses.replace(runs[odd], record=dataclasses.replace(record, force_N=factor * record.force_N))
    kept = [run for place, run in enumerate(runs) if place not in dropped]
    write_campaign(folder, kept, name="virtual", notes="")
    return folder


def base_law_on(folder):
    """Give the tests as a diagnosis weighs them, and the base law judged on them."""
    structure = Structure("power")
    problem, first = prepare(structure, loops_of(read_campaign(folder)))
    return weighed_again(problem, structure, first, [first])


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_a_run_of_another_specimen_is_named_with_what_it_is_off_by(factor, tmp_path):
    problem, law = base_law_on(written(tmp_path / "tests", odd=4, factor=factor))
    found = run_apart(law, problem)
    assert found is not None and found.run == problem.loops.run[4]
    assert found.share > 0.8 and found.left < 0.5
    assert (found.stiffness, found.damping) == pytest.approx((factor - 1, factor - 1), abs=0.02)
    assert f"{factor - 1:+.0%} and its damping" in found.words() and not found.at_a_corner


def test_of_a_run_at_a_corner_it_is_said_that_what_the_law_lacks_may_grow_to_there(tmp_path):
    problem, law = base_law_on(written(tmp_path / "tests", odd=8, factor=1.25))
    found = run_apart(law, problem)
    assert found is not None and found.run == problem.loops.run[8] and found.at_a_corner
    assert "What the law lacks may grow to there" in found.words()


@pytest.mark.parametrize("factor", [1.0, 1.02])
def test_a_run_that_rigs_scatter_may_make_does_not(factor, tmp_path):
    problem, law = base_law_on(written(tmp_path / "tests", odd=4, factor=factor))
    assert run_apart(law, problem) is None


def test_what_a_law_lacks_in_many_runs_sets_none_apart(tmp_path):
    problem, law = base_law_on(written(tmp_path / "tests", effects=("hardening",), k5=400.0))
    assert law.lack.share > 1 and run_apart(law, problem) is None


def test_a_run_that_is_alone_at_its_amplitude_may_show_what_the_device_does_there(tmp_path):
    alone, others = 8, (2, 5)  # at 0.9 mm
    problem, law = base_law_on(written(tmp_path / "tests", odd=alone, factor=1.25, dropped=others))
    assert np.count_nonzero(problem.loops.amplitude_mm > 0.8) == 1
    assert run_apart(law, problem) is None


def test_it_is_told_though_scatter_might_pass_for_the_rest_and_no_term_is_searched_for_it(tmp_path):
    tests = pc.read_campaign(written(tmp_path / "tests", odd=4, factor=1.25))
    answer = pc.diagnose(pc.identify(tests), tests).to_dict()
    assert any("stands apart" in line for line in answer["left_over"])
    assert "discover" not in answer["next_command"]
