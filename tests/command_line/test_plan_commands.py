"""`plan` as a user calls it."""

from __future__ import annotations

import json

import pytest
from banded import banded


def test_the_next_loop_test_of_a_pipe(tmp_path, pipeclamp):
    path = banded(tmp_path, 1.0)
    drive, answer, report = tmp_path / "next.csv", tmp_path / "plan.json", tmp_path / "plan.html"
    done = pipeclamp("plan", path, "--limits", "A=0.02..1", "--drive", drive, "--json", answer, "--report", report)
    said = " ".join(done.stdout.split())
    assert "Next test: run a sine test of the clamp of hard at" in said
    assert "mountings and the law's form stay" in said
    assert f"{drive} holds its drive signal" in said
    told = json.loads(answer.read_text(encoding="utf-8"))
    first = told["tests"][0]
    assert first["peak_mm"]["high"] - first["peak_mm"]["low"] < told["peak_mm"]["high"] - told["peak_mm"]["low"]
    peak = max(abs(float(line.split(",")[1])) for line in drive.read_text(encoding="utf-8").splitlines()[1:])
    assert peak == pytest.approx(first["amplitude_mm"], rel=1e-3)
    assert "Where a test narrows the band" in report.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--at", "top"], "clamp1, tip"),
        (["--bands", "0"], "expected a number from 1 to 99.9"),
        (["--limits", "A=3"], "--limits"),
        (["--drive", "next.txt"], "ends in .csv or .parquet"),
    ],
)
def test_what_cannot_serve_is_refused(tmp_path, refused, options, said):
    assert said in refused("plan", banded(tmp_path, 1.0), *options, status=2)
