"""A fit from a law that is known: neither set of weights may lead it to where the tests are less likely."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.fitting import identify
from pipeclamp_identification.fitting.least_squares import unfitted
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure

LAW = {
    "k10": 100.0, "k1_A": 0.0, "k1_T": 0.0, "k30": 0.0, "k3_A": 0.0, "k3_T": 0.0,
    "c0": 5.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 1.0, "alpha_A": 0.0, "alpha_f": 0.0,
}  # fmt: skip


@pytest.mark.parametrize("astray", [0, 2])
def test_a_known_law_is_not_led_into_a_poorer_valley(campaign_of, run_of, monkeypatch, astray):
    """Weights of scatter alone had led a measured friction device, with a mass more, to a tenth more of error."""
    random = np.random.default_rng(1)
    phase = 2 * np.pi * np.arange(1000) / 200

    def run(amplitude):
        force = amplitude * (100 * np.sin(phase) + 5 * 2 * np.pi * np.cos(phase))
        record = Record(phase / (2 * np.pi), amplitude * np.sin(phase), force + random.standard_normal(len(phase)))
        return run_of(record, f"{amplitude} mm")

    loops = loops_of(campaign_of(*map(run, (0.3, 0.6, 0.9))))
    begun = []

    def led(structure, observations, *, start, **options):
        begun.append(start)
        values = {**start, "k10": 50.0} if len(begun) == astray + 1 else start
        return unfitted(structure, observations, values)

    monkeypatch.setattr(identify, "fit", led)
    found = identify.fit_structure(Structure("power"), loops, loop_observations(loops), start=LAW)
    assert found.law.values["k10"] == 100.0
    assert len(begun) == 4
