"""A user's own effect as data: what its declaration in TOML holds."""

from __future__ import annotations

import keyword
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.signals import CONDITION, Role
from pipeclamp_models.base.toml_file import LARGEST_QUANTITY, Number, TomlTable


def _free_symbol(name: str) -> str:
    from pipeclamp_models.law.names import RESERVED

    if name in RESERVED:
        raise ValueError(f"{RESERVED[name]}; expected another symbol")
    if keyword.iskeyword(name) or name.startswith(CONDITION):
        raise ValueError(f"is reserved; expected another symbol, such as {name}0")
    return name


def _printable(text: str) -> str:
    if not text.isprintable() or text != text.strip():
        raise ValueError("expected a unit in one line of letters and signs, such as N/mm")
    return text


def _number_or_text(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("expected a number or an expression in quotes")
    if isinstance(value, str):
        return value
    if not abs(value) <= LARGEST_QUANTITY:
        raise ValueError(f"expected a finite number up to {LARGEST_QUANTITY:g}")
    return float(value)


def _one_or_several(value: Any) -> Any:
    return tuple(value) if isinstance(value, list | tuple) else (value,)


SymbolName = Annotated[
    str, Field(pattern=r"^[A-Za-z]([A-Za-z0-9_]*[A-Za-z0-9])?$", max_length=32), AfterValidator(_free_symbol)
]
Phrase = Annotated[str, Field(min_length=4, max_length=400)]
UnitText = Annotated[str, Field(min_length=1, max_length=32), AfterValidator(_printable)]
DeclaredNumber = Annotated[float | str, BeforeValidator(_number_or_text)]


class ParameterTable(TomlTable):
    """A parameter: `start`, `lower` and `upper` are numbers or expressions in the data's scales."""

    symbol: SymbolName
    unit: UnitText
    meaning: Phrase
    start: Annotated[tuple[DeclaredNumber, ...], Field(min_length=1, max_length=8), BeforeValidator(_one_or_several)]
    lower: DeclaredNumber | None = None
    upper: DeclaredNumber | None = None
    neutral: Number | None = None
    follows: tuple[str, ...] = ()
    levels: Annotated[int, Field(ge=2, le=20)] = 2


class CoefficientTable(TomlTable):
    """A factor of the force that other effects may scale, by its symbol or its role."""

    symbol: SymbolName
    unit: UnitText
    role: Role | None = None
    expression: str


class StateTable(TomlTable):
    """Memory: `update` is the value after a step from `y_previous` to `y` that lasts `h` seconds."""

    symbol: SymbolName
    unit: UnitText
    meaning: Phrase
    update: str
    start: Number = 0.0


class ScaleTable(TomlTable):
    """A factor on a coefficient of other effects, named by its symbol or its role."""

    coefficient: Annotated[str, Field(min_length=1, max_length=32)]
    factor: str


class Declaration(TomlTable):
    """What a user states of an effect; what each expression may use is said in `effect_of`."""

    id: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]
    title: Phrase
    looks_like: Phrase
    part: Literal["clamp", "rig"] = "clamp"
    source: str = ""
    imitated_by: tuple[str, ...] = ()
    told_apart_by: str = ""
    conditions: Annotated[tuple[str, ...], Field(max_length=8)] = ()
    parameters: Annotated[tuple[ParameterTable, ...], Field(min_length=1, max_length=20)]
    coefficients: Annotated[tuple[CoefficientTable, ...], Field(max_length=10)] = ()
    states: Annotated[tuple[StateTable, ...], Field(max_length=10)] = ()
    force: str = ""
    energy: str = ""
    scales: Annotated[tuple[ScaleTable, ...], Field(max_length=10)] = ()
    path: str = ""
    lag: str = ""
    about_mm: Number = 0.0


def merged(present: Sequence[Declaration], further: Iterable[Declaration]) -> tuple[Declaration, ...]:
    """Give the declarations and further ones, each once.

    Raises:
        UserError: two that differ have one id.
    """
    found = {declaration.id: declaration for declaration in present}
    for declaration in further:
        if found.setdefault(declaration.id, declaration) != declaration:
            raise UserError(
                f"effect {declaration.id!r} is declared twice, and differently (in the law, or in two files); "
                "give one of them another id"
            )
    return tuple(found.values())
