"""Zip archives, FMUs among them: looked at before anything is unpacked, and read whole."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import refuse_no_file

MOST_ARCHIVE_BYTES = 1_000_000_000
"""Of all files of an archive, unpacked."""
MOST_ARCHIVE_FILES = 100_000
MOST_UNPACKED_TIMES, FEW_BYTES = 300, 1_000_000
"""Bytes for each byte of the archive, and those of any: zeros shrink a thousandfold, but no text, number or program."""
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Compressions of an FMU, by its standard."""
DAMAGE = (OSError, EOFError, ValueError, RuntimeError, NotImplementedError, zipfile.BadZipFile, zlib.error)
"""What reading a damaged archive raises."""


def read_archive(path: Path, expected: str) -> dict[str, bytes]:
    """Read all files of an archive by their names.

    Args:
        path: of the archive.
        expected: what it should be, for messages.

    Raises:
        UserError: it can't be read, is damaged or encrypted, or would unpack to more than memory should hold.
    """
    with opened_archive(path, expected) as archive:
        return {entry.filename: _content(archive, entry) for entry in archive.infolist() if not entry.is_dir()}


def read_part(path: Path, name: str, expected: str) -> bytes:
    """Read one file of an archive.

    Raises:
        UserError: as of `read_archive`, or there is no such file in it.
    """
    with opened_archive(path, expected) as archive:
        if name not in archive.namelist():
            raise UserError(f"{path}: holds no {name}; expected {expected}")
        return _content(archive, archive.getinfo(name))


def _content(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bytes:
    """Read a file of an archive; `ZipFile.read` would unpack all that there is, and then take what was stated."""
    with archive.open(entry) as stream:
        return stream.read(entry.file_size + 1)


def unpack_archive(path: Path, folder: Path, expected: str) -> None:
    """Unpack an archive into a folder.

    Raises:
        UserError: as of `read_archive`.
    """
    with opened_archive(path, expected) as archive:
        archive.extractall(folder)


@contextmanager
def opened_archive(path: Path, expected: str) -> Iterator[zipfile.ZipFile]:
    """Open an archive that is fit to be unpacked.

    Raises:
        UserError: as of `read_archive`; also where what is done with it inside finds it damaged.
    """
    refuse_no_file(path, expected)
    try:
        with zipfile.ZipFile(path) as archive:
            _refuse_unfit(path, archive.infolist(), expected)
            yield archive
    except UserError:
        raise
    except DAMAGE as error:
        raise UserError(f"{path}: not a whole zip archive ({error}); expected {expected}") from error


def _refuse_unfit(path: Path, entries: list[zipfile.ZipInfo], expected: str) -> None:
    """Refuse what must not be unpacked, by what the archive's directory says of it.

    A file that is read in parts never unpacks to more than is said there: zipfile stops, and its check sum is wrong.
    """
    size, packed = sum(entry.file_size for entry in entries), path.stat().st_size
    if size > FEW_BYTES + MOST_UNPACKED_TIMES * packed:
        raise UserError(
            f"{path}: would unpack to {size / 1e6:.3g} MB, {size / packed:.0f} times its size; expected {expected}"
        )
    if size > MOST_ARCHIVE_BYTES or len(entries) > MOST_ARCHIVE_FILES:
        raise UserError(
            f"{path}: would unpack to {size / 1e9:.3g} GB in {len(entries)} files, "
            f"at most {MOST_ARCHIVE_BYTES / 1e9:g} GB in {MOST_ARCHIVE_FILES} can be taken; expected {expected}"
        )
    for entry in entries:
        if entry.flag_bits & 0x1:
            raise UserError(f"{path}: {entry.filename!r} in it is encrypted; expected {expected}, without a password")
        if entry.compress_type not in METHODS:
            raise UserError(
                f"{path}: {entry.filename!r} in it is compressed by method {entry.compress_type}; expected {expected}, "
                "with files stored or deflated"
            )
        windows = PureWindowsPath(entry.filename)
        if windows.drive or windows.root or ".." in PurePosixPath(windows.as_posix()).parts:
            raise UserError(f"{path}: {entry.filename!r} in it lies outside of it; expected {expected}")
