"""What a whole motion makes of states, and of small changes of them, is what its steps make one after the other."""

from __future__ import annotations

from functools import reduce

import numpy as np
import pytest

from pipeclamp_models.law.law import Structure, smoothing
from pipeclamp_models.law.outline import number_in
from pipeclamp_models.realise.arrays import realise
from pipeclamp_models.realise.force import force_of_equations, step_slopes
from pipeclamp_models.realise.motion import sinusoids
from pipeclamp_models.realise.sizes import data_sizes
from pipeclamp_models.realise.walks import Taken

SAMPLES = 64
STRUCTURES = [
    Structure("memory"),
    Structure("power", ("bouc_wen", "relaxation_spread")),
    Structure("power", ("slip_spread", "play")),
    Structure("power", ("oil_damper",)),
    Structure("power", ("inner_mass",)),
    Structure("power", ("pressed_slip",)),
]


@pytest.mark.parametrize("structure", STRUCTURES, ids=lambda one: "+".join((one.base, *one.effects)))
def test_a_turn_is_all_steps_of_a_cycle(structure):
    motion = sinusoids(np.array([0.2, 0.5, 1.0]), np.array([1.0, 4.0, 2.0]), np.full(3, 293.15), SAMPLES)
    equations = structure.equations
    sizes = data_sizes(motion, np.full(3, 1500.0))
    values = [number_in(parameter.starts[0], sizes) for parameter in equations.parameters]
    found = force_of_equations(equations, values, smoothing(0.2, 1.0), motion)
    assert not found.unsettled.any()

    compiled, rows = realise(equations), np.arange(3)
    taken = [np.atleast_2d(each) for each in (motion.y, motion.v, motion.a, np.roll(motion.y, 1, axis=1), motion.h)]
    slow = [motion.slow[name] for name in compiled.slow]
    numbers = [*values, *smoothing(0.2, 1.0)]
    arguments = [*taken, *compiled.coefficients(*slow, *numbers), *numbers]
    end = np.array(found.states)[:, :, -1]
    steps = step_slopes(equations, values, smoothing(0.2, 1.0), motion, found.states)
    slopes = reduce(lambda before, step: step @ before, np.moveaxis(steps, 1, 0))
    for turn in compiled.turns:
        after, largest, own = turn(end, Taken(arguments, motion.y.shape))
        size = np.max(np.abs(np.array(found.states)[turn.states]), axis=2)
        np.testing.assert_allclose(after, end[turn.states], rtol=1e-6, atol=1e-8 * size.max())
        np.testing.assert_allclose(largest, size, rtol=1e-6, atol=1e-8 * size.max())
        np.testing.assert_allclose(own, slopes[np.ix_(rows, turn.states, turn.states)], rtol=1e-6, atol=1e-9)
