"""`plan` as a user calls it."""

from __future__ import annotations

import json
import shlex
import sys
from types import SimpleNamespace

import pytest
from banded import banded
from few_effects import few_effects
from typer.testing import CliRunner

import pipeclamp as pc
from pipeclamp.__main__ import main
from pipeclamp.cli import planning
from pipeclamp.cli.app import app
from pipeclamp.show import narrowing as views
from pipeclamp_identification.planning import narrowing


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
    again = f"pipeclamp plan {path} --limits A=0.02..1 --drive {drive} --json {answer} --report {report}"
    first = "once that test has been run, and the law is identified from it too"
    assert done.stdout.splitlines()[-1] == f"Next, {first}: {again}"
    page = report.read_text(encoding="utf-8")
    assert f"Next, {first}, run the command below." in page
    assert again in page


def test_without_a_drive_the_next_command_writes_one(tmp_path, monkeypatch, capsys):
    """What is said after a plan that is found elsewhere: `plan` itself is tried above."""
    path = banded(tmp_path, 1.0)
    monkeypatch.setattr(narrowing, "plan_tests", lambda *_, **__: SimpleNamespace(tests=["one"]))
    monkeypatch.setattr(views, "band_plan_view", lambda *_: None)
    monkeypatch.setattr(planning, "show", lambda *_: None)
    monkeypatch.setattr(sys, "argv", ["pipeclamp", "plan", str(path), "--limits", "A=0.02..1"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    following = " ".join(capsys.readouterr().out.split())
    assert following == f"Next: pipeclamp plan {path} --limits A=0.02..1 --drive next_test.csv"


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


def test_a_campaign_is_planned_and_tried_on_the_rig(tmp_path, pipeclamp):
    folder, answer, report = tmp_path / "planned", tmp_path / "plan.json", tmp_path / "plan.html"
    pc.open_law("emwm2").save(tmp_path / "my law.json")
    options = ["--hours", "0.3", "--limits", "A=0.2..1,f=2..6,T=20..20", "--json", answer, "--report", report]
    words = ["plan", "-o", folder, "--law", tmp_path / "my law.json", *options]
    with few_effects("hardening", "asymmetry", "memory", "viscous", "quadratic_damping", "damping_temperature"):
        done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 0, done.output
    said = " ".join(done.stdout.split())
    told = json.loads(answer.read_text(encoding="utf-8"))
    assert f"In {told['hours']:.3g} rig hours this plan can tell all {told['stages'][-1]['told']} effects " in said
    assert f"names 90% of them where their rms force is above {told['newtons']:.3g} N, " in said
    page = report.read_text(encoding="utf-8")
    assert "What hours buy" in page
    lines = done.stdout.splitlines()
    following = f"pipeclamp identify {folder} -o law.json"
    assert lines[-1] == f"Next, once its records are in {folder / 'runs'}: {following}"
    assert following in page
    (tried,) = (line for line in lines if line.startswith("To try it"))
    campaign = tmp_path / "virtual"
    rate = ["--rate", "400", "--force-noise", "3", "--format", "parquet"]
    line = tried.partition(": pipeclamp ")[2].replace("-o virtual", f"-o {campaign}")
    done = pipeclamp(*shlex.split(line), *rate)
    assert done.stdout.splitlines()[-1] == f"Next: pipeclamp identify {campaign} -o law.json"
    planned = [line.split(",")[0] for line in (folder / "runs.csv").read_text(encoding="utf-8").splitlines()]
    ran = [line.split(",")[0] for line in (campaign / "runs.csv").read_text(encoding="utf-8").splitlines()]
    assert ran == planned
    assert len(ran) == told["runs"] + 1
    assert pipeclamp("metrics", campaign).returncode == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "expected either SYSTEM.toml"),
        (["-o", "new", "--at", "tip"], "got --at; expected that of a system alone"),
        (["-o", "new", "--hours", "0"], "--hours: got 0; expected a number above 0"),
        (["-o", "new", "--limits", "A=1..2,f=5..6,v=..1"], "no sine test keeps all of"),
    ],
)
def test_a_campaign_that_cannot_be_planned_is_refused(tmp_path, refused, words, said):
    words = [str(tmp_path / word) if word == "new" else word for word in words]
    assert said in refused("plan", *words, status=2)
    assert not (tmp_path / "new").exists()
