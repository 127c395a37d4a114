"""Packing a slave's source, its description and its documentation into an FMU, the same bytes for the same content."""

from __future__ import annotations

import io
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from xml.etree.ElementTree import Element

from pythonfmu import FmuBuilder

from pipeclamp_fmu.contents.content import Content
from pipeclamp_fmu.describe.legal import PYTHON_NEEDS, licence_files
from pipeclamp_fmu.describe.model_description import FILE_NAME as MODEL_DESCRIPTION
from pipeclamp_fmu.describe.model_description import completed, xml_bytes
from pipeclamp_fmu.slaves.loading import instance_of
from pipeclamp_fmu.slaves.one_module import content_hash
from pipeclamp_fmu.slaves.values_file import FILE_NAME, values_text
from pipeclamp_models.base.files import write_whole

OPTIONS = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}
"""What the slaves can do; needsExecutionTool would make some importers refuse them."""

UNUSED = ("__main__.py", "csvbuilder.py", "deploy.py", MODEL_DESCRIPTION, FILE_NAME)
"""Modules of pythonfmu that nothing in an FMU imports, and what is written anew for each FMU's values."""

NO_DATE = (1980, 1, 1, 0, 0, 0)
"""The earliest date that a zip file can hold."""


def write_fmu(content: Content, output: Path) -> str:
    """Write an FMU, whole or not at all.

    Returns:
        its model identifier, which is unique for its program.

    Raises:
        UserError: the file can't be written.
    """
    values = values_text("", content.name, content.numbers) if content.numbers else ""
    program = _Program(content.identifier, content.module, bool(values), values)
    write_whole(output, zipped({**_packed_by_pythonfmu(program), **python_files(content)}))
    return content.identifier


def module_file(content: Content) -> str:
    """Give the name of the slave's module inside its FMU."""
    return f"resources/{content.identifier}.py"


def python_files(content: Content) -> dict[str, bytes]:
    """Give the files that depend on values, not on the program alone."""
    named = values_text("", content.name, content.numbers)
    token = content_hash(
        content.identifier,
        repr(content.text),
        repr(sorted(content.quantities.items())),
        repr(content.tunable),
        repr(sorted(content.initially.items())),
        content.documentation,
        named,
    )
    files = {
        MODEL_DESCRIPTION: xml_bytes(
            completed(
                _described(content),
                token,
                content.text,
                content.quantities,
                content.initially,
                content.starts,
                content.tunable,
            )
        ),
        "documentation/index.html": content.documentation.encode("utf-8"),
        "documentation/externalDependencies.txt": PYTHON_NEEDS.encode("utf-8"),
        **licence_files("pythonfmu"),
        **content.further,
    }
    if content.numbers:
        files[f"resources/{FILE_NAME}"] = values_text(token, content.name, content.numbers).encode("utf-8")
    return files


def _described(content: Content) -> Element:
    """Give the model description as pythonfmu writes it."""
    slave = instance_of(content.module, content.identifier, values_text("", content.name, content.numbers))
    description: Element = slave.to_xml(OPTIONS)
    return description


@dataclass(frozen=True)
class _Program:
    """A slave without what its values decide.

    Attributes:
        identifier: name of its module, unique for it.
        module: the module's text.
        with_values: whether it reads a file of values.
        values: one such file's text, with which pythonfmu can make an instance.
    """

    identifier: str
    module: str
    with_values: bool
    values: str = field(compare=False)


@lru_cache(maxsize=8)
def _packed_by_pythonfmu(program: _Program) -> Mapping[str, bytes]:
    """Let pythonfmu make an FMU of the slave, once for all values; give the files by name that they don't decide."""
    name = program.identifier
    with tempfile.TemporaryDirectory(prefix="pipeclamp_") as folder, _restored_imports(name):
        script, values = Path(folder) / f"{name}.py", Path(folder) / FILE_NAME
        script.write_text(program.module, encoding="utf-8", newline="\n")
        values.write_text(program.values, encoding="utf-8", newline="\n")
        beside = [values] if program.with_values else []
        packed = FmuBuilder.build_FMU(script, Path(folder) / f"{name}.fmu", project_files=beside)
        with zipfile.ZipFile(packed) as archive:
            return {name: archive.read(name) for name in archive.namelist() if Path(name).name not in UNUSED}


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
        for name in sorted(files, key=lambda name: (name != MODEL_DESCRIPTION, name)):
            entry = zipfile.ZipInfo(name, NO_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whatever the platform
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, files[name])
    return stream.getvalue()
