"""Points that a fit may start from, each effect as large as the data ask for, and a law linearised there."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping

import numpy as np

from pipeclamp_identification.fitting.joint.evaluator import Evaluator, Remembered, smoothing_of
from pipeclamp_identification.fitting.joint.not_fitted import undetermined
from pipeclamp_identification.fitting.joint.starts import (
    Linearised,
    SizedEffect,
    Values,
    combined,
    sized,
    starts_of_effects,
)
from pipeclamp_identification.fitting.observations import Observations, data_scales
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.one_thread import one_thread
from pipeclamp_models.base.signals import column_of
from pipeclamp_models.base.units import grows_with_force
from pipeclamp_models.law.law import Structure, scaled_in
from pipeclamp_models.law.outline import Sizes
from pipeclamp_models.realise.force import LawForce


def starting_points(
    structure: Structure, observations: Observations, given: Mapping[str, float]
) -> list[dict[str, float]]:
    """Give the points that a fit starts from, each effect's in combination; see `fit`."""
    return combined(starts_by_effect(structure, given, data_scales(observations)))


def starts_by_effect(structure: Structure, given: Mapping[str, float], scales: Sizes) -> list[list[Values]]:
    """Give the points that each effect starts from: given values, the effect's own starts, or both; see `fit`."""
    equations = structure.equations
    stated = starts_of_effects(equations, given, scales)
    new = {parameter.effect for parameter in equations.parameters if parameter.name not in given}
    if not new or not given:  # then no effect has to be looked up, which loads the mathematics
        return stated
    scaled = set().union(*(scaled_in(structure, effect) for effect in structure.all_effects() if effect.name in new))
    anew = {name: value for name, value in given.items() if name not in scaled}
    return [
        [*points, *(point for point in own if point not in points)]
        for points, own in zip(stated, starts_of_effects(equations, anew, scales), strict=True)
    ]


def sized_start(
    structure: Structure, observations: Observations, start: Mapping[str, float], known: Collection[str]
) -> Mapping[str, float]:
    """Give a start with each effect that isn't known as large as the data ask for; see `sized`.

    Args:
        structure: the law's structure.
        observations: what is fitted.
        start: a value for each parameter.
        known: names of the parameters whose values are known.
    """
    terms = _unsized(structure, observations, known)
    return sized(start, linearised(structure, observations, start), known, terms)[0] if terms else start


def sized_and_linearised(
    structure: Structure, observations: Observations, start: Mapping[str, float], known: Collection[str]
) -> tuple[Mapping[str, float], Linearised]:
    """Give a start with each effect that isn't known as large as the data ask for, and the law linearised there.

    Arguments as for `sized_start`.
    """
    there = linearised(structure, observations, start)
    effects = _unsized(structure, observations, known)
    return sized(start, there, known, effects) if effects else (start, there)


def _unsized(structure: Structure, observations: Observations, known: Collection[str]) -> list[SizedEffect]:
    """Give, for each effect that isn't known, the parameters that its force is in proportion to, if it has others.

    Where the residuals aren't linear in the force, one step doesn't tell how large it is: none then.
    """
    if not observations.are_linear:
        return []
    held = structure.held()
    found = []
    for _, group in itertools.groupby(structure.equations.parameters, key=lambda parameter: parameter.effect):
        parameters = [one for one in group if one.name not in known and one.name not in held]
        sizes = [one.name for one in parameters if grows_with_force(one.unit)]
        if sizes and len(parameters) > 1:  # the size of a single one is a fit's first step
            found.append(SizedEffect(sizes, [one.name for one in parameters if one.name not in sizes]))
    return found


def linearised(structure: Structure, observations: Observations, values: Mapping[str, float]) -> Linearised:
    """Give a law's residuals at a point, linearised.

    Args:
        structure: the law's structure.
        observations: what it would be fitted to.
        values: the point, a value for each parameter.
    """
    equations = structure.equations
    out = set(structure.held()) | set(undetermined(equations, observations))
    free = np.array([index for index, name in enumerate(equations.names) if name not in out], dtype=np.intp)
    begin = np.array([structure.held().get(name, values[name]) for name in equations.names])
    evaluator = Evaluator(Remembered(observations, equations, smoothing_of(observations)), begin, free)
    with one_thread():
        residual, jacobian = evaluator.residual(begin[free]), evaluator.jacobian(begin[free])
    return Linearised(tuple(equations.names[index] for index in free), residual, jacobian)


def no_force(structure: Structure, observations: Observations, law_force: LawForce) -> UserError | None:
    """Give what to tell of a law that has no finite force somewhere on the tests; None where it has.

    Args:
        structure: the law's structure.
        observations: the tests.
        law_force: the law's force on their motion.
    """
    nowhere = np.argwhere(~np.isfinite(law_force.force))
    if not len(nowhere):
        return None
    for signal in sorted(structure.equations.slow_signals):
        if not np.all(np.isfinite(observations.motion.slow[signal])):
            return UserError(
                f"the law depends on {column_of(signal)}, which not all tests state; fill it in in runs.csv"
            )
    row, sample = nowhere[0]
    y, v = observations.motion.y[row, sample], observations.motion.v[row, sample]
    declared = ", ".join(repr(one.id) for one in structure.declared if one.id in structure.effects)
    return UserError(
        f"{f'effect {declared}' if declared else 'the law'}: has no finite force on these tests where the fit begins, "
        f"at y = {y:.3g} mm, v = {v:.3g} mm/s for one; expected expressions that have a value at every displacement "
        "and velocity: abs(y)**0.5 for y**0.5, say"
    )
