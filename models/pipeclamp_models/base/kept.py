"""What takes long to work out, and is the same each time, kept in the user's cache folder from one call to the next.

Only this package's sources, the versions of SymPy and llvmlite and a name decide what is kept, so that nothing kept is
ever out of date.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import re
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import write_whole

FOLDER_VARIABLE = "PIPECLAMP_CACHE"
"""Environment variable that names another folder; nothing is kept where it is empty."""
MOST_VERSIONS = 3
"""Versions of the sources whose folders stay."""
WRITERS = ("sympy", "llvmlite")
"""Packages that write what is kept."""
VERSION = "[0-9a-f]{16}"
"""The names of such folders."""


def kept(name: str, make: Callable[[], Any]) -> Any:
    """Give what `make` makes, or what it made in an earlier call under this name.

    A folder that can't be read or written, or a file in it that isn't whole, only costs time.

    Args:
        name: says all that it is made from besides the package's sources.
        make: makes it, such as JSON holds: dicts, lists, text, numbers.
    """
    folder = _folder()
    if folder is None:
        return json.loads(json.dumps(make()))
    path = folder / version_of(Path(__file__).parents[1]) / f"{_digest(name)}.json"
    known = _read(path)
    if known is not None:
        return known
    content = json.dumps(make())
    _write(path, content)
    return json.loads(content)


def _folder() -> Path | None:
    """Give the folder that all versions keep things in, None where nothing is to be kept."""
    named = os.environ.get(FOLDER_VARIABLE)
    if named is None:
        return platformdirs.user_cache_path("pipeclamp", appauthor=False)
    return Path(named) if named else None


@cache
def version_of(package: Path) -> str:
    """Name a package's sources by what stands in them, so that nobody who changes one has to think of a number."""
    content = hashlib.sha256("".join(map(importlib.metadata.version, WRITERS)).encode())
    for path in sorted(package.rglob("*.py")):
        content.update(path.relative_to(package).as_posix().encode() + path.read_bytes())
    return content.hexdigest()[:16]


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _read(path: Path) -> Any:
    """Give what a file holds below its first line, a digest of the rest; None where it isn't there or not whole."""
    try:
        digest, _, content = path.read_text(encoding="utf-8").partition("\n")
    except (OSError, UnicodeDecodeError):
        return None
    return json.loads(content) if digest == _digest(content) else None


def _write(path: Path, content: str) -> None:
    """Write such a file, whole or not at all; other processes may be writing the same."""
    try:
        if not path.parent.is_dir():
            path.parent.mkdir(parents=True, exist_ok=True)
            # the folder may hold what isn't ours
            folders = [folder for folder in path.parents[1].iterdir() if re.fullmatch(VERSION, folder.name)]
            for old in sorted(folders, key=lambda folder: folder.stat().st_mtime)[:-MOST_VERSIONS]:
                shutil.rmtree(old, ignore_errors=True)
        write_whole(path, f"{_digest(content)}\n{content}")
    except (OSError, UserError):
        pass
