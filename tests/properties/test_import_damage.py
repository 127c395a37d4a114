"""Damaged files of each format end in one clear message each, or in the runs that they still hold.

The environment variable PIPECLAMP_DAMAGED says how many files of each kind are tried: 250 makes 3,000, in 3 minutes.
"""

from __future__ import annotations

import os
import struct
import sys
import zipfile
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from exports import loop, text
from format_writers import WRITERS, Writer
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeclamp_identification.importing import apart
from pipeclamp_identification.importing.apart import read_apart
from pipeclamp_identification.importing.raw import Damaged
from pipeclamp_identification.importing.records.planner import plan_import
from pipeclamp_identification.importing.stated import Options
from pipeclamp_models.base.errors import UserError

EACH = int(os.environ.get("PIPECLAMP_DAMAGED", "6"))
LONGEST_LINE = 600
KINDS = {**WRITERS, "text": Writer(".csv", lambda path, run: path.write_bytes(text(run).encode()) and None)}
HOSTILE = [
    *(
        struct.pack("<I", 0xFFFFFFFF),
        struct.pack("<Q", 1 << 60),
        struct.pack("<Q", 1 << 33),
        struct.pack(">I", 1 << 31),
    ),
    *(b"1e308", b"99999999999", bytes(16)),
]
"""Counts and numbers that no file of this size holds."""


@cache
def whole(kind: str) -> bytes:
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"a{KINDS[kind].ending}"
        KINDS[kind].write(path, loop(cycles=4))
        return path.read_bytes()


@st.composite
def damages(draw: st.DrawFn) -> tuple[str, float, float, bytes, int]:
    what = draw(st.sampled_from(["cut", "flip", "hostile", "gone", "other", "doubled"]))
    places = st.one_of(st.floats(0, 1), st.floats(0, 0.05), st.floats(0.95, 1))
    return what, draw(places), draw(places), draw(st.sampled_from(HOSTILE)), draw(st.integers(1, 255))


def damaged(content: bytes, damage: tuple[str, float, float, bytes, int], other: bytes) -> bytes:
    what, one, two, hostile, mask = damage
    first, second = sorted((int(one * len(content)), int(two * len(content))))
    if what == "cut":
        return content[:first]
    if what == "flip":
        changed = bytearray(content)
        for place in {first, second, (first + second) // 2}:
            if place < len(changed):
                changed[place] ^= mask
        return bytes(changed)
    if what == "hostile":
        return content[:first] + hostile + content[first + len(hostile) :]
    if what == "gone":
        return content[:first] + content[second:]
    if what == "doubled":
        return content[:second] + content[first:]
    return other


@pytest.mark.filterwarnings("error", "ignore::ResourceWarning")
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_ends_in_one_message(kind, tmp_path):
    for module in KINDS[kind].modules:
        pytest.importorskip(module)
    others = [name for name in ("Parquet", "text") if name != kind]
    path = tmp_path / f"a{KINDS[kind].ending}"

    @settings(max_examples=EACH, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(damage=damages(), other=st.sampled_from(others))
    def damage_it(damage, other):
        path.write_bytes(damaged(whole(kind), damage, whole(other)))
        try:
            plan = plan_import([path], Options(), tmp_path)
        except UserError as error:
            first, *rest = str(error).splitlines()
            assert first.startswith(str(path)) or path.name in first or "no run can be used" in first
            assert len(first) <= LONGEST_LINE, first
            assert all(line.startswith("  ") for line in rest)
        else:
            assert plan.runs

    damage_it()


def test_a_reader_that_breaks_down_ends_in_one_message(tmp_path, monkeypatch):
    (tmp_path / "breaks_down.py").write_text("import os\n\n\ndef read(path):\n    os._exit(139)\n")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.setattr(apart, "_WAITING", [])  # of another path
    with pytest.raises(Damaged, match=r"broke down \(status 139\)"):
        read_apart("breaks_down", tmp_path / "a.mf4")


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_without_a_force_says_so(kind, tmp_path, monkeypatch):
    for module in KINDS[kind].modules:
        pytest.importorskip(module)
    path = tmp_path / f"a{KINDS[kind].ending}"
    if kind == "text":
        path.write_text(text(loop(), names="Zeit [s];Weg [mm];Druck [bar]"))
    else:
        import format_writers

        names = {"Last": "Druck"}
        channels = format_writers.channels
        monkeypatch.setattr(
            format_writers, "channels", lambda run: {names.get(name, name): v for name, v in channels(run).items()}
        )
        monkeypatch.setattr(format_writers, "UNITS", {"Zeit": "s", "Weg": "mm", "Druck": "bar"})
        KINDS[kind].write(path, loop())
    with pytest.raises(UserError, match="no channel is called a force or is in a unit of one"):
        plan_import([path], Options(), tmp_path)


@pytest.mark.parametrize("kind", KINDS)
def test_an_empty_file_says_so(kind, tmp_path):
    path = tmp_path / f"a{KINDS[kind].ending}"
    path.write_bytes(b"")
    with pytest.raises(UserError, match="is empty"):
        plan_import([path], Options(), tmp_path)


def far_cell(path: Path) -> None:
    import xlsxwriter

    with xlsxwriter.Workbook(str(path)) as book:
        sheet = book.add_worksheet()
        sheet.write_row(0, 0, [1.0, 2.0])
        sheet.write(1_048_575, 16_383, 1.0)


def bomb(path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("xl/worksheets/sheet1.xml", b"<row/>" * 20_000_000)


def zeros(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {"Weg_mm": np.zeros(40_000_000)}, do_compression=True)


def chunks_that_are_not_there(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("Weg_mm", (10**12,), "f8", chunks=(10**6,))


def one_row_repeated(path: Path) -> None:
    import polars as pl

    pl.DataFrame({"Weg_mm": np.zeros(60_000_000)}).write_parquet(path, compression="zstd")


HUGE = {
    "a.xlsx": (far_cell, "claims 1.71799e\\+10 cells", ("xlsxwriter", "python_calamine")),
    "b.xlsx": (bomb, "would unpack to", ("python_calamine",)),
    "c.mat": (zeros, "claims 4e\\+07 samples", ("pymatreader",)),
    "d.h5": (chunks_that_are_not_there, "claims 1e\\+12 samples", ("h5py",)),
    "e.parquet": (one_row_repeated, "claims 6e\\+07 samples", ()),
}


@pytest.mark.parametrize("name", HUGE)
def test_a_file_that_claims_more_than_it_holds_is_not_unpacked(name, tmp_path):
    write, told, modules = HUGE[name]
    for module in modules:
        pytest.importorskip(module)
    write(tmp_path / name)
    with pytest.raises(UserError, match=told):
        plan_import([tmp_path / name], Options(), tmp_path)
