"""A diagnosis of tests at one amplitude, and at one frequency too: what nothing is proved by."""

import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Law, Structure


@pytest.mark.parametrize(("amplitudes", "kind"), [((0.5,), "part"), ((0.2, 0.5, 0.8), "cause")])
def test_what_explains_them_is_a_part_and_no_cause(amplitudes, kind, tmp_path):
    """Repeats at one condition ended in a traceback, or in "Missing: rounded_friction."."""
    clamp = law_of(open_law("emwm2"))
    values = {**clamp.values, "k2": 400.0}
    law = Law(Structure("power", ("asymmetry",)), values, clamp.v_r, clamp.y_r)
    plan = Plan(amplitudes, (2.0,), (20.0,), cycles=4, rate=300, repeats=4)
    write_campaign(tmp_path / "c", virtual_runs(law, plan), name="c", notes="")
    found = diagnose(Structure("power"), read_campaign(tmp_path / "c")).found
    assert (found.verdict, found.effects, found.kind) == ("missing", ("asymmetry",), kind)
    told = any("at one amplitude and frequency" in reason for reason in found.reasons)
    assert told == (kind == "part")


@pytest.mark.parametrize(("amplitudes", "kind"), [((0.5,), "part"), ((0.2, 0.5, 0.8), "cause")])
def test_what_slips_is_no_cause_at_one_amplitude(amplitudes, kind, tmp_path):
    """Three slip elements follow any one loop: of a device of Bouc and Wen's form "Missing: memory:3." was told."""
    clamp = law_of(open_law("emwm2"))
    law = Law(Structure("power", ("memory",)), {**clamp.values, "k_s": 2500.0, "z_s": 400.0}, clamp.v_r, clamp.y_r)
    plan = Plan(amplitudes, (1.0, 3.0, 8.0), (20.0, 60.0), cycles=4, rate=600)
    write_campaign(tmp_path / "c", virtual_runs(law, plan), name="c", notes="")
    with few_effects("memory", "viscous", "coulomb", "asymmetry"):
        found = diagnose(Structure("power"), read_campaign(tmp_path / "c")).found
    assert (found.verdict, found.effects[0], found.kind) == ("missing", "memory", kind)
    told = any("at one amplitude, at which what slips otherwise" in reason for reason in found.reasons)
    assert told == (kind == "part")
