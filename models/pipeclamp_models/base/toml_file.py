"""TOML files as validated tables: unknown keys refused with the best match, errors that name the place."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from pipeclamp_models.base.errors import UserError, did_you_mean
from pipeclamp_models.base.files import why_unreadable
from pipeclamp_models.base.units import CELSIUS

SMALLEST, LARGEST = 1e-12, 1e15
"""No quantity is nearer to zero or larger, in any unit; powers and products of such stay numbers."""


def _of_some_size(value: float) -> float:
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"expected 0, or a size between {SMALLEST:g} and {LARGEST:g}")
    return value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(_of_some_size)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Celsius = Annotated[Number, Field(gt=-CELSIUS)]
"""A temperature in degC."""
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", max_length=64)]
"""A name that FMU variables and table columns can carry."""

VARIANT = "("
"""What the tag of a union's variant begins with, so that it stays out of the place that an error names."""


class Table(BaseModel):
    """What all tables share: keys that aren't known are refused, values don't change once read."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    raise ValueError(unknown(str(key), list(cls.model_fields), "key"))
        return data


Model = TypeVar("Model", bound=Table)
Found = TypeVar("Found")


def unknown(name: str, known: list[str], kind: str) -> str:
    """Say that a name isn't known, which one was probably meant, and which there are."""
    expected = ", ".join(known) if known else "none"
    return f"{kind} {name!r} is not known; {did_you_mean(name, known)}expected {expected}"


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
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: {why_unreadable(error)}; expected {what}, a TOML file in UTF-8") from error
    return parse_table(text, model, str(path))


def parse_table(text: str, model: type[Model], where: str) -> Model:
    """Read TOML text into a table; `where` is named in errors.

    Raises:
        UserError: the text is not TOML, or doesn't hold what the table expects.
    """
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{where}: not valid TOML: {error}") from error
    return validated(content, model, where)


def validated(content: Any, model: type[Model], where: str) -> Model:
    """Make a table of what a TOML file holds; `where` is named in errors.

    Raises:
        UserError: it doesn't hold what the table expects.
    """
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise UserError(f"{where}: {_explain(error)}") from error


def _explain(error: ValidationError) -> str:
    """Give the first problem of a validation in words."""
    first = error.errors()[0]
    place = ""
    for part in first["loc"]:
        if isinstance(part, int):
            place += f"[{part + 1}]"
        elif not part.startswith(VARIANT):
            place += f".{part}" if place else part
    message = first["msg"].removeprefix("Value error, ")
    got = "" if isinstance(first["input"], dict | list) else f", got {first['input']!r}"
    others = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    return f"{place or 'the file as a whole'}: {message}{got}{others}"
