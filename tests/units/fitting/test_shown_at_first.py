"""Which parameters a fit frees at first: those that the tests show, were they of a usual size."""

import numpy as np
import pytest
import scipy.optimize

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure


@pytest.fixture(scope="module")
def observations(tmp_path_factory):
    """Loops of three amplitudes about a mean force of 5 N, at which a stiffness of 2 N/mm rubs with 8 N."""
    folder, t, runs = tmp_path_factory.mktemp("tests") / "c", np.arange(400) / 100, []
    for amplitude in (0.5, 1.0, 2.0):
        y, v = amplitude * np.sin(2 * np.pi * t), 2 * np.pi * amplitude * np.cos(2 * np.pi * t)
        force = 5 + 2 * y + 0.05 * y**3 + 8 * np.tanh(v) + 0.2 * np.random.default_rng(1).standard_normal(len(t))
        runs.append(WrittenRun({"run": f"a{amplitude:g}", "temperature_C": 20.0}, Record(t, y, force)))
    write_campaign(folder, iter(runs), name="c", notes="")
    return loop_observations(loops_of(read_campaign(folder)))


@pytest.mark.parametrize("structure", [Structure("power", ("offset",)), Structure("series:3:2")], ids=str)
def test_what_starts_from_nothing_is_shown_all_the_same(structure, observations, monkeypatch):
    """A mean force that starts from 0 N had no size: all else was fitted to the end first, and then once more."""
    freed, minimise = [], scipy.optimize.least_squares

    def counting(residual, start, **how):
        freed.append(len(start))
        return minimise(residual, start, **how)

    monkeypatch.setattr(scipy.optimize, "least_squares", counting)
    found = fit(structure, observations)
    assert freed == [len(found.fitted)]
