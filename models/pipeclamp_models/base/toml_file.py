"""TOML files as validated tables: unknown keys refused with the best match, errors that name the place."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.files import read_text
from pipeclamp_models.base.said import few_of
from pipeclamp_models.base.units import CELSIUS

SMALLEST_QUANTITY, LARGEST_QUANTITY = 1e-12, 1e15
"""No quantity is nearer to zero or larger, in any unit; powers and products of such stay numbers."""


def _of_some_size(value: float) -> float:
    if value and not SMALLEST_QUANTITY <= abs(value) <= LARGEST_QUANTITY:
        raise ValueError(f"expected 0, or a size between {SMALLEST_QUANTITY:g} and {LARGEST_QUANTITY:g}")
    return value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(_of_some_size)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Celsius = Annotated[Number, Field(gt=-CELSIUS)]
"""A temperature in degC."""
ShortName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
"""A name that FMU variables and table columns can carry."""

MOST_LEVELS = 30
"""Levels of tables and lists in one another; no description has more than a few."""

MOST_OTHERS = 4
"""Places with further problems that are named."""
VARIANT = "("
"""What the tag of a union's variant begins with, so that it stays out of the place that an error names."""


MOST_NAMES_LISTED = 20
"""Known names that an error lists."""


class TomlTable(BaseModel):
    """What all tables share: keys that aren't known are refused, values don't change once read."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    raise ValueError(unknown(str(key), list(cls.model_fields), "key"))
        return data


Model = TypeVar("Model", bound=TomlTable)
Found = TypeVar("Found")


def unknown(name: str, known: list[str], kind: str) -> str:
    """Say that a name isn't known, which one was probably meant, and which there are."""
    expected = few_of(known, MOST_NAMES_LISTED) or "none"
    return f"{kind} {_short(repr(name), 60)} is not known; {did_you_mean(name, known)}expected {expected}"


def looked_up(find: Callable[[str], Found]) -> Callable[[str], str]:
    """Make a validator of a look-up: the name passes where the look-up finds it."""

    def check(name: str) -> str:
        try:
            find(name)
        except UserError as error:
            raise ValueError(str(error)) from error
        return name

    return check


def read_table(path: Path, model: type[Model], what: str = "a description") -> Model:
    """Read a TOML file into a table; `what` it should be is named in errors.

    Raises:
        UserError: the file is missing, is not TOML, or doesn't hold what the table expects.
    """
    return validated(read_toml(path, what), model, str(path))


class Described(NamedTuple):
    """A kind of description: the key that no other kind has, and what is expected where another stands."""

    key: str
    expected: str


DESCRIBED = {
    "pipe": Described("ends", "a pipe there, PIPE.toml, the file that a system's [pipe] names"),
    "system": Described("run", "a system there, SYSTEM.toml, which names the pipe's file under [pipe]"),
    "study": Described("vary", "a study there, STUDY.toml, which names the system's file and what is varied"),
}
"""Descriptions that stand side by side in a folder, and are taken for one another."""


def read_described(path: Path, model: type[Model], kind: str) -> Model:
    """Read a description; `kind` is one of DESCRIBED.

    Raises:
        UserError: the file is missing, is not TOML, describes something else, or doesn't hold what the table expects.
    """
    text = read_text(path, f"the description of a {kind}, a TOML file")
    if text.lstrip().startswith("{"):
        raise UserError(f"{path}: is JSON, as a law's file is; expected {DESCRIBED[kind].expected}")
    content = _parsed(text, str(path))
    others = [one for one, described in DESCRIBED.items() if one != kind and described.key in content]
    if others and DESCRIBED[kind].key not in content:
        raise UserError(f"{path}: describes a {others[0]}; expected {DESCRIBED[kind].expected}")
    return validated(content, model, str(path))


def refuse_described(path: Path, expected: str) -> None:
    """Refuse the description of a pipe, a system or a study in the place of something else.

    Raises:
        UserError: the file holds one.
    """
    try:
        content = read_toml(path)
    except UserError:
        return  # whoever reads it next says what is wrong
    for kind, described in DESCRIBED.items():
        if described.key in content:
            raise UserError(f"{path}: describes a {kind}; expected {expected} there")


def read_toml(path: Path, what: str = "a description") -> dict[str, Any]:
    """Read a TOML file; `what` it should be is named in errors.

    Raises:
        UserError: the file is missing or is not TOML.
    """
    return _parsed(read_text(path, f"{what}, a TOML file"), str(path))


def parse_table(text: str, model: type[Model], where: str) -> Model:
    """Read TOML text into a table; `where` is named in errors.

    Raises:
        UserError: the text is not TOML, or doesn't hold what the table expects.
    """
    return validated(_parsed(text, where), model, where)


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{where}: not valid TOML: {error}") from error
    except (ValueError, RecursionError) as error:  # integers of thousands of digits; tables within tables
        raise UserError(f"{where}: not valid TOML: a number or a nesting is too large") from error
    if _depth(content) > MOST_LEVELS:
        raise UserError(f"{where}: tables or lists are nested deeper than {MOST_LEVELS} levels; expected plain tables")
    return content


def _depth(content: Mapping[str, Any]) -> int:
    """Count the levels of tables and lists, one more than MOST_LEVELS where there are still more."""
    level: list[Any] = [content]
    for depth in range(MOST_LEVELS + 1):
        if not level:
            return depth
        inside = (one.values() if isinstance(one, dict) else one for one in level)
        level = [one for entries in inside for one in entries if isinstance(one, dict | list)]
    return MOST_LEVELS + 1


def validated(content: Any, model: type[Model], where: str) -> Model:
    """Make a table of what a TOML file holds; `where` is named in errors.

    Raises:
        UserError: it doesn't hold what the table expects.
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise UserError(f"{where}: {explained(error)}") from error


def explained(error: ValidationError) -> str:
    """Give the first problem of a validation in words: its place, what was got, where others are."""
    first, *more = error.errors(include_url=False)
    place = _place(first["loc"])
    found = [place]
    for one in more:
        # of a place that may hold one of several kinds, each kind has its own problem there or below
        if not (other := _place(one["loc"])).startswith(tuple(found)):
            found.append(other)
    others = f" (also to mend: {few_of(found[1:], most=MOST_OTHERS)})" if len(found) > 1 else ""
    kind, given = first["type"], first["input"]
    if kind in ("missing", "extra_forbidden"):
        return f"{place}: {'is missing; expected it there' if kind == 'missing' else 'is no key that is known'}{others}"
    if kind == "json_invalid":
        return f"{place}: is no valid JSON: {first['ctx']['error']}"
    is_nested = isinstance(given, dict | list)
    got = f"got {_short(repr(given), 60)}"
    if expected := EXPECTED.get(kind, "").format(**first.get("ctx", {})):
        nested = "got a list" if isinstance(given, list) else "got a table"
        return f"{place}: {nested if is_nested else got}; expected {expected}{others}"
    message = _short(first["msg"].removeprefix("Value error, "), 200)
    return f"{place}: {message}{'' if is_nested else f', {got}'}{others}"


def _place(location: Sequence[int | str]) -> str:
    """Give the place of a problem as a file's reader writes it: "clamps[2].law"."""
    place = ""
    for part in location:
        if isinstance(part, int):
            place += f"[{part + 1}]"
        elif not part.startswith(VARIANT):
            place += f".{part}" if place else part
    return _short(place, 80) or "the file as a whole"


EXPECTED = {
    "float_type": "a number", "float_parsing": "a number", "finite_number": "a finite number",
    "int_type": "a whole number", "int_parsing": "a whole number", "int_from_float": "a whole number",
    "string_type": "text", "bool_type": "true or false",
    "dict_type": "a table", "model_type": "a table", "model_attributes_type": "a table",
    "list_type": "a list", "tuple_type": "a list",
    "literal_error": "{expected}",
    "greater_than": "a number above {gt:g}", "greater_than_equal": "a number of at least {ge:g}",
    "less_than": "a number below {lt:g}", "less_than_equal": "a number of at most {le:g}",
    "too_short": "{min_length} entries at least", "too_long": "{max_length} entries at most",
    "string_too_short": "{min_length} letters at least", "string_too_long": "{max_length} letters at most",
    "string_pattern_mismatch": "letters, digits and _, a letter first ({pattern})",
}  # fmt: skip
"""What was expected, by the kind of a problem, with words of its own."""


def _short(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - 3]}..."
