"""Files are read in a process of their own, which goes on to the next file where the last one was sound."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pipeclamp_identification.importing import apart
from pipeclamp_identification.importing.apart import read_apart
from pipeclamp_identification.importing.raw import Damaged

READER = """
import os

count = 0


def read(path):
    global count
    count += 1
    told = path.read_text()
    print("a library's own words")
    os.write(1, b"and those of its C code")
    if told == "breaks down" or (told == "breaks down later" and count > 1):
        os._exit(3)
    if told == "is no such file":
        raise ValueError(told)
    return [os.getpid(), count, told]
"""


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], list[object]]]:
    """Give a function that reads a file of some text: process, how manieth file of it, and the text."""
    (tmp_path / "reads_text.py").write_text(READER, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.chdir(tmp_path)
    apart._end_waiting()

    def one(text: str) -> list[object]:
        Path("file.txt").write_text(text, encoding="utf-8")
        return list(read_apart("reads_text", Path("file.txt")))

    yield one
    apart._end_waiting()


def test_a_process_goes_on_to_the_next_file(read) -> None:
    first = read("sound")
    assert read("sound, too") == [first[0], 2, "sound, too"]


def test_after_a_file_that_cannot_be_read_another_process_reads(read) -> None:
    before = read("sound")
    with pytest.raises(RuntimeError, match="is no such file"):
        read("is no such file")
    after = read("sound")
    assert after[0] != before[0]
    assert after[1] == 1
    with pytest.raises(Damaged, match=r"broke down \(status 3\)"):
        read("breaks down")
    assert read("sound")[1] == 1


def test_what_a_former_file_left_behind_is_not_held_against_the_next_one(read) -> None:
    """Only a process that has read nothing before tells that a file is damaged."""
    before = read("sound")
    process, count, _ = read("breaks down later")
    assert process != before[0]
    assert count == 1


def test_a_process_that_nobody_asks_ends_and_another_takes_its_place(read) -> None:
    first = read("sound")
    (waiting,) = apart._WAITING
    waiting._process.terminate()
    waiting._process.wait()
    again = read("sound")
    assert again[0] != first[0]
    apart._end_waiting()
    assert apart._WAITING == []


def test_an_answer_that_nobody_waited_for_is_not_taken_for_the_next_files(read, monkeypatch) -> None:
    read("sound")
    (waiting,) = apart._WAITING

    def interrupted(*given: object) -> None:
        waiting._process.stdin.write(b'["reads_text", "file.txt", "."]\n')
        waiting._process.stdin.flush()
        raise KeyboardInterrupt

    monkeypatch.setattr(waiting, "asked", interrupted)
    with pytest.raises(KeyboardInterrupt):
        read("interrupted")
    assert waiting._process.poll() is not None
    assert read("the next one")[1:] == [1, "the next one"]
