"""A pipe's reference results: how it moves when it is shaken below its lowest frequency and its clamps push."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.linalg import expm

from pipeclamp_fmu.contents.reference import Reference
from pipeclamp_fmu.describe.model_description import Quantity
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.pipe.modes import ReducedPipe

REFERENCE_STEPS = 400
WAVES = 1.7
"""Of the first input, in all steps; each further input has a third of one more."""


def pipe_reference(
    pipe: ReducedPipe, step: float, inputs: Sequence[str], described: Mapping[str, Quantity]
) -> Reference:
    """Give a pipe's motion with inputs held over each step, as masters have it that step all models in parallel.

    So what depends on the modes alone is the same in model exchange, where inputs are held from row to row.

    Args:
        pipe: what moves.
        step: s.
        inputs: names, of the excitation and of the clamps' forces.
        described: the variables, whose nominal values size the inputs.
    """
    waves = WAVES + np.arange(len(inputs)) / 3
    sizes = np.array([described[name].nominal or 1.0 for name in inputs])
    loads = sizes * np.sin(math.pi * waves * np.arange(REFERENCE_STEPS)[:, None] / REFERENCE_STEPS) ** 2
    motion = _held_steps(pipe, step, loads)
    names, shapes = (*pipe.clamp_names, *pipe.probe_names), (*pipe.clamp_shapes, *pipe.probe_shapes)
    modes = len(pipe.omega)
    results = {
        f"{name}.{kind}": (motion[:, place : place + modes] @ np.array(shape)).tolist()
        for kind, place in (("s", 0), ("v", modes))
        for name, shape in zip(names, shapes, strict=True)
    }
    stimuli = dict(zip(inputs, loads.T.tolist(), strict=True))
    return Reference("shaken", "from rest, all inputs of the form sin^2", step, stimuli, results, at_once=False)


@one_thread()
def _held_steps(pipe: ReducedPipe, step: float, loads: Array) -> Array:
    """Give modal displacements and velocities after each step, (n, 2 modes), of loads that are held over it."""
    modes = len(pipe.omega)
    by_load = np.array([pipe.excitation_participation, *(np.negative(shape) for shape in pipe.clamp_shapes)])
    generator = np.zeros((2 * modes + len(by_load),) * 2)
    generator[:modes, modes : 2 * modes] = np.eye(modes)
    generator[modes : 2 * modes, : 2 * modes] = np.hstack([-pipe.stiffness_matrix, -pipe.damping_matrix])
    generator[modes : 2 * modes, 2 * modes :] = by_load.T
    over_step = expm(step * generator)[: 2 * modes]
    motion = np.zeros((len(loads) + 1, 2 * modes))
    for row, load in enumerate(loads):
        motion[row + 1] = over_step @ np.concatenate([motion[row], load])
    return motion[1:]
