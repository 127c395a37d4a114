"""Laws: a base and effects, composed into one set of equations, with values for its parameters.

Nothing here loads SymPy before it is needed: that takes half a second.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.kept import kept
from pipeclamp_models.base.signals import Part
from pipeclamp_models.law.declaration import Declaration, merged
from pipeclamp_models.law.outline import Outline, ParameterOutline, StateOutline, as_json, from_json, outline_of

if TYPE_CHECKING:
    from pipeclamp_models.equations.effect import Effect
    from pipeclamp_models.law.compose import Composed


@dataclass(frozen=True)
class Base:
    """A base law.

    Attributes:
        terms: names of the effects that it consists of.
        fixed: parameters that its form fixes.
        general: whether it may stand for any device; otherwise it states one clamp's surfaces.
        signed: whether coefficients of its damping have either sign, so that a fit may create energy.
    """

    terms: tuple[str, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    general: bool = True
    signed: bool = False


BASES: Mapping[str, Base] = {
    "power": Base(("linear_stiffness", "cubic_stiffness", "power_damping")),
    "memory": Base(
        ("linear_stiffness", "cubic_stiffness", "power_damping", "memory"),
        {"alpha0": 1.0, "alpha_A": 0.0, "alpha_f": 0.0},
    ),
    "series": Base(("elastic_series", "damping_series"), signed=True),
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
        from pipeclamp_models.law.catalogue import effect_id

        added = tuple(self.effect(name) for name in self.effects)
        kinds = {effect_id(effect.name): effect.name for effect in added}
        terms = (name for name in find_base(self.base).terms if kinds.get(effect_id(name), name) == name)
        return (*(self.effect(name) for name in terms), *added)

    def effect(self, name: str) -> Effect:
        """Give an effect by its name: of the catalogue, or declared.

        Raises:
            UserError: there is no such effect.
        """
        from pipeclamp_models.law.catalogue import find_effect
        from pipeclamp_models.law.declared import effect_of

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
            UserError: as `Equations.composed`.
        """
        return _equations(replace(self, frozen=()), ("base", "clamp", "rig"))

    @property
    def equations_without_rig(self) -> Equations:
        """The equations that travel: without what belongs to the rig; equal structures share one set.

        Raises:
            UserError: as `Equations.composed`.
        """
        return _equations(replace(self, frozen=()), ("base", "clamp"))

    def refuse_misfits(self) -> None:
        """Refuse effects that can't be composed, without composing them.

        Raises:
            UserError: as `Equations.composed`.
        """
        from pipeclamp_models.law.compose import refuse_misfits

        refuse_misfits(self.all_effects(), self.base)

    def own(self, values: Mapping[str, float]) -> dict[str, float]:
        """Give those values, by name, that are of the structure's parameters."""
        names = set(self.equations.names)
        return {name: value for name, value in values.items() if name in names}

    def held(self) -> dict[str, float]:
        """Give the values at which the base's form and `frozen` hold parameters."""
        return {**find_base(self.base).fixed, **dict(self.frozen)}


BASE_LAW = Structure()
"""The base law without effects."""


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of a structure: what they are in, and, where that is asked for, the mathematics itself.

    SymPy composes and derives; what numbers take of that is kept from one call to the next (`kept`), so that a command
    on known equations does without.

    Attributes:
        structure: the structure; which parameters are held is left out.
        parts: of which parts effects count.
    """

    structure: Structure
    parts: tuple[Part, ...]

    @cached_property
    def composed(self) -> Composed:
        """The composed equations, symbolic.

        Raises:
            UserError: an effect isn't known, two use one symbol or one path, or a modifier finds nothing to scale.
        """
        from pipeclamp_models.law.compose import compose

        effects = tuple(effect for effect in self.structure.all_effects() if effect.part in self.parts)
        return compose(effects, self.structure.base)

    def __reduce__(
        self,
    ) -> tuple[Callable[[Structure, tuple[Part, ...]], Equations], tuple[Structure, tuple[Part, ...]]]:
        # what was composed stays behind: effects hold functions that no other process can be sent
        return _equations, (self.structure, self.parts)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects that they are composed of."""
        return self.composed.effects

    @cached_property
    def key(self) -> str:
        """All that the equations are made from besides the program's sources."""
        structure = self.structure
        declared = [declaration.model_dump_json() for declaration in structure.declared]
        return json.dumps([structure.base, structure.effects, declared, self.parts])

    @cached_property
    def outline(self) -> Outline:
        """What the law consists of.

        Raises:
            UserError: as `composed`.
        """
        return from_json(kept(f"outline {self.key}", lambda: as_json(outline_of(self.composed))))

    @property
    def parameters(self) -> tuple[ParameterOutline, ...]:
        """All parameters."""
        return self.outline.parameters

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters in order."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def neutral_values(self) -> dict[str, float]:
        """Values at which parameters do nothing, by name, of those that have one."""
        return {one.name: one.neutral for one in self.parameters if one.neutral is not None}

    @property
    def states(self) -> tuple[StateOutline, ...]:
        """The memory."""
        return self.outline.states

    @property
    def slow_signals(self) -> frozenset[str]:
        """Names of the slow signals (A, f, T, further conditions) that the law depends on."""
        return self.outline.slow_signals

    @property
    def ages(self) -> bool:
        """Whether the law depends on the load cycles that the specimen has seen."""
        return "N" in self.slow_signals


@lru_cache(maxsize=256)
def _equations(structure: Structure, parts: tuple[Part, ...]) -> Equations:
    """Give the equations of a structure, composed once at most.

    The one place that remembers equations, and with them what is compiled of them: a diagnosis makes the structure of a
    candidate anew in every fold and every process's task.
    """
    equations = Equations(structure, parts)
    _ = equations.outline  # so that whoever holds equations needn't heed that they can't be composed
    return equations


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
    return 2 * math.pi * lowest_frequency * y_r, y_r


def bare_for(effect: Effect) -> Structure:
    """Give the plainest law that an effect can be added to, or that it is a term of.

    It is the first base law that has what the effect scales; where none has, the first one with the first effect of
    the catalogue that brings it; else the first one.
    """
    from pipeclamp_models.law.catalogue import listed
    from pipeclamp_models.law.compose import scaled_by

    if effect.part == "base":
        return Structure(next(name for name, base in BASES.items() if effect.id in base.terms))
    plainest = Structure(next(iter(BASES)))
    if not effect.scales:
        return plainest
    bases = (Structure(name) for name in BASES)
    able = (bare for bare in bases if scaled_by(effect, bare.equations.composed.coefficients))
    brought = (replace(plainest, effects=(one.name,)) for one in listed() if scaled_by(effect, one.coefficients))
    return next(itertools.chain(able, brought), plainest)


def scaled_in(structure: Structure, effect: Effect) -> set[str]:
    """Give the parameters of a law's effects that an effect scales; none of the base law's."""
    from pipeclamp_models.law.compose import scaled_by

    return {
        parameter.name
        for name in structure.effects
        if scaled_by(effect, (present := structure.effect(name)).coefficients)
        for parameter in present.parameters
    }


def with_effect(structure: Structure, effect: str) -> Structure:
    """Give the structure with one more effect; a larger member of a numbered family takes the smaller one's place.

    Raises:
        UserError: the effect, or a larger one of its family, is there already, or it is part of the base law.
    """
    from pipeclamp_models.law.catalogue import effect_id, member_number

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
