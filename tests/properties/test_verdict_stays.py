"""A verdict is the same whatever the order of the runs and the unit in which the device is strong."""

from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_models.law.law import Law, Structure

TRUTH = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
    "k_s": 900.0, "z_s": 150.0, "k2": 60.0,
}  # fmt: skip
"""Elastic slip, and halves that are pressed unequally."""
PLAN = Plan(temperatures=(20.0, 300.0), rate=500.0, seed=5)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stays") / "campaign"
    structure = Structure("power", ("memory", "asymmetry"))
    law = Law(structure, {name: TRUTH[name] for name in structure.equations.names}, 0.0126, 0.002)
    write_campaign(folder, virtual_runs(law, PLAN), name="virtual", notes="")
    return read_campaign(folder)


@pytest.fixture(scope="module")
def found(campaign):
    return diagnose(Structure("power"), campaign)


def same(one, other):
    assert (one.verdict, one.kind, one.effects) == (other.verdict, other.kind, other.effects)
    assert one.law.heldout_nrmse == pytest.approx(other.law.heldout_nrmse, rel=1e-3)
    assert one.best.heldout_nrmse == pytest.approx(other.best.heldout_nrmse, rel=1e-2)


def test_neither_the_order_of_runs_nor_the_size_of_the_force_matters(campaign, found):
    assert found.effects
    order = np.random.default_rng(1).permutation(len(campaign.runs))
    shuffled = [campaign.runs[place] for place in order]
    runs = tuple(replace(run, record=replace(run.record, force_N=1000.0 * run.record.force_N)) for run in shuffled)
    same(diagnose(Structure("power"), replace(campaign, runs=runs)), found)
