"""Laws with memory come to a steady motion where a response begins: out of rest, or next to a march from there.

That of a clearance before the clamp is balanced, and held against co-simulation, in properties/test_three_ways.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from cantilever import cantilever
from test_effect_contract import FURTHER, SMOOTHING, STRUCTURES, name_of, sound_values

from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.stepping import CONDITIONS_FIRST, conditions_of
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.steady.clamp import SteadyClamp, samples_of_law
from pipeclamp_system.steady.start import begun

WITH_MEMORY = [
    structure
    for structure in STRUCTURES
    if structure.equations_without_rig.composed.states and structure.effects != ("play",)
]
ACCELERATION, FREQUENCY = 20.0, 9.0


@pytest.mark.parametrize("structure", WITH_MEMORY, ids=name_of)
def test_a_steady_motion_is_balanced_where_a_response_begins(structure: Structure) -> None:
    law = Law(structure, sound_values(structure), *SMOOTHING)
    named = conditions_of(structure.equations_without_rig)[len(CONDITIONS_FIRST) :]
    further = {name: FURTHER[name] for name in named}
    samples = samples_of_law(law, {"T": 293.15, **further}, 3.0, 60.0)
    clamp = SteadyClamp(law, 293.15, None, None, (0.01, 3.0), (1.0, 60.0), further, samples)
    pipe = reduce(parse_pipe(cantilever(ratio=0.01, up_to_Hz=200)))
    system = SteadySystem(pipe, [(0, clamp)], lambda frequency: ACCELERATION)
    unknowns = begun(system, FREQUENCY)
    assert unknowns is not None
    two = np.array([FREQUENCY])
    H = (unknowns.size - 1) // 2
    off = system.residuals(unknowns[None], two, np.array([ACCELERATION]), system.responses(two, H))
    assert np.abs(off).max() < 1e-5 * np.abs(unknowns).max()
    equations, cycle = structure.equations_without_rig, clamp.cycle(system.unpacked(unknowns[None])[:, 0], two)
    alone, whole = (
        force_of_equations(equations, law.vector(equations), SMOOTHING, cycle, memory_told=told)
        for told in (False, True)
    )
    assert np.array_equal(alone.force, whole.force)
    assert [alone.steps is None, whole.steps is None] == [True, False]
