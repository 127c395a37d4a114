"""What a killed process leaves beside a campaign's place goes with the next that writes there, what a living one holds
stays."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pipeclamp_models.base import owned
from pipeclamp_models.base.files import staged_folder, write_folder

KILLED = """
import os, sys
from pathlib import Path
from pipeclamp_models.base.files import staged_folder
with staged_folder(Path(sys.argv[1])) as work:
    (work / "runs").mkdir()
    (work / "runs" / "a.parquet").write_bytes(b"some")
    os._exit(9)
"""
LIVING = """
import sys
from pathlib import Path
from pipeclamp_models.base.files import staged_folder
with staged_folder(Path(sys.argv[1])) as work:
    print(work, flush=True)
    sys.stdin.read()
    print((work / "own").exists(), flush=True)
"""


def command(code, place):
    return [sys.executable, "-c", code, str(place)]


@pytest.fixture
def rooms():
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


def test_what_a_killed_process_left_goes_with_the_next(tmp_path, rooms):
    place = tmp_path / "clamp [7]"
    assert subprocess.run(command(KILLED, place), env=rooms, check=False).returncode == 9
    left = [path for path in tmp_path.iterdir() if path.is_dir()]
    assert len(left) == 1 and (left[0] / "runs" / "a.parquet").exists()
    write_folder(place, [("a.csv", b"1")])
    assert [path.name for path in tmp_path.iterdir()] == ["clamp [7]"]


def test_what_a_living_process_holds_stays(tmp_path, rooms):
    place, pipe = tmp_path / "clamp_7", subprocess.PIPE
    with subprocess.Popen(command(LIVING, place), env=rooms, stdin=pipe, stdout=pipe, text=True) as living:
        work = Path(living.stdout.readline().strip())
        (work / "own").touch()
        write_folder(place, [("a.csv", b"1")])
        assert (work / "own").exists()
        assert living.communicate("")[0].strip() == "True"
    assert [path.name for path in tmp_path.iterdir()] == ["clamp_7"]


def test_other_places_and_what_others_made_stay(tmp_path, rooms):
    assert subprocess.run(command(KILLED, tmp_path / "clamp_7.b"), env=rooms, check=False).returncode == 9
    for name in (".clamp_7.mine.part", ".clamp_7.part.lock", ".clamp_7.Mine.part.lock"):
        (tmp_path / name).mkdir()
    before = {path.name for path in tmp_path.iterdir()}
    with staged_folder(tmp_path / "clamp_7"):
        pass
    assert {path.name for path in tmp_path.iterdir()} == before


def test_a_lock_that_another_took_for_abandoned_is_made_anew(tmp_path, monkeypatch):
    made = []
    is_ours = owned._is_ours

    def taken_at_first(handle):
        made.append(handle)
        if len(made) == 1:
            # by the other, which deletes it while it holds it
            next(tmp_path.iterdir()).unlink()
        return is_ours(handle)

    monkeypatch.setattr(owned, "_is_ours", taken_at_first)
    with owned.owned_folder(tmp_path / "clamp_7") as work:
        assert len(made) == 2
        assert work.with_name(work.name + owned.LOCK).exists()
    assert not list(tmp_path.iterdir())


def test_without_locks_nothing_is_taken_for_abandoned(tmp_path, rooms, monkeypatch):
    assert subprocess.run(command(KILLED, tmp_path / "clamp_7"), env=rooms, check=False).returncode == 9
    before = set(tmp_path.iterdir())
    monkeypatch.setattr(owned, "_is_ours", lambda handle: False)
    write_folder(tmp_path / "clamp_7", [("a.csv", b"1")])
    assert before < set(tmp_path.iterdir())
    assert (tmp_path / "clamp_7" / "a.csv").exists()


def test_a_folder_that_cant_be_deleted_yet_is_tried_again(tmp_path, rooms, monkeypatch):
    place = tmp_path / "clamp_7"
    assert subprocess.run(command(KILLED, place), env=rooms, check=False).returncode == 9
    with monkeypatch.context() as patched:
        patched.setattr(owned.shutil, "rmtree", lambda path, ignore_errors: None)
        owned.clear_abandoned(place)
    assert len(list(tmp_path.iterdir())) == 2
    owned.clear_abandoned(place)
    assert not list(tmp_path.iterdir())
