"""Records that went through a moving average: found by their noise, and a law comes back as if they hadn't."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.smoothing import averaged, find_smoothing, gain
from pipeclamp_identification.fitting.identify import identify
from pipeclamp_identification.fitting.misfit import overall_nrmse
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

RATE_PER_CYCLE = 500
CYCLES = 6
TRUTH = {"k10": 2000.0, "k1_A": -0.2, "k1_T": 0.0, "k30": 500.0, "k3_A": -0.4, "k3_T": 0.0,
         "c0": 40.0, "c_A": 0.1, "c_f": -0.1, "alpha0": 0.4, "alpha_A": 0.0, "alpha_f": 0.0}  # fmt: skip


def smoothed(values, share):
    """The mean over a share of the period around each sample; ends as long as half of it are cut by the caller."""
    width = round(share * RATE_PER_CYCLE)
    return np.convolve(values, np.full(width, 1 / width), mode="same") if width > 1 else values


def records(share, coloured=0.0):
    """Noisy records of the truth at twelve conditions, averaged over a share of the period."""
    random = np.random.default_rng(5)
    law = Law(Structure("power"), TRUTH, 1e-3, 1e-4)
    for A in (0.2, 0.5, 1.0, 2.0):
        for f in (1.0, 3.0, 8.0):
            motion = sinusoids(A, f, 293.15, RATE_PER_CYCLE)
            force = np.tile(force_of_law(law, motion).force[0], CYCLES + 2)
            y = np.tile(motion.y[0], CYCLES + 2)
            white = random.normal(size=(2, len(y)))
            slow = signal.lfilter([1.0], [1.0, -0.97], random.normal(size=len(y)))
            force = force + 0.004 * np.std(force) * (white[0] + coloured * slow)
            y = y + 2e-4 * A * white[1]
            inner = slice(RATE_PER_CYCLE, -RATE_PER_CYCLE)
            time = np.arange(len(y)) / (f * RATE_PER_CYCLE)
            yield Record(time[inner] - time[inner][0], smoothed(y, share)[inner], smoothed(force, share)[inner])


def campaign(run_of, share, coloured=0.0):
    runs = tuple(
        run_of(record, name=f"run{index}", temperature_C=20.0) for index, record in enumerate(records(share, coloured))
    )
    tests = Campaign("smoothed", "", "sha256:none", runs, (), ())
    return replace(tests, smoothing=find_smoothing([(run.record, run.cycles) for run in runs]))


@pytest.mark.parametrize("share", [0.06, 0.1, 0.2])
def test_an_average_is_found_and_seen_through(run_of, share):
    tests = campaign(run_of, share)
    width = round(share * RATE_PER_CYCLE) / RATE_PER_CYCLE
    assert tests.smoothing.force == pytest.approx(width, rel=0.03)
    assert tests.smoothing.displacement == pytest.approx(width, rel=0.03)
    assert "moving average" in tests.smoothing.words()
    found = identify(tests)
    blind = identify(replace(tests, smoothing=type(tests.smoothing)()))
    assert overall_nrmse(found.misfits) < 0.006
    assert overall_nrmse(blind.misfits) > 2 * overall_nrmse(found.misfits)
    for name in ("k10", "c0", "alpha0"):
        assert found.fit.law.values[name] == pytest.approx(TRUTH[name], rel=0.03), name


@pytest.mark.parametrize("coloured", [0.0, 1.0, 5.0])
def test_none_is_found_where_none_was(run_of, coloured):
    tests = campaign(run_of, 0.0, coloured)
    assert tests.smoothing.force == tests.smoothing.displacement == 0.0
    assert tests.smoothing.words() == ""


def test_averaging_multiplies_each_harmonic_by_its_gain():
    theta = 2 * np.pi * np.arange(256) / 256
    for order in (1, 3, 7):
        wave = np.cos(order * theta)
        np.testing.assert_allclose(averaged(wave, 0.1), gain(0.1, order) * wave, atol=1e-12)
    assert gain(0.1, 10) == pytest.approx(0.0, abs=1e-12)
