"""What is larger than on most rigs and clamps is found, too: a late force channel, an oil that thins."""

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


def fitted(folder, effect, temperatures=(20.0,), **values):
    """Give what is fitted to tests of a clamp with an effect of this size."""
    structure = Structure("power", (effect,))
    plan = Plan((0.3, 0.9), (1.0, 2.0, FASTEST_HZ), temperatures, rate=400.0, seed=5)
    neutral = {each.name: each.neutral for each in structure.effect(effect).parameters}
    runs = virtual_runs(Law(structure, {**BASE, **neutral, **values}, 0.0126, 0.002), plan)
    write_campaign(folder, runs, name="virtual", notes="")
    return identify(read_campaign(folder), structure).fit.law.values


@pytest.mark.parametrize("of_a_cycle", [0.02, 0.07, 0.15])
def test_a_late_force_is_told_from_damping(tmp_path, of_a_cycle):
    """At a twentieth of a cycle the delay had stood at its bound, so that nothing could be named for it."""
    late = of_a_cycle / FASTEST_HZ
    assert fitted(tmp_path / "tests", "delay", tau_d=late)["tau_d"] == pytest.approx(late, rel=0.02)


@pytest.mark.parametrize(("slope", "bend"), [(-1.5, 0.5), (-4.0, 1.5)])
def test_an_oil_that_thins_is_followed(tmp_path, slope, bend):
    """Of one that loses nine tenths of its viscosity in 60 K the slope had stood at -2 per 100 K."""
    found = fitted(tmp_path / "tests", "damping_temperature", (20.0, 50.0, 80.0), c_T1=slope, c_T2=bend)
    for t in (0.3, 0.6):
        thinner = found["c_T1"] * t + found["c_T2"] * t**2
        assert thinner == pytest.approx(slope * t + bend * t**2, rel=0.1)
