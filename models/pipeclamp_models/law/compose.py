"""Equations of effects, composed into one set: the one place where a law's mathematics is put together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import sympy as sp

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Stage, State
from pipeclamp_models.equations.replacing import replaced
from pipeclamp_models.law.catalogue import effect_id
from pipeclamp_models.law.series import Path, behind

FAST_SYMBOLS = frozenset(signal.symbol for signal in symbols.FAST)
FIXED_SYMBOLS = frozenset((*symbols.REFERENCES, symbols.v_r, symbols.y_r))
HELD = "_"
"""What the symbol of a slow signal ends in where it is held over a cycle, as no symbol of an effect does."""


@dataclass(frozen=True, eq=False)
class Composed:
    """A composed law, symbolic: what every realisation is derived from.

    Attributes:
        effects: the effects it was composed of.
        parameters: all parameters.
        coefficients: functions of slow signals and parameters, by which `force` is short.
        force: N, in fast signals, coefficients, parameters and states (after their update).
        states: the memory.
        stages: what is computed on the way to the states after a step, in order; their updates are in these too.
        energy: stored energy, N mm.
        lag: time in s by which the measured force is late, in parameters.
    """

    effects: tuple[Effect, ...]
    parameters: tuple[Parameter, ...]
    coefficients: tuple[Coefficient, ...]
    force: sp.Expr
    states: tuple[State, ...]
    stages: tuple[Stage, ...]
    energy: sp.Expr
    lag: sp.Expr

    @cached_property
    def within_steps(self) -> tuple[sp.Expr, ...]:
        """What a step computes before the force: the stages, then the states' updates."""
        return (*(stage.expression for stage in self.stages), *(state.update for state in self.states))

    @cached_property
    def at_rest(self) -> sp.Expr:
        """The force at rest at y = 0 with an unloaded memory, N, in slow signals and parameters."""
        still = dict.fromkeys(FAST_SYMBOLS, sp.S.Zero)
        unloaded = {state.symbol: sp.sympify(state.start) for state in self.states}
        slow = {coefficient.symbol: coefficient.expression for coefficient in self.coefficients}
        return self.force.xreplace({**still, **unloaded}).xreplace(slow)

    @cached_property
    def used_symbols(self) -> frozenset[sp.Symbol]:
        """All symbols that the force depends on: a modifier may have a parameter with nothing to scale."""
        expressions = [coefficient.expression for coefficient in self.coefficients]
        expressions += [self.force, self.lag, *self.within_steps]
        return frozenset().union(*(expression.free_symbols for expression in expressions))

    @cached_property
    def slow_signals(self) -> frozenset[sp.Symbol]:
        """The slow signals (A, f, T, further conditions) that the law depends on."""
        free = set().union(*(coefficient.expression.free_symbols for coefficient in self.coefficients))
        return frozenset(free - {parameter.symbol for parameter in self.parameters} - FIXED_SYMBOLS)


def compose(effects: tuple[Effect, ...], base: str) -> Composed:
    """Compose the equations of effects; the base law's name is for messages.

    Raises:
        UserError: two effects use one symbol or one path, or a modifier finds nothing to scale.
    """
    refuse_misfits(effects, base)
    plain = [coefficient for effect in effects for coefficient in effect.coefficients]
    effects = tuple(_without_idle(effect, plain) for effect in effects)
    fast = FAST_SYMBOLS | {symbol for effect in effects for symbol in effect.within_steps}
    coefficients, fast_factors = _scaled(effects, plain, fast)
    in_series = {symbols.x: next((each.replaces[symbols.x] for each in _replacing(symbols.x, effects)), symbols.y)}

    def whole(expression: sp.Expr) -> sp.Expr:
        return replaced(replaced(expression, fast_factors), in_series)

    before = next(iter(_replacing(symbols.y, effects)), None)
    clamp = _path([effect for effect in effects if effect.part != "rig" and effect is not before], whole)
    clamp = behind(before, clamp) if before else clamp
    rig = _path([effect for effect in effects if effect.part == "rig"], whole)
    force, energy = clamp.force + rig.force, clamp.energy + rig.energy
    states, stages = (*clamp.states, *rig.states), (*clamp.stages, *rig.stages)
    parameters = tuple(parameter for effect in effects for parameter in effect.parameters)
    # A slow signal within a force is a coefficient of its own, held over a cycle as the others are.
    known = fast | FIXED_SYMBOLS | {entry.symbol for entry in parameters} | {entry.symbol for entry in coefficients}
    known |= {stage.symbol for stage in stages}
    within = [*(stage.expression for stage in stages), *(state.update for state in states)]
    bare = set().union(*(entry.free_symbols for entry in (force, energy, *within))) - known
    held = {symbol: sp.Symbol(f"{symbol}{HELD}", real=True) for symbol in sorted(bare, key=str)}
    return Composed(
        effects=effects,
        parameters=parameters,
        coefficients=(
            *coefficients,
            *(Coefficient(symbol, symbols.unit(signal), None, signal) for signal, symbol in held.items()),
        ),
        force=replaced(force, held),
        states=tuple(replace(state, update=replaced(state.update, held)) for state in states),
        stages=tuple(replace(stage, expression=replaced(stage.expression, held)) for stage in stages),
        energy=replaced(energy, held),
        lag=sp.Add(*(effect.lag for effect in effects)),
    )


def _scaled(
    effects: Iterable[Effect], coefficients: Sequence[Coefficient], fast: frozenset[sp.Symbol]
) -> tuple[list[Coefficient], dict[sp.Symbol, sp.Expr]]:
    """Give coefficients with the factors that effects scale them by.

    A factor that changes within a cycle (with v, say) goes into the force itself; coefficients stay slow.

    Args:
        effects: all of the law's.
        coefficients: as their effects state them.
        fast: symbols that change within a cycle.

    Returns:
        the coefficients; and what stands in the force for those that fast factors scale, by symbol.
    """
    scaled = list(coefficients)
    fast_factors: dict[sp.Symbol, sp.Expr] = {}
    for effect in effects:
        for index, factor in scaled_by(effect, scaled):
            entry = scaled[index]
            if factor.free_symbols & fast:
                fast_factors[entry.symbol] = fast_factors.get(entry.symbol, entry.symbol) * factor
            else:
                scaled[index] = replace(entry, expression=entry.expression * factor)
    return scaled, fast_factors


def _path(effects: Sequence[Effect], whole: Callable[[sp.Expr], sp.Expr]) -> Path:
    """Give the sum of effects side by side; `whole` makes an effect's expression the law's."""
    return Path(
        whole(sp.Add(*(effect.force for effect in effects))),
        whole(sp.Add(*(effect.energy for effect in effects))),
        tuple(replace(state, update=whole(state.update)) for effect in effects for state in effect.states),
        tuple(replace(stage, expression=whole(stage.expression)) for effect in effects for stage in effect.stages),
    )


def scaled_by(effect: Effect, coefficients: Sequence[Coefficient]) -> list[tuple[int, sp.Expr]]:
    """Give which coefficients an effect scales, by name or by role, each with the factor."""
    return [
        (index, factor)
        for target, factor in effect.scales.items()
        for index, entry in enumerate(coefficients)
        if entry.is_scaled_by(target)
    ]


def _without_idle(effect: Effect, coefficients: Sequence[Coefficient]) -> Effect:
    """Give an effect without those parameters that are there only if a factor with them scales something."""
    scaling = frozenset().union(*(factor.free_symbols for _, factor in scaled_by(effect, coefficients)))
    kept = tuple(one for one in effect.parameters if not one.if_scaled or one.symbol in scaling)
    return effect if kept == effect.parameters else replace(effect, parameters=kept)


def brought_into_view(
    effects: Sequence[Effect], coefficients: Sequence[Coefficient]
) -> dict[sp.Symbol, tuple[sp.Expr, ...]]:
    """Give the factors by which starts and bounds reach further, by parameter: of the unit of what is scaled."""
    return {
        parameter.symbol: scaling.brings_into_view
        for scaling in effects
        if scaling.brings_into_view
        for index, _ in scaled_by(scaling, coefficients)
        for effect in effects
        for parameter in effect.parameters
        if parameter.unit == coefficients[index].unit
        and parameter.symbol in coefficients[index].expression.free_symbols
    }


def refuse_misfits(effects: tuple[Effect, ...], base: str) -> None:
    """Refuse effects that can't be composed, without composing them, which takes up to a second.

    Raises:
        UserError: as `compose`.
    """
    _refuse_clashes(effects)
    coefficients = [coefficient for effect in effects for coefficient in effect.coefficients]
    for effect in effects:
        if effect.scales and not scaled_by(effect, coefficients):
            raise UserError(
                f"effect {effect.name!r} scales {' and '.join(effect.scales)}, which base law {base!r} lacks"
            )
    for signal, what in ((symbols.x, "the elastic path"), (symbols.y, "the whole clamp")):
        found = _replacing(signal, effects)
        if len(found) > 1:
            names = " and ".join(repr(effect.name) for effect in found)
            raise UserError(f"effects {names} both stand in series with {what}; leave one out")


def _replacing(signal: sp.Symbol, effects: Iterable[Effect]) -> list[Effect]:
    """Give the effects that put another displacement in a signal's place: one at most where they can be composed."""
    return [effect for effect in effects if signal in effect.replaces]


def _refuse_clashes(effects: tuple[Effect, ...]) -> None:
    """Refuse effects that are named twice or that share a symbol: its name is what files and sources know."""
    owner: dict[str, Effect] = {}
    members: dict[str, Effect] = {}
    for effect in effects:
        other = members.setdefault(effect_id(effect.name), effect)
        if other.name != effect.name:
            raise UserError(
                f"effects {other.name!r} and {effect.name!r} are one effect with different numbers, and a law has one "
                "of them; leave one out"
            )
        for symbol in effect.own_symbols:
            if symbol in owner:
                name = owner[symbol].name
                raise UserError(
                    f"effect {effect.name!r} is there twice; name it once"
                    if name == effect.name
                    else f"effects {name!r} and {effect.name!r} both use the symbol {symbol}; leave one out"
                )
            owner[symbol] = effect
