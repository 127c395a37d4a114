"""A diagnosis of tests at one amplitude and frequency: there is nothing that it could foretell."""

import pytest

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
