"""A fit ends where no parameter changes any more, however large another one is."""

import pytest

from pipeclamp_identification.campaign import rig
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.problem import CLOSELY
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import Law, Structure

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
PLAN = rig.TestPlan((0.2, 0.6, 1.0), (1.0, 4.0), (20.0, 150.0), rate=500.0, seed=5)


def stop(most):
    """A stop on one side with a damping, whose coefficient is stated in nN s/mm and has an upper bound."""
    return Declaration.model_validate(
        {
            "id": "stop", "title": "a damped stop", "looks_like": "a kink",
            "force": "k_b * max(y - y_b, 0) + c_b / 1e9 * v",
            "parameters": [
                {"symbol": "k_b", "unit": "N/mm", "meaning": "stiffness", "start": 100.0, "lower": 0},
                {"symbol": "y_b", "unit": "mm", "meaning": "place", "start": 0.75, "lower": 0, "upper": "A_highest"},
                {"symbol": "c_b", "unit": "-", "meaning": "damping", "start": most, "lower": 0, "upper": most},
            ],
        }
    )  # fmt: skip


def test_a_large_number_at_its_bound_ends_no_fit_of_small_ones(tmp_path):
    """Beside 4e9 any step of a place in mm was next to none: the fit ended where it began."""
    values = {**BASE, "k_b": 300.0, "y_b": 0.4, "c_b": 4.2e9}
    truth = Law(Structure("power", ("stop",), declared=(stop(1e10),)), values, 0.0126, 0.002)
    write_campaign(tmp_path / "campaign", rig.virtual_runs(truth, PLAN), name="virtual", notes="")
    observations = loop_observations(loops_of(read_campaign(tmp_path / "campaign")))
    given = Structure("power", ("stop",), declared=(stop(4e9),))
    start = {**BASE, "k_b": 200.0, "y_b": 0.6, "c_b": 4e9}
    found = fit(given, observations, start=start, tolerance=CLOSELY)
    assert found.law.values["y_b"] == pytest.approx(0.4, abs=0.01)
    assert found.law.values["k_b"] == pytest.approx(300.0, rel=0.03)
    assert "c_b" in found.at_bound
