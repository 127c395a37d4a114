"""What `effects` answers: the catalogue, each effect with equations, units, bounds and sizes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from pydantic import Field

from pipeclamp_models.base.answer import AnswerModel
from pipeclamp_models.base.signals import CONDITION
from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.catalogue import find_effect, listed, showable
from pipeclamp_models.law.declaration_files import read_effects
from pipeclamp_models.law.declared import effect_of
from pipeclamp_models.law.outline import Sizes
from pipeclamp_models.realise.reading.text import effect_statements, symbols_of
from pipeclamp_models.realise.sizes import file_sizes, number_of

TYPICAL_LAW = "emwm2"
"""The bundled law whose clamp's loops typical sizes are stated for."""


class EquationAnswer(AnswerModel):
    """One equation of an effect."""

    says: str
    equation: str = Field(description="plain text")
    latex: str


class SymbolAnswer(AnswerModel):
    """What an equation uses besides parameters, or a state."""

    symbol: str
    unit: str
    meaning: str


class ParameterAnswer(AnswerModel):
    """A parameter of an effect; a bound that isn't there is None."""

    symbol: str
    unit: str
    meaning: str
    lower: float | None
    upper: float | None
    typical: float = Field(description="size for the loops of the clamp `typical_for`")


class EffectAnswer(AnswerModel):
    """One effect of the catalogue."""

    effect: str
    id: str
    part: str = Field(description="clamp: travels into the FMU; rig: corrects the measurement; base: term of base laws")
    does: str
    equations: tuple[EquationAnswer, ...]
    symbols: tuple[SymbolAnswer, ...]
    states: tuple[SymbolAnswer, ...]
    parameters: tuple[ParameterAnswer, ...]
    looks_like: str
    imitated_by: tuple[str, ...]
    told_apart_by: str
    source: str


class CatalogueAnswer(AnswerModel):
    """The answer of `pipeclamp effects --json`."""

    typical_for: str = Field(description="the bundled law whose clamp's loops typical sizes are stated for")
    effects: tuple[EffectAnswer, ...]


def asked_effects(name: str | None, declared: Iterable[Path]) -> list[Effect]:
    """Give the effect that is asked for, or else all of the catalogue.

    Args:
        name: of the effect, or the path of its declaration.
        declared: declarations of a user's own effects, which join the catalogue.

    Raises:
        UserError: there is no such effect, or a declaration can't serve.
    """
    names, declarations = read_effects([] if name is None else [name], declared)
    own = {declaration.id: effect_of(declaration) for declaration in declarations}
    return [find_effect(showable(names[0]), own)] if names else [*listed(), *own.values()]


def catalogue_answer(effects: Sequence[Effect]) -> CatalogueAnswer:
    """Give what is stated of effects, with sizes for the reference clamp."""
    sizes = reference_sizes(effects)
    return CatalogueAnswer(typical_for=TYPICAL_LAW, effects=tuple(_effect(effect, sizes) for effect in effects))


def parameter_answers(effects: Sequence[Effect]) -> list[tuple[str, ParameterAnswer]]:
    """Give each parameter of effects beside its effect's name, with sizes for the reference clamp."""
    sizes = reference_sizes(effects)
    return [(effect.name, _parameter(one, sizes)) for effect in effects for one in effect.parameters]


def reference_sizes(effects: Iterable[Effect]) -> Sizes:
    """Give the sizes of the reference clamp's loops; what effects follow besides counts as 1."""
    followed = {str(signal) for effect in effects for one in effect.parameters for signal in one.follows}
    return file_sizes(open_law(TYPICAL_LAW), sorted(name for name in followed if name.startswith(CONDITION)))


def _effect(effect: Effect, sizes: Sizes) -> EffectAnswer:
    return EffectAnswer(
        effect=effect.name,
        id=effect.id,
        part=effect.part,
        does=effect.does,
        equations=tuple(
            EquationAnswer(says=one.words, equation=one.plain, latex=one.latex) for one in effect_statements(effect)
        ),
        symbols=tuple(
            SymbolAnswer(symbol=str(signal.symbol), unit=signal.unit, meaning=signal.meaning)
            for signal in symbols_of(effect)
        ),
        states=tuple(
            SymbolAnswer(symbol=str(state.symbol), unit=state.unit, meaning=state.meaning) for state in effect.states
        ),
        parameters=tuple(_parameter(one, sizes) for one in effect.parameters),
        looks_like=effect.looks_like,
        imitated_by=effect.imitated_by,
        told_apart_by=effect.told_apart_by,
        source=effect.source,
    )


def _parameter(parameter: Parameter, sizes: Sizes) -> ParameterAnswer:
    return ParameterAnswer(
        symbol=parameter.name,
        unit=parameter.unit,
        meaning=parameter.meaning,
        lower=_finite(number_of(parameter.lower, sizes)),
        upper=_finite(number_of(parameter.upper, sizes)),
        typical=number_of(parameter.size, sizes),
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
