"""A force channel that isn't straight is told as such; an effect that gives more on one side stays the cause."""

from dataclasses import replace

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.diagnosed import diagnosed
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Law, Structure

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = Plan((0.3, 0.6, 0.9), (1.0, 4.0), (20.0, 150.0), rate=500.0, seed=5)
ALIKE = (
    "asymmetry", "hardening", "pressed_slip", "memory", "unilateral_contact", "offset", "end_stop", "gas_spring", "gap"
)  # fmt: skip
"""What such a channel was taken for, or may be."""


def bent(run, level, share, side):
    """Give a run whose channel gives a share less of what lies beyond a force; side 0 for both directions."""
    force = run.record.force_N
    beyond = np.sign(force) * np.maximum(np.abs(force) - level, 0.0) * (force * side >= 0)
    return replace(run, record=replace(run.record, force_N=force - share * beyond))


def asked(folder, effects=(), channel=None, **values):
    runs = virtual_runs(Law(Structure("power", effects), {**BASE, **values}, 0.0126, 0.002), PLAN)
    write_campaign(folder, [bent(run, *channel) for run in runs] if channel else runs, name="virtual", notes="")
    tests = read_campaign(folder)
    with few_effects(*ALIKE):
        return diagnosed(law_file(identify(tests), tests, name="law", provenance=Provenance("test")), tests)


@pytest.mark.parametrize(
    ("level", "share", "side"), [(400.0, 0.02, 1), (400.0, 0.02, -1), (0.0, 0.02, 1), (500.0, 0.03, 0)]
)
def test_a_channel_that_gives_less_is_no_physics(tmp_path, level, share, side):
    """It had been called asymmetry, or a slip force that pressure raises."""
    found = asked(tmp_path / "tests", channel=(level, share, side))
    assert (found.verdict, found.effects) == ("unknown", ())
    assert "a force channel that gives" in found.diagnosis.reasons[0]
    told = found.diagnosis.found.bent
    assert told.side == side
    assert told.share == pytest.approx(-share, rel=0.35)
    assert not found.calls_for_a_term  # a term would only write down what the amplifier does


@pytest.mark.parametrize(("effect", "values"), [("asymmetry", {"k2": 40.0}), ("hardening", {"k5": 60.0})])
def test_a_spring_that_gives_more_on_one_side_or_far_out_is_the_cause(tmp_path, effect, values):
    found = asked(tmp_path / "tests", (effect,), **values)
    assert (found.verdict, found.kind, found.effects) == ("missing", "cause", (effect,))
