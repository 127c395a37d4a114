"""What the clamp on the virtual rig obeys: a law with further effects, other values and further conditions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.campaign.rig.plan import TestPlan
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.signals import column_of, signal_of
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.equations.effect import Parameter
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import LawFile, law_of
from pipeclamp_models.law.law import Equations, Law, with_effect
from pipeclamp_models.law.range import outside_range
from pipeclamp_models.realise.sizes import law_sizes, number_of

OF_THE_PLAN = {"A", "f", "T", "N"}
"""Slow signals that a plan states for each of its runs."""


def refuse_unstated(equations: Equations, conditions: Mapping[str, float]) -> None:
    """Refuse a law that follows a condition which isn't stated.

    Args:
        equations: the law's.
        conditions: further columns of runs.csv that are stated.

    Raises:
        UserError: one isn't; the message says how to state it.
    """
    stated = {signal_of(column) for column in conditions}
    needed = equations.slow_signals - OF_THE_PLAN - stated
    if needed:
        columns = sorted(column_of(name) for name in needed)
        raise UserError(f"the law depends on {', '.join(columns)}; state a value for each: --set {columns[0]}=...")


def beyond_range(file: LawFile, plan: TestPlan) -> list[str]:
    """Say which of a plan's conditions lie beyond the data of the law that stands for the clamp."""
    planned = {
        "A": plan.amplitudes,
        "f": plan.frequencies,
        "T": tuple(value + CELSIUS for value in plan.temperatures),
    }
    words = []
    for name, values in planned.items():
        outside = outside_range(file, [f"{value:g}" for value in values], {name: np.array(values)})
        words += list(outside.values())
    return words


@dataclass(frozen=True)
class Truth:
    """What the virtual clamp obeys.

    Attributes:
        law: the law.
        conditions: further columns of runs.csv, the same in every run.
        whence: where each parameter's value is from that the law's file doesn't state: SET or TYPICAL, by name.
    """

    law: Law
    conditions: Mapping[str, float]
    whence: Mapping[str, str]


SET = "--set"
TYPICAL = "typical size"


def truth_of(
    file: LawFile,
    effects: Sequence[str],
    values: Mapping[str, float],
    plan: TestPlan,
    declared: Iterable[Declaration] = (),
) -> Truth:
    """Give what the virtual clamp obeys: a law file's law, with further effects and other values.

    Args:
        file: the law to begin with.
        effects: names of effects to add.
        values: parameters by name, each in its unit; what is no parameter is a further column of runs.csv, the same in
            every run. A parameter of an added effect that isn't named gets a typical size, for the loops of the law
            under the plan.
        plan: what is run.
        declared: a user's own effects.

    Raises:
        UserError: an effect isn't known or is there already, a value is neither a parameter's
            nor a condition's, or it is out of bounds.
    """
    law = law_of(file)
    structure = replace(law.structure.with_declared(declared), frozen=())
    for effect in effects:
        structure = with_effect(structure, effect)
    equations = structure.equations
    followed = equations.slow_signals - OF_THE_PLAN
    conditions = {name: value for name, value in values.items() if name not in equations.names}
    unknown = sorted(column for column in conditions if signal_of(column) not in followed)
    if unknown:
        columns = sorted(column_of(name) for name in followed)
        known = [*equations.names, *columns]
        units = ", ".join([*(f"{one.name} ({one.unit})" for one in equations.parameters), *columns])
        raise UserError(
            f"--set: {', '.join(unknown)} is no parameter of the law and no condition that it follows; "
            f"{did_you_mean(unknown[0], known)}it has {units}"
        )
    parameters = equations.composed.parameters
    for parameter in parameters:
        _refuse_beyond(parameter, values.get(parameter.name))
    given = {**law.values, **values}
    lacking = [parameter for parameter in parameters if parameter.name not in given]
    typical: dict[str, float] = {}
    if lacking:
        refuse_unstated(equations, conditions)
        plan.check()
        further = {signal_of(column): value for column, value in conditions.items()}
        temperatures = [T + CELSIUS for T in plan.temperatures]
        slow = {"N": plan.cycles, **further}
        sizes = law_sizes(law, plan.amplitudes, plan.frequencies, temperatures, slow, plan.about or 0.0)
        typical = {parameter.name: number_of(parameter.size, sizes) for parameter in lacking}
    whence = {name: SET for name in values if name in equations.names} | dict.fromkeys(typical, TYPICAL)
    known_values = {**given, **typical}
    return Truth(
        Law(structure, {name: known_values[name] for name in equations.names}, law.v_r, law.y_r), conditions, whence
    )


def _refuse_beyond(parameter: Parameter, value: float | None) -> None:
    """Refuse a value beyond bounds that are numbers, which physics sets; others hang on the data's sizes."""
    lower, upper = (
        bound if isinstance(bound, int | float) else otherwise
        for bound, otherwise in ((parameter.lower, -np.inf), (parameter.upper, np.inf))
    )
    if value is not None and not lower <= value <= upper:
        expected = f"at least {lower:g}" if upper == np.inf else f"{lower:g} to {upper:g}"
        raise UserError(
            f"--set: {parameter.name} = {value:g} {parameter.unit} ({parameter.meaning}); expected {expected}"
        )
