"""Files that can't be used and may be left out, as campaign.toml states them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeclamp_identification.campaign.description import LeftOutFile
from pipeclamp_identification.importing.reading import digest_of
from pipeclamp_identification.importing.stated import LeaveOut
from pipeclamp_identification.importing.texts.decoding import file_name
from pipeclamp_identification.importing.unusable import UnusableFileError, UnusableFiles


def left_out_files(
    unusable: Mapping[Path, UnusableFileError], files: int, before: Sequence[LeftOutFile], leave_out: LeaveOut
) -> tuple[LeftOutFile, ...]:
    """Give the files that are left out, where they may be.

    Args:
        unusable: the error of each.
        files: of the import in all.
        before: that were left out by an earlier import.
        leave_out: says whether.

    Raises:
        UserError: they mustn't be, or there is no other.
    """
    found = {path: _of_unusable(path, error) for path, error in unusable.items()}
    anew = {path: unusable[path] for path, one in found.items() if not _is_among(one, before)}
    new = UnusableFiles(anew, files)
    if anew and not (new.others and leave_out(new)):
        raise new.refusal()
    return tuple(found.values())


def _of_unusable(path: Path, error: UnusableFileError) -> LeftOutFile:
    try:
        digest = digest_of(path)
    except UnusableFileError:
        digest = None
    return LeftOutFile(file=file_name(path), sha256=digest, why=error.why)


def _is_among(file: LeftOutFile, before: Sequence[LeftOutFile]) -> bool:
    """Tell whether a file, with this content, was left out before."""
    return file.sha256 is not None and (file.file, file.sha256) in {(one.file, one.sha256) for one in before}
