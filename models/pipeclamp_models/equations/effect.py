"""What an effect states: the contract of every file in `effects/` and of users' declarations."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import sympy as sp

from pipeclamp_models.base.signals import Part, Role
from pipeclamp_models.equations import symbols

NOTHING = sp.Integer(0)
UNIT_OF_TIME = re.compile(r"\b(s\d?|Hz|t)\b")
"""In units of parameters: a mass is N s2/mm."""


@dataclass(frozen=True)
class Parameter:
    """A number of an effect that is identified from tests.

    Attributes:
        symbol: its symbol, unique within a law.
        unit: unit in the house's system (mm, N, s, K, Hz).
        meaning: one phrase.
        start: where the fit starts: one value, or several where the error has several valleys
            (the parameters of one effect then have equally many). A value may be an expression
            in the data's scales (`symbols.SCALES`).
        lower, upper: bounds that physics sets; numbers or expressions in the data's scales.
        neutral: the value at which it changes nothing, where there is one. A parameter that the
            data can't determine is frozen there.
        follows: the slow signals that must vary in the data for it to be determined.
        levels: how many distinct levels of them it takes.
        typical: a size at which the effect shows in a loop, where `start` has none: to try it out on the virtual rig.
        known_within: standard deviation by which `neutral` is known beforehand, from physics: of a normal prior.
        if_scaled: whether it is there only in laws that have what a factor with it scales.
        by_shape: whether nothing but a loop's shape tells it from others where the amplitude doesn't vary.
        stated: whether others are stated at it, so that no data determine it: it stays where it starts.
    """

    symbol: sp.Symbol
    unit: str
    meaning: str
    start: sp.Expr | float | tuple[sp.Expr | float, ...]
    lower: sp.Expr | float = -math.inf
    upper: sp.Expr | float = math.inf
    neutral: float | None = None
    follows: tuple[sp.Symbol, ...] = ()
    levels: int = 2
    typical: sp.Expr | float | None = None
    known_within: float | None = None
    if_scaled: bool = False
    by_shape: bool = False
    stated: bool = False

    @property
    def name(self) -> str:
        """The symbol as text, as it stands in parameter files."""
        return str(self.symbol)

    @property
    def starts(self) -> tuple[sp.Expr | float, ...]:
        """All starts as a tuple."""
        return self.start if isinstance(self.start, tuple) else (self.start,)

    @property
    def spread(self) -> sp.Expr | float | None:
        """Standard deviation of the normal prior about `neutral`; None where there is none.

        How strongly a coefficient follows a condition is what few conditions leave open, so it shrinks to "not at all"
        as far as the data don't say otherwise. Its bounds, which lie symmetrically, are three standard deviations off.
        """
        if self.known_within is not None:
            return self.known_within
        symmetric = self.neutral is not None and not self.lower + self.upper - 2 * self.neutral
        return self.upper / 3 if self.follows and symmetric and self.upper != math.inf else None

    @property
    def size(self) -> sp.Expr | float:
        """A typical size, such as real clamps and rigs have: what is stated, or the middle one of the starts."""
        return self.typical if self.typical is not None else self.starts[len(self.starts) // 2]


@dataclass(frozen=True)
class Coefficient:
    """A named factor of a force that depends on slow signals; modifiers scale it by name or role.

    Of slip forces that differ between the directions, those on the way down are scaled by the role "slip down", too.
    """

    symbol: sp.Symbol
    unit: str
    role: Role | None
    expression: sp.Expr
    down: bool = False

    def is_scaled_by(self, target: str) -> bool:
        """Tell whether a modifier that scales a name or role scales it."""
        return target in (str(self.symbol), self.role) or (self.down and target == f"{self.role} down")


@dataclass(frozen=True)
class State:
    """Memory of an effect: `update` is the value after a step from `y_previous` to `y` lasting `h`.

    In `update` the symbol stands for the value before the step, in forces for the value after it.
    """

    symbol: sp.Symbol
    unit: str
    meaning: str
    update: sp.Expr
    start: float = 0.0


@dataclass(frozen=True)
class Stage:
    """What is computed within a step on the way to the new states, so that no expression is written twice.

    `expression` is in what updates are in, and in the stages before it. Forces don't know stages.
    """

    symbol: sp.Symbol
    unit: str
    meaning: str
    expression: sp.Expr


@dataclass(frozen=True, eq=False)
class Refinement:
    """The next larger member of an effect's family, which does all that the effect does, and more.

    Attributes:
        name: the larger member, as commands and files name it.
        start: makes starting values of all of the larger member's parameters from the effect's own fitted ones, both
            by name.
        at_once: whether a diagnosis that would add the effect tries the larger member too, without being asked again.
        seen_in_metrics: whether dW and W of a loop can tell the larger member from the effect.
    """

    name: str
    start: Callable[[Mapping[str, float]], dict[str, float]]
    at_once: bool = True
    seen_in_metrics: bool = True


@dataclass(frozen=True, eq=False)
class Effect:
    """One physical effect: a term (adds `force`), a modifier (`scales`, `replaces`), or both.

    Attributes:
        id: the name that stays, without the argument of a family.
        part: "clamp" travels into the FMU; "rig" corrects the measurement and stays out of it;
            "base" is a term of a base law.
        does: what it does, in a phrase.
        source: the publication that the equation comes from: author, title, journal or book, year.
        looks_like: what a person sees in a loop when the effect is missing.
        imitated_by: ids of what looks alike.
        told_apart_by: the test that tells them apart.
        parameters: what is identified.
        coefficients: named factors that modifiers may scale.
        force: the force it adds, N; zero for a pure modifier.
        states: its memory.
        stages: what is computed on the way to the new states, in order.
        energy: the energy that it stores, N mm, so that what is dissipated can be accounted for.
        scales: factors on coefficients, by coefficient name or by role; roles that no term has are passed over.
        brings_into_view: factors by which starts and bounds of parameters reach further where it scales them: what lies
            outside of the tests' view at one condition, at another it may lie within.
        replaces: what stands in place of a fast signal, for effects in series with a path: of `x` for all forces of the
            elastic path, of `y` and `v` for all else in the clamp (what the rig adds stays outside). In updates of what
            stands behind, the effect's own states then count before the step with `y_previous`, after it with `y`.
        passes: the force that comes through to the clamp's end, in `F_path`; for effects that replace `y`. Stages of
            theirs may use `F_moved(place, velocity, rounded)`, the last in the place of v_r.
        lag: time in s by which the measured force is late; for rig effects.
        argument: the argument that made it of a family, "" otherwise.
        refinement: the next larger member of its family; None where there is none.
        special_cases: ids of effects that it becomes at some values of its parameters: where one of them does as well,
            that one is named.
        many_of: of these, the one of which it is many, or a smoothed one: that and no more sets it apart. Where the
            one fits worse, it has no other form of its own that may stand behind this one.
        essence: parameters of which one at least differs from neutral where the effect is there: without them it is
            another effect, in its form at most.
    """

    id: str
    part: Part
    does: str
    source: str
    looks_like: str
    imitated_by: tuple[str, ...]
    told_apart_by: str
    parameters: tuple[Parameter, ...]
    coefficients: tuple[Coefficient, ...] = ()
    force: sp.Expr = NOTHING
    states: tuple[State, ...] = ()
    stages: tuple[Stage, ...] = ()
    energy: sp.Expr = NOTHING
    scales: Mapping[str, sp.Expr] = field(default_factory=dict)
    brings_into_view: tuple[sp.Expr, ...] = ()
    replaces: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    passes: sp.Expr = symbols.F_path
    lag: sp.Expr = NOTHING
    argument: str = ""
    refinement: Refinement | None = None
    special_cases: tuple[str, ...] = ()
    many_of: str = ""
    essence: tuple[sp.Symbol, ...] = ()

    @property
    def name(self) -> str:
        """The id with its argument, as it is written in commands and files."""
        return f"{self.id}:{self.argument}" if self.argument else self.id

    @property
    def is_constant(self) -> bool:
        """Whether it is a force that nothing changes, neither the motion nor a condition."""
        own = {parameter.symbol for parameter in self.parameters}
        return self.force != NOTHING and not self.states and self.force.free_symbols <= own

    @property
    def is_elastic(self) -> bool:
        """Whether its force follows the displacement alone, the same way to and fro."""
        moving = {symbols.v, symbols.a, symbols.y_previous, symbols.h}
        return self.force != NOTHING and not self.within_steps and not self.force.free_symbols & moving

    @property
    def is_of_time(self) -> bool:
        """Whether it needs tests whose time was measured: seconds stand in what it can't be without, or a speed."""
        of_time = [bool(UNIT_OF_TIME.search(one.unit)) or symbols.f in one.follows for one in self.parameters]
        lasting = [of for of, one in zip(of_time, self.parameters, strict=True) if one.neutral is None]
        over_speed = symbols.v_0 in self.force.free_symbols
        return over_speed or any(lasting) or (bool(of_time) and all(of_time))

    @property
    def within_steps(self) -> tuple[sp.Symbol, ...]:
        """The symbols of its states and stages."""
        return (*(state.symbol for state in self.states), *(stage.symbol for stage in self.stages))

    @property
    def own_symbols(self) -> tuple[str, ...]:
        """Names of what it brings into a law: parameters, coefficients, states and stages. No other effect has them."""
        fitted = (*(one.symbol for one in self.parameters), *(one.symbol for one in self.coefficients))
        return tuple(map(str, (*fitted, *self.within_steps)))


@dataclass(frozen=True, eq=False)
class Family:
    """Effects that take an argument in their name, such as `memory:2` or `condition:current_A`.

    Attributes:
        id: the name before the colon.
        argument_means: what stands after the colon.
        default: the argument that the bare id stands for; None where one must be given, the name of a further column of
            runs.csv.
        build: makes the effect; raises ValueError with what was expected for a bad argument.
        numbered: whether the argument is a number, by which members are larger and smaller; a law has one of them, and
            they are one effect to a diagnosis. Otherwise each member is an effect of its own.
    """

    id: str
    argument_means: str
    default: str | None
    build: Callable[[str], Effect]
    numbered: bool = False


def power_surface(reference: sp.Expr, exponents: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    """A power surface over ratios: reference (A/A0)^a (f/f0)^b (T/T0)^d, as Eq. 20 to 24 of Jiang et al. 2020."""
    ratio = {
        symbols.A: symbols.A / symbols.A_0,
        symbols.f: symbols.f / symbols.f_0,
        symbols.T: symbols.T / symbols.T_0,
    }
    return sp.Mul(reference, *(ratio[signal] ** exponent for signal, exponent in exponents.items()))


def exponent(
    symbol: sp.Symbol, of: str, over: sp.Symbol, limit: float, typical: float | None = None, *, by_shape: bool = False
) -> Parameter:
    """The exponent of a power surface: neutral at zero, free only where the signal varies."""
    meaning = f"exponent of {of} over {over}"
    return Parameter(
        symbol, "-", meaning, 0.0, -limit, limit, neutral=0.0, follows=(over,), typical=typical, by_shape=by_shape
    )
