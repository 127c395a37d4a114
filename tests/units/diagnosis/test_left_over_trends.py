"""What goes one way at one end of a condition, and the other way at the other, is told with its size."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.leftover import describe

RUNS = 18
CYCLE = np.arange(RUNS) * 7.0
ELASTIC, DAMPING = np.zeros((2, RUNS, 7))
ELASTIC[:, 1], DAMPING[:, 2] = 400.0, 90.0


def told(off, conditions=None):
    """Give what is said of a law whose residual this is, in tests of one amplitude after another, over and over."""
    loops = SimpleNamespace(
        amplitude_mm=np.tile([0.5, 1.0, 2.0], RUNS // 3), frequency_Hz=np.full(RUNS, 2.0),
        temperature_K=np.full(RUNS, np.nan), density_g_cm3=np.full(RUNS, np.nan), cycle=CYCLE,
        conditions=conditions or {},
    )  # fmt: skip
    problem = SimpleNamespace(
        loops=loops,
        plain_residual=lambda law_force: off,
        harmonics=SimpleNamespace(seen=np.ones_like(off, dtype=bool)),
        noise=SimpleNamespace(directions=SimpleNamespace(elastic=ELASTIC, damping=DAMPING)),
    )
    judged = SimpleNamespace(result=SimpleNamespace(law_force=None), lack=SimpleNamespace(by_channel=np.ones(7)))
    campaign = SimpleNamespace(smoothing=SimpleNamespace(force=True), runs=())
    return [words for words in describe(judged, problem, campaign, ()).words if "against the law's" in words]


@pytest.mark.parametrize(("what", "direction"), [("stiffness", ELASTIC), ("damping", DAMPING)])
def test_what_runs_in_is_told_with_its_size(what, direction):
    """Of pads that ran in, 23 % over 140 cycles, it had been said that the error lies in harmonic 1 in quadrature."""
    share = 0.2 * (1 - np.exp(-CYCLE / 50)) - 0.12
    share -= np.median(share)
    words = told(share[:, None] * direction)
    low, high = 100 * np.median(share[:6]), 100 * np.median(share[-6:])
    ends = f"{low:+.2g}% in the lowest third of it, {high:+.2g}% in the highest"
    assert words == [f"its {what} rises with cycle number against the law's: {ends} (rank correlation 1.00)"]


def test_what_goes_up_and_down_by_chance_is_no_trend():
    assert told(0.02 * np.random.default_rng(3).standard_normal((RUNS, 1)) * DAMPING) == []


def test_what_is_off_one_way_throughout_is_no_trend():
    """That it grows is told anyway."""
    assert told(np.linspace(0.01, 0.2, RUNS)[:, None] * DAMPING) == []


def test_of_conditions_that_went_together_two_are_told_at_most():
    off = np.linspace(-0.1, 0.1, RUNS)[:, None] * DAMPING
    assert len(told(off, dict.fromkeys(("hours", "oil_C", "day"), CYCLE))) == 2
