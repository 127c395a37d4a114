"""A law without its mathematics: what its parameters and states are, as words and numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from types import CodeType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import sympy as sp

    from pipeclamp_models.equations.effect import Parameter
    from pipeclamp_models.law.compose import Composed

NumberOrExpression = float | str
"""A number, or Python's expression of one in the data's scales."""
Sizes = Mapping[str, float]
"""The data's scales and the reference values of ratios, by the names of their symbols."""


WIDER_STARTS = 2
"""Bounds of what another condition brings into view reach so many times as far as its starts do, on a log scale: how
far it moves there isn't known before."""
NEAR_BOUND = 1e-5
"""A parameter that is at a bound lies this close to it, or at another one."""


def bound_at(value: float, *bounds: object) -> float:
    """Give the bound that a value has run into, of those that are numbers; the value where it is at none of them.

    A fit stops short of a bound by what its arithmetic leaves, 1e-57 where 0 is meant.
    """
    known = [float(bound) for bound in bounds if isinstance(bound, int | float) and math.isfinite(bound)]
    return next((one for one in known if abs(value - one) <= NEAR_BOUND * max(abs(one), 1.0)), value)


@dataclass(frozen=True)
class ParameterOutline:
    """A parameter of a law.

    Attributes:
        name, unit, meaning, size, neutral, levels, by_shape, stated: as of the effect's `Parameter`.
        effect: name of the effect that it belongs to.
        starts: where the fit starts, one value or several.
        lower, upper: bounds.
        spread: standard deviation of its prior about `neutral`, None where there is none.
        follows: names of the slow signals that must vary in the data for it to be determined.
        used: whether anything in the law depends on it.
        at_rest: whether it makes a force at rest at y = 0, the memory unloaded.
    """

    name: str
    unit: str
    meaning: str
    effect: str
    starts: tuple[NumberOrExpression, ...]
    size: NumberOrExpression
    lower: NumberOrExpression
    upper: NumberOrExpression
    spread: NumberOrExpression | None
    neutral: float | None
    follows: tuple[str, ...]
    levels: int
    used: bool
    at_rest: bool
    by_shape: bool
    stated: bool


@dataclass(frozen=True)
class StateOutline:
    """A state of a law: its name, and its value at rest."""

    name: str
    start: float


@dataclass(frozen=True)
class Outline:
    """What a law consists of.

    Attributes:
        effects: names of the effects that it was composed of.
        parameters: all parameters.
        states: the memory.
        slow_signals: names of the slow signals (A, f, T, further conditions) that it depends on.
        coefficients: names of the functions of slow signals and parameters that its force is in.
        fades: whether its memory fades with time.
        late: whether the measured force lags behind.
    """

    effects: tuple[str, ...]
    parameters: tuple[ParameterOutline, ...]
    states: tuple[StateOutline, ...]
    slow_signals: frozenset[str]
    coefficients: tuple[str, ...]
    fades: bool
    late: bool


def as_json(outline: Outline) -> dict[str, Any]:
    """Give an outline as JSON holds it."""
    return {**asdict(outline), "slow_signals": sorted(outline.slow_signals)}


def from_json(content: Mapping[str, Any]) -> Outline:
    """Give the outline that was made such."""
    parameters = [
        {**entry, "starts": tuple(entry["starts"]), "follows": tuple(entry["follows"])}
        for entry in content["parameters"]
    ]
    return Outline(
        effects=tuple(content["effects"]),
        parameters=tuple(ParameterOutline(**entry) for entry in parameters),
        states=tuple(StateOutline(**entry) for entry in content["states"]),
        slow_signals=frozenset(content["slow_signals"]),
        coefficients=tuple(content["coefficients"]),
        fades=content["fades"],
        late=content["late"],
    )


def outline_of(composed: Composed) -> Outline:
    """Give the outline of composed equations."""
    from pipeclamp_models.equations import symbols
    from pipeclamp_models.law.compose import brought_into_view

    factors = brought_into_view(composed.effects, composed.coefficients)
    return Outline(
        effects=tuple(effect.name for effect in composed.effects),
        parameters=tuple(
            _parameter(parameter, effect.name, factors.get(parameter.symbol, ()), composed)
            for effect in composed.effects
            for parameter in effect.parameters
        ),
        states=tuple(StateOutline(str(state.symbol), float(state.start)) for state in composed.states),
        slow_signals=frozenset(map(str, composed.slow_signals)),
        coefficients=tuple(str(coefficient.symbol) for coefficient in composed.coefficients),
        fades=any(symbols.h in expression.free_symbols for expression in composed.within_steps),
        late=composed.lag != 0,
    )


def _parameter(parameter: Parameter, effect: str, factors: Sequence[sp.Expr], composed: Composed) -> ParameterOutline:
    starts = (*parameter.starts, *(factor * start for factor in factors for start in parameter.starts))
    lower, upper = parameter.lower, parameter.upper
    if factors:
        import sympy as sp

        lower, upper = lower * sp.Min(1, *factors) ** WIDER_STARTS, upper * sp.Max(1, *factors) ** WIDER_STARTS
    return ParameterOutline(
        name=parameter.name,
        unit=parameter.unit,
        meaning=parameter.meaning,
        effect=effect,
        starts=tuple(_quantity(start) for start in starts),
        size=_quantity(parameter.size),
        lower=_quantity(lower),
        upper=_quantity(upper),
        spread=None if parameter.spread is None else _quantity(parameter.spread),
        neutral=parameter.neutral,
        follows=tuple(map(str, parameter.follows)),
        levels=parameter.levels,
        used=parameter.symbol in composed.used_symbols,
        at_rest=parameter.symbol in composed.at_rest.free_symbols,
        by_shape=parameter.by_shape,
        stated=parameter.stated,
    )


def _quantity(value: sp.Expr | float) -> NumberOrExpression:
    """Give a start or a bound as Python's own expression."""
    if isinstance(value, int | float):
        return float(value)
    from sympy.printing.pycode import pycode

    return str(pycode(value)) if value.free_symbols else float(value)


def number_in(quantity: NumberOrExpression, sizes: Sizes) -> float:
    """Give a start or a bound as a number, for data of these sizes."""
    if isinstance(quantity, float):
        return quantity
    return float(eval(_compiled(quantity), {"math": math}, dict(sizes)))


@lru_cache(maxsize=4096)
def _compiled(expression: str) -> CodeType:
    return compile(expression, "<size>", "eval")


def levels_taken(signal: str, parameters: Iterable[ParameterOutline]) -> int:
    """Give the levels of a slow signal that parameters take which follow it, at most; 0 where none follows it."""
    return max((one.levels for one in parameters if signal in one.follows), default=0)
