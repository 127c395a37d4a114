"""Records between their samples: the ways of each sample's step, and a law's states along them."""

import math

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.steps.ways import ways_along

OMEGA, SAMPLES = 2 * math.pi * 3.0, 31
H = 1 / (3.0 * 8.37)
"""Some eight samples a cycle."""
VALUES = {"k10": 900.0, "k30": 40.0, "c0": 2.0, "alpha0": 1.0, "k_s": 700.0, "z_s": 120.0, "g_p": 0.05}


def shaken(sizes=(0.6,), phase=0.3):
    theta = OMEGA * H * np.arange(SAMPLES) + phase * np.arange(1, len(sizes) + 1)[:, None]
    size = np.array(sizes)[:, None]
    y, v = size * np.sin(theta), size * OMEGA * np.cos(theta)
    return y, v, np.full((len(sizes), 1), H), y[:, :1]


def along(y, v, h, rest, parts, values=VALUES):
    equations = Structure("memory", ("play",)).equations
    slow = {name: np.ones_like(h) for name in equations.slow_signals}
    motion = Motion(y, v, np.zeros_like(y), slow, h, periodic=False, rest=rest)
    if parts:
        motion = Motion(**{**vars(motion), "ways": ways_along(y, v, h, rest, parts)})
    vector = [values.get(name, 0.0) for name in equations.names]
    return equations.names, force_of_equations(equations, vector, (1e-3, 1e-3), motion)


@pytest.mark.parametrize("parts", [1, 16])
def test_ways_lead_from_sample_to_sample_and_end_where_the_motion_turns(parts):
    y, v, h, rest = shaken()
    ways = ways_along(y, v, h, rest, parts)
    assert np.array_equal(ways.y[:, ways.last], y)
    assert np.array_equal(ways.step[ways.last], np.arange(SAMPLES))
    assert np.allclose(np.add.reduceat(ways.h[0], np.append(0, ways.last[:-1] + 1)), H)
    assert not (ways.v[:, 1:] * ways.v[:, :-1] < -1e-9).any()
    turns = np.flatnonzero(ways.v[0] == 0.0)
    assert len(turns) == np.count_nonzero(np.diff(np.sign(v[0])))
    assert np.abs(ways.y[0, turns]) == pytest.approx(0.6, rel=1e-3)  # the cubic's, with eight samples a cycle
    assert ways.length.sum() == pytest.approx(np.abs(np.diff(ways.y[0], prepend=rest[0])).sum())


def test_a_record_without_velocities_moves_straight():
    y, v, h, rest = shaken()
    ways = ways_along(y, np.zeros_like(v), h, rest, 16)
    moved = ways.h[0] > 0.0
    assert np.array_equal(ways.y[0, moved], y[0])
    assert np.allclose(ways.h[0, moved], H)


def test_rows_do_not_see_each_other():
    sizes = (0.6, 0.4, 0.05)
    y, v, h, rest = shaken(sizes)
    _, together = along(y, v, h, rest, 16)
    for row in range(len(sizes)):
        one = slice(row, row + 1)
        _, alone = along(y[one], v[one], h[one], rest[one], 16)
        assert together.force[row] == pytest.approx(alone.force[0], rel=1e-12, abs=1e-9)
    motion = Motion(y, v, y, {}, h, periodic=False, rest=rest, ways=ways_along(y, v, h, rest, 16))
    assert np.array_equal(motion.rows(np.array([2])).y_previous, motion.y_previous[2:])
