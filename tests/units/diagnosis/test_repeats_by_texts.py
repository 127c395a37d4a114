"""What is said of runs that differ at the same conditions, where only a text tells them apart."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.repeats import unstated


def differing(valves, specimen=None):
    """What is said of runs at one condition whose stiffness differs by half, a valve's setting each."""
    count, ones = len(valves), np.ones(len(valves))
    rows = tuple(SimpleNamespace(labels={"specimen": specimen or "", "valve": valve}) for valve in valves)
    loops = SimpleNamespace(
        rows=rows, run=[f"r{number}" for number in range(count)], specimen=[specimen] * count, conditions={},
        amplitude_mm=ones, frequency_Hz=ones, temperature_K=300 * ones,
        density_g_cm3=np.nan * ones, cycle=np.nan * ones,
    )  # fmt: skip
    elastic, damping = np.tile([0.0, 10.0, 0.0], (count, 1)), np.tile([0.0, 0.0, 10.0], (count, 1))
    directions = SimpleNamespace(elastic=elastic, damping=damping)
    noise = SimpleNamespace(directions=directions, variance=np.full((count, 3), 1e-4))
    residual = elastic * np.linspace(-0.25, 0.25, count)[:, None]
    return unstated(loops, noise, residual, residual).words()


def test_a_text_that_makes_no_groups_isnt_called_unstated():
    said = differing(("open", "half", "closed", "closed"))
    assert "isn't stated" not in said
    assert "only valve in runs.csv may tell why" in said
    assert "two runs each" in said


@pytest.mark.parametrize("valves", [("", "", "", ""), ("open",) * 4, ("open", "open", "closed", "closed")])
def test_what_no_text_tells_or_groups_took_isnt_stated(valves):
    assert "isn't stated (specimen, preload or mounting, say)" in differing(valves, "S1")
