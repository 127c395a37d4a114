"""Files that are dropped on the page: limited in size and number, with names that are names and no paths."""

from __future__ import annotations

import re
import shutil
import time
import unicodedata
from collections.abc import AsyncIterator
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.files import WINDOWS_DEVICES

MOST_UPLOAD_BYTES = 512 * 2**20
"""Of one file."""
MOST_UPLOAD_FILES = 500
MOST_TOTAL_BYTES = 4 * 2**30
"""Of all files in the studio's folder."""
LONGEST_FILE_NAME = 120
ABANDONED_s = 86400.0
"""After a day without another file nobody has the page open any more on which files were dropped."""
BATCH = re.compile(r"[0-9a-f]{16}")
RESERVED = re.compile(rf"(?i)({WINDOWS_DEVICES})(\..*)?")


def safe_name(given: str) -> str:
    """Give a file's name without anything that leads elsewhere.

    Raises:
        UserError: nothing is left of it.
    """
    last = re.split(r"[/\\]", unicodedata.normalize("NFC", given))[-1]
    name = re.sub(r"[^\w.()\[\] +=,@°-]", "_", last).strip(" .")
    if not name.strip("_"):
        raise UserError(f"{given!r}: is no name of a file; expected one such as A0.5_f3_T20.csv")
    stem, dot, suffix = name.rpartition(".")
    shortened = f"{stem[: LONGEST_FILE_NAME - len(suffix) - 1]}{dot}{suffix}" if dot and len(suffix) < 20 else name
    shortened = shortened[:LONGEST_FILE_NAME]
    return f"_{shortened}" if RESERVED.fullmatch(shortened) else shortened


def safe_campaign(given: str) -> str:
    """Give the name of a campaign's folder.

    Raises:
        UserError: it is none.
    """
    name = given.strip()
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}", name) or RESERVED.fullmatch(name) or name == "uploads":
        raise UserError(f"{given!r}: is no name for a campaign; expected letters, digits, _ and -, such as clamp_7")
    return name


def batch_folder(home: Path, batch: str) -> Path:
    """Give the folder of files that were dropped together.

    Raises:
        UserError: that is no name of one.
    """
    if not BATCH.fullmatch(batch):
        raise UserError("got no batch of files; drop the files again")
    return home / "uploads" / batch


def taken(home: Path, batch: str) -> Path:
    """Give the folder of files that were dropped together and are still there.

    Raises:
        UserError: they aren't, or that is no name of a batch.
    """
    folder = batch_folder(home, batch)
    if not folder.is_dir():
        raise UserError("the files that were dropped are no longer here: a campaign was made of them; drop them again")
    return folder


def clear(home: Path, batch: str) -> None:
    """Remove files that were dropped together: a campaign holds what was in them."""
    shutil.rmtree(batch_folder(home, batch), ignore_errors=True)


def clear_abandoned(home: Path) -> None:
    """Remove files that were dropped long ago; newer ones may be those of another studio in the same folder."""
    for folder in (home / "uploads").glob("*"):
        if BATCH.fullmatch(folder.name) and not folder.is_symlink() and _age_s(folder) > ABANDONED_s:
            clear(home, folder.name)


def _age_s(folder: Path) -> float:
    try:
        return time.time() - folder.stat().st_mtime
    except FileNotFoundError:  # another studio has just removed it
        return 0.0


async def take(home: Path, batch: str, given: str, content: AsyncIterator[bytes]) -> str:
    """Take a file; it is there whole or not at all.

    Args:
        home: the studio's folder.
        batch: name of the files that were dropped together.
        given: the file's name as the browser has it.
        content: its bytes, piece by piece.

    Returns:
        the name that it has here.

    Raises:
        UserError: it is too large, one too many, or of a name that is there already.
    """
    folder, name = batch_folder(home, batch), safe_name(given)
    folder.mkdir(parents=True, exist_ok=True)
    if folder.resolve() != home.resolve() / "uploads" / batch:
        raise UserError(f"{folder}: leads elsewhere; expected a folder of the studio")
    if sum(1 for _ in folder.iterdir()) >= MOST_UPLOAD_FILES:
        raise UserError(f"{name}: one file too many; expected at most {MOST_UPLOAD_FILES} at once")
    target, part = folder / name, folder / f".{name}.part"
    if target.exists() or part.exists():
        raise UserError(f"{name}: is there already; expected files of different names")
    room = min(MOST_UPLOAD_BYTES, MOST_TOTAL_BYTES - _size_of(folder.parent))
    try:
        with part.open("xb") as stream:
            async for piece in content:
                room -= len(piece)
                if room < 0:
                    raise UserError(
                        f"{name}: too large; expected at most {MOST_UPLOAD_BYTES >> 20} MB a file, "
                        f"{MOST_TOTAL_BYTES >> 30} GB in all"
                    )
                stream.write(piece)
        part.rename(target)
    finally:
        part.unlink(missing_ok=True)
    return name


def _size_of(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
