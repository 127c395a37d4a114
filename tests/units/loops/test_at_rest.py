"""Forces at rest before the tests: a constant force shows there, slip that differs between the directions doesn't."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.fitting.identify import identify
from pipeclamp_identification.loops.loops import by_stretch, loops_of
from pipeclamp_models.law.law import Structure

AMPLITUDES = (2.0, 3.0, 4.0, 6.0)
FREQUENCIES = (0.5, 1.0)


def simulated(
    amplitude: float,
    frequency: float,
    *,
    up: float,
    down: float,
    constant: float,
    held: float = 0.0,
    rest: float = 0.5,
    middle: float = 0.0,
) -> Record:
    """Simulate a spring with an element that slips and holds a force: some periods at rest, then growing sines.

    They grow about another place than that of the rest, in amplitudes, if asked.
    """
    time = np.arange(0.0, (rest + 8.0) / frequency, 0.002 / frequency)
    since = time * frequency - rest
    grown = np.clip(since / 2, 0.0, 1.0) if rest else 1.0
    y = amplitude * grown * (middle + np.sin(2 * np.pi * np.maximum(since, 0.0)))
    force = np.empty(len(y))
    for sample, step in enumerate(np.diff(y, prepend=0.0)):
        held = min(max(held + 800.0 * step, -down), up)
        force[sample] = 50.0 * y[sample] + held + constant
    noise = np.random.default_rng(int(10 * amplitude + frequency)).normal(scale=2.0, size=len(y))
    return Record(time, y, force + noise)


@pytest.fixture
def device(run_of, campaign_of):
    def campaign(**device):
        conditions = [(A, f) for A in AMPLITUDES for f in FREQUENCIES]
        return campaign_of(*(run_of(simulated(A, f, **device), name=f"{A}-{f}") for A, f in conditions))

    return campaign


SLIPS_MORE_ONE_WAY = {"up": 150.0, "down": 350.0, "constant": 0.0}
PRELOADED = {"up": 250.0, "down": 250.0, "constant": -100.0}


def test_rest_tells_a_constant_force_from_slip_that_differs(device):
    for given, at_rest, denied in ((SLIPS_MORE_ONE_WAY, 0.0, True), (PRELOADED, -100.0, False)):
        loops = loops_of(device(**given))
        np.testing.assert_allclose(loops.force[:, 0].real, -100.0, atol=10.0)
        np.testing.assert_allclose(loops.force_at_rest_N, at_rest, atol=5.0)
        assert loops.deny_constant_force is by_stretch(loops).deny_constant_force is denied


def test_what_begins_in_motion_elsewhere_or_is_held_by_friction_denies_nothing(device):
    for begun in ({"rest": 0.0}, {"middle": -0.3}):
        unknown = loops_of(device(**SLIPS_MORE_ONE_WAY, **begun))
        assert np.isnan(unknown.force_at_rest_N).all()
        assert not unknown.deny_constant_force
    assert not loops_of(device(**PRELOADED, held=140.0)).deny_constant_force


def test_a_constant_force_that_rest_denies_is_held_with_the_reason(device):
    for given, denied in ((SLIPS_MORE_ONE_WAY, True), (PRELOADED, False)):
        fit = identify(device(**given), Structure(effects=("offset",))).fit
        assert ("at rest" in fit.frozen.get("F_o", "")) is denied
        assert fit.law.values["F_o"] == pytest.approx(0.0 if denied else -100.0, abs=15.0)
