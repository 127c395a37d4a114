"""Files that part a program where it turns, so that each run is half a cycle: what is told of them."""

from __future__ import annotations

import numpy as np
import pytest

import pipeclamp as pc


@pytest.fixture
def files(tmp_path):
    """A program of growing cycles with a column that numbers its passes, and a plain sine."""
    folder = tmp_path / "files"
    folder.mkdir()
    time = np.arange(0, 6, 0.004)
    for name, amplitude, tail in (("grows", 0.2 + 0.15 * np.floor(time), True), ("sine", 0.5, False)):
        y = -amplitude * np.cos(2 * np.pi * time)
        force = 900 * y + 40 * np.sign(np.sin(2 * np.pi * time))
        numbers = np.floor(2 * time) if tail else np.zeros(time.size)
        rows = [f"{t},{s},{f},{n:.0f}" for t, s, f, n in zip(time, y, force, numbers, strict=True)]
        text = "\n".join(["Time [s],Displacement [mm],Force [N],Pass", *rows, ""])
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return folder


def told(files, names, segment):
    found = pc.import_files(
        [files / f"{name}.csv" for name in names], "new", columns=f"segment={segment}", dry_run=True
    )
    return " ".join(str(found).split())


@pytest.mark.parametrize("names", [["grows"], ["grows", "sine"]])
def test_half_passes_point_to_cycles(files, names):
    words = told(files, names, "Pass")
    assert ("no run is a sine" if len(names) == 1 else "no run of grows.csv is a sine") in words
    assert "or that was parted where it turns, --columns segment=each-cycle makes each cycle a run" in words


def test_cycles_that_are_runs_are_pointed_to_no_more(files):
    assert "each-cycle" not in told(files, ["grows", "sine"], "each-cycle")


def test_one_half_pass_that_no_cycle_can_be_made_of_is_not_pointed_to_them(files):
    lines = (files / "grows.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (files / "half.csv").write_text("".join(lines[:126]), encoding="utf-8")
    words = told(files, ["half"], "each-cycle")
    assert (
        "never turns back" in pc.import_files(files / "half.csv", "new", dry_run=True).to_dict()["runs"][0]["done"][-1]
    )
    assert "no run is a sine, which alone a law is fitted to; `pipeclamp compare`" in words
