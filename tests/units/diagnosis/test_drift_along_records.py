"""Drift along the cycles of records, and scatter between runs of which each is parted into stretches."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.diagnosis.evidence import drifts
from pipeclamp_identification.diagnosis.noise import noise_model
from pipeclamp_identification.loops.loops import by_stretch, loops_of

RUNS, CYCLES, SAMPLES = 16, 3, 100


@pytest.fixture
def loops(campaign_of, run_of):
    """Give tests at four amplitudes and frequencies, whose stiffness is off, and drifts, by shares of their own."""

    def made(off, drift):
        random = np.random.default_rng(2)

        def run(row):
            amplitude, frequency = 0.2 * 2 ** (row % 4), 2.0 ** (row // 4)
            turns = np.arange(CYCLES * SAMPLES) / SAMPLES
            y, v = amplitude * np.sin(2 * np.pi * turns), amplitude * np.cos(2 * np.pi * turns)
            force = 1000 * y * (1 + off[row] + drift[row] * (turns - CYCLES / 2)) + 300 * v
            noise = random.standard_normal(len(y))
            return run_of(Record(turns / frequency, y, force + noise), f"run {row:02d}")

        return loops_of(campaign_of(*(run(row) for row in range(RUNS))))

    return made


def test_runs_that_drift_each_its_own_way_are_no_drift(loops):
    """By noise of the single cycles alone one of a hundred campaigns without a drift had one."""
    own = np.random.default_rng(2).standard_normal(RUNS)
    assert not drifts(loops(np.zeros(RUNS), 0.004 * (own - own.mean() + 0.4)))
    assert drifts(loops(np.zeros(RUNS), np.full(RUNS, 0.004)))


def test_stretches_show_as_much_scatter_as_their_runs(loops):
    """Of three stretches each, what is off alike in all of a run had passed for three runs that agree."""
    off = 0.01 * np.random.default_rng(4).standard_normal(RUNS)
    whole = loops(off, np.zeros(RUNS))
    parted = by_stretch(whole)

    def told(of):
        harmonics = np.stack([[0.0, *np.stack([x.real, x.imag], 1)[1:].ravel()] for x in of.force])
        elastic = np.zeros_like(harmonics)
        elastic[:, 1] = 1000 * of.amplitude_mm
        true = np.array([off[int(name.split()[1])] for name in of.run])
        return noise_model(of, np.zeros_like(elastic), true[:, None] * elastic)

    assert told(parted).runs == told(whole).runs == RUNS
    assert told(parted).scatter.stiffness == pytest.approx(told(whole).scatter.stiffness, rel=0.05)
