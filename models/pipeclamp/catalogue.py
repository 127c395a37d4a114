"""The catalogue: every effect that the folder `effects/` holds, found by scanning it."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from pipeclamp import effects
from pipeclamp.effect import Effect, Family
from pipeclamp.errors import UserError, did_you_mean


@cache
def entries() -> Mapping[str, Effect | Family]:
    """Give every effect and family of the folder by its id."""
    found: dict[str, Effect | Family] = {}
    for module in sorted(pkgutil.iter_modules(effects.__path__), key=lambda module: module.name):
        entry: Effect | Family = importlib.import_module(f"{effects.__name__}.{module.name}").EFFECT
        found[entry.id] = entry
    return found


def find_effect(name: str, declared: Mapping[str, Effect] | None = None) -> Effect:
    """Give the effect that is written `id` or `id:argument`.

    Args:
        name: the name as in commands and files.
        declared: a user's own effects by id, looked up before the folder.

    Raises:
        UserError: no such effect, or an argument that it can't take.
    """
    known: dict[str, Effect | Family] = {**entries(), **(declared or {})}
    identifier, colon, argument = name.partition(":")
    entry = known.get(identifier)
    if entry is None:
        meant = did_you_mean(identifier, known, most=3)
        raise UserError(f"effect {name!r} is not in the catalogue; {meant}expected one that `pipeclamp effects` lists")
    if isinstance(entry, Effect):
        if colon:
            raise UserError(f"effect {name!r}: {identifier} takes no argument; write {identifier!r}")
        return entry
    if not colon and entry.default is None:
        raise UserError(f"effect {name!r} needs {entry.argument_means} after a colon: {identifier}:...")
    try:
        return entry.build(argument if colon else str(entry.default))
    except ValueError as error:
        raise UserError(f"effect {name!r}: got {argument!r} after the colon; expected {error}") from error
