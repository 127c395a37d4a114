"""A slave's instance without an FMU around it."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from pipeclamp_fmu.slaves.values_file import FILE_NAME


def instance_of(module: str, class_name: str, values: str) -> Any:
    """Make an instance of a slave of a module, with a file of values, as an importer does."""
    scope: dict[str, Any] = {"__name__": class_name}
    exec(module, scope)
    with tempfile.TemporaryDirectory(prefix="pipeclamp_") as folder:
        Path(folder, FILE_NAME).write_text(values, encoding="utf-8", newline="\n")
        return scope[class_name](instance_name=class_name, resources=folder)
