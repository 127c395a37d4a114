"""Folders that are being filled, beside the places that they are for: a lock tells whether their process lives."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

PART, LOCK = ".part", ".lock"
TRIES = 3
"""Names that are tried, where another process takes a new lock for one that was left."""


@contextmanager
def owned_folder(place: Path) -> Iterator[Path]:
    """Give a new folder beside a place; when it isn't there any more, or the caller is done, nothing of it is left.

    What processes that were killed left beside the same place goes, too: the system gives their locks free, on Windows
    as elsewhere, whatever ended them.

    Raises:
        OSError: it can't be made.
    """
    clear_abandoned(place)
    lock, handle = _new_lock(place)
    work = _folder_of(lock)
    try:
        work.mkdir(mode=0o700)
        yield work
    finally:
        _clear(lock, handle)


def clear_abandoned(place: Path) -> None:
    """Delete the folders beside a place that no living process owns."""
    mine = re.compile(re.escape(f".{place.name}.") + r"[a-z0-9_]+" + re.escape(PART + LOCK))
    with suppress(OSError):
        for lock in [one for one in place.parent.iterdir() if mine.fullmatch(one.name)]:
            # of another user's, or gone meanwhile
            with suppress(OSError):
                handle = os.open(lock, os.O_RDWR)
                if _is_ours(handle):
                    _clear(lock, handle)
                else:
                    os.close(handle)


def _new_lock(place: Path) -> tuple[Path, int]:
    """Make a lock beside a place, and hold it.

    Where the file system knows no locks, it is held by nobody; then nobody finds it abandoned either.

    Returns:
        its file and handle.
    """
    for left in reversed(range(TRIES)):
        handle, name = tempfile.mkstemp(dir=place.parent, prefix=f".{place.name}.", suffix=PART + LOCK)
        # before it was held, another process may have taken it for abandoned
        if (_is_ours(handle) and Path(name).exists()) or not left:
            break
        os.close(handle)
    return Path(name), handle


def _folder_of(lock: Path) -> Path:
    return lock.with_name(lock.name.removesuffix(LOCK))


def _is_ours(handle: int) -> bool:
    """Take a lock, unless another process holds it; tell whether it is ours."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _clear(lock: Path, handle: int) -> None:
    """Delete a folder whose lock is held, and the lock; it stays where the folder does, for the next one to try."""
    work = _folder_of(lock)
    shutil.rmtree(work, ignore_errors=True)
    gone = not os.path.lexists(work)
    # while it is held, so that nobody takes it up just then; Windows deletes no file that is open
    if gone:
        with suppress(OSError):
            lock.unlink()
    os.close(handle)
    if gone:
        with suppress(OSError):
            lock.unlink()
