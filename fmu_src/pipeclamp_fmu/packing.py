"""Packing a slave's source, its description and its documentation into an FMU, the same bytes for the same content."""

from __future__ import annotations

import io
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pythonfmu
from pythonfmu import FmuBuilder

from pipeclamp.files import write_whole
from pipeclamp_fmu.model_description import ModelText, Quantity, completed
from pipeclamp_fmu.one_module import content_hash

OPTIONS = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
"""What the slaves can do; needsExecutionTool would make some importers refuse them."""

NO_DATE = (1980, 1, 1, 0, 0, 0)
"""The earliest date that a zip file can hold."""


@dataclass(frozen=True)
class Content:
    """What an FMU is made of.

    Attributes:
        kind: "clamp" or "pipe", the start of the names of module, class and library.
        source: the slave's module, in one file.
        class_name: name of the slave's class in it.
        text: what the description says of the whole.
        quantities: what it says of each variable.
        initial_inputs: the variables that outputs depend on at initialisation.
        documentation: `documentation/index.html`.
        further: further files by name.
    """

    kind: str
    source: str
    class_name: str
    text: ModelText
    quantities: Mapping[str, Quantity]
    initial_inputs: tuple[str, ...]
    documentation: str
    further: Mapping[str, bytes] = field(default_factory=dict)


def write_fmu(content: Content, output: Path) -> str:
    """Write an FMU, whole or not at all.

    Returns:
        its model identifier, which is unique for its content.

    Raises:
        UserError: the file can't be written.
    """
    digest = content_hash(
        content.source,
        repr(content.text),
        repr(sorted(content.quantities.items())),
        content.documentation,
        str(pythonfmu.__version__),
    )
    identifier = f"{content.kind}_{digest[:16]}"
    files = _packed_by_pythonfmu(identifier, content.source.replace(content.class_name, identifier))
    files["modelDescription.xml"] = completed(
        files["modelDescription.xml"], digest, content.text, content.quantities, content.initial_inputs
    )
    files["documentation/index.html"] = content.documentation.encode("utf-8")
    files |= content.further
    write_whole(output, zipped(files))
    return identifier


def _packed_by_pythonfmu(identifier: str, source: str) -> dict[str, bytes]:
    """Let pythonfmu make an FMU of the source and give its files by name."""
    with tempfile.TemporaryDirectory(prefix="pipeclamp_") as folder, _restored_imports(identifier):
        script = Path(folder) / f"{identifier}.py"
        script.write_text(source, encoding="utf-8", newline="\n")
        packed = FmuBuilder.build_FMU(script, Path(folder) / f"{identifier}.fmu", **OPTIONS)
        with zipfile.ZipFile(packed) as archive:
            return {name: archive.read(name) for name in archive.namelist()}


@contextmanager
def _restored_imports(module: str) -> Iterator[None]:
    """Undo what pythonfmu's builder leaves behind: an entry of `sys.path` and the imported slave."""
    path = list(sys.path)
    try:
        yield
    finally:
        sys.path[:] = path
        sys.modules.pop(module, None)


def zipped(files: Mapping[str, bytes]) -> bytes:
    """Give a zip file in a fixed order, without dates."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(name, NO_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whatever the platform
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return stream.getvalue()
