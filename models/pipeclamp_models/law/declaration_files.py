"""Declarations of users' effects, read from files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.toml_file import read_table, read_toml
from pipeclamp_models.law.declaration import Declaration, merged

SUFFIX = ".toml"
"""How the path of a declaration ends, where it stands in place of an effect's name."""


def read_declaration(path: Path) -> Declaration:
    """Read a declaration.

    Raises:
        UserError: the file can't be read, isn't of the form, or its id is one of the catalogue's.
    """
    from pipeclamp_models.law.declared import effect_of

    declaration = read_table(path, Declaration, "the declaration of an effect")
    try:
        effect_of(declaration)
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    return declaration


def refuse_declaration(path: Path) -> None:
    """Refuse the declaration of an effect where a law or a system is expected.

    Raises:
        UserError: the file holds a declaration.
    """
    if path.suffix != SUFFIX or not path.is_file():
        return
    try:
        content = read_toml(path)
    except UserError:
        return  # whoever reads it next says what is wrong
    if "id" in content and "parameters" in content:
        raise UserError(
            f"{path}: declares the effect {content['id']!r}; expected a law, a coupled system, or the name of a "
            "bundled law: add the effect to a law by pipeclamp add"
        )


def read_effects(names: Iterable[str], files: Iterable[Path]) -> tuple[tuple[str, ...], tuple[Declaration, ...]]:
    """Give effects' names, with ids for the paths of declarations among them, and all declarations that were read.

    Args:
        names: names of effects, or paths that end in .toml.
        files: further declarations.

    Raises:
        UserError: a declaration can't serve, or two of them have one id.
    """
    declarations = [read_declaration(file) for file in files]
    ids = []
    for name in names:
        if name.endswith(SUFFIX):
            declarations.append(read_declaration(Path(name)))
            ids.append(declarations[-1].id)
        else:
            ids.append(name)
    return tuple(ids), merged((), declarations)
