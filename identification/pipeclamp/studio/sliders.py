"""Sliders: a law's parameters as they can be moved, and those that a candidate would add."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pipeclamp.studio.diagnosis_shown import CandidateShown
from pipeclamp_models.base.units import unit_shown
from pipeclamp_models.law.file import LawFile, structure_of
from pipeclamp_models.law.outline import NumberOrExpression, ParameterOutline

MOST_ERRORS = 10.0
"""A slider reaches this many standard errors, and to zero and twice the value at least."""


@dataclass(frozen=True)
class Slider:
    """A parameter that can be moved, from low to high; its standard error where it has one."""

    name: str
    value: float
    low: float
    high: float
    unit: str
    meaning: str
    error: float | None


def sliders_of(file: LawFile) -> tuple[tuple[str, tuple[Slider, ...]], ...]:
    """Give the parameters of a law, by effect, the last effect first; held ones stay."""
    groups: dict[str, list[Slider]] = {}
    for parameter in structure_of(file).equations.parameters:
        entry = file.coefficients[parameter.name]
        if entry.state != "held":
            groups.setdefault(parameter.effect, []).append(_slider(parameter, entry.value, entry.standard_error))
    return tuple((effect, tuple(sliders)) for effect, sliders in reversed(groups.items()))


def candidate_sliders(file: LawFile, candidate: CandidateShown) -> tuple[Slider, ...]:
    """Give the parameters that a candidate would add to a law, at the values that the diagnosis fitted."""
    structure = replace(structure_of(file), effects=candidate.effects)
    return tuple(
        _slider(parameter, candidate.values[parameter.name], None)
        for parameter in structure.equations.parameters
        if parameter.name in candidate.values and parameter.name not in file.coefficients
    )


def _slider(parameter: ParameterOutline, value: float, error: float | None) -> Slider:
    reach = max(abs(value), MOST_ERRORS * (error or 0.0)) or 1.0
    low = max(value - reach, _bound(parameter.lower, -math.inf))
    high = min(value + reach, _bound(parameter.upper, math.inf))
    return Slider(parameter.name, value, low, high, unit_shown(parameter.unit), parameter.meaning, error)


def _bound(bound: NumberOrExpression, otherwise: float) -> float:
    """Give a bound that is a number; one that is in sizes of the data doesn't limit a slider."""
    return otherwise if isinstance(bound, str) else float(bound)
