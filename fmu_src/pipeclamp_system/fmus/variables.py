"""The variables of an FMU of FMI 2.0 co-simulation, as its description lists them and as we call them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy

from pipeclamp_fmu.describe.model_description import FILE_NAME as MODEL_DESCRIPTION
from pipeclamp_models.base.archive import opened_archive
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.toml_file import unknown


@dataclass(frozen=True)
class FmuVariable:
    """A variable of an FMU: its name there, its reference, its type, its causality."""

    name: str
    reference: int
    kind: str
    causality: str


Variables = Mapping[str, FmuVariable]
"""Variables by the names that we know them by."""


EXPECTED = "an FMU of FMI 2.0 for co-simulation"
IDENTIFIER = re.compile(r"\w{1,200}", re.ASCII)
"""A model's, which is the name of its library."""


def read_model_description(path: Path) -> Any:
    """Read an FMU's model description.

    Raises:
        UserError: the file is no FMU of FMI 2.0 co-simulation.
    """
    with opened_archive(path, EXPECTED) as archive:
        if MODEL_DESCRIPTION not in archive.namelist():
            raise UserError(f"{path}: holds no {MODEL_DESCRIPTION}; expected {EXPECTED}")
        try:
            # of the file that was looked at, which is open already
            description = fmpy.read_model_description(archive.fp)
        except Exception as error:  # fmpy raises bare Exceptions for all that can be wrong with a file
            raise UserError(f"{path}: not a readable FMU ({error}); expected {EXPECTED}") from error
    if description.fmiVersion != "2.0" or description.coSimulation is None:
        raise UserError(
            f"{path}: FMI {description.fmiVersion}, "
            f"{'co-simulation' if description.coSimulation else 'no co-simulation'}; expected FMI 2.0 co-simulation, "
            "which `pipeclamp build-fmu` and `build-pipe` make unless they are told --fmi 3"
        )
    if not IDENTIFIER.fullmatch(description.coSimulation.modelIdentifier or ""):
        got = (description.coSimulation.modelIdentifier or "")[:60]
        raise UserError(f"{path}: modelIdentifier: got {got!r}; expected letters, digits and _ ({EXPECTED})")
    return description


def variables_of(description: Any) -> Variables:
    """Give the variables that a model description lists."""
    return {
        variable.name: FmuVariable(variable.name, variable.valueReference, variable.type, variable.causality)
        for variable in description.modelVariables
    }


def find_variables(variables: Variables, names: Sequence[str], path: Path) -> list[FmuVariable]:
    """Give variables by name; the FMU's `path` is named in errors.

    Raises:
        UserError: the FMU has no such variable.
    """
    for name in names:
        if name not in variables:
            raise UserError(f"{path}: {unknown(name, list(variables), 'variable')}")
    return [variables[name] for name in names]


def renamed(variables: Variables, names: Mapping[str, str], path: Path) -> Variables:
    """Let variables be known by our names: ours to the FMU's.

    Raises:
        UserError: the FMU has no such variable.
    """
    found = find_variables(variables, list(names.values()), path)
    theirs = set(names.values())
    others = {name: variable for name, variable in variables.items() if name not in theirs}
    return others | dict(zip(names, found, strict=True))
