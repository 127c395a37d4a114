"""A cheap screen: what each effect of the catalogue promises by one step of linear least squares."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeclamp_identification.diagnosis.objections import are_one_memory
from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.fitting.joint.points import no_force, sized_and_linearised, starting_points
from pipeclamp_identification.fitting.joint.starts import Linearised, kept
from pipeclamp_identification.fitting.least_squares import unfitted
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_identification.fitting.surfaces import elastic_values, surface_values
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import Workers
from pipeclamp_models.equations.effect import Family
from pipeclamp_models.law.catalogue import effect_id, entries, find_effect
from pipeclamp_models.law.law import Structure, with_effect
from pipeclamp_models.realise.sizes import about


def candidate_names(structure: Structure, conditions: Iterable[str], *, time_measured: bool = True) -> list[str]:
    """Give the effects that could be missing: those of the catalogue and the user's that the law hasn't got yet.

    Args:
        structure: the law's structure.
        conditions: further columns of the tests.
        time_measured: whether their seconds are seconds: otherwise the catalogue's effects of time aren't asked.
    """
    present = {effect_id(effect.name): effect for effect in structure.all_effects()}
    names, of_columns = [], []
    for name, entry in entries().items():
        if isinstance(entry, Family) and entry.default is None:
            of_columns.append(name)
        elif find_effect(name).part != "base" and (time_measured or not find_effect(name).is_of_time):
            larger = present[name].refinement if name in present else None
            names += [name] if name not in present else [larger.name] if larger else []
    declared = (declaration.id for declaration in structure.declared)
    further = [*(f"{name}:{column}" for name in of_columns for column in conditions), *declared]
    return names + [name for name in further if name not in structure.effects]


@dataclass(frozen=True, eq=False)
class FitStart:
    """Where a fit may start: each effect that isn't known as large as the data ask for.

    Attributes:
        values: all of the law's parameters.
        step: the law there, linearised.
        cost: after one step of linear least squares.
    """

    values: Mapping[str, float]
    step: Linearised
    cost: float


@dataclass(frozen=True, eq=False)
class Promise:
    """What an effect promises by one step of linear least squares from the best of its starts.

    Attributes:
        name: the effect.
        gain: by how much the step lowers the cost; nothing where the tests determine no parameter of the effect, for it
            is the law's own then.
        starts: where the law with the effect may start, most promising first.
    """

    name: str
    gain: float
    starts: Sequence[FitStart]


def promising_starts(
    structure: Structure, problem: Problem, points: Iterable[tuple[Mapping[str, float], Collection[str]]]
) -> list[FitStart]:
    """Give where a fit may start, most promising first.

    Args:
        structure: what is to be fitted.
        problem: the data.
        points: a value for each parameter, and the names of those whose values are known.
    """
    started = [sized_and_linearised(structure, problem.coarse, point, known) for point, known in points]
    starts = [FitStart(values, step, step.cost_after_one_step()) for values, step in started]
    return sorted(starts, key=lambda start: start.cost)


def _promise(structure: Structure, problem: Problem, law: Judged, name: str) -> Promise | None:
    """Give what an effect promises; None if it can't be fitted.

    Args:
        structure: the law's structure.
        problem: the data.
        law: the law as it is.
        name: the effect.
    """
    declared = any(declaration.id == name for declaration in structure.declared)
    try:
        larger = with_effect(structure, name)
        stated = list(_starts(structure, larger, name, problem, law))
    except UserError:
        if declared:
            raise  # who declares an effect wants to know why it can't be tried
        return None
    starts = promising_starts(larger, problem, stated)
    if declared:
        law_there = unfitted(larger, problem.coarse, starts[0].values).law_force
        if refusal := no_force(larger, problem.coarse, law_there):
            raise refusal
    own = set(starts[0].step.free) - set(law.result.law.values)
    return Promise(name, law.result.cost - starts[0].cost if own else 0.0, starts)


def _starts(
    structure: Structure, larger: Structure, name: str, problem: Problem, law: Judged
) -> Iterator[tuple[Mapping[str, float], Collection[str]]]:
    """Give the points that an effect is tried from, beside or in place of what the law has, and what stays of that."""
    values = law.result.law.values
    smaller = next((one for one in structure.all_effects() if effect_id(one.name) == effect_id(name)), None)
    if smaller is not None:
        gone = {parameter.name for parameter in smaller.parameters}
        for point in refined_starts(larger, smaller, problem.observations, values):
            yield point, set(values) - gone
        return
    for given in (values, *_beside_a_constant(structure, larger, name, problem, values)):
        for point in starting_points(larger, problem.observations, given):
            yield point, kept(point, values)


def _beside_a_constant(
    structure: Structure, larger: Structure, name: str, problem: Problem, values: Mapping[str, float]
) -> Iterator[Mapping[str, float]]:
    """Give where the law's stiffness may stand beside a constant force, of tests that don't move about zero.

    Without one, the stiffness carries the mean force too, by exponents of the amplitude as well, and no one step leads
    from there to where it is by the loops alone.
    """
    if about(problem.observations.motion) and larger.effect(name).is_constant:
        yield {**values, **elastic_values(surface_values(structure, problem.loops))}


def beside(promise: Promise, first: Judged, law: Judged) -> tuple[float, dict[str, float], Promise]:
    """Give what an effect promises beside another one that has been fitted, where to start them, and the effect.

    What the effect adds to the residuals, and its derivatives, are taken over from where it stood alone.

    Args:
        promise: the effect on the law as it is.
        first: the law with the other effect.
        law: the law as it is.
    """
    jacobian = first.fitted.jacobian.reshape(-1, first.fitted.jacobian.shape[2])
    own = set(first.result.equations.names)
    costs = []
    for start in promise.starts:
        step = start.step
        new = [place for place, name in enumerate(step.free) if name not in own]
        together = Linearised(
            first.result.fitted + tuple(step.free[place] for place in new),
            step.residual + (first.fitted.residual - law.fitted.residual).ravel(),
            np.concatenate([jacobian, step.jacobian[:, new]], axis=1),
        )
        costs.append(together.cost_after_one_step())
    best = int(np.argmin(costs))
    return first.result.cost - costs[best], {**promise.starts[best].values, **first.result.law.values}, promise


def screened(
    structure: Structure,
    problem: Problem,
    law: Judged,
    workers: Workers,
    ids: Collection[str] | None = None,
) -> list[Promise]:
    """Screen every effect by one step; most promising first.

    Args:
        structure: the law's structure.
        problem: the data.
        law: the law as it is.
        workers: who does it, and who is told.
        ids: effects that are screened; all where None.

    Raises:
        UserError: a declared effect can't be tried.
    """
    loops = problem.loops
    names = candidate_names(structure, loops.conditions, time_measured=loops.time_measured)
    asked = names if ids is None else [name for name in names if effect_id(name) in ids]
    found = workers.each(partial(_promise, structure, problem, law), asked, "screened {}".format)
    promises = [promise for promise in found if promise is not None]
    return sorted(promises, key=lambda promise: -promise.gain)


def fits(structure: Structure, name: str) -> bool:
    """Tell whether an effect can be added to a law: a modifier can't, where the law has nothing that it scales."""
    try:
        with_effect(structure, name).refuse_misfits()
    except UserError:
        return False
    return True


def fits_beside(structure: Structure, name: str) -> bool:
    """Tell whether an effect can be added to a law that another effect has joined, as a second one.

    Two memories that imitate each other are one memory, told more finely, and no second effect.
    """
    alike = (are_one_memory(structure.effect(name), present) for present in structure.all_effects())
    return fits(structure, name) and not any(alike)
