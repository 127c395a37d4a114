"""What of a coupled model may be wrong: the pipe's supports, damping, mass and modulus, and the clamps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from math import exp

import numpy as np

from pipeclamp_identification.attribution.measuring_suspects import measuring_suspects
from pipeclamp_identification.attribution.misstated import misstated
from pipeclamp_identification.attribution.suspect import (
    A_FACTOR,
    LARGEST_LOG_FACTOR,
    LOG_FACTORS,
    ModelChange,
    Suspect,
    Values,
    ValueSearch,
    amount_words,
    factor_words,
)
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription
from pipeclamp_identification.on_pipe.model import CoupledModel
from pipeclamp_models.base.digits import one_digit
from pipeclamp_models.effects.cubic_stiffness import k3
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.law import Law
from pipeclamp_models.pipe.description import Damping, EndCondition, PipeDescription, PointMass, Springs
from pipeclamp_models.pipe.modes import CONDITION_STIFFNESS
from pipeclamp_models.pipe.section import beam_of
from pipeclamp_system.steady.clamp import SteadyClamp

SMALL_FACTOR = 0.1
"""Logarithm, likewise, of a factor that only corrects another one."""
SHARE_STARTS = (0.01, 0.05, 0.2)
"""Shares, likewise, of what has no size of its own."""
MASS_POSITIONS = 6
"""Positions along the pipe at which the search for a mass begins."""
RIGID_SIDE = 1e6
"""Times the pipe's own stiffness: that of the other direction of a support that gives way in one."""
CUBIC = str(k3)
"""The coefficient of a law's cubic stiffness: at large motion it may be wrong by another factor."""
SMALL_RATIO = 0.01
"""What the damping ratio of a pipe that is stated without damping is counted in."""

MOUNT = Declaration.model_validate(
    {
        "id": "mount",
        "title": "The clamp as mounted: factors on its stiffness, on the cubic part of it, and on its damping",
        "looks_like": "a clamp that is stiffer or more damped than its law, as a whole",
        "parameters": [
            {"symbol": symbol, "unit": "-", "meaning": f"factor on the {of}", "start": 1.0, "neutral": 1.0}
            for symbol, of in (
                ("mount_stiffness", "stiffness"),
                ("mount_cubic", "cubic stiffness besides"),
                ("mount_damping", "damping"),
            )
        ],
        "scales": [
            {"coefficient": "stiffness", "factor": "mount_stiffness"},
            {"coefficient": CUBIC, "factor": "mount_cubic"},
            {"coefficient": "damping", "factor": "mount_damping"},
            {"coefficient": "slip", "factor": "mount_damping"},
        ],
    }
)
"""Scales a law by the roles of its coefficients; the slip force of elastic-slip elements is counted as damping."""
FACTORS = {"stiffness": ("mount_stiffness", "mount_cubic"), "damping": ("mount_damping",)}
"""Which of these are refitted together."""


def suspects_of(model: CoupledModel, measurement: MeasurementDescription) -> tuple[Suspect, ...]:
    """Give all that may be wrong in a model, and in what was measured with its probes."""
    return (
        *_held(model.pipe), _damping(model.pipe), *_masses(model.pipe), *_clamps(model), *misstated(model),
        *measuring_suspects(model, measurement),
    )  # fmt: skip


def with_mounts(model: CoupledModel) -> CoupledModel:
    """Give a model whose clamps carry factors on stiffness and damping, all 1."""
    clamps = {
        temperature: tuple((index, replace(clamp, law=_mounted(clamp.law))) for index, clamp in at_temperature)
        for temperature, at_temperature in model.clamps.items()
    }
    return replace(model, clamps=clamps)


def _mounted(law: Law) -> Law:
    structure = law.structure.with_declared([MOUNT])
    structure = replace(structure, effects=(*structure.effects, MOUNT.id))
    neutral = {table.symbol: 1.0 for table in MOUNT.parameters}
    return replace(law, structure=structure, values={**law.values, **neutral})


def _clamps(model: CoupledModel) -> Iterator[Suspect]:
    for index, name in enumerate(model.clamp_names):
        clamp = next(iter(model.clamps.values()))[index][1]
        for role, factors in FACTORS.items():
            parameters = tuple(factor for factor in factors if _matters(clamp, factor))
            if not parameters:
                continue
            more = parameters[1:]
            yield Suspect(
                id=f"{name}.{role}",
                side="clamp",
                kind="a clamp's " + role,
                words=f"the {role} of clamp {name}",
                change=partial(_scaled_clamp, index, parameters),
                value_words=_clamp_words,
                starts=tuple((value, *(SMALL_FACTOR for _ in more)) for value in LOG_FACTORS),
                lower=(-LARGEST_LOG_FACTOR, *(-LARGEST_LOG_FACTOR for _ in more)),
                upper=(LARGEST_LOG_FACTOR, *(LARGEST_LOG_FACTOR for _ in more)),
            )


def _matters(clamp: SteadyClamp, factor: str) -> bool:
    """Tell whether a factor moves a clamp's force on the largest sinusoid in its law's range.

    A law may state a coefficient as 0: a factor on that is told by nothing.
    """
    mounted = replace(clamp, law=_mounted(clamp.law))
    motion, at = np.array([[0.0, clamp.range_A[1]]], dtype=np.complex128), np.array([np.mean(clamp.range_f)])
    doubled = replace(mounted, law=replace(mounted.law, values={**mounted.law.values, factor: 2.0}))
    return not np.array_equal(mounted.forces(motion, at), doubled.forces(motion, at))


def _clamp_words(values: Values, errors: Values) -> str:
    whole = factor_words("its law's", 1.0, "", values, errors)
    if len(values) == 1:
        return whole
    cubic = sum(values)
    return f"{whole}, its cubic part {exp(cubic):.3g} ± {exp(cubic) * errors[1]:.1g} times"


def _scaled_clamp(which: int, parameters: tuple[str, ...], model: CoupledModel, values: Values) -> CoupledModel:
    def scaled(clamp: SteadyClamp) -> SteadyClamp:
        factors = {name: exp(value) for name, value in zip(parameters, values, strict=True)}
        return replace(clamp, law=replace(clamp.law, values={**clamp.law.values, **factors}))

    clamps = {
        temperature: tuple(
            (index, scaled(clamp) if place == which else clamp) for place, (index, clamp) in enumerate(at_temperature)
        )
        for temperature, at_temperature in model.clamps.items()
    }
    return replace(model, clamps=clamps)


def _held(pipe: PipeDescription) -> Iterator[Suspect]:
    """Give the stiffness of ends and supports: of springs a factor, of what is held rigidly how far it gives way."""
    length = pipe.pipe.length_m
    bending = beam_of(pipe).bending_stiffness
    own = Springs(stiffness_N_mm=48e-3 * bending / length**3, rotational_stiffness_Nm_rad=bending / length)
    places: list[tuple[str | int, str, EndCondition, str]] = [
        ("left", "left", pipe.ends.left, "the left end"),
        ("right", "right", pipe.ends.right, "the right end"),
        *(
            (index, f"support:{support.position_m:g}", support.condition, f"the support at {support.position_m:g} m")
            for index, support in enumerate(pipe.supports)
        ),
    ]
    for place, identifier, condition, words in places:
        for name, unit, kind in (
            ("stiffness_N_mm", "N/mm", "stiffness"),
            ("rotational_stiffness_Nm_rad", "N m/rad", "rotational stiffness"),
        ):
            held = _holding(condition, name, own, unit)
            if held is None:
                continue
            yield Suspect(
                id=f"{identifier}.{name.partition('_')[0]}",
                side="pipe",
                kind="a support's stiffness",
                words=f"the {kind} of {words}",
                change=partial(_held_otherwise, place, name, held.stiffness, own),
                value_words=held.value_words,
                starts=held.search.starts,
                lower=held.search.lower,
                upper=held.search.upper,
            )


@dataclass(frozen=True)
class _Holding:
    """How one stiffness of an end or a support may be wrong: by a value, in words, within bounds."""

    stiffness: Callable[[float], float]
    value_words: Callable[[Values, Values], str]
    search: ValueSearch


def _holding(condition: EndCondition, name: str, own: Springs, unit: str) -> _Holding | None:
    """Give how a stiffness may be wrong; None where it is left out.

    What is rigid gives way by a compliance, counted in that of the pipe; a pin may hold the slope by a stiffness,
    counted likewise. `own` are the pipe's own stiffnesses.
    """
    size = float(getattr(own, name))
    if isinstance(condition, Springs):
        stated = float(getattr(condition, name))
        if not stated:
            return None
        return _Holding(lambda value: stated * exp(value), partial(factor_words, "", stated, unit), A_FACTOR)
    shares = ValueSearch(tuple((share,) for share in SHARE_STARTS), (0.0,), (100.0,))
    if getattr(_springs(condition, own), name):
        return _Holding(lambda value: size / max(value, 1 / RIGID_SIDE), partial(_compliance_words, size, unit), shares)
    if condition == "pinned":
        return _Holding(lambda value: size * value, partial(amount_words, size, unit, "instead of none"), shares)
    return None


def _springs(condition: EndCondition, own: Springs) -> Springs:
    """Give a condition as springs, far stiffer than the pipe where it is rigid."""
    if isinstance(condition, Springs):
        return condition
    displacement, slope = (RIGID_SIDE if stiffness else 0.0 for stiffness in CONDITION_STIFFNESS[condition])
    return Springs(
        stiffness_N_mm=displacement * own.stiffness_N_mm,
        rotational_stiffness_Nm_rad=slope * own.rotational_stiffness_Nm_rad,
    )


def _held_otherwise(
    place: str | int, name: str, stiffness: Callable[[float], float], own: Springs, model: CoupledModel, values: Values
) -> CoupledModel:
    if values[0] == 0:
        return model
    pipe = model.pipe
    update = {name: stiffness(values[0])}
    if isinstance(place, int):
        supports = list(pipe.supports)
        held = _springs(supports[place].condition, own).model_copy(update=update)
        supports[place] = supports[place].model_copy(update={"condition": held})
        return replace(model, pipe=pipe.model_copy(update={"supports": tuple(supports)}))
    held = _springs(getattr(pipe.ends, place), own).model_copy(update=update)
    return replace(model, pipe=pipe.model_copy(update={"ends": pipe.ends.model_copy(update={place: held})}))


def _compliance_words(size: float, unit: str, values: Values, errors: Values) -> str:
    if values[0] <= 1 / RIGID_SIDE:
        return "rigid, as stated"
    share = errors[0] / values[0]
    return (
        f"{size / values[0]:.3g} {unit} ({f'± {share:.0%}' if share < 1 else 'to more than ± 100%'}) instead of rigid"
    )


def _share_words(size: float, unit: str, values: Values, errors: Values) -> str:
    return f"{size * (1 + values[0]):.4g} ± {one_digit(size * errors[0])} {unit} instead of {size:.4g} {unit}"


def _damping(pipe: PipeDescription) -> Suspect:
    stated = pipe.damping

    def damped(model: CoupledModel, values: Values) -> CoupledModel:
        factor = exp(values[0])
        update = {name: factor * value for name, value in stated.model_dump().items() if value is not None}
        return replace(model, pipe=model.pipe.model_copy(update={"damping": stated.model_copy(update=update)}))

    def damped_at_all(model: CoupledModel, values: Values) -> CoupledModel:
        ratio = Damping(ratio=SMALL_RATIO * values[0])
        return replace(model, pipe=model.pipe.model_copy(update={"damping": ratio}))

    change: ModelChange = damped
    value_words, search = partial(factor_words, "what is stated", 1.0, ""), A_FACTOR
    if stated.ratio:
        value_words = partial(factor_words, "", 100 * stated.ratio, "% of critical")
    if not any(value for value in stated.model_dump().values()):
        change, search = damped_at_all, ValueSearch(((0.3,), (1.0,), (3.0,)), (0.0,), (50.0,))
        value_words = partial(amount_words, 100 * SMALL_RATIO, "% of critical", "instead of none")
    return Suspect(
        id="damping",
        side="pipe",
        kind="the pipe's damping",
        words="the pipe's own damping",
        change=change,
        value_words=value_words,
        starts=search.starts,
        lower=search.lower,
        upper=search.upper,
    )


def _masses(pipe: PipeDescription) -> Iterator[Suspect]:
    """Give the mass per length (fill, insulation) and a mass at a place that isn't known."""
    beam, length = beam_of(pipe), pipe.pipe.length_m
    moving = beam.mass_per_length * length

    def filled(model: CoupledModel, values: Values) -> CoupledModel:
        more = model.pipe.pipe.added_mass_kg_m + values[0] * beam.mass_per_length
        table = model.pipe.pipe.model_copy(update={"added_mass_kg_m": more})
        return replace(model, pipe=model.pipe.model_copy(update={"pipe": table}))

    def loaded(model: CoupledModel, values: Values) -> CoupledModel:
        if values[0] == 0:
            return model
        mass = PointMass(position_m=values[1] * length, mass_kg=0.0).model_copy(update={"mass_kg": moving * values[0]})
        return replace(model, pipe=model.pipe.model_copy(update={"masses": (*model.pipe.masses, mass)}))

    def value_words(values: Values, errors: Values) -> str:
        mass = f"{moving * values[0]:+.3g} ± {one_digit(moving * errors[0])} kg"
        # of no mass the place says nothing
        return f"{mass} at {length * values[1]:.3g} ± {one_digit(length * errors[1])} m" if values[0] else mass

    yield Suspect(
        id="mass_per_length",
        side="pipe",
        kind="the pipe's mass",
        words="the pipe's mass per length (fill, insulation)",
        change=filled,
        value_words=partial(_share_words, beam.mass_per_length, "kg/m"),
        starts=((-0.15,), (0.15,)),
        lower=(-0.7,),
        upper=(3.0,),
    )
    places = [(index + 0.5) / MASS_POSITIONS for index in range(MASS_POSITIONS)]
    yield Suspect(
        id="added_mass",
        side="pipe",
        kind="the pipe's mass",
        words="a mass on the pipe that isn't in its description",
        change=loaded,
        value_words=value_words,
        starts=tuple((share, place) for share in (0.03, 0.1) for place in places),
        lower=(0.0, 0.01),
        upper=(2.0, 0.99),
        others=tuple((place,) for place in places),
    )
