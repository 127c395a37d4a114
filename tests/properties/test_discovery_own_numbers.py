"""Each number of a term does something of its own: what another does as well can't be told, nor can its strength.

What creeps had a strength, a way and a time, of which two were shown: a fit left its strength undetermined, so that it
was taken to explain nothing, and no such element was ever proposed.
"""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from pipeclamp_identification.discovery.grammar import terms
from pipeclamp_models.base.signals import REFERENCES
from pipeclamp_models.realise.array_source import ArrayPrinter
from pipeclamp_models.realise.motion import sinusoids
from pipeclamp_models.realise.sizes import data_sizes, number_of

PLAIN = [one for one in terms((), {}) if one.family != "factor"]
A, F = np.meshgrid((0.2, 0.5, 1.0), (0.5, 8.0))
MOTION = sinusoids(A.ravel(), F.ravel(), 293.15, 48)
RUNS, SAMPLES = MOTION.y.shape
SIZES = data_sizes(replace(MOTION, slow={**MOTION.slow, "T": np.full((RUNS, 1), 293.15)}), np.full(RUNS, 100.0))
STILL = {
    **{name: float(value) for name, value in REFERENCES.items()},
    **{name: values[:, 0] for name, values in MOTION.slow.items()},
    "h": MOTION.h[:, 0], "v_r": 0.01, "y_r": 0.002,
}  # fmt: skip
MOVING = {"y": MOTION.y, "v": MOTION.v, "y_previous": MOTION.y_previous}
CYCLES = 2
STEP = 1e-4
TOLD_APART = 1e-4


def function(expression):
    free = sorted(expression.free_symbols, key=str)
    compiled = sp.lambdify(free, expression, modules="numpy", printer=ArrayPrinter)
    return lambda **known: compiled(*(known[str(symbol)] for symbol in free))


def of_its_own(term, values):
    """Give the smallest singular value of what each number of a term does to its force, each of unit length."""
    force = function(term.effect.force)
    walks = [(str(state.symbol), function(state.update)) for state in term.effect.states]

    def forces(values):
        now, along = {name: np.zeros(RUNS) for name, _ in walks}, []
        for place in list(range(SAMPLES)) * (CYCLES if walks else 1):
            here = {**STILL, **values, **{name: value[:, place] for name, value in MOVING.items()}}
            now = {name: update(**here, **now) for name, update in walks}
            along.append(np.broadcast_to(force(**here, **now), (RUNS,)))
        return np.concatenate(along[-SAMPLES:])

    slopes = []
    for name, value in values.items():
        change = forces({**values, name: value * (1 + STEP)}) - forces({**values, name: value * (1 - STEP)})
        slopes.append(change / max(float(np.linalg.norm(change)), 1e-300))
    return np.linalg.svd(np.array(slopes), compute_uv=False)[-1]


@pytest.mark.parametrize("family", ["spring", "damper", "element"])
def test_each_number_of_a_term_does_something_of_its_own(family):
    for term in (one for one in PLAIN if one.family == family):
        parameters = term.effect.parameters
        starts = (
            {one.name: number_of(one.starts[start % len(one.starts)], SIZES) for one in parameters}
            for start in range(max(len(one.starts) for one in parameters))
        )
        assert any(of_its_own(term, start) > TOLD_APART for start in starts), term.declaration.id
