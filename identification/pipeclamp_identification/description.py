"""campaign.toml: the name of a campaign, what holds for every run, and the names of a test machine's columns."""

from __future__ import annotations

import difflib
import math
import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StrictFloat, StrictInt, StrictStr, ValidationError

from pipeclamp.errors import UserError

FILE_NAME = "campaign.toml"

RecordColumn = Literal["time_s", "displacement_mm", "force_N", "temperature_C"]


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise ValueError("expected a finite number")
    return value


def _finite_and_not_zero(value: float) -> float:
    if value == 0.0:
        raise ValueError("expected a factor other than 0")
    return _finite(value)


def _not_blank(text: str) -> str:
    if not text.strip():
        raise ValueError("expected a text that is not blank")
    return text


Text = Annotated[StrictStr, AfterValidator(_not_blank)]
Number = Annotated[StrictFloat | StrictInt, AfterValidator(_finite)]


class ColumnSource(BaseModel):
    """Where one of our record columns comes from in a test machine's export: ours = factor * theirs."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Text = Field(alias="from")
    factor: Annotated[StrictFloat | StrictInt, AfterValidator(_finite_and_not_zero)] = 1.0


class CampaignDescription(BaseModel):
    """campaign.toml as CAMPAIGN.md describes it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Text
    notes: StrictStr = ""
    defaults: dict[str, Number | StrictStr] = {}
    columns: dict[RecordColumn, ColumnSource] = {}


def read_description(folder: Path) -> CampaignDescription:
    """Read and check the campaign.toml of a campaign's folder.

    Args:
        folder: the campaign's folder.

    Returns:
        What it says.

    Raises:
        UserError: the folder or the file is not there, is no TOML, or has keys or values that CAMPAIGN.md doesn't know.
    """
    path = folder / FILE_NAME
    if not folder.is_dir():
        raise UserError(f"{folder}: no such folder; expected a campaign's folder with {FILE_NAME} and runs.csv")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise UserError(
            f"{path}: no such file; expected it in the campaign's folder, with at least: name = \"...\""
        ) from None
    except OSError as error:
        raise UserError(f"{path}: can't be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: is no valid TOML: {error}") from error
    try:
        return CampaignDescription.model_validate(content)
    except ValidationError as error:
        raise UserError(_first_fault(path, error)) from error


def _first_fault(path: Path, error: ValidationError) -> str:
    fault = error.errors()[0]
    # pydantic ends a location with the member of the union that it tried, which is no key of the user's
    keys = [str(part) for part in fault["loc"]]
    got = repr(fault["input"])
    if keys[0] == "columns" and keys[-1] == "[key]":
        return _unknown_key(path, "[columns]", keys[1], list(RecordColumn.__args__))  # type: ignore[attr-defined]
    if fault["type"] == "extra_forbidden" and keys[0] == "columns":
        return _unknown_key(path, f"[columns] {keys[1]}", keys[-1], ["from", "factor"])
    if fault["type"] == "extra_forbidden":
        return _unknown_key(path, "top level", keys[-1], list(CampaignDescription.model_fields))
    if fault["type"] == "missing":
        example = 'name = "..."' if keys == ["name"] else '{ from = "Load [kN]", factor = 1000 }'
        return f"{path}, {'.'.join(keys)}: is missing; expected for example: {example}"
    if keys[0] == "columns" and len(keys) == 2:
        return f'{path}, columns.{keys[1]}: got {got}; expected for example: {{ from = "Load [kN]", factor = 1000 }}'
    if keys[0] == "defaults" and len(keys) > 1:
        return f"{path}, defaults.{keys[1]}: got {got}; expected a finite number or a text"
    return f"{path}, {'.'.join(keys[:3])}: got {got}; {fault['msg'].removeprefix('Value error, ')}"


def _unknown_key(path: Path, where: str, key: str, known: list[str]) -> str:
    best = difflib.get_close_matches(key, known, n=1, cutoff=0.0)[0]
    return f"{path}, {where}: unknown key {key!r}; expected one of {', '.join(known)}; the best match is {best!r}"
