"""Writing files whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from pipeclamp.errors import UserError


def write_whole(path: Path, content: bytes | str) -> None:
    """Write `content` to `path` so that the file appears whole or not at all.

    Args:
        path: the file to write; an existing one is replaced.
        content: bytes, or text that is written as UTF-8 with "\\n" line ends on every platform.

    Raises:
        UserError: the folder doesn't exist or can't be written.
    """
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
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
