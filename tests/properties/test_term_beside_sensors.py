"""A sensor's fault that was taken off the records, or mains hum in them, stands in the way of no search for a term."""

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
    "k10": 150.0, "k1_A": -0.1, "k1_T": 0.0, "k30": 5.0, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 8.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.6, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip
PLAN = Plan((0.3, 0.6, 0.9), (1.0, 4.0), (20.0,), rate=400.0, seed=5)


def faulty(run, number, fault):
    """Give a run with damping that grows with the displacement squared, and with a sensor's fault."""
    record = run.record
    velocity = np.gradient(record.displacement_mm, record.time_s)
    force = record.force_N + 6.0 * record.displacement_mm**2 * velocity
    if number < 2 and fault == "drifting zero":
        force = force + np.ptp(force) * np.linspace(0.0, 0.1, len(force))
    if fault == "falling gain":
        force = force * np.linspace(1.0, 0.9, len(force))
    if fault == "hum":
        force = force + 0.004 * np.ptp(force) * np.sin(2 * np.pi * 46.6 * record.time_s + number)
    return replace(run, record=replace(record, force_N=force))


@pytest.mark.parametrize(
    ("fault", "done", "called"),
    [
        ("none", [], True),
        ("hum", [], True),
        ("drifting zero", ["corrected"], True),
        ("falling gain", ["kept"], False),
    ],
)
def test_a_term_is_sought_unless_the_fault_is_in_what_is_left(tmp_path, fault, done, called):
    """The next command had been `compare` wherever a sensor had been at fault in one run, or mains hum was seen."""
    runs = virtual_runs(Law(Structure("power", ()), BASE, 0.0126, 0.002), PLAN)
    tests = [faulty(run, number, fault) for number, run in enumerate(runs)]
    write_campaign(tmp_path / "tests", tests, name="virtual", notes="")
    campaign = read_campaign(tmp_path / "tests")
    assert [one.done for one in campaign.faults] == done
    with few_effects("offset"):
        found = diagnosed(law_file(identify(campaign), campaign, name="law", provenance=Provenance("test")), campaign)
    assert found.verdict == "unknown"
    assert found.diagnosis.leftover.not_periodic is (fault == "hum")
    assert found.calls_for_a_term is called
