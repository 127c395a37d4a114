"""Putting another law's parameters into a finished clamp FMU, without a compiler."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from pipeclamp_fmu.build import native_clamp_content, python_clamp_content
from pipeclamp_fmu.contents.clamp_model import ClampStart
from pipeclamp_fmu.contents.reference import FOLDER as REFERENCES
from pipeclamp_fmu.describe.model_description import FILE_NAME as MODEL_DESCRIPTION
from pipeclamp_fmu.native.clamp import DISSIPATED, MEMORY
from pipeclamp_fmu.native.packing import native_files
from pipeclamp_fmu.native.sources import c_sources
from pipeclamp_fmu.python.packing import module_file, python_files, zipped
from pipeclamp_fmu.slaves.values_file import FILE_NAME, told_values
from pipeclamp_models.base.archive import read_archive
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.law.file import LawFile

EXPECTED = "a clamp FMU made by `pipeclamp build-fmu`"
GENERATED = ("sources/law.h", "sources/layout.h")
"""What says which equations and variables a native FMU has."""

PYTHON_CLAMP = re.compile(r"resources/clamp_[0-9a-f]{16}\.py")


def set_parameters(fmu: Path, file: LawFile, output: Path) -> None:
    """Put a law's parameters, range and documentation into a clamp FMU, which keeps its program.

    So the law must have the equations that the FMU was built from. What the FMU was told to start with when it was
    built (A, f, T, track, T_in as an input) stays; what it wasn't told becomes the middle of the law's range.

    Args:
        fmu: an FMU built by this program, of either kind.
        file: the law.
        output: the FMU to write, whole or not at all; may be `fmu`.

    Raises:
        UserError: the file is no such FMU, the law has other equations, its range doesn't hold what the FMU was told to
            start with, or as `build_clamp`.
    """
    files = read_archive(fmu, EXPECTED)
    native = set(GENERATED) <= files.keys()
    if not native and not any(PYTHON_CLAMP.fullmatch(name) for name in files):
        raise UserError(f"{fmu}: not a clamp FMU; expected {EXPECTED}")
    built = _built(fmu, files)
    replaced = _native_values(files, built, file) if native else _python_values(files, built, file)
    if replaced is None:
        raise UserError(
            f"{fmu}: built for other equations than those of law {file.name!r} (base {file.base}, effects "
            f"{', '.join(file.effects) or 'none'}), or by another version of this program; expected a law of the same "
            "base and effects, else build anew: pipeclamp build-fmu"
        )
    # what stands behind the law is the new one's, which may have fewer parameter sets
    kept = {name: content for name, content in files.items() if not name.startswith(f"{REFERENCES}/")}
    write_whole(output, zipped(kept | replaced))


@dataclass(frozen=True)
class _Built:
    """What a finished FMU says of itself: version of FMI, identifier, and what it was told to start with."""

    fmi: int
    identifier: str
    start: ClampStart


def _built(fmu: Path, files: Mapping[str, bytes]) -> _Built:
    """Give what a finished FMU says of itself.

    Raises:
        UserError: a file of it is missing, or isn't as this program writes it.
    """
    place = MODEL_DESCRIPTION
    try:
        root = ElementTree.fromstring(files[MODEL_DESCRIPTION])
        connected = [entry.get("name") for entry in root.iter() if entry.get("causality") == "input"]
        events = root.get("numberOfEventIndicators", "0") != "0" or root.find(".//EventIndicator") is not None
        states = any(entry.get("name") == f"{MEMORY}{DISSIPATED}" for entry in root.iter())
        fmi = {"2": 2, "3": 3}[root.get("fmiVersion", "")[:1]]
        identifier = next(root.iter("CoSimulation")).attrib["modelIdentifier"]
        place = f"resources/{FILE_NAME}"
        asked = told_values(files[place].decode("utf-8"))
    except (ElementTree.ParseError, LookupError, StopIteration, ValueError, struct.error) as error:
        what = "isn't as it was built" if place in files else "is missing"
        raise UserError(f"{fmu}: {place} in it {what}; expected {EXPECTED}, whole") from error
    start = ClampStart(
        A=asked.get("A"),
        f=asked.get("f"),
        T=asked.get("T"),
        track=bool(asked.get("track", False)),
        connected_temperature="T_in" in connected,
        events=events,
        memory_as_states=states,
    )
    return _Built(fmi, identifier, start)


def _python_values(files: Mapping[str, bytes], built: _Built, file: LawFile) -> dict[str, bytes] | None:
    """Give the files of a Python FMU that say a law's values, None where its program is another."""
    content = python_clamp_content(file, built.start)
    return python_files(content) if module_file(content) in files else None


def _native_values(files: Mapping[str, bytes], built: _Built, file: LawFile) -> dict[str, bytes] | None:
    """Give the files of a native FMU that say a law's values, None where its program is another."""
    content = native_clamp_content(file, built.start)
    sources = c_sources(content.model, built.fmi, built.identifier)
    if any(files[name] != sources[name.removeprefix("sources/")].encode("utf-8") for name in GENERATED):
        return None
    return native_files(content, built.identifier, built.fmi)
