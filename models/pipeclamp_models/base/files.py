"""Writing files and folders whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path

from pipeclamp_models.base.errors import UserError


def why_unreadable(error: OSError | UnicodeDecodeError) -> str:
    """Say why a text file couldn't be read, without the system's numbers."""
    if isinstance(error, UnicodeDecodeError):
        return f"is not UTF-8 text (byte {error.start})"
    return "no such file" if isinstance(error, FileNotFoundError) else f"can't be read ({error.strerror})"


def refuse_file(path: Path) -> None:
    """Refuse a path that no file can be written to, before the work that would fill it.

    Raises:
        UserError: there is a folder of that name, or the file's folder doesn't exist.
    """
    if path.is_dir():
        raise UserError(f"{path}: is a folder; expected the name of a file to write")
    _refuse_parent(path)


def refuse_folder(folder: Path) -> None:
    """Refuse a path that no new folder can be made at, before the work that would fill it.

    Raises:
        UserError: there is something of that name, or its parent folder doesn't exist.
    """
    if folder.exists():
        raise UserError(f"{folder}: exists already; expected a folder that is not there yet")
    _refuse_parent(folder)


def _refuse_parent(path: Path) -> None:
    if not path.parent.is_dir():
        there = "is no folder" if path.parent.exists() else "doesn't exist"
        raise UserError(f"{path}: can't write there ({path.parent} {there}); expected an existing folder")


def write_whole(path: Path, content: bytes | str) -> None:
    """Write `content` to `path` so that the file appears whole or not at all.

    Args:
        path: the file to write; an existing one is replaced.
        content: bytes, or text that is written as UTF-8 with "\\n" line ends on every platform.

    Raises:
        UserError: there is a folder of that name, or the file's folder doesn't exist or can't be written.
    """
    refuse_file(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    except OSError as error:
        raise UserError(
            f"{path}: can't write there ({error.strerror}); expected an existing folder that is writable"
        ) from error
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except BaseException as error:
        Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise UserError(f"{path}: can't be written ({error.strerror})") from error
        raise


def write_folder(folder: Path, files: Iterable[tuple[str, bytes]]) -> tuple[str, ...]:
    """Write files into a new folder, which appears whole or not at all.

    Args:
        folder: the folder to make.
        files: path inside the folder, with forward slashes, and content of each.

    Returns:
        the paths that were written.

    Raises:
        UserError: the folder exists, or its parent can't be written.
    """
    refuse_folder(folder)
    try:
        work = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}.", suffix=".part"))
    except OSError as error:
        raise UserError(
            f"{folder}: can't write there ({error.strerror}); expected an existing parent folder"
        ) from error
    written = []
    try:
        for file, content in files:
            (work / file).parent.mkdir(parents=True, exist_ok=True)
            (work / file).write_bytes(content)
            written.append(file)
        work.chmod(0o755)
        work.rename(folder)
    except BaseException:
        shutil.rmtree(work, ignore_errors=True)
        raise
    return tuple(written)
