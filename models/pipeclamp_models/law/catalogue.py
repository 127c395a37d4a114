"""The catalogue: every effect that the folder `effects/` holds, found by scanning it."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache, lru_cache

from pipeclamp_models import effects
from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.equations.effect import Effect, Family


@cache
def identifiers() -> tuple[str, ...]:
    """Give the id of every effect and family of the folder: the name of its file."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(effects.__path__)))


@cache
def find_entry(identifier: str) -> Effect | Family | None:
    """Give an effect or family of the folder by its id, None where there is none; no other's file is run for it."""
    if identifier not in identifiers():
        return None
    entry: Effect | Family = importlib.import_module(f"{effects.__name__}.{identifier}").EFFECT
    if entry.id != identifier:
        raise ValueError(f"{effects.__name__}.{identifier}: got id {entry.id!r}; expected the name of the file")
    return entry


@cache
def entries() -> Mapping[str, Effect | Family]:
    """Give every effect and family of the folder by its id."""
    return {identifier: entry for identifier in identifiers() if (entry := find_entry(identifier))}


def find_effect(name: str, declared: Mapping[str, Effect] | None = None) -> Effect:
    """Give the effect that is written `id` or `id:argument`.

    Args:
        name: the name as in commands and files.
        declared: a user's own effects by id, looked up before the folder.

    Raises:
        UserError: no such effect, or an argument that it can't take.
    """
    identifier, colon, argument = name.partition(":")
    entry = (declared or {}).get(identifier) or find_entry(identifier)
    if entry is None:
        meant = did_you_mean(identifier, (*identifiers(), *(declared or {})), most=3)
        raise UserError(f"effect {name!r} is not in the catalogue; {meant}expected one that `pipeclamp effects` lists")
    if isinstance(entry, Effect):
        if colon:
            raise UserError(f"effect {name!r}: {identifier} takes no argument; write {identifier!r}")
        return entry
    if not colon and entry.default is None:
        raise UserError(f"effect {name!r} needs {entry.argument_means} after a colon: {identifier}:...")
    try:
        return _member(entry, argument if colon else str(entry.default))
    except ValueError as error:
        raise UserError(f"effect {name!r}: got {argument!r} after the colon; expected {error}") from error


@lru_cache(maxsize=256)
def _member(family: Family, argument: str) -> Effect:
    """Build a member of a family; a diagnosis asks for the same few many hundred times."""
    return family.build(argument)


def showable(name: str) -> str:
    """Give a name with an argument where it needs one and has none: `condition` as `condition:column`."""
    entry = entries().get(name)
    return f"{name}:column" if isinstance(entry, Family) and entry.default is None else name


def listed() -> list[Effect]:
    """Give every effect of the folder, of families the member that the bare id stands for."""
    return [find_effect(showable(name)) for name in entries()]


def symbols_taken() -> frozenset[str]:
    """Give every symbol that a listed effect brings into a law."""
    return frozenset(symbol for effect in listed() for symbol in effect.own_symbols)


def effect_id(name: str) -> str:
    """Give what a law has one of: the id before a number (`memory` of `memory:2`), or else the whole name."""
    identifier = name.partition(":")[0]
    entry = find_entry(identifier)
    return name if isinstance(entry, Family) and not entry.numbered else identifier


def member_number(name: str) -> int:
    """Give the number of a member of a numbered family: 2 of `memory:2`, 1 of `memory`; 0 of any other effect."""
    identifier, _, argument = name.partition(":")
    entry = find_entry(identifier)
    return int(argument or str(entry.default)) if isinstance(entry, Family) and entry.numbered else 0


def act_alike(effect: Effect, other: str) -> bool:
    """Tell whether one of two effects is known to imitate the other, or is a special case of it."""
    twin = find_effect(other) if effect_id(other) in entries() else None
    if twin is None:
        return False
    return any(one.id in (*of.imitated_by, *of.special_cases) for one, of in ((twin, effect), (effect, twin)))
