"""A cheap screen: what each effect of the catalogue promises by one step of linear least squares."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem, are_one_memory
from pipeclamp_identification.fitting.least_squares import sized_and_linearised, starting_points
from pipeclamp_identification.fitting.refinement import refined_starts
from pipeclamp_identification.fitting.starts import Linearised, kept
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.equations.effect import Family
from pipeclamp_models.law.catalogue import effect_id, entries, find_effect
from pipeclamp_models.law.law import Structure, with_effect


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
class Promise:
    """What an effect promises by one step of linear least squares from the best of its starts.

    Attributes:
        name: the effect.
        gain: by how much the step lowers the cost.
        start: the start's values, all of the law's parameters.
        steps: the law with the effect at each of its starts, linearised.
        starts: those starts.
    """

    name: str
    gain: float
    start: Mapping[str, float]
    steps: Sequence[Linearised]
    starts: Sequence[Mapping[str, float]]

    def ranked_starts(self) -> list[Mapping[str, float]]:
        """Give the starts, most promising first."""
        costs = [step.cost_after_one_step() for step in self.steps]
        return [self.starts[place] for place in np.argsort(costs, kind="stable")]


def _promise(structure: Structure, name: str, problem: Problem, law: Judged) -> Promise | None:
    """Give what an effect promises; None if it can't be fitted.

    Args:
        structure: the law's structure.
        name: the effect.
        problem: the data.
        law: the law as it is.
    """
    try:
        larger = with_effect(structure, name)
        stated = list(_starts(structure, larger, name, problem, law))
    except UserError:
        if any(declaration.id == name for declaration in structure.declared):
            raise  # who declares an effect wants to know why it can't be tried
        return None
    started = [sized_and_linearised(larger, problem.coarse, point, known) for point, known in stated]
    starts, steps = [start for start, _ in started], [step for _, step in started]
    costs = [step.cost_after_one_step() for step in steps]
    best = int(np.argmin(costs))
    return Promise(name, law.result.cost - costs[best], starts[best], steps, starts)


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
    for point in starting_points(larger, problem.observations, values):
        yield point, kept(point, values)


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
    for step in promise.steps:
        new = [place for place, name in enumerate(step.free) if name not in own]
        together = Linearised(
            first.result.fitted + tuple(step.free[place] for place in new),
            step.residual + (first.fitted.residual - law.fitted.residual).ravel(),
            np.concatenate([jacobian, step.jacobian[:, new]], axis=1),
        )
        costs.append(together.cost_after_one_step())
    best = int(np.argmin(costs))
    return first.result.cost - costs[best], {**promise.starts[best], **first.result.law.values}, promise


def screened(
    structure: Structure,
    problem: Problem,
    law: Judged,
    tell: Callable[[str], None],
    ids: Collection[str] | None = None,
) -> list[Promise]:
    """Screen every effect, or those of some ids, by one step; most promising first."""
    promises = []
    loops = problem.loops
    names = candidate_names(structure, loops.conditions, time_measured=loops.time_measured)
    for name in names if ids is None else [name for name in names if effect_id(name) in ids]:
        tell(f"screen {name}")
        promise = _promise(structure, name, problem, law)
        if promise is not None:
            promises.append(promise)
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
