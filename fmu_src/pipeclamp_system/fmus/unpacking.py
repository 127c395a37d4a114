"""Where FMUs are unpacked: pythonfmu 0.7 ends the whole process where the path holds characters that a URI encodes.

It is handed its folder as a URI and undoes %20, the space, alone.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.fmus.messages import PYTHON_FMU
from pipeclamp_system.fmus.variables import read_model_description

PREFIX = "pipeclamp_"


def unpacking_folder(fmus: Sequence[Path]) -> Path:
    """Make a temporary folder that these FMUs can be unpacked in.

    It is a usual one, unless a Python FMU is among them that couldn't stand its path: then it is in the first of the
    system's other temporary folders that it can.

    Raises:
        UserError: there is no such folder, or an FMU can't be read.
    """
    usual = Path(tempfile.gettempdir())
    if is_plain(usual) or not any(map(_runs_python, fmus)):
        return Path(tempfile.mkdtemp(prefix=PREFIX))
    for folder in _others():
        if is_plain(folder) and os.access(folder, os.W_OK | os.X_OK):
            return Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    raise UserError(
        f"Python FMUs can't be unpacked in the temporary folder {usual}: of its path, pythonfmu takes ASCII letters, "
        "digits, spaces and - . _ ~ alone; expected TMPDIR to name another folder, or FMUs built with --kind native"
    )


def is_plain(folder: Path) -> bool:
    """Tell whether a folder's path stands in a URI as it is, but for spaces."""
    return "%" not in folder.absolute().as_uri().replace("%20", "")


def _others() -> Sequence[Path]:
    """Give the system's temporary folders, those that all can write to first."""
    if os.name == "nt":
        return [Path(os.environ.get("SYSTEMROOT", r"C:\Windows")) / "Temp", Path(r"C:\Temp")]
    return [Path("/tmp"), Path("/var/tmp")]


def _runs_python(fmu: Path) -> bool:
    return PYTHON_FMU in (read_model_description(fmu).generationTool or "")
