"""STUDY.toml: a system, what is varied in it, and what is asked of each case."""

from __future__ import annotations

import copy
import hashlib
import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from pipeclamp_fmu.build import version
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.toml_file import Number, TomlTable, read_described, read_toml, unknown, validated
from pipeclamp_models.pipe.description import PipeDescription, read_pipe
from pipeclamp_system.bands.band import steps_of
from pipeclamp_system.bands.described import refuse_unknown
from pipeclamp_system.description.system import SystemDescription, files_of_system

MOST_CASES = 1_000_000
"""More than these are a mistake, or want a study of another kind."""

NUMBER = "system.clamps.number"
"""The varied quantity that keeps only so many of the system's clamps, in their order."""

Values = Mapping[str, float]


class Range(TomlTable):
    """Evenly spaced values, both ends included."""

    start: Number
    stop: Number
    points: Annotated[int, Field(strict=True, ge=2, le=100_000)]


Varied = Annotated[
    Annotated[tuple[Number, ...], Tag("(list)")] | Annotated[Range, Tag("(table)")],
    Discriminator(lambda values: "(list)" if isinstance(values, list | tuple) else "(table)"),
]


class StudyDescription(TomlTable):
    """A study: every combination of what is varied is one case.

    Attributes:
        name, notes: for people.
        system: SYSTEM.toml, relative to the study's folder; its pipe is a PIPE.toml.
        measure: "steady" (harmonic balance at the excitation's frequency), "peak" (the largest motion over the system's
            [response] frequencies), or "cosim" (co-simulation, the end of the run).
        vary: values by place: "pipe" or "system", then keys; an entry of a list by its name, its `at`, or * for all.
    """

    name: str = "study"
    notes: str = ""
    system: str
    measure: Literal["steady", "peak", "cosim"] = "steady"
    vary: Annotated[dict[str, Varied], Field(min_length=1)]

    @model_validator(mode="after")
    def _not_too_many(self) -> Self:
        for place, values in self.vary.items():
            if not isinstance(values, Range) and not values:
                raise ValueError(f"vary.{place!r} is empty; expected numbers, or start, stop and points")
        if self.count > MOST_CASES:
            raise ValueError(f"vary: {self.count} cases; expected at most {MOST_CASES}")
        return self

    @property
    def axes(self) -> dict[str, tuple[float, ...]]:
        """The values of each place."""
        return {
            place: tuple(np.linspace(values.start, values.stop, values.points).tolist())
            if isinstance(values, Range)
            else values
            for place, values in self.vary.items()
        }

    @property
    def count(self) -> int:
        """How many cases there are."""
        return prod(values.points if isinstance(values, Range) else len(values) for values in self.vary.values())


@dataclass(frozen=True)
class Study:
    """A study with what its files say.

    Attributes:
        description: of the study.
        folder: of SYSTEM.toml, to which its paths are relative.
        pipe, system: the tables of PIPE.toml and SYSTEM.toml.
        fingerprint: of all files, and this program, that decide the results.
        per_cent: that bands of the amplitudes hold; None: without bands.
    """

    description: StudyDescription
    folder: Path
    pipe: Mapping[str, Any]
    system: Mapping[str, Any]
    fingerprint: str
    per_cent: float | None = None

    def cases(self) -> Iterator[tuple[int, dict[str, float]]]:
        """Give each case's number and values."""
        axes = self.description.axes
        for number, values in enumerate(itertools.product(*axes.values())):
            yield number, dict(zip(axes, values, strict=True))

    def described(self, values: Values) -> tuple[PipeDescription, SystemDescription]:
        """Give pipe and system of a case.

        Raises:
            UserError: a place isn't there, or the case describes nothing that can be.
        """
        return described_with(self.pipe, self.system, values)


def described_with(
    pipe: Mapping[str, Any], system: Mapping[str, Any], values: Values
) -> tuple[PipeDescription, SystemDescription]:
    """Give pipe and system with other values at some places.

    Args:
        pipe, system: the tables of PIPE.toml and SYSTEM.toml.
        values: by place, as of `StudyDescription.vary`.

    Raises:
        UserError: a place isn't there, or this describes nothing that can be.
    """
    tables = {"pipe": copy.deepcopy(dict(pipe)), "system": copy.deepcopy(dict(system))}
    for place, value in values.items():
        if place == NUMBER:
            tables["system"]["clamps"] = _first_clamps(tables["system"].get("clamps", []), value)
        else:
            _put(tables, place.split("."), value, place)
    where = ", ".join(f"{place} = {value:g}" for place, value in values.items())
    return validated(tables["pipe"], PipeDescription, where), validated(tables["system"], SystemDescription, where)


def refuse_places(places: Iterable[str], where: str) -> None:
    """Refuse places that lie neither in the pipe nor in the system; `where` is named in the error.

    Raises:
        UserError: one does.
    """
    for place in places:
        if place != NUMBER and place.split(".")[0] not in ("pipe", "system"):
            raise UserError(f"{where}: vary.{place!r}: expected pipe.… or system.…, for example pipe.flow.velocity_m_s")


def tables_of(system_path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Give the tables of a system's pipe and of the system itself.

    Raises:
        UserError: a file can't be read, or the pipe is an FMU.
    """
    system = read_toml(system_path)
    file = system["pipe"].get("file")
    if file is None:
        raise UserError(f"{system_path}: pipe: got an FMU; expected file = 'PIPE.toml', whose values can be varied")
    pipe_path = system_path.parent / file
    read_pipe(pipe_path)
    return read_toml(pipe_path), system


def _first_clamps(clamps: list[Any], number: float) -> list[Any]:
    """Give so many of a system's clamps.

    Raises:
        UserError: there aren't so many, or it is no whole number.
    """
    if number not in range(len(clamps) + 1):
        raise UserError(
            f"vary.{NUMBER!r}: got {number:g}; expected a whole number from 0 to {len(clamps)}, the clamps there are"
        )
    return clamps[: int(number)]


def _put(table: Any, keys: list[str], value: float, place: str) -> None:
    """Put a value at a place of nested tables.

    Raises:
        UserError: the place isn't there.
    """
    key, *rest = keys
    if isinstance(table, list) and not all(isinstance(entry, dict) for entry in table):
        _put_into_list(table, keys, value, place)
        return
    if isinstance(table, list):
        named = {str(entry.get("name", entry.get("at", index))): entry for index, entry in enumerate(table, 1)}
        if key != "*" and key not in named:
            raise UserError(f"vary.{place!r}: {unknown(key, list(named), 'entry')}")
        if not rest:
            raise UserError(f"vary.{place!r}: is a table, not a number; expected one of its keys behind it")
        for entry in table if key == "*" else [named[key]]:
            _put(entry, rest, value, place)
        return
    if not isinstance(table, dict):
        raise UserError(f"vary.{place!r}: {key!r} stands behind something that is no table")
    if rest:
        if key in ("pipe", "system", "flow", "axial", "excitation", "damping", "modes", "run") or key in table:
            _put(table.setdefault(key, {}), rest, value, place)
            return
        raise UserError(f"vary.{place!r}: {unknown(key, list(table), 'table')}")
    table[key] = value


def _put_into_list(entries: list[Any], keys: list[str], value: float, place: str) -> None:
    """Put a value in the place of a list's number, which is named by its place from 1.

    Raises:
        UserError: there is no such place, or no number stands there.
    """
    places = [str(index) for index in range(1, len(entries) + 1)]
    key, *rest = keys
    if rest or (key != "*" and key not in places):
        raise UserError(f"vary.{place!r}: {unknown('.'.join(keys), places, 'entry of the list')}")
    for index in range(len(entries)) if key == "*" else [places.index(key)]:
        entries[index] = value


def files_of_study(path: Path) -> list[Path]:
    """Give the files that a study is read from beside its own: the system, and what that names.

    Raises:
        UserError: the study or its system can't be read.
    """
    system = path.parent / read_described(path, StudyDescription, "study").system
    return [system, *files_of_system(system)]


def read_study(path: Path, per_cent: float | None = None) -> Study:
    """Read a study with its system and its pipe, and check its first and its last case.

    Args:
        path: STUDY.toml.
        per_cent: that bands of the amplitudes are to hold, such as 95; None for no bands.

    Raises:
        UserError: a file can't be read, or a place isn't there; the message names it; with bands: no law tells how sure
            it is.
        UsageError: the share can't be held by a band, or the cases are co-simulated.
    """
    description = read_described(path, StudyDescription, "study")
    if per_cent is not None:
        steps_of(per_cent)
        if description.measure == "cosim":
            raise UsageError(f"--bands: {path} measures 'cosim', whose bands take an ensemble a case; use 'peak'")
    digest = hashlib.sha256(path.read_bytes())
    system_path = path.parent / description.system
    used = files_of_system(system_path)
    pipe, system = tables_of(system_path)
    for one in (system_path, *used):
        digest.update(one.read_bytes())
    digest.update(version().encode())
    digest.update(b"" if per_cent is None else f"bands {per_cent!r}".encode())
    study = Study(description, system_path.parent.resolve(), pipe, system, digest.hexdigest(), per_cent)
    refuse_places(description.vary, str(path))
    try:
        for pick in (0, -1):
            study.described({place: values[pick] for place, values in description.axes.items()})
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
    if per_cent is not None:
        whole = study.described({place: values[-1] for place, values in description.axes.items()})[1]
        refuse_unknown(whole, study.folder, str(path))
    return study
