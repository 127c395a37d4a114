"""Files to tables, whatever their format; what isn't whole is told in one sentence."""

from __future__ import annotations

import gc
import hashlib
import logging
import pkgutil
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from pipeclamp_identification.importing import formats
from pipeclamp_identification.importing.raw import Damaged, Format, RawTable, side_by_side, without_controls
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError
from pipeclamp_identification.units.stated import unit_in_name
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.quiet import quietly
from pipeclamp_models.base.tables import pl

HEAD = 512
"""Bytes by which a format is told."""
MOST_TOLD = 160
"""Characters of a foreign library's message that a user sees."""
MOST_OF_CELL = 30
"""Characters of a cell."""


@dataclass(frozen=True)
class SourceFile:
    """A file as it was read: its format and its tables."""

    path: Path
    format: str
    tables: tuple[RawTable, ...]

    @property
    def name(self) -> str:
        """The file's name, without its folders."""
        return file_name(self.path)


def stem_of(path: Path) -> str:
    """Give a file's name without what tells its format."""
    plain = file_name(path).removesuffix(".gz")
    return Path(plain).stem or plain


@cache
def known_formats() -> tuple[Format, ...]:
    """Give every format that there is a module of, text last: it has no mark of its own."""
    names = sorted(module.name for module in pkgutil.iter_modules(formats.__path__))
    found: list[Format] = [import_module(f"{formats.__name__}.{name}").FORMAT for name in names]
    return tuple(sorted(found, key=lambda one: one.name == TEXT))


TEXT = "delimited text"


def files_in(given: Sequence[Path]) -> tuple[Path, ...]:
    """Give the files that are named: those of a folder, too, by the endings of known formats, in order of their names.

    Raises:
        UserError: there is no such file, it is none that holds data, or it is named twice.
    """
    found: list[Path] = []
    for path in given:
        if path.is_dir():
            inside = _read_of(path)
            if not inside:
                first = next((one.name for one in sorted(path.iterdir()) if one.is_file()), "")
                raise UserError(
                    f"{path}: holds no file with an ending of a known format"
                    + (f" (but {without_controls(first)!r})" if first else "")
                    + "; expected endings such as .csv, .xlsx or .tdms, or the files themselves named"
                )
            found += inside
        elif path.is_file():
            found.append(path)
        else:
            why = "is no file with data (a device or pipe)" if path.exists() else "no such file"
            raise UserError(f"{path}: {why}; expected a test machine's file, or a folder of them")
    seen: dict[Path, Path] = {}
    for path in found:
        if (other := seen.setdefault(path.resolve(), path)) is not path:
            raise UserError(f"{path}: is named twice (as {other}); expected each file once")
    return tuple(found)


def passed_over_in(given: Sequence[Path]) -> tuple[list[str], list[str]]:
    """Give the names of the files in folders that `files_in` doesn't give; those that a system hides aside.

    Returns:
        names of files of no known ending; and of those that are left, for they may describe the others.
    """
    folders = [path for path in given if path.is_dir()]
    read = {one for folder in folders for one in _read_of(folder)}
    inside = (one for folder in folders for one in sorted(folder.iterdir()))
    over = [one for one in inside if one.is_file() and one not in read and not one.name.startswith(".")]
    return [one.name for one in over if not _formats_named(one)], [one.name for one in over if _formats_named(one)]


def _read_of(folder: Path) -> list[Path]:
    """Give the files of a folder that are read: of known endings, and notes on others where there are no others."""
    named = [(path, one) for path in sorted(folder.iterdir()) if path.is_file() for one in _formats_named(path)]
    tests = [path for path, one in named if not one.is_also_notes]
    return tests or [path for path, _ in named]


def _formats_named(path: Path) -> list[Format]:
    return [one for one in known_formats() if path.suffix.lower() in one.suffixes][:1]


def digest_of(path: Path) -> str:
    """Give the SHA-256 of a file's bytes.

    Raises:
        UnusableFileError: it can't be read.
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise _unusable(path, f"can't be read ({error.strerror})") from error


class Contents:
    """Tells the files of an import apart by their content.

    Attributes:
        again: names of files whose content the campaign holds already.
        notes: which were left aside beside others of the same content.
    """

    def __init__(self, known: Mapping[str, str]) -> None:
        """Take the SHA-256 of files that the campaign holds, by name."""
        self._known = known
        self._new: dict[str, str] = {}
        self.again: list[str] = []
        self.notes: list[str] = []

    def __bool__(self) -> bool:
        """Tell whether any file has served yet."""
        return bool(self._new or self.again)

    def is_new(self, path: Path, sha256: str) -> bool:
        """Tell whether a file is to be taken.

        Raises:
            UserError: another one has its name.
        """
        called = file_name(path)
        if sha256 in self._known.values():
            self.again.append(called)
            return False
        if (other := self._new.get(sha256)) is not None:
            words = f"{called}: left aside, for it has the same content as {other}: one measurement counts once"
            self.notes += [] if words in self.notes else [words]
            return False
        if called in self._known:
            raise UserError(
                f"{path}: the campaign holds a file of this name with other content; expected another name, or a new "
                "campaign"
            )
        if called in self._new.values():
            raise UserError(f"{path}: another file has this name; expected a name of its own for each")
        self._new[sha256] = called
        return True


def read_file(path: Path) -> SourceFile:
    """Read a test machine's file.

    Raises:
        UnusableFileError: it can't be read, is damaged, or of no format that is known.
        UserError: it is of a format whose package isn't installed.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD)
    except OSError as error:
        raise _unusable(path, f"can't be read ({error.strerror})") from error
    if not head:
        raise _unusable(path, "is empty (0 bytes); export or copy it again")
    found = _format_of(path, head)
    if found.module and find_spec(found.module) is None:
        raise UserError(
            f"{path}: {found.name} is read by the package {found.package}, which isn't installed; "
            "expected it: pip install 'pipeclamp[import]'"
        )
    tables: tuple[RawTable, ...] = ()
    failure = ""
    with _silently():
        try:
            read = [part for table in found.read(path) if table.length for part in side_by_side(table)]
            tables = tuple(_told_apart(table) for table in read)
        except Damaged as error:
            failure = str(error)
        except UserError as error:
            failure = str(error).removeprefix(f"{path}: ")
        except (Exception, pl.exceptions.PanicException) as error:  # foreign readers raise anything of a damaged file
            failure = f"is no whole {found.name} file ({_first_line(error)}); export or copy it again"
        if failure:
            # what a reader leaves half made speaks up when it goes
            gc.collect()
    if failure:
        raise _unusable(path, failure)
    if not tables:
        raise _unusable(path, f"holds no channel of numbers; expected {found.name} with time, displacement and force")
    return SourceFile(path, found.name, tables)


def _unusable(path: Path, why: str) -> UnusableFileError:
    return UnusableFileError(str(path), why, is_damaged=True)


def _told_apart(table: RawTable) -> RawTable:
    """Give a table whose channels have names of their own that can be printed."""
    seen: dict[str, int] = {}
    channels = []
    for channel in table.channels:
        channel = replace(channel, name=without_controls(channel.name), unit=without_controls(channel.unit))
        seen[channel.heading] = seen.get(channel.heading, 0) + 1
        if (number := seen[channel.heading]) > 1:
            # before the unit, which must be found as that of the first
            base, unit = unit_in_name(channel.name)
            channel = replace(channel, name=f"{base} #{number} [{unit}]" if unit else f"{channel.name} #{number}")
        channels.append(channel)
    plain, cut = without_controls, partial(_cut, most=MOST_OF_CELL)
    unread = tuple(replace(one, name=plain(one.name), unit=plain(one.unit), text=cut(one.text)) for one in table.unread)
    labels = tuple(
        label
        for one in table.labels
        if (
            label := replace(one, name=plain(one.name), unit=plain(one.unit), texts=tuple(map(plain, one.texts)))
        ).heading
        not in seen
    )
    return replace(table, name=plain(table.name), channels=tuple(channels), unread=unread, labels=labels)


def _format_of(path: Path, head: bytes) -> Format:
    """Tell a file's format by what it begins with; an ending that says another format is refused where that is sure."""
    for one in known_formats():
        if one.begins(head):
            return one
    named = next((one for one in known_formats() if path.suffix.lower() in one.suffixes), None)
    text = known_formats()[-1]
    # LabVIEW and others call tables of text .xls
    if named not in (None, text) and not _is_text(head):
        raise _unusable(path, f"is no {named.name} file, by its first bytes; export or copy it again")
    if not _is_text(head):
        raise _unusable(path, f"is of no known format; expected {', '.join(one.name for one in known_formats())}")
    return text


def _is_text(head: bytes) -> bool:
    """Tell whether bytes may be text: no control characters but those of lines, tabs and UTF-16's zeros."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff", b"\x1f\x8b")):
        return True
    controls = sum(byte < 32 and byte not in (0, 9, 10, 12, 13, 26) for byte in head)
    zeros = head.count(0)
    return controls == 0 and (zeros == 0 or 0.3 < zeros / len(head) < 0.6)


def _first_line(error: BaseException) -> str:
    """Give the first line of a foreign message, cut, without control characters."""
    line = (str(error).strip().splitlines() or [""])[0] or type(error).__name__
    return _cut(line, MOST_TOLD)


def _cut(text: str, most: int) -> str:
    """Give a text without control characters, no longer than that."""
    plain = without_controls(text)
    return plain if len(plain) <= most else f"{plain[:most]}..."


@contextmanager
def _silently() -> Iterator[None]:
    """Keep foreign readers from writing warnings, logs, and what destructors and Rust raise between our lines."""
    before, hook = logging.root.manager.disable, sys.unraisablehook
    logging.disable(logging.CRITICAL)
    sys.unraisablehook = lambda unraisable: None
    try:
        with quietly(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)
        sys.unraisablehook = hook
