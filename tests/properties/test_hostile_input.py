"""Whatever stands in a file that a user names, its reader takes it or says in one short line what is wrong.

The environment variable PIPECLAMP_HOSTILE says how many inputs each reader gets: 1200 makes 20,400.
"""

from __future__ import annotations

import gzip
import io
import os
import re
import shutil
import signal
import warnings
import zipfile
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from project import EXAMPLES

from pipeclamp_fmu.build import build_clamp
from pipeclamp_fmu.set_parameters import set_parameters
from pipeclamp_identification.campaign.drive import read_drive
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.rig.truth import truth_of
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.on_pipe.measurement import read_measurement
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import LONGEST_LINE
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration_files import read_declaration
from pipeclamp_models.law.file import law_text, read_law
from pipeclamp_models.pipe.description import read_pipe
from pipeclamp_system.description.system import read_system
from pipeclamp_system.fmus.variables import read_model_description
from pipeclamp_system.study.description import read_study

EACH = int(os.environ.get("PIPECLAMP_HOSTILE", "12"))
SECONDS = 30
NASTY = [
    *("", "0", "-1", "nan", "-inf", "1e39", "1e400", "-1e-320", "9" * 39, "9" * 5000, "-273.15", "true", "[]", '""'),
    *("[" * 1000, "{a=" * 400, "a." * 2000, '"' * 3, "\0", "\x1b[2J", "[/b]", "\r", "\n" * 3, "\u202e", "é", ",", "#"),
    *("x" * 3000, "x" * 200_000, "k_b**y**v**A", "sin(" * 99, "(y+v+A+T)**99", "1/0", "\\u0000", "%s", "../../x", "-"),
]  # fmt: skip
MEASUREMENT = """
[[probes]]
name = "midspan"
unit = "mm"
[[responses]]
file = "response.csv"
temperature_C = 20.0
"""
RESPONSE = "frequency_Hz,acceleration_m_s2,midspan_amplitude,midspan_phase_deg\n1,1,0.1,-3\n2,1,0.3,-90\n3,1,0.1,-170\n"
DECLARATION = """
id = "bracket"
title = "A bracket that the clamp touches"
looks_like = "a kink at a fixed displacement"
force = "k_b * max(y - y_b, 0)"
energy = "k_b * max(y - y_b, 0)**2 / 2"
[[parameters]]
symbol = "k_b"
unit = "N/mm"
meaning = "stiffness of the bracket"
start = "0.2 * F_typical / A_typical"
lower = 0
[[parameters]]
symbol = "y_b"
unit = "mm"
meaning = "displacement at which it touches"
start = [0.1, 0.2]
"""
STUDY = """
system = "system.toml"
measure = "peak"
[vary]
"system.clamps.clamp1.temperature_C" = { start = 20.0, stop = 80.0, points = 3 }
"system.response.levels.1" = [1.0, 2.0]
"""


@dataclass(frozen=True)
class Reader:
    """A file of a folder that is made hostile and what reads it."""

    file: str
    read: Callable[[Path], object]


def parameters_set(folder: Path) -> None:
    set_parameters(folder / "clamp.fmu", open_law("emwm2"), folder / "out.fmu")


READERS = {
    "campaign.toml": Reader("campaign.toml", read_tests),
    "runs.csv": Reader("runs.csv", read_tests),
    "record": Reader("runs/a.csv", read_tests),
    "gzip": Reader("runs/b.csv.gz", read_tests),
    "Parquet": Reader("runs/c.parquet", read_tests),
    "metrics": Reader("metrics/runs.csv", lambda folder: read_tests(folder / "metrics")),
    "law": Reader("law.json", lambda folder: read_law(folder / "law.json")),
    "pipe": Reader("pipe.toml", lambda folder: read_pipe(folder / "pipe.toml")),
    "system": Reader("system.toml", lambda folder: read_system(folder / "system.toml")),
    "study": Reader("study.toml", lambda folder: read_study(folder / "study.toml")),
    "declaration": Reader("effect.toml", lambda folder: read_declaration(folder / "effect.toml")),
    "set-parameters": Reader("clamp.fmu", parameters_set),
    "FMU": Reader("clamp.fmu", lambda folder: read_model_description(folder / "clamp.fmu")),
    "description": Reader("modelDescription.xml", parameters_set),
    "measurement": Reader("measurement.toml", lambda folder: read_measurement(folder / "measurement.toml")),
    "response": Reader("response.csv", lambda folder: read_measurement(folder / "measurement.toml")),
    "drive": Reader("runs/a.csv", lambda folder: read_drive(folder / "runs" / "a.csv")),
}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a whole file for each reader."""
    folder = tmp_path_factory.mktemp("whole") / "files"
    law = open_law("emwm2")
    plan = Plan(amplitudes=(0.3,), frequencies=(2.0,), temperatures=(20.0, 80.0, 200.0), cycles=3.0, rate=60.0)
    write_campaign(folder, virtual_runs(truth_of(law, (), {}, plan, ()).law, plan, {}), name="a", notes="")
    frames = [pl.read_csv(path) for path in sorted((folder / "runs").iterdir())]
    shutil.rmtree(folder / "runs")
    (folder / "runs").mkdir()
    frames[0].write_csv(folder / "runs" / "a.csv")
    (folder / "runs" / "b.csv.gz").write_bytes(gzip.compress(frames[1].write_csv().encode(), mtime=0))
    frames[2].write_parquet(folder / "runs" / "c.parquet")
    table = "run,file,amplitude_mm,frequency_Hz,temperature_C,valve\n"
    rows = zip("abc", ("a.csv", "b.csv.gz", "c.parquet"), (20, 80, 200), strict=True)
    table += "".join(f"{name},runs/{file},0.3,2,{T},v{name}\n" for name, file, T in rows)
    (folder / "runs.csv").write_text(table, encoding="utf-8")
    (folder / "metrics").mkdir()
    (folder / "metrics" / "campaign.toml").write_text('name = "metrics"\n', encoding="utf-8")
    names = "run,amplitude_mm,frequency_Hz,temperature_C,dissipated_energy_J,max_elastic_energy_J\n"
    (folder / "metrics" / "runs.csv").write_text(
        f"{names}a,0.3,2,20,0.211,0.105\nb,0.6,2,90,0.7,0.4\n", encoding="utf-8"
    )
    (folder / "law.json").write_text(law_text(law), encoding="utf-8")
    shutil.copy(EXAMPLES / "pipe.toml", folder)
    system = (EXAMPLES / "system.toml").read_text(encoding="utf-8").replace("clamp_a.json", "law.json")
    (folder / "system.toml").write_text(
        f"{system}\n[response]\nfrom_Hz = 2\nto_Hz = 5\nlevels = [1.0]\n", encoding="utf-8"
    )
    for name, text in (("study.toml", STUDY), ("effect.toml", DECLARATION), ("measurement.toml", MEASUREMENT)):
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "response.csv").write_text(RESPONSE, encoding="utf-8")
    build_clamp(law, folder / "clamp.fmu")
    with zipfile.ZipFile(folder / "clamp.fmu") as archive:
        (folder / "modelDescription.xml").write_bytes(archive.read("modelDescription.xml"))
    return folder


@st.composite
def damages(draw: st.DrawFn) -> tuple[str, float, float, str, int]:
    """What is done, between which shares of the file, with which text and which bits."""
    what = draw(st.sampled_from(["value", "value", "value", "put", "cut", "flip", "gone", "doubled", "random"]))
    places = st.one_of(st.floats(0, 1), st.floats(0, 0.05), st.floats(0.95, 1))
    text = draw(st.one_of(st.sampled_from(NASTY), st.text(max_size=30)))
    return what, draw(places), draw(places), text, draw(st.integers(1, 255))


def damaged(content: bytes, damage: tuple[str, float, float, str, int]) -> bytes:
    what, one, two, text, mask = damage
    first, second = sorted((int(one * len(content)), int(two * len(content))))
    nasty = text.encode("utf-8", "surrogatepass")
    if what == "value":
        values = list(re.finditer(rb"[-\w.+]+", content))
        value = values[min(int(one * len(values)), len(values) - 1)]
        return content[: value.start()] + nasty + content[value.end() :]
    if what == "put":
        return content[:first] + nasty + content[first:]
    if what == "cut":
        return content[:first]
    if what == "gone":
        return content[:first] + content[second:]
    if what == "doubled":
        return content[:second] + content[first:]
    if what == "random":
        return nasty
    changed = bytearray(content)
    for place in {first, second, (first + second) // 2}:
        if place < len(changed):
            changed[place] ^= mask
    return bytes(changed)


class TooLong(BaseException):
    """A reader hangs."""


@contextmanager
def no_hang():
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def ring(number, frame):
        raise TooLong

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("name", READERS)
def test_a_hostile_file_is_taken_or_told_in_a_line(name, files, tmp_path):
    reader = READERS[name]
    folder = tmp_path / "files"
    shutil.copytree(files, folder)
    whole = (files / reader.file).read_bytes()
    inside = name == "description"

    @settings(max_examples=EACH, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(damage=damages())
    def read_it(damage):
        content = damaged(whole, damage)
        (folder / reader.file).write_bytes(content)
        if inside:
            put_inside(files / "clamp.fmu", folder / "clamp.fmu", content)
        try:
            with no_hang(), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                reader.read(folder)
        except UserError as error:
            first, *further = str(error).split("\n")
            assert 0 < len(first) <= LONGEST_LINE, first
            assert all(line.startswith("  ") and len(line) <= LONGEST_LINE for line in further)
            assert all(line.isprintable() or "\u00a0" in line for line in (first, *further)), str(error)

    read_it()


def put_inside(fmu: Path, output: Path, content: bytes) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(fmu) as whole, zipfile.ZipFile(stream, "w") as changed:
        for entry in whole.infolist():
            if not entry.filename.startswith("binaries"):
                changed.writestr(entry, content if entry.filename == "modelDescription.xml" else whole.read(entry))
    output.write_bytes(stream.getvalue())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no such pipes")
@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_what_is_no_file_is_not_opened(name, kind, files, tmp_path):
    folder = tmp_path / "files"
    shutil.copytree(files, folder)
    # a folder is where measurement.toml is looked for
    words = "no such file; expected" if (name, kind) == ("measurement", "folder") else f"is a {kind}; expected"
    place = folder / ("clamp.fmu" if name == "description" else READERS[name].file)
    place.unlink()
    make = {"pipe": os.mkfifo, "device": lambda path: path.symlink_to("/dev/zero"), "folder": Path.mkdir}[kind]
    make(place)
    with no_hang(), pytest.raises(UserError, match=words):
        READERS[name].read(folder)
