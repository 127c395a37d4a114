"""A force at a half of the drive's frequency is told where there is one, and not where noise is all there is."""

from __future__ import annotations

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.leftover import fractional_lines

PER_CYCLE = 16


def found_in(runs, cycles, rng, line=0.0, order=1.5):
    """What is found in so many runs of white noise of 1 N, with a force of that order at a random phase in each."""
    phase = 2 * np.pi * np.arange(cycles * PER_CYCLE) / PER_CYCLE
    timing = SimpleNamespace(count=cycles, bounds=PER_CYCLE * np.arange(cycles + 1), phase=lambda record: phase)
    errors = [
        line * np.cos(order * phase + rng.uniform(0, 2 * np.pi)) + rng.standard_normal(len(phase)) for _ in range(runs)
    ]
    misfits = tuple(SimpleNamespace(measured=error, computed=0 * error) for error in errors)
    return fractional_lines(SimpleNamespace(runs=[SimpleNamespace(cycles=timing, record=None)] * runs), misfits)


@pytest.mark.parametrize("cycles", [4, 5, 12])
def test_noise_holds_no_line_however_many_the_runs(cycles):
    rng = np.random.default_rng(7)
    assert [found_in(240, cycles, rng) for _ in range(10)] == [()] * 10


@pytest.mark.parametrize(("cycles", "order"), [(4, 0.5), (6, 1.5), (12, 2.5)])
def test_a_subharmonic_is_found(cycles, order):
    rng = np.random.default_rng(7)
    assert found_in(16, cycles, rng, line=0.6, order=order) == (order,)


def test_of_a_long_record_some_cycles_are_asked():
    """Ten thousand cycles had taken their square of memory."""
    tracemalloc.start()
    try:
        rng = np.random.default_rng(7)
        assert found_in(4, 10_000, rng, line=0.6) == (1.5,)
        assert tracemalloc.get_traced_memory()[1] < 100e6
    finally:
        tracemalloc.stop()
