"""Packing a native FMU: libraries, sources, values, descriptions; the same bytes for the same content and compiler."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeclamp_fmu.describe.legal import licence_files
from pipeclamp_fmu.describe.model_description import FILE_NAME as MODEL_DESCRIPTION
from pipeclamp_fmu.describe.model_description import ModelText
from pipeclamp_fmu.describe.variables import Dependencies, numbers_of
from pipeclamp_fmu.native.compiler import PLATFORMS, compile_sources, refuse_unknown_platforms
from pipeclamp_fmu.native.description import (
    Description,
    Terminal,
    build_description,
    model_description,
    terminals_and_icons,
)
from pipeclamp_fmu.native.sources import NativeModel, c_sources
from pipeclamp_fmu.python.packing import zipped
from pipeclamp_fmu.slaves.one_module import content_hash
from pipeclamp_fmu.slaves.values_file import FILE_NAME, values_text
from pipeclamp_models.base.files import write_whole


@dataclass(frozen=True)
class NativeContent:
    """What a native FMU is made of.

    Attributes:
        kind: "clamp" or "pipe", the start of the identifier.
        text: what the description says of the whole.
        model: the model in C.
        terminals: its connectors.
        dependencies: of its outputs and its states' derivatives.
        documentation: `documentation/index.html`.
        icon: a PNG, empty for none.
        further: further files by name.
    """

    kind: str
    text: ModelText
    model: NativeModel
    terminals: Sequence[Terminal]
    dependencies: Dependencies
    documentation: str
    icon: bytes
    further: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Built:
    """What was written: the FMU's model identifier, its version of FMI, the platforms that it has libraries for."""

    identifier: str
    fmi: int
    platforms: tuple[str, ...]


def write_native_fmu(content: NativeContent, output: Path, fmi: int, platforms: Sequence[str]) -> Built:
    """Write a native FMU, whole or not at all.

    Args:
        content: what it is made of.
        output: the file to write.
        fmi: version of FMI, 2 or 3.
        platforms: to compile for; none gives an FMU of sources alone.

    Raises:
        UserError: a platform is not known or can't be compiled for, or the file can't be written.
    """
    refuse_unknown_platforms(platforms, fmi)
    structure = content_hash(*c_sources(content.model, fmi, "").values())
    identifier = f"{content.kind}_{structure[:16]}"
    sources = c_sources(content.model, fmi, identifier)
    libraries = compile_sources(sources, platforms)
    files = {f"sources/{name}": text.encode("utf-8") for name, text in sources.items()}
    files |= native_files(content, identifier, fmi)
    for name, library in libraries.items():
        target = PLATFORMS[name]
        files[f"binaries/{target.folder[fmi]}/{identifier}{target.ending}"] = library
    write_whole(output, zipped(files))
    return Built(identifier, fmi, tuple(platforms))


def native_files(content: NativeContent, identifier: str, fmi: int) -> dict[str, bytes]:
    """Give the files that depend on values, not on structure alone: they can be replaced without a compiler."""
    model = content.model
    numbers = numbers_of(model.variables, model.ranges)
    token = content_hash(
        identifier,
        repr(content.text),
        values_text("", model.name, numbers),
        repr(model.variables),
        repr(content.dependencies),
        content.documentation,
    )
    description = Description(
        identifier=identifier,
        token=token,
        text=content.text,
        variables=model.variables,
        indicator=model.indicator,
        steps_matter=model.steps_matter,
        exchange_slopes=model.exchange_slopes,
        terminals=content.terminals,
        dependencies=content.dependencies,
        tool=f"pipeclamp {content.text.version}",
    )
    files = {
        MODEL_DESCRIPTION: model_description(description, fmi),
        f"resources/{FILE_NAME}": values_text(token, model.name, numbers).encode("utf-8"),
        "sources/buildDescription.xml": build_description(identifier, fmi),
        "documentation/index.html": content.documentation.encode("utf-8"),
        **content.further,
    }
    files |= licence_files()
    shows_icon = fmi == 3 and bool(content.icon)
    if shows_icon or content.terminals:
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals_and_icons(description, with_icon=shows_icon)
    if content.icon:
        files["model.png" if fmi == 2 else "terminalsAndIcons/icon.png"] = content.icon
    return files
