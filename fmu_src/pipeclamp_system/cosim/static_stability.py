"""Whether a pipe stays at rest between its clamps: clamps of negative stiffness may exceed what it holds them with."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.range import conditions_inside
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_models.pipe.modes import ReducedPipe, reduce
from pipeclamp_models.realise.scalar_law import scalar_law
from pipeclamp_system.cosim.building import law_in
from pipeclamp_system.cosim.law_conditions import further_conditions, given_conditions
from pipeclamp_system.description.system import ClampSource, SystemDescription

SMALL_SHARE = 1e-3
"""Of the amplitude that a law is taken for: the displacement by which its stiffness at rest is told."""
KILO = 1e3
"""N/m in N/mm."""


def about_rest(description: SystemDescription, folder: Path, where: str, although: str = "") -> str:
    """Say that a pipe leaves its rest by itself, by how much in N/mm, and what helps; "" where it doesn't.

    Nothing is said of FMUs in the place of laws or of the pipe, whose equations aren't known. `although` ends the first
    half of the sentence: whatever it leaves its rest in spite of.

    Raises:
        UserError: a law or the pipe can't be read.
    """
    laws = [clamp for clamp in description.clamps if clamp.law is not None and clamp.fmu is None]
    known = {clamp.at: stiffness_at_rest(clamp, description, folder, where) for clamp in laws}
    negative = [name for name, stiffness in known.items() if stiffness < 0]
    if not negative or description.pipe.file is None:
        return ""
    pipe = reduce(read_pipe(folder / description.pipe.file))
    here = [name for name in negative if name in pipe.clamp_names]
    held = {name: _held_with(pipe, {one: k for one, k in known.items() if one != name}, name) for name in here}
    name = min(here, key=lambda one: known[one] + held[one], default=None)
    if name is None or known[name] + held[name] >= 0:
        return ""
    beside = "the pipe with its other clamps" if len(known) > 1 else "the pipe"
    return (
        f"clamp {name!r} has a negative stiffness at rest, {plain(known[name], 4)} N/mm, and {beside} holds it with "
        f"{plain(held[name], 4)} N/mm: together {plain(known[name] + held[name], 4)} N/mm, so that the pipe leaves "
        f"its rest{although}; expected a law above {plain(-held[name], 4)} N/mm (at its A and T), or a support there"
    )


def stiffness_at_rest(clamp: ClampSource, description: SystemDescription, folder: Path, where: str) -> float:
    """Give the stiffness of a clamp's law at rest, N/mm: what a small displacement needs that stays through the run.

    Raises:
        UserError: the law can't be read, or is given a condition that it doesn't follow.
    """
    file = law_in(folder, str(clamp.law))
    A, f = (conditions_inside(file.range, given_conditions(clamp, description)._asdict())[name] for name in "Af")
    law = scalar_law(law_of(file))
    further = further_conditions(file, clamp, where)
    coefficients = law.coefficients(A, f, clamp.temperature_C + CELSIUS, *(further[name] for name in law.further))
    rest, small = tuple(start for _, start in law.states), SMALL_SHARE * A
    up, down = (law.step(coefficients, rest, 0.0, y, 0.0, description.run.stop_s)[0] for y in (small, -small))
    return float(up - down) / (2 * small)


def _held_with(pipe: ReducedPipe, clamps: dict[str, float], name: str) -> float:
    """Give the static stiffness, N/mm, with which a pipe and some clamps (N/mm, by name) hold the place of another."""
    shapes: dict[str, Array] = dict(zip(pipe.clamp_names, map(np.array, pipe.clamp_shapes), strict=True))
    stiffness = pipe.stiffness_matrix
    for one, own in clamps.items():
        if one in shapes:
            stiffness = stiffness + KILO * own * np.outer(shapes[one], shapes[one])
    # The force that a displacement of 1 m takes: also of a pipe that can move as a rigid body, which none holds.
    bordered = np.block([[stiffness, -shapes[name][:, None]], [shapes[name][None], np.zeros((1, 1))]])
    return float(np.linalg.lstsq(bordered, np.append(np.zeros(len(stiffness)), 1.0), rcond=None)[0][-1]) / KILO
