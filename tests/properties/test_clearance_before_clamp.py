"""Steady motions of a clamp behind a clearance (`play`): as large and as stable as by events located in time.

The truth is an integrator of its own: the cantilever's modes by Dormand-Prince of order 8 to 1e-8, the clamp pushed,
pulled, carried without force or let go, each change located as an event. 60 cycles from rest; half the peak-to-peak
displacement of clamp and tip in the last of them, and what a disturbance of 0.1 % falls by.
"""

from __future__ import annotations

from collections.abc import Callable
from math import log
from pathlib import Path

import numpy as np
import pytest
from cantilever import cantilever, shaken

from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.description.system import read_system
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.described import steady_clamps
from pipeclamp_system.steady.states import SteadyState, half_range

ACCELERATION = 3.0
SOFT = {"k10": 4.046, "k30": 0.3, "c0": 1.5, "alpha0": 0.6}
STIFF = {"k10": 202.3, "k30": 40.0, "c0": 8.0, "alpha0": 0.6}
TRUTH = [
    (STIFF | {"g_p": 0.1}, 6.0, (0.234539, 0.516703)),
    (STIFF | {"g_p": 0.3}, 6.0, (0.508253, 1.188477)),
    (STIFF | {"g_p": 0.3}, 9.0, (0.499339, 1.148404)),
    (SOFT | {"g_p": 0.3}, 9.0, (1.562881, 2.965708)),
]
FALLS = 0.6088
"""Of a disturbance in a cycle, of the stiff clamp behind 0.3 mm at 9 Hz."""


@pytest.fixture
def motion(tmp_path: Path, write_law: Callable[..., None]) -> Callable[[dict[str, float], float], SteadyState]:
    def at(values: dict[str, float], frequency: float) -> SteadyState:
        write_law(tmp_path / "law.json", values, "power", ("play",))
        (tmp_path / "pipe.toml").write_text(cantilever(0.01, 200.0, probes={"tip": 3.0}), encoding="utf-8")
        (tmp_path / "system.toml").write_text(shaken(0.5, frequency, ACCELERATION), encoding="utf-8")
        pipe = reduce(read_pipe(tmp_path / "pipe.toml"))
        clamps = steady_clamps(read_system(tmp_path / "system.toml"), pipe, tmp_path, None, "test")
        state = SteadySystem(pipe, clamps, lambda frequency: ACCELERATION).at(frequency)
        assert state is not None
        return state

    return at


@pytest.mark.parametrize(("values", "frequency", "truth"), TRUTH)
def test_a_clamp_behind_a_clearance_moves_and_is_stable_as_in_time(motion, values, frequency, truth):
    state = motion(values, frequency)
    found = np.concatenate([half_range(state.clamps), half_range(state.probes)])
    assert found == pytest.approx(truth, rel=2.5e-3)
    assert state.stable


def test_a_disturbance_behind_a_clearance_dies_out_as_fast_as_in_time(motion):
    assert motion(STIFF | {"g_p": 0.3}, 9.0).growth == pytest.approx(9.0 * log(FALLS), rel=0.15)
