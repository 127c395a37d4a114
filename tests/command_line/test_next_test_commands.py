"""The worked example of the next test is run as it stands, and prints what its page says."""

from __future__ import annotations

import re
import shlex

import pytest
from project import ROOT

PAGE = (ROOT / "docs" / "howto" / "next-test.md").read_text(encoding="utf-8")


LINES = [shlex.split(line) for line in re.findall(r"^pipeclamp (.*)$", PAGE, re.M)]


@pytest.fixture(scope="module")
def folder(pipeclamp, tmp_path_factory):
    """A folder with the narrow campaign and its law, as the page's first two lines make them."""
    folder = tmp_path_factory.mktemp("next")
    for line in LINES[:2]:
        pipeclamp(*line, cwd=folder)
    return folder


def plain(text: str) -> str:
    return " ".join(text.split())


def test_the_worked_example(pipeclamp, folder):
    assert [line[0] for line in LINES] == ["rig", "identify", "diagnose", "rig", "join", "diagnose"]
    said = plain(re.sub(r"^> ", "", re.search(r"(?:^> .*\n)+", PAGE, re.M)[0], flags=re.M))
    proposed, _, _ = (plain(pipeclamp(*line, cwd=folder).stdout) for line in LINES[2:5])
    for sentence in said.removesuffix(".").split(". "):
        assert sentence in proposed
    assert (folder / "drive.csv").read_text().startswith("time_s,displacement_mm\n0.0,0.0\n")
    settled = plain(pipeclamp(*LINES[-1], "--drive", "further.csv", cwd=folder).stdout)
    assert "Missing: stiffness_frequency." in settled
    assert "further.csv isn't written: no test is proposed" in settled
    assert not (folder / "further.csv").exists()


def test_limits_that_no_motion_keeps_are_answered_as_the_page_says(pipeclamp, folder):
    limits, said = re.search(r'With `--limits (\S+)`: "(No next test: .*?)"', PAGE, re.S).groups()
    found = pipeclamp("diagnose", "narrow.json", "narrow", "--limits", limits, "--drive", "none.parquet", cwd=folder)
    assert plain(said) in plain(found.stdout)
    assert not (folder / "none.parquet").exists()
