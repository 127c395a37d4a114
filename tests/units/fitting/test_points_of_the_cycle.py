"""How closely laws are evaluated over the cycle where a record has few samples of it."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.fitting.observations import SAMPLES_PER_CYCLE, loop_observations, points_enough
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law

DAMPER = Law(
    Structure("power"),
    {
        "k10": 100.0, "k1_A": 0.0, "k1_T": 0.0, "k30": 0.0, "k3_A": 0.0, "k3_T": 0.0,
        "c0": 1000.0, "c_A": 0.0, "c_f": 0.0, "alpha0": 0.3, "alpha_A": 0.0, "alpha_f": 0.0,
    },
    v_r=0.01,
    y_r=0.01,
)  # fmt: skip
"""Nearly all of its force is damping, which is steep at a reversal."""


@pytest.mark.parametrize("samples", [100, 200, 250])
def test_points_lie_as_close_as_the_samples_beside_a_reversal_ask(campaign_of, run_of, samples):
    """A noisy record needs few points, but force isn't straight between that at the reversal and the next."""
    random = np.random.default_rng(samples)

    def run(place):
        phase = 2 * np.pi * (np.arange(4 * samples) + place) / samples
        velocity = 2 * np.pi * np.cos(phase)
        force = 100 * np.sin(phase) + 1000 * np.abs(velocity) ** 0.3 * np.sign(velocity)
        noise = 15 * random.standard_normal(len(phase))
        return run_of(Record(phase / (2 * np.pi), np.sin(phase), force + noise), f"from {place}")

    loops = loops_of(campaign_of(*(run(place) for place in np.linspace(-0.45, 0.45, 7))))

    def seen(points):
        observed = loop_observations(loops, points)
        return observed.transformed(force_of_law(DAMPER, observed.motion).force)

    off = np.abs(seen(points_enough(loops)) - seen(4 * SAMPLES_PER_CYCLE))
    assert np.max(off / loop_observations(loops).standard_error) < 1.0
