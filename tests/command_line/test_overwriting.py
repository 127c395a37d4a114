"""No command writes over what it reads; a law alone may make way for its successor."""

import shutil
from pathlib import Path

import pytest

from pipeclamp_identification.campaign.bundled import bundled_campaign
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import read_law, write_law

HELDOUT = "clamp_a_heldout"
"""The smallest of the bundled campaigns."""
SYSTEM = """
[pipe]
file = "pipe.toml"
[[clamps]]
at = "c1"
law = "law.json"
temperature_C = 20.0
amplitude_mm = 0.5
frequency_Hz = 5.0
[[clamps]]
at = "c2"
fmu = "clamp.fmu"
temperature_C = 20.0
track = true
[excitation]
kind = "record"
file = "record.csv"
[run]
stop_s = 1.0
step_s = 1e-3
"""
STUDY = """
system = "system.toml"
[vary]
"pipe.flow.velocity_m_s" = [0.0]
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a campaign, a law, a system and a study, in which commands are called."""
    shutil.copytree(bundled_campaign(HELDOUT), tmp_path / "tests")
    write_law(open_law("emwm2"), tmp_path / "law.json")
    for name, text in (("system.toml", SYSTEM), ("study.toml", STUDY), ("unread.toml", "name = 'x'")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    for name in ("pipe.toml", "clamp.fmu", "record.csv"):
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def record_in(folder: Path) -> str:
    return next(path for path in sorted(folder.rglob("*.*")) if path.parent != folder).relative_to(folder).as_posix()


@pytest.mark.parametrize(
    "words",
    [
        "identify tests -o tests/runs.csv",
        "identify tests -o tests/RECORD",
        "compare law.json tests --json tests/campaign.toml",
        "compare law.json tests --json law.json",
        "compare law.json tests --json ../{name}/law.json",
        "diagnose law.json tests --auto tests/runs.csv",
        "diagnose law.json tests --json law.json",
        "add law.json memory tests -o tests/RECORD",
        "remove law.json memory tests -o tests/runs.csv",
        "refit law.json tests -o tests/runs.csv",
        "metrics tests --json tests/RECORD",
        "build-fmu law.json -o law.json",
        "cosim unread.toml -o unread.toml",
        "cosim system.toml -o pipe.toml",
        "cosim system.toml -o result.csv --report record.csv",
        "response system.toml -o law.json",
        "system system.toml -o clamp.fmu",
        "sweep study.toml -o system.toml",
        "sweep study.toml -o law.json",
        "compare system.toml tests --json law.json",
    ],
)
def test_an_input_is_not_written_over(words, place, refused):
    called = words.format(name=place.name).replace("RECORD", record_in(place / "tests")).split()
    before = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    assert "would write over it; expected another file" in refused(*called, status=2)
    assert {path: path.read_bytes() for path in place.rglob("*") if path.is_file()} == before


def test_two_answers_need_two_files(place, refused):
    words = ["compare", "law.json", "tests", "--json", "answer", "--report", "answer"]
    assert "two answers would be written there" in refused(*words, status=2)


def test_a_law_makes_way_for_its_successor_and_answers_may_be_renewed(place, pipeclamp):
    law = place / "law.json"
    for _ in range(2):
        pipeclamp("identify", place / "tests", "-o", law)
    pipeclamp("add", law, "offset", place / "tests", "-o", law)
    assert read_law(law).effects == ("offset",)
    # beside the tests, but no part of them
    for _ in range(2):
        pipeclamp("compare", law, place / "tests", "--json", place / "tests" / "answer.json")


MEASURED = """
[[probes]]
name = "tip"
position_m = 2.0
unit = "mm"

[[responses]]
file = "sines.csv"
"""


def test_what_was_measured_on_a_pipe_is_not_written_over(tmp_path, refused):
    for name, text in (("measurement.toml", MEASURED), ("sines.csv", ""), ("system.toml", "name = 'x'")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    for name in ("measurement.toml", "sines.csv"):
        words = ["compare", tmp_path / "system.toml", tmp_path, "--json", tmp_path / name]
        assert "would write over it" in refused(*words, status=2)
