"""Writing files and folders whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.owned import owned_folder

FILE_KINDS = {
    stat.S_ISDIR: "is a folder",
    stat.S_ISFIFO: "is a pipe",
    stat.S_ISCHR: "is a device",
    stat.S_ISBLK: "is a device",
    stat.S_ISSOCK: "is a socket",
}
"""What may stand where a file is expected; opening some of them waits for ever."""
DEVICES = Path("/dev")
"""Folder of devices, /dev/stdout among them, which leads to a file where the output goes to one."""
WINDOWS_DEVICES = r"con|prn|aux|nul|com\d|lpt\d"
"""Names that are devices on Windows, whatever ends they have; in any case."""
PLAIN_FILE_NAME = re.compile(rf"(?!({WINDOWS_DEVICES})$)\w[\w-]{{0,63}}", re.ASCII | re.IGNORECASE)
"""Names without an end that files may have on every system."""
LONGEST_PLAIN = 60
"""Characters of a name that is made plain."""
FMU, SSP = ".fmu", ".ssp"
"""How names end by which tools know what they hold."""
FULL = (errno.ENOSPC, errno.EDQUOT)
"""Errors of a disk, or a user's share of it, that is full."""
ROOM = "expected room on its disk: free some, or name another place"
WAITS_s = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Waited before a file that can't be replaced is tried again."""


def refuse_no_file(path: Path, expected: str, where: str | None = None) -> None:
    """Refuse what is no file, before it is opened.

    Args:
        path: that is to be read.
        expected: what it should be, with what to do, for the message.
        where: what the message begins with; the path by default.

    Raises:
        UserError: there is none, or a folder, a pipe, a device.
    """
    place = str(path) if where is None else where
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        raise UserError(f"{place}: no such file; expected {expected}") from error
    except OSError as error:
        raise UserError(f"{place}: can't be read ({error.strerror}); expected {expected}") from error
    except ValueError as error:
        raise UserError(f"{place}: is no name that a file can have; expected {expected}") from error
    if not stat.S_ISREG(mode):
        kind = next((words for is_kind, words in FILE_KINDS.items() if is_kind(mode)), "is no file")
        raise UserError(f"{place}: {kind}; expected {expected}")


def read_content(path: Path, expected: str, where: str | None = None) -> bytes:
    """Read a file: the one way to any that a user names.

    Args:
        path: of the file.
        expected: what it should be, with what to do, for the message.
        where: what the message begins with; the path by default.

    Raises:
        UserError: it can't be read, or is none.
    """
    refuse_no_file(path, expected, where)
    try:
        return path.read_bytes()
    except OSError as error:
        place = path if where is None else where
        raise UserError(f"{place}: can't be read ({error.strerror}); expected {expected}") from error


def read_text(path: Path, expected: str) -> str:
    """Read a text file as `read_content` does; its line ends become "\\n", and no byte order mark stays.

    Raises:
        UserError: it can't be read, is none, or isn't UTF-8.
    """
    content = read_content(path, expected)
    try:
        text = content.decode("utf-8-sig")  # editors on Windows begin UTF-8 with a mark
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not UTF-8 text (byte {error.start}); expected {expected}, in UTF-8") from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def refuse_file(path: Path) -> None:
    """Refuse a path that no file can be written to, before the work that would fill it.

    Raises:
        UserError: there is a folder of that name, it is -, or its folder doesn't exist or can't be written to.
    """
    if "\0" in str(path):
        raise UserError(f"{path}: is no name that a file can have; expected the name of a file to write")
    if path == Path("-"):
        raise UserError("-: stands for no stdout here; expected the name of a file to write")
    if path.is_dir():
        raise UserError(f"{path}: is a folder; expected the name of a file to write")
    if (path.exists() and not path.is_file()) or path.parent == DEVICES:
        # a file would take its place
        raise UserError(f"{path}: is a device or a pipe; expected the name of a file to write")
    refuse_parent(path)


def refuse_ending(path: Path, ending: str, what: str) -> None:
    """Refuse a name to write by which tools don't know what it holds.

    Args:
        path: of the file to write.
        ending: that it needs, such as ".fmu", in any case.
        what: it holds.

    Raises:
        UsageError: it ends otherwise.
    """
    if path.suffix.casefold() != ending:
        raise UsageError(
            f"{path}: the name of {what} ends in {ending}, by which tools know it; expected {path.stem}{ending}, say"
        )


def refuse_folder(folder: Path) -> None:
    """Refuse a path that no new folder can be made at, before the work that would fill it.

    Raises:
        UserError: there is something of that name, or its parent folder doesn't exist or can't be written to.
    """
    if "\0" in str(folder):
        raise UserError(f"{folder}: is no name that a folder can have; expected one that is not there yet")
    if os.path.lexists(folder):
        raise UserError(f"{folder}: exists already; expected a folder that is not there yet")
    refuse_parent(folder)


def refuse_parent(path: Path) -> None:
    """Refuse a path in a folder that isn't there, or that can't be written to.

    Raises:
        UserError: its parent is no folder, doesn't exist, or can't be written to.
    """
    if not path.parent.is_dir():
        there = "is no folder" if path.parent.exists() else "doesn't exist"
        raise UserError(f"{path}: can't write there ({path.parent} {there}); expected an existing folder")
    try:  # what a folder's mode says isn't all: a disk may be read-only, a server may have lists of its own
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise UserError(
            f"{path}: can't write there ({error.strerror}); expected an existing folder that is writable"
        ) from error


def write_whole(path: Path, content: bytes | str) -> None:
    """Write `content` to `path` so that the file appears whole or not at all.

    Args:
        path: the file to write; an existing one is replaced, of a link the one that it leads to.
        content: bytes, or text that is written as UTF-8 with "\\n" line ends on every platform; bytes of files' names
            that are no text are written as question marks, which any reader of the file takes.

    Raises:
        UserError: there is a folder of that name, or the file's folder doesn't exist or can't be written.
    """
    refuse_file(path)
    data = content.encode("utf-8", "replace") if isinstance(content, str) else content
    place = Path(os.path.realpath(path))  # links in a circle, too
    try:
        handle, temporary = tempfile.mkstemp(dir=place.parent, prefix=f".{place.name}.", suffix=".part")
    except OSError as error:
        raise UserError(
            f"{path}: can't write there ({error.strerror}); expected an existing folder that is writable"
        ) from error
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
        Path(temporary).chmod(0o644)
        _replace(Path(temporary), place)
    except BaseException as error:
        Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError):
            remedy = f"; {ROOM}" if error.errno in FULL else ""
            raise UserError(f"{path}: can't be written ({error.strerror}){remedy}") from error
        raise


def _replace(temporary: Path, path: Path) -> None:
    """Put a file in the place of another; on Windows only once nobody reads that one, which takes moments."""
    for wait in WAITS_s:
        try:
            temporary.replace(path)
        except PermissionError:
            time.sleep(wait)
        else:
            return
    temporary.replace(path)


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
    written = []
    with staged_folder(folder) as work:
        for file, content in files:
            (work / file).parent.mkdir(parents=True, exist_ok=True)
            (work / file).write_bytes(content)
            written.append(file)
        work.chmod(0o755)
        work.rename(folder)
    return tuple(written)


@contextmanager
def staged_folder(folder: Path) -> Iterator[Path]:
    """Give a new folder beside the place of another, to be renamed to it when it is whole; what is left is deleted.

    That holds of what killed processes left there, too.

    Raises:
        UserError: it can't be made, or its disk is full.
    """
    with ExitStack() as stack:
        try:
            work = stack.enter_context(owned_folder(folder))
        except OSError as error:
            raise UserError(
                f"{folder}: can't write there ({error.strerror}); expected an existing parent folder"
            ) from error
        try:
            yield work
        except OSError as error:
            if error.errno not in FULL:
                raise
            raise UserError(f"{folder}: can't be written ({error.strerror}); {ROOM}") from error


def replace_folder(work: Path, folder: Path) -> None:
    """Put a finished folder in a place, where another may be, which is deleted when the new one is there.

    No system exchanges two folders in one step. Between the two steps the old one stands beside its place, whole;
    where the process ends just then, `restored` puts it back.
    """
    work.chmod(0o755)
    if not folder.exists():
        work.rename(folder)
        return
    aside = set_aside(folder)
    shutil.rmtree(aside, ignore_errors=True)  # of a process that ended after both steps
    folder.rename(aside)
    try:
        work.rename(folder)
    except BaseException:
        aside.rename(folder)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def set_aside(folder: Path) -> Path:
    """Give where a folder stands while another takes its place."""
    return beside(folder, f".{folder.resolve().name}.before")


def beside(folder: Path, name: str) -> Path:
    """Give a path beside a folder, which may be the one that a command is called in, or one above it."""
    return folder.with_name(name) if folder.name not in ("", "..") else folder / ".." / name


def restored(folder: Path) -> bool:
    """Put a folder back that was set aside by a process which ended before its successor was in place; tell whether."""
    if os.path.lexists(folder) or not set_aside(folder).is_dir():
        return False
    set_aside(folder).rename(folder)
    return True


def plain_stems(names: Sequence[str]) -> list[str]:
    """Give names of files for texts, without an end, plain on every system: no two alike, whatever their case."""
    taken: set[str] = set()
    found = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_")[:LONGEST_PLAIN] or "group"
        found.append(untaken(plain if PLAIN_FILE_NAME.fullmatch(plain) else f"{plain}_", taken))
    return found


def untaken(stem: str, taken: set[str], end: str = "") -> str:
    """Give a name (a file's without its end), longer where another has it, in whatever case, as on Windows; take it.

    Args:
        stem: the name.
        taken: names with their ends, in lower case, of a folder; the new one joins them.
        end: the name's end.
    """
    while f"{stem}{end}".casefold() in taken:
        stem += "_"
    taken.add(f"{stem}{end}".casefold())
    return stem
