"""Putting another law's parameters into a finished clamp FMU, without a compiler."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from pipeclamp_fmu.build import native_clamp_content, python_clamp_content
from pipeclamp_fmu.contents.clamp import Start
from pipeclamp_fmu.native.packing import native_files
from pipeclamp_fmu.native.sources import c_sources
from pipeclamp_fmu.python.packing import module_file, python_files, zipped
from pipeclamp_fmu.slaves.values_file import FILE_NAME, told_values
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole
from pipeclamp_models.law.file import LawFile

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
    files = _read(fmu)
    if set(GENERATED) <= files.keys():
        replaced = _native_values(files, file)
    elif any(PYTHON_CLAMP.fullmatch(name) for name in files):
        replaced = _python_values(files, file)
    else:
        raise UserError(f"{fmu}: not a clamp FMU; expected one made by `pipeclamp build-fmu`")
    if replaced is None:
        raise UserError(
            f"{fmu}: built for other equations than those of law {file.name!r} (base {file.base}, effects "
            f"{', '.join(file.effects) or 'none'}), or by another version of this program; expected a law of the same "
            "base and effects, else build anew: pipeclamp build-fmu"
        )
    write_whole(output, zipped(files | replaced))


def _read(fmu: Path) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(fmu) as archive:
            return {name: archive.read(name) for name in archive.namelist()}
    except (OSError, zipfile.BadZipFile) as error:
        raise UserError(f"{fmu}: not a readable FMU ({error}); expected one made by `pipeclamp build-fmu`") from error


def _told(files: Mapping[str, bytes]) -> Start:
    """Give what an FMU was told to start with when it was built."""
    told = told_values(files.get(f"resources/{FILE_NAME}", b"").decode("utf-8"))
    variables = ElementTree.fromstring(files["modelDescription.xml"]).iter()
    connected = [entry.get("name") for entry in variables if entry.get("causality") == "input"]
    return Start(
        A=told.get("A"),
        f=told.get("f"),
        T=told.get("T"),
        track=bool(told.get("track", False)),
        connected_temperature="T_in" in connected,
    )


def _python_values(files: Mapping[str, bytes], file: LawFile) -> dict[str, bytes] | None:
    """Give the files of a Python FMU that say a law's values, None where its program is another."""
    content = python_clamp_content(file, _told(files))
    return python_files(content) if module_file(content) in files else None


def _native_values(files: Mapping[str, bytes], file: LawFile) -> dict[str, bytes] | None:
    """Give the files of a native FMU that say a law's values, None where its program is another."""
    description = ElementTree.fromstring(files["modelDescription.xml"])
    fmi = int(description.get("fmiVersion", "")[0])
    identifier = next(description.iter("CoSimulation")).get("modelIdentifier", "")
    content = native_clamp_content(file, _told(files))
    sources = c_sources(content.model, fmi, identifier)
    if any(files[name] != sources[name.removeprefix("sources/")].encode("utf-8") for name in GENERATED):
        return None
    return native_files(content, identifier, fmi)
