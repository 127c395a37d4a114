"""Where the fit of a law begins in which an effect's next larger member takes its place."""

from __future__ import annotations

from collections.abc import Mapping

from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.observations import Observations
from pipeclamp_models.equations.effect import Effect
from pipeclamp_models.law.law import Structure


def refined_starts(
    larger: Structure, smaller: Effect, observations: Observations, values: Mapping[str, float]
) -> list[dict[str, float]]:
    """Give the points that the larger law's fit starts from: the larger member's own starts, and the smaller's values.

    Args:
        larger: the law's structure with the larger member.
        smaller: the effect whose place it takes.
        observations: what is fitted.
        values: fitted values of the law with the smaller one, by parameter.
    """
    own = {parameter.name for parameter in smaller.parameters}
    shared = {name: value for name, value in values.items() if name not in own}
    starts = starting_points(larger, observations, shared)
    return starts if smaller.refinement is None else [*starts, shared | smaller.refinement.start(values)]
