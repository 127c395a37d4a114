"""What of a coupled model may be stated wrongly besides: the pipe's modulus, a clamp's position, its temperature."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import exp

from pipeclamp_identification.attribution.suspect import A_FACTOR, Suspect, Values, ValueSearch, factor_words
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_models.pipe.description import MaterialTable, PipeDescription, Place
from pipeclamp_models.pipe.materials import COLD
from pipeclamp_models.pipe.section import section_of

POSITION_SHARES = (0.02, 0.1)
"""Shares of the pipe's length by which a position may be wrong, at which a search begins."""
WARMER = (10.0, 50.0)
"""K, likewise."""
COLDEST, WARMEST = -200.0, 500.0
"""K, as far as a temperature may be off."""


def misstated(model: CoupledModel) -> Iterator[Suspect]:
    """Give the pipe's modulus, the clamps' positions, and their temperature where a law follows it."""
    yield _modulus(model.pipe)
    length = model.pipe.pipe.length_m
    for index, place in enumerate(model.pipe.clamps):
        search = displacement_search(place.position_m, length)
        yield Suspect(
            id=f"{place.name}.position",
            side="clamp",
            kind="a clamp's position",
            words=f"the position of clamp {place.name}",
            change=partial(_moved_clamp, index),
            value_words=partial(place_words, place.position_m),
            starts=search.starts,
            lower=search.lower,
            upper=search.upper,
        )
    if any("T" in clamp.law.equations.slow_signals for _, clamp in next(iter(model.clamps.values()))):
        yield Suspect(
            id="clamps.temperature",
            side="clamp",
            kind="the clamps' temperature",
            words="the temperature of the clamps",
            change=_warmed,
            value_words=warmth_words,
            starts=tuple((side * step,) for step in WARMER for side in (-1, 1)),
            lower=(COLDEST,),
            upper=(WARMEST,),
        )


def displacement_search(position: float, length: float) -> ValueSearch:
    """Give starts and bounds of a displacement (m) of something at a position on a pipe of some length."""
    steps = (side * share * length for share in POSITION_SHARES for side in (-1, 1))
    inside = tuple((step,) for step in steps if 0 < position + step < length)
    return ValueSearch(inside, (-position,), (length - position,))


def moved(place: Place, distance: float) -> Place:
    """Give a place that lies elsewhere."""
    return place.model_copy(update={"position_m": place.position_m + distance})


def place_words(position: float, values: Values, errors: Values) -> str:
    """Say a position."""
    return f"{position + values[0]:.4g} ± {errors[0]:.1g} m instead of {position:.4g} m"


def _moved_clamp(index: int, model: CoupledModel, values: Values) -> CoupledModel:
    if values[0] == 0:
        return model
    clamps = list(model.pipe.clamps)
    clamps[index] = moved(clamps[index], values[0])
    return replace(model, pipe=model.pipe.model_copy(update={"clamps": tuple(clamps)}))


def warmth_words(values: Values, errors: Values) -> str:
    """Say by how much a temperature is off; what moves nothing, or is known less well than its range, isn't known."""
    if not 0.0 < errors[0] < WARMEST - COLDEST:
        return "these measurements don't tell it"
    return f"{values[0]:+.3g} ± {errors[0]:.1g} K from what is stated"


def _warmed(model: CoupledModel, values: Values) -> CoupledModel:
    if values[0] == 0:
        return model
    clamps = {
        temperature: tuple(
            (index, replace(clamp, temperature=clamp.temperature + values[0])) for index, clamp in at_temperature
        )
        for temperature, at_temperature in model.clamps.items()
    }
    return replace(model, clamps=clamps)


def _modulus(pipe: PipeDescription) -> Suspect:
    """Give Young's modulus; of what else the material is made stays as it is at the pipe's temperature."""
    section = section_of(pipe)
    warmed = pipe.pipe.temperature_C - COLD
    grown = 1e3 * section.outer / pipe.pipe.outer_diameter_mm - 1
    stated = MaterialTable(
        E_GPa=1e-9 * section.modulus,
        density_kg_m3=section.density,
        expansion_1e6_K=max(0.0, 1e6 * grown / warmed) if warmed else 0.0,
        poisson=section.poisson,
    )

    def stiffer(model: CoupledModel, values: Values) -> CoupledModel:
        if values[0] == 0:
            return model
        material = stated.model_copy(update={"E_GPa": exp(values[0]) * stated.E_GPa})
        table = model.pipe.pipe.model_copy(update={"material": material})
        return replace(model, pipe=model.pipe.model_copy(update={"pipe": table}))

    return Suspect(
        id="modulus",
        side="pipe",
        kind="the pipe's modulus",
        words="the pipe's modulus of elasticity (its bending stiffness)",
        change=stiffer,
        value_words=partial(factor_words, "", stated.E_GPa, "GPa"),
        starts=A_FACTOR.starts,
        lower=(-2.0,),
        upper=(2.0,),
    )
