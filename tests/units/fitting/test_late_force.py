"""A force that is measured late by more than a twentieth of a cycle is found, too."""

import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.fitting.identify import identify
from pipeclamp_models.law.law import Law, Structure

BASE = {
    "k10": 150.0, "k1_A": -0.1, "k1_T": 0.0, "k30": 5.0, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 8.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.6, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip
FASTEST_HZ = 4.0


@pytest.mark.parametrize("of_a_cycle", [0.02, 0.07, 0.15])
def test_a_late_force_is_told_from_damping(tmp_path, of_a_cycle):
    """At a twentieth of a cycle the delay had stood at its bound, so that nothing could be named for it."""
    late = of_a_cycle / FASTEST_HZ
    plan = Plan((0.3, 0.9), (1.0, 2.0, FASTEST_HZ), (20.0,), rate=400.0, seed=5)
    runs = virtual_runs(Law(Structure("power", ("delay",)), {**BASE, "tau_d": late}, 0.0126, 0.002), plan)
    write_campaign(tmp_path / "tests", runs, name="virtual", notes="")
    fitted = identify(read_campaign(tmp_path / "tests"), Structure("power", ("delay",)))
    assert fitted.fit.law.values["tau_d"] == pytest.approx(late, rel=0.02)
