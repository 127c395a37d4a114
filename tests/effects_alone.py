"""What effects do by themselves: a clamp that has nothing else."""

from collections.abc import Mapping, Sequence

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.law.law import Structure
from pipeclamp_models.realise.force import force_of_equations
from pipeclamp_models.realise.motion import Motion


def force_of_effects(effects: Sequence[str], values: Mapping[str, float], motion: Motion) -> Array:
    """Give the force of effects on a motion, N, shape (R, n); parameters without a value are 0."""
    equations = Structure("power", tuple(effects)).equations
    given = dict.fromkeys(equations.names, 0.0) | {"alpha0": 1.0} | values
    return force_of_equations(equations, [given[name] for name in equations.names], (0.01, 0.001), motion).force
