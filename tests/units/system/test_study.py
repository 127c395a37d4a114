"""Studies: cases, resuming after a kill, one table at the end."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import polars as pl
import pytest

from pipeclamp.pages.system.study import study_sections
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.steady.balance import SteadySystem
from pipeclamp_system.study.case import evaluate
from pipeclamp_system.study.description import read_study
from pipeclamp_system.study.run import journal_of, run_study

PIPE = """
name = "pipe"
[pipe]
outer_diameter_mm = 114.3
wall_mm = 3.6
length_m = 10.0
material = "carbon steel"
fluid = "water"
[ends]
left = "pinned"
right = "pinned"
[[clamps]]
name = "c1"
position_m = 1.5
[[clamps]]
name = "c2"
position_m = 7.0
[[probes]]
name = "middle"
position_m = 5.0
[damping]
ratio = 0.02
[modes]
up_to_Hz = 60.0
"""
SYSTEM = """
[pipe]
file = "pipe.toml"
[[clamps]]
at = "c1"
law = "emwm2"
temperature_C = 20.0
amplitude_mm = 0.5
[[clamps]]
at = "c2"
law = "emwm2"
temperature_C = 20.0
amplitude_mm = 0.5
[excitation]
kind = "sine"
acceleration_m_s2 = 1.0
frequency_Hz = 3.7
[run]
stop_s = 1.0
step_s = 0.01
"""
STUDY = """
name = "both clamps"
system = "system.toml"
{measure}
[vary]
{vary}
"""
TWO = """
"pipe.clamps.c1.position_m" = { start = 1.0, stop = 2.0, points = 3 }
"system.clamps.*.temperature_C" = [20.0, 300.0]
"""


@pytest.fixture
def write(tmp_path: Path):
    def make(vary: str = TWO, measure: str = "") -> Path:
        (tmp_path / "pipe.toml").write_text(PIPE, encoding="utf-8")
        (tmp_path / "system.toml").write_text(SYSTEM, encoding="utf-8")
        path = tmp_path / "study.toml"
        path.write_text(STUDY.format(vary=vary, measure=measure), encoding="utf-8")
        return path

    return make


def test_every_combination_is_a_case(write) -> None:
    study = read_study(write())
    cases = [values for _, values in study.cases()]
    assert len(cases) == study.description.count == 6
    assert list(cases[0].values()) == [1.0, 20.0]
    assert list(cases[-1].values()) == [2.0, 300.0]
    pipe, system = study.described(cases[-1])
    assert pipe.clamps[0].position_m == 2.0
    assert [clamp.temperature_C for clamp in system.clamps] == [300.0, 300.0]


def test_places_that_the_files_leave_out_can_be_varied(write) -> None:
    vary = '"pipe.flow.velocity_m_s" = [0.0, 8.0]\n"system.clamps.number" = [0, 1, 2]'
    study = read_study(write(vary))
    rows = [evaluate(study, number, values) for number, values in study.cases()]
    assert [row["error"] for row in rows] == [""] * 6
    assert rows[0]["middle.s [mm]"] != rows[3]["middle.s [mm]"]  # the flow
    assert rows[1]["middle.s [mm]"] > 2 * rows[2]["middle.s [mm]"]  # the second clamp helps
    assert "c2.s [mm]" in rows[2]
    assert "c2.s [mm]" not in rows[1]


@pytest.mark.parametrize("measure", ["peak", "cosim"])
def test_other_measures(write, measure: str) -> None:
    study = read_study(write('"system.excitation.acceleration_m_s2" = [0.2, 1.0]', f'measure = "{measure}"'))
    rows = [evaluate(study, number, values) for number, values in study.cases()]
    assert [row["error"] for row in rows] == ["", ""]
    assert rows[0]["middle.s [mm]"] < rows[1]["middle.s [mm]"]


def test_a_peak_that_was_not_reached_is_no_result(write, monkeypatch: pytest.MonkeyPatch) -> None:
    study = read_study(write('"system.excitation.acceleration_m_s2" = [0.2]', 'measure = "peak"'))
    follow = SteadySystem.curve
    monkeypatch.setattr(SteadySystem, "curve", lambda self, first, last, _: follow(self, first, last)[:5])
    ((number, values),) = study.cases()
    marched = evaluate(study, number, values)
    assert marched["error"] == ""
    monkeypatch.setattr(SteadySystem, "marched", lambda *_: None)
    row = evaluate(study, number, values)
    assert "its peak isn't known" in row["error"]
    assert "middle.s [mm]" not in row
    # What is given up from below may be whole from above.
    monkeypatch.setattr(
        SteadySystem, "curve", lambda self, first, last, _: follow(self, first, last)[: 5 if first < last else None]
    )
    balanced = evaluate(study, number, values)
    assert balanced["error"] == ""
    assert marched["middle.s [mm]"] == pytest.approx(balanced["middle.s [mm]"], rel=0.01)


@pytest.mark.parametrize("number", [-1.0, 0.5, 3.0])
def test_a_number_of_clamps_that_cannot_be_is_refused(write, number: float) -> None:
    with pytest.raises(
        UserError, match=rf"system\.clamps\.number.*got {number:g}; expected a whole number from 0 to 2"
    ):
        read_study(write(f'"system.clamps.number" = [{number}]'))


def test_every_file_decides_whether_a_study_goes_on(write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write()
    system = SYSTEM.replace(
        'kind = "sine"\nacceleration_m_s2 = 1.0\nfrequency_Hz = 3.7', 'kind = "record"\nfile = "r.csv"'
    )
    system = system.replace("amplitude_mm = 0.5", "amplitude_mm = 0.5\nfrequency_Hz = 3.7")
    (tmp_path / "system.toml").write_text(system, encoding="utf-8")
    prints = []
    for last in (1.0, 1.0, 2.0):
        (tmp_path / "r.csv").write_text(f"time_s,acceleration_m_s2\n0,0\n1,{last}\n", encoding="utf-8")
        prints.append(read_study(path).fingerprint)
    assert prints[0] == prints[1] != prints[2]
    monkeypatch.setattr("pipeclamp_system.study.description.version", lambda: "another")
    assert read_study(path).fingerprint not in prints


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ('"pipe.clamps.c3.position_m" = [1.0]', ["pipe.clamps.c3.position_m", "'c3'", "did you mean"]),
        ('"pipe.clamps.c1.positon_m" = [1.0]', ["positon_m", "did you mean 'position_m'"]),
        ('"pip.length_m" = [1.0]', ["expected pipe.… or system.…"]),
        ('"pipe.clamps.c1.position_m" = [1.0, 11.0]', ["11", "beyond the pipe's length_m"]),
        ('"pipe.clamps.c1.position_m" = []', ["is empty"]),
        ('"pipe.pipe.length_m" = { start = 1.0, stop = 2.0 }', ["points"]),
        ("", ["vary"]),
    ],
)
def test_a_wrong_study_is_refused(write, vary: str, words: list[str]) -> None:
    with pytest.raises(UserError) as refused:
        read_study(write(vary))
    assert all(word in str(refused.value) for word in ["study.toml", *words]), refused.value


def test_a_case_that_cannot_be_does_not_stop_the_others(write, tmp_path: Path) -> None:
    study = read_study(write('"pipe.clamps.c1.position_m" = [1.0, 20.0, 2.0]'))
    frame = run_study(study, tmp_path / "study.parquet", jobs=1)
    assert frame["error"].to_list()[::2] == ["", ""]
    assert "beyond the pipe's length_m" in frame["error"][1]
    sections = study_sections(study, frame)
    assert "1 cases gave no result" in " ".join(sections[0].paragraphs)
    assert sections[1].figures


def test_the_table_is_written_and_the_journal_goes(write, tmp_path: Path) -> None:
    study, output = read_study(write()), tmp_path / "study.parquet"
    told: list[int] = []
    run_study(study, output, jobs=2, progress=lambda done, count: told.append(done))
    frame = pl.read_parquet(output)
    assert frame["case"].to_list() == list(range(6))
    assert sorted(told) == list(range(7))
    assert not journal_of(output).exists()
    hot, cold = (frame.filter(pl.col("system.clamps.*.temperature_C") == T)["middle.s [mm]"] for T in (300.0, 20.0))
    assert hot.to_list() != cold.to_list()


def test_a_killed_study_goes_on_with_nothing_lost_or_done_twice(write, tmp_path: Path) -> None:
    path = write('"pipe.clamps.c1.position_m" = { start = 1.0, stop = 2.0, points = 16 }')
    output = tmp_path / "study.parquet"
    command = [sys.executable, "-m", "pipeclamp", "sweep", str(path), "-o", str(output), "--jobs", "1"]
    journal = journal_of(output)
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as running:
        until = time.monotonic() + 300
        while time.monotonic() < until and not (journal.exists() and journal.read_text().count("\n") > 4):
            time.sleep(0.02)
        running.kill()
    kept = [json.loads(line) for line in journal.read_text(encoding="utf-8").split("\n")[1:-1]]
    assert 4 <= len(kept) < 16
    with journal.open("a", encoding="utf-8") as stream:
        stream.write('{"case": 15, "erro')  # as a kill in the middle of a line leaves it
    subprocess.run(command, check=True, capture_output=True)
    frame = pl.read_parquet(output)
    assert frame["case"].to_list() == list(range(16))
    assert (frame["error"] == "").all()
    # The time that a case took tells whether it was done again.
    assert [frame["seconds"][row["case"]] for row in kept] == [row["seconds"] for row in kept]


def test_a_journal_of_another_study_is_refused(write, tmp_path: Path) -> None:
    output = tmp_path / "study.parquet"
    journal_of(output).write_text("of something else\n", encoding="utf-8")
    with pytest.raises(UserError, match=r"study\.parquet\.journal: holds cases of another study"):
        run_study(read_study(write()), output, jobs=1)


@pytest.mark.skipif(os.name != "posix", reason="interrupts with a signal")
def test_an_interrupt_is_one_line_that_says_how_to_go_on(write, tmp_path: Path) -> None:
    write('"pipe.clamps.c1.position_m" = { start = 1.0, stop = 2.0, points = 300 }')
    output = tmp_path / "s.parquet"
    words = (sys.executable, "-m", "pipeclamp", "sweep", "study.toml", "-o", output.name, "--jobs", "2")
    pipe = subprocess.PIPE
    # A terminal sends Ctrl-C to all processes of a command.
    with subprocess.Popen(words, cwd=tmp_path, stdout=pipe, stderr=pipe, text=True, start_new_session=True) as run:
        while not (journal_of(output).exists() and journal_of(output).read_text(encoding="utf-8").count("\n") > 2):
            assert run.poll() is None
            time.sleep(0.05)
        os.killpg(run.pid, signal.SIGINT)
        _, said = run.communicate(timeout=600)
    assert run.returncode == 130
    assert re.fullmatch(
        r"the cases that run are finished first; Ctrl-C again ends at once\n"
        r"pipeclamp: interrupted: \d+ of 300 cases are kept in s\.parquet\.journal; the same command goes on with the "
        r"others\n",
        said,
    ), said


def test_a_law_used_beyond_its_data_is_said(write) -> None:
    study = read_study(write('"system.clamps.*.temperature_C" = [20.0, 900.0]'))
    frame = pl.from_dicts([evaluate(study, number, values) for number, values in study.cases()])
    assert frame["c1.inRange"].dtype == pl.Boolean
    assert not frame["c1.inRange"][1]
    said = study_sections(study, frame)[0].paragraphs
    outside = (~frame["c1.inRange"]).sum()
    assert f"c1: its law is used beyond the range of its data in {outside} of 2 cases." in said
    assert said[0].startswith("c1 moves least"), "what came out comes first"


def test_a_dask_cluster_takes_the_same_study(write, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    study = read_study(write())
    here = run_study(study, tmp_path / "here.parquet", jobs=1)
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        there = run_study(study, tmp_path / "there.parquet", scheduler=cluster.scheduler_address)
    assert there.drop("seconds").equals(here.drop("seconds"))


@pytest.mark.skipif(os.name != "posix", reason="limits a file's size")
def test_what_a_full_disk_stops_loses_no_finished_case(write, tmp_path: Path) -> None:
    study, output = read_study(write()), tmp_path / "study.parquet"
    kept = f"{study.fingerprint}\n" + "".join(f'{{"case": {number}}}\n' for number in range(1000))
    journal_of(output).write_text(kept + '{"case": 1000', encoding="utf-8")
    words = f"""
import resource, signal
from pathlib import Path
from types import SimpleNamespace
from pipeclamp_system.study.run import _opened
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
with _opened(Path({str(journal_of(output))!r}), SimpleNamespace(fingerprint={study.fingerprint!r}), fresh=False):
    pass
"""
    subprocess.run([sys.executable, "-c", words], check=False)
    assert journal_of(output).read_text(encoding="utf-8") == kept


def test_another_process_may_have_ended_the_same_study_first(write, tmp_path: Path) -> None:
    study, output = read_study(write('"system.excitation.acceleration_m_s2" = [0.2]')), tmp_path / "study.parquet"

    def ended_elsewhere(done: int, count: int) -> None:
        if done == count:
            journal_of(output).unlink()

    assert run_study(study, output, jobs=1, progress=ended_elsewhere).height == 1
    assert output.exists()


@pytest.mark.parametrize("content", [b"\xff\xfe", b"{bad\n", b"[]\n", b"{}\n"])
def test_a_damaged_journal_is_refused(write, tmp_path: Path, content) -> None:
    study, output = read_study(write()), tmp_path / "study.parquet"
    journal_of(output).write_bytes(study.fingerprint.encode() + b"\n" + content)
    with pytest.raises(UserError, match=r"study\.parquet\.journal: .*; .*delete it to begin anew"):
        run_study(study, output, jobs=1)


def test_a_number_of_a_list_is_varied_by_its_place(write) -> None:
    path = write('"system.response.levels.2" = [3.0, 4.0]')
    system = path.with_name("system.toml")
    text = system.read_text(encoding="utf-8")
    system.write_text(f"{text}\n[response]\nfrom_Hz = 1\nto_Hz = 2\nlevels = [1.0, 2.0]\n", encoding="utf-8")
    study = read_study(path)
    assert study.described({"system.response.levels.2": 3.0})[1].response.levels == (1.0, 3.0)
    with pytest.raises(UserError, match="'3' is not known"):
        study.described({"system.response.levels.3": 3.0})
