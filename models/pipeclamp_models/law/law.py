"""Laws: a base and effects, composed into one set of equations, with values for its parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import sympy as sp

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.equations import symbols
from pipeclamp_models.equations.effect import Coefficient, Effect, Parameter, Part, Stage, State
from pipeclamp_models.law.catalogue import effect_id, find_effect, member_number
from pipeclamp_models.law.declaration import Declaration, effect_of, merged
from pipeclamp_models.law.series import Path, behind

FAST_SYMBOLS = frozenset(signal.symbol for signal in symbols.FAST)
FIXED_SYMBOLS = frozenset((*symbols.REFERENCES, symbols.v_r, symbols.y_r))


HELD = "_"
"""What the symbol of a slow signal ends in where it is held over a cycle, as no symbol of an effect does."""


@dataclass(frozen=True)
class Base:
    """A base law.

    Attributes:
        terms: names of the effects that it consists of.
        fixed: parameters that its form fixes.
        general: whether it may stand for any device; otherwise it states one clamp's surfaces.
    """

    terms: tuple[str, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    general: bool = True


BASES: Mapping[str, Base] = {
    "power": Base(("linear_stiffness", "cubic_stiffness", "power_damping")),
    "memory": Base(
        ("linear_stiffness", "cubic_stiffness", "power_damping", "memory"),
        {"alpha0": 1.0, "alpha_A": 0.0, "alpha_f": 0.0},
    ),
    "series": Base(("elastic_series", "damping_series")),
    "published": Base(("published_clamp",), general=False),
}
"""Base laws by name: Eq. 17 (`power`), Eq. 14 (`memory`), Eq. 10 (`series`), the paper's own surfaces."""


def find_base(name: str) -> Base:
    """Give a base law by name; `series:5:2` is the series with powers up to 5 of y and 2 of v.

    Raises:
        UserError: there is no such base.
    """
    identifier, *orders = name.split(":")
    base = BASES.get(identifier)
    if base is None or len(orders) not in ({0, 2} if identifier == "series" else {0}):
        raise UserError(f"base law {name!r} is not known; expected one of {', '.join(BASES)} or series:5:2")
    if orders:
        return replace(base, terms=tuple(f"{term}:{order}" for term, order in zip(base.terms, orders, strict=True)))
    return base


@dataclass(frozen=True)
class Structure:
    """Which equations a law has.

    Attributes:
        base: name of the base law.
        effects: names of the effects added to it, in the order they were added.
        frozen: parameters that are not identified, with the value they are held at.
        declared: a user's own effects, in use or not.
    """

    base: str = "power"
    effects: tuple[str, ...] = ()
    frozen: tuple[tuple[str, float], ...] = ()
    declared: tuple[Declaration, ...] = ()

    def all_effects(self) -> tuple[Effect, ...]:
        """Give the base's terms and the effects added to them, in order.

        Of a numbered family, an added member takes the place of the base's: `memory` with `memory:2` has two elements.
        """
        added = tuple(self.effect(name) for name in self.effects)
        kinds = {effect_id(effect.name): effect.name for effect in added}
        terms = (name for name in find_base(self.base).terms if kinds.get(effect_id(name), name) == name)
        return (*(self.effect(name) for name in terms), *added)

    def effect(self, name: str) -> Effect:
        """Give an effect by its name: of the catalogue, or declared.

        Raises:
            UserError: there is no such effect.
        """
        return find_effect(name, {declaration.id: effect_of(declaration) for declaration in self.declared})

    def with_declared(self, declarations: Iterable[Declaration]) -> Structure:
        """Give the structure with further declarations at hand.

        Raises:
            UserError: two that differ have one id.
        """
        return replace(self, declared=merged(self.declared, declarations))

    @property
    def equations(self) -> Equations:
        """The structure's equations, rig effects among them; equal structures share one set.

        Raises:
            UserError: as `compose`.
        """
        return _equations(self, ("base", "clamp", "rig"))

    @property
    def equations_without_rig(self) -> Equations:
        """The equations that travel: without what belongs to the rig; equal structures share one set.

        Raises:
            UserError: as `compose`.
        """
        return _equations(self, ("base", "clamp"))

    def own(self, values: Mapping[str, float]) -> dict[str, float]:
        """Give those values, by name, that are of the structure's parameters."""
        names = set(self.equations.names)
        return {name: value for name, value in values.items() if name in names}

    def held(self) -> dict[str, float]:
        """Give the values at which the base's form and `frozen` hold parameters."""
        return {**find_base(self.base).fixed, **dict(self.frozen)}


@dataclass(frozen=True, eq=False)
class Equations:
    """A composed law, still symbolic: what every realisation is derived from.

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
    def names(self) -> tuple[str, ...]:
        """Names of the parameters in order."""
        return tuple(parameter.name for parameter in self.parameters)

    @cached_property
    def within_steps(self) -> tuple[sp.Expr, ...]:
        """What a step computes before the force: the stages, then the states' updates."""
        return (*(stage.expression for stage in self.stages), *(state.update for state in self.states))

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


@lru_cache(maxsize=256)
def _equations(structure: Structure, parts: tuple[Part, ...]) -> Equations:
    """Give the equations of a structure, composed once.

    The one place that remembers equations, and with them what is compiled of them: a diagnosis makes the structure of a
    candidate anew in every fold and every process's task.
    """
    return compose(structure, parts)


def compose(structure: Structure, parts: tuple[Part, ...]) -> Equations:
    """Compose the equations of a structure from the effects of the given parts; see `Structure.equations`.

    Raises:
        UserError: two effects use one symbol or one path, or a modifier finds nothing to scale.
    """
    effects = tuple(effect for effect in structure.all_effects() if effect.part in parts)
    _refuse_clashes(effects)
    coefficients = [coefficient for effect in effects for coefficient in effect.coefficients]
    # A factor that changes within a cycle (with v, say) goes into the force itself; coefficients stay slow.
    fast_factors: dict[sp.Symbol, sp.Expr] = {}
    fast = FAST_SYMBOLS | {symbol for effect in effects for symbol in effect.within_steps}
    for effect in effects:
        scaled = [
            (index, factor)
            for target, factor in effect.scales.items()
            for index, entry in enumerate(coefficients)
            if target in (str(entry.symbol), entry.role)
        ]
        if effect.scales and not scaled:
            raise UserError(
                f"effect {effect.name!r} scales {' and '.join(effect.scales)}, which base law {structure.base!r} lacks"
            )
        for index, factor in scaled:
            entry = coefficients[index]
            if factor.free_symbols & fast:
                fast_factors[entry.symbol] = fast_factors.get(entry.symbol, entry.symbol) * factor
            else:
                coefficients[index] = replace(entry, expression=entry.expression * factor)
    elastic = _in_series(effects, symbols.x, "the elastic path")
    in_series = {symbols.x: elastic.replaces[symbols.x] if elastic else symbols.y}

    def whole(expression: sp.Expr) -> sp.Expr:
        return expression.xreplace(fast_factors).xreplace(in_series)

    def path(some: Iterable[Effect]) -> Path:
        terms = list(some)
        return Path(
            whole(sp.Add(*(effect.force for effect in terms))),
            whole(sp.Add(*(effect.energy for effect in terms))),
            tuple(replace(state, update=whole(state.update)) for effect in terms for state in effect.states),
            tuple(replace(stage, expression=whole(stage.expression)) for effect in terms for stage in effect.stages),
        )

    parameters = tuple(parameter for effect in effects for parameter in effect.parameters)
    before = _in_series(effects, symbols.y, "the whole clamp")
    clamp = path(effect for effect in effects if effect.part != "rig" and effect is not before)
    clamp = behind(before, clamp) if before else clamp
    rig = path(effect for effect in effects if effect.part == "rig")
    force, energy = clamp.force + rig.force, clamp.energy + rig.energy
    states, stages = (*clamp.states, *rig.states), (*clamp.stages, *rig.stages)
    # A slow signal within a force is a coefficient of its own, held over a cycle as the others are.
    known = fast | FIXED_SYMBOLS | {entry.symbol for entry in parameters} | {entry.symbol for entry in coefficients}
    known |= {stage.symbol for stage in stages}
    within = [*(stage.expression for stage in stages), *(state.update for state in states)]
    bare = set().union(*(entry.free_symbols for entry in (force, energy, *within))) - known
    held = {symbol: sp.Symbol(f"{symbol}{HELD}", real=True) for symbol in sorted(bare, key=str)}
    coefficients += [Coefficient(symbol, symbols.unit(signal), None, signal) for signal, symbol in held.items()]
    return Equations(
        effects=effects,
        parameters=parameters,
        coefficients=tuple(coefficients),
        force=force.xreplace(held),
        states=tuple(replace(state, update=state.update.xreplace(held)) for state in states),
        stages=tuple(replace(stage, expression=stage.expression.xreplace(held)) for stage in stages),
        energy=energy.xreplace(held),
        lag=sp.Add(*(effect.lag for effect in effects)),
    )


def _in_series(effects: Iterable[Effect], signal: sp.Symbol, what: str) -> Effect | None:
    """Give the effect that replaces a signal, None where there is none.

    Raises:
        UserError: two effects do.
    """
    found = [effect for effect in effects if signal in effect.replaces]
    if len(found) > 1:
        names = " and ".join(repr(effect.name) for effect in found)
        raise UserError(f"effects {names} both stand in series with {what}; leave one out")
    return found[0] if found else None


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
        own = (
            [str(parameter.symbol) for parameter in effect.parameters]
            + [str(coefficient.symbol) for coefficient in effect.coefficients]
            + [str(symbol) for symbol in effect.within_steps]
        )
        for symbol in own:
            if symbol in owner:
                name = owner[symbol].name
                raise UserError(
                    f"effect {effect.name!r} is there twice; name it once"
                    if name == effect.name
                    else f"effects {name!r} and {effect.name!r} both use the symbol {symbol}; leave one out"
                )
            owner[symbol] = effect


@dataclass(frozen=True)
class Law:
    """A structure with a value for each parameter.

    Attributes:
        structure: the equations.
        values: parameter values by name, in the house's units.
        v_r: velocity below which |v|^alpha sgn v is smoothed, mm/s.
        y_r: displacement below which sgn y is smoothed, mm.
    """

    structure: Structure
    values: Mapping[str, float]
    v_r: float
    y_r: float

    @property
    def equations(self) -> Equations:
        """The equations of its structure."""
        return self.structure.equations

    def vector(self, equations: Equations) -> tuple[float, ...]:
        """Give the values in the order of the equations' parameters."""
        return tuple(self.values[name] for name in equations.names)


SMOOTHING = 0.01
"""v_r as a share of the smallest peak velocity in range: costs less than 0.05 % of dW, even at alpha = 0."""


def smoothing(smallest_amplitude: float, lowest_frequency: float) -> tuple[float, float]:
    """Give v_r (mm/s) and y_r (mm) for a range that begins at this amplitude (mm) and frequency (Hz)."""
    y_r = SMOOTHING * smallest_amplitude
    return float(2 * sp.pi * lowest_frequency) * y_r, y_r


def with_effect(structure: Structure, effect: str) -> Structure:
    """Give the structure with one more effect; a larger member of a numbered family takes the smaller one's place.

    Raises:
        UserError: the effect, or a larger one of its family, is there already, or it is part of the base law.
    """
    added = structure.effect(effect)
    if added.part == "base":
        raise UserError(f"effect {effect!r} is a term of base laws; choose a base with identify --base")
    present = [one.name for one in structure.all_effects() if effect_id(one.name) == effect_id(added.name)]
    law = " + ".join((structure.base, *structure.effects))
    if added.name in present:
        raise UserError(f"effect {effect!r} is in the law already: {law}; expected another one")
    for name in present:
        if member_number(name) > member_number(added.name):
            raise UserError(
                f"effect {effect!r}: the law has {name!r} already, which does what {effect!r} does, and more: {law}; "
                f"to have {effect!r} in its place, remove {name!r} first"
            )
    kept = tuple(name for name in structure.effects if structure.effect(name).name not in present)
    return replace(structure, effects=(*kept, effect))
