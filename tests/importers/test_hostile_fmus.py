"""Native FMUs with parts that are gone, cut, doubled or oddly packed: what reads FMUs takes them or says so in a line.

The environment variable PIPECLAMP_HOSTILE_FMUS says how many of each kind are tried.
"""

from __future__ import annotations

import os
import random
import struct
import zipfile
import zlib
from pathlib import Path

import pytest

from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import LONGEST_LINE
from pipeclamp_models.law.file import LawFile
from pipeclamp_system.fmus.participant import LoadedFmu

EACH = int(os.environ.get("PIPECLAMP_HOSTILE_FMUS", "3"))
DONE = ("gone", "cut", "empty", "twice", "stored", "bzip2", "lzma", "renamed", "foreign", "claims")
BOMB = 2_100_000_000


def damaged(fmu: Path, output: Path, what: str, chance: random.Random) -> str:
    """Write an FMU of which one part is damaged; give the part's name."""
    with zipfile.ZipFile(fmu) as archive:
        parts = {entry.filename: archive.read(entry) for entry in archive.infolist() if not entry.is_dir()}
    chosen = chance.choice(sorted(parts))
    methods = {"stored": zipfile.ZIP_STORED, "bzip2": zipfile.ZIP_BZIP2, "lzma": zipfile.ZIP_LZMA}
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            if name != chosen:
                archive.writestr(name, content)
            elif what == "cut":
                archive.writestr(name, content[: chance.randrange(len(content))])
            elif what == "empty":
                archive.writestr(name, b"")
            elif what == "foreign":
                archive.writestr(name, parts[chance.choice(sorted(parts))])
            elif what == "renamed":
                archive.writestr(chance.choice(["../" + name, "C:/x", name.upper(), "\u202e", name + "/x"]), content)
            elif what != "gone":
                archive.writestr(name, content, methods.get(what))
                if what == "twice":
                    archive.writestr(name, content[: len(content) // 2])
    if what == "claims":
        directory_says(output, chosen, chance.choice([0, 1, 1 << 31, BOMB, 0xFFFFFFFE]))
    return chosen


def directory_says(path: Path, name: str, size: int) -> None:
    """Change the size that an archive's directory states of a file."""
    content = bytearray(path.read_bytes())
    place = content.rindex(name.encode(), 0, len(content))
    struct.pack_into("<I", content, place - 46 + 24, size)
    path.write_bytes(content)


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("what", DONE)
def test_a_native_fmu_with_a_damaged_part_is_taken_or_told_in_a_line(what, native_fmus, law_with_memory, tmp_path):
    chance = random.Random(what)
    taken = 0
    for number in range(EACH):
        path = tmp_path / f"{number}.fmu"
        part = damaged(native_fmus[2], path, what, chance)
        if part.endswith(".so") and what == "foreign":
            continue
        for use in (changed, loaded):
            try:
                use(path, law_with_memory, tmp_path / f"{use.__name__}{number}")
                taken += 1
            except UserError as error:
                first, *further = str(error).split("\n")
                assert str(path) in first or path.name in first
                assert len(first) <= LONGEST_LINE
                assert all(line.startswith("  ") for line in further)
    assert taken or what != "stored"


def changed(path: Path, law: LawFile, place: Path) -> None:
    set_parameters(path, law, place.with_suffix(".fmu"))


def loaded(path: Path, law: LawFile, place: Path) -> None:
    place.mkdir()
    LoadedFmu(path, "clamp", place).slave.freeInstance()


@pytest.mark.parametrize("honest", [True, False])
def test_two_gigabytes_of_zeros_are_never_unpacked(honest, law_with_memory, tmp_path):
    path = tmp_path / "bomb.fmu"
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    block = packer.compress(bytes(10_000_000)) + packer.flush(zlib.Z_FULL_FLUSH)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("modelDescription.xml", block * (BOMB // 10_000_000))
    content = bytearray(path.read_bytes())
    directory = content.rindex(b"PK\x01\x02")
    for place, offset in ((0, 8), (directory, 10)):
        struct.pack_into("<H", content, place + offset, zipfile.ZIP_DEFLATED)
    for place, offset in ((0, 22), (directory, 24)):
        struct.pack_into("<I", content, place + offset, BOMB if honest else 1000)
    path.write_bytes(content)
    told = "would unpack to" if honest else "not a whole zip archive"
    with pytest.raises(UserError, match=told):
        set_parameters(path, law_with_memory, tmp_path / "out.fmu")
    (tmp_path / "unpacked").mkdir()
    with pytest.raises(UserError, match="would unpack to" if honest else "not a (whole zip archive|readable FMU)"):
        LoadedFmu(path, "clamp", tmp_path / "unpacked")
    assert sum(one.stat().st_size for one in (tmp_path / "unpacked").rglob("*") if one.is_file()) < 2000


def test_a_library_cut_anywhere_is_not_loaded(native_fmus, tmp_path):
    with zipfile.ZipFile(native_fmus[2]) as archive:
        parts = {entry.filename: archive.read(entry) for entry in archive.infolist() if not entry.is_dir()}
    name = next(name for name in parts if Path(name).suffix in (".so", ".dll", ".dylib"))
    chance = random.Random(0)
    for number in range(EACH):
        path, folder = tmp_path / f"{number}.fmu", tmp_path / f"unpacked{number}"
        folder.mkdir()
        with zipfile.ZipFile(path, "w") as archive:
            for part, content in parts.items():
                archive.writestr(part, content[: chance.randrange(len(content))] if part == name else content)
        with pytest.raises(UserError, match="is cut short"):
            LoadedFmu(path, "clamp", folder)
