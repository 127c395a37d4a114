"""Laws that come with the program: the published readings and a law fitted to the published tables."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.toml_file import refuse_described
from pipeclamp_models.law.declaration_files import refuse_declaration
from pipeclamp_models.law.file import LawFile, parse_law, read_law


def bundled_laws() -> tuple[str, ...]:
    """Give the names of the bundled laws."""
    folder = resources.files("pipeclamp_models").joinpath("data", "laws")
    return tuple(sorted(Path(entry.name).stem for entry in folder.iterdir() if entry.name.endswith(".json")))


def open_law(name_or_path: str) -> LawFile:
    """Give a law by the path of its file or by the name of a bundled one.

    Raises:
        UserError: there is neither such a file nor such a bundled law, or the file isn't a law.
    """
    path = Path(name_or_path)
    if path.suffix == ".toml":
        refuse_described(path, "a law")
        refuse_declaration(path)
    if path.exists() or path.suffix:
        return read_law(path)
    names = bundled_laws()
    if name_or_path not in names:
        refuse_effect(name_or_path, "a law")
        raise UserError(
            f"{name_or_path}: no such file, and no bundled law of that name; {did_you_mean(name_or_path, names)}"
            f"expected one of {', '.join(names)}"
        )
    content = resources.files("pipeclamp_models").joinpath("data", "laws", f"{name_or_path}.json")
    return parse_law(content.read_text(encoding="utf-8"), f"bundled law {name_or_path}")


def refuse_effect(name: str, expected: str) -> None:
    """Refuse an effect's name in the place of a law's or a campaign's.

    Raises:
        UserError: it is one.
    """
    from pipeclamp_models.law.catalogue import identifiers  # for a mistake alone: it loads all effects

    if name.partition(":")[0] in identifiers():
        raise UserError(f"{name}: an effect; expected {expected} there: law, effect, tests come in this order")
