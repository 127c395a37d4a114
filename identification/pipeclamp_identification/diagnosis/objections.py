"""What speaks against an effect that was fitted to tests, whatever it gains there."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from pipeclamp_identification.diagnosis.thresholds import RIVAL_LIKELIHOOD
from pipeclamp_identification.fitting.group_factors import GroupFactors
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_models.base.units import grows_with_force
from pipeclamp_models.equations.effect import Effect, Parameter
from pipeclamp_models.law.catalogue import find_effect
from pipeclamp_models.law.law import Structure

KNOWN_DEVIATIONS = 2.0
"""Standard deviations of a prior within which any value is likely."""


def objections(effects: tuple[str, ...], result: Fit) -> tuple[str, ...]:
    """Say what speaks physically against a fitted effect: a magnitude at its bound, or one that says nothing.

    A bound at which a parameter changes nothing is no objection: what it stands for isn't there, the rest may be.
    """
    errors = result.standard_errors()
    against = [
        _at_bound_words(parameter, result) for parameter in _at_bounds(effects, result) if not _shapes(parameter)
    ]
    against += [
        f"the data determines no parameter of {name}"
        for name in effects
        if not any(parameter.name in errors for parameter in result.law.structure.effect(name).parameters)
    ]
    return tuple(against)


def reservations(effects: tuple[str, ...], result: Fit) -> tuple[str, ...]:
    """Say why a fitted effect isn't the cause, though it may take a part.

    Its shape lies at the end of its range, or the law has what acts like it, or what was added with it does: one of the
    two mends the other's form.
    """
    at_bounds = [_at_bound_words(each, result) for each in _at_bounds(effects, result) if _shapes(each)]
    structure = result.law.structure
    alike = [
        f"the law has {present.name}, which acts like {name}"
        for name in effects
        for present in structure.all_effects()
        if present.name not in effects and _may_be_one_memory(structure.effect(name), present)
    ]
    together = [
        f"{one} and {other} act alike"
        for one, other in combinations(effects, 2)
        if _may_be_one_memory(structure.effect(one), structure.effect(other))
    ]
    return (*at_bounds, *alike, *together)


def without_essence(name: str, result: Fit) -> str:
    """Say that what sets a fitted effect apart can't be told from nothing; empty where it can."""
    effect = result.law.structure.effect(name)
    away = {
        parameter.name: result.law.values[parameter.name] - (parameter.neutral or 0.0)
        for parameter in effect.parameters
        if parameter.symbol in effect.essence
    }
    told = [own for own in away if own in result.fitted]
    if not away or any(away[own] for own in away if own not in told):
        return ""
    places = [result.fitted.index(own) for own in told]
    offset = np.array([away[own] for own in told])
    if offset @ np.linalg.pinv(result.covariance[np.ix_(places, places)]) @ offset >= RIVAL_LIKELIHOOD:
        return ""
    apart = " and ".join(away)
    return f"what sets {name} apart, {apart}, can't be told from nothing: something else of its form stands behind it"


def of_groups(effects: tuple[str, ...], structure: Structure, factors: GroupFactors | None) -> tuple[str, ...]:
    """Say which effects follow a condition of the groups' own, beside which the groups differ all the same.

    What they take may then be the groups' too: three specimens that differ by chance lie near some curve of a density.
    """
    if factors is None:
        return ()
    follows = {
        name: {str(symbol) for parameter in structure.effect(name).parameters for symbol in parameter.follows}
        for name in effects
    }
    return tuple(f"the groups still differ beside {name}" for name in effects if follows[name] & factors.own)


def _may_be_one_memory(one: Effect, other: Effect) -> bool:
    """Tell whether two effects with states, or special cases of them, imitate each other."""
    forms = [[effect, *map(find_effect, effect.special_cases)] for effect in (one, other)]
    pairs = [(form, another) for form in forms[0] for another in forms[1]]
    return any(are_one_memory(*pair) or (pair[0].id == pair[1].id and bool(pair[0].states)) for pair in pairs)


def are_one_memory(one: Effect, other: Effect) -> bool:
    """Tell whether two effects with states imitate each other."""
    alike = one.id in other.imitated_by and other.id in one.imitated_by
    return alike and bool(one.states) and bool(other.states)


def _at_bounds(effects: tuple[str, ...], result: Fit) -> list[Parameter]:
    """Give the effects' parameters at bounds that say something: not that they change nothing, nor what is known."""
    return [
        parameter
        for name in effects
        for parameter in result.law.structure.effect(name).parameters
        if parameter.name in result.at_bound
        and parameter.neutral != result.at_bound[parameter.name]
        and not _likely_beforehand(parameter, result.law.values[parameter.name])
    ]


def _likely_beforehand(parameter: Parameter, value: float) -> bool:
    """Tell whether physics alone lets a parameter be so: tests that end it at a bound there don't determine it."""
    if parameter.known_within is None or parameter.neutral is None:
        return False
    return abs(value - parameter.neutral) <= KNOWN_DEVIATIONS * parameter.known_within


def _shapes(parameter: Parameter) -> bool:
    """Tell whether a parameter says what form an effect has, such as an exponent, a way, a time, not how much of it."""
    return not grows_with_force(parameter.unit)


def _at_bound_words(parameter: Parameter, result: Fit) -> str:
    return f"{parameter.name} ran into its bound ({result.at_bound[parameter.name]:.4g})"
