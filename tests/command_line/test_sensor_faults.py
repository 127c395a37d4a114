"""Faults of sensors, made by the virtual rig, as the commands and the Python API tell them."""

import json

import pytest

import pipeclamp as pc

PLAN = ("--amplitudes", "0.3,0.9", "--frequencies", "1,4", "--temperatures", "20,250", "--rate", "300")


@pytest.fixture(scope="module")
def drifting(pipeclamp, tmp_path_factory):
    path = tmp_path_factory.mktemp("drift") / "campaign"
    pipeclamp("rig", "emwm2", "-o", path, *PLAN, "--force-drift", "40")
    return path


def test_a_diagnosis_tells_sensors_before_physics(pipeclamp, drifting, tmp_path):
    told = pipeclamp(
        "diagnose", "emwm2", drifting, "--json", tmp_path / "answer.json", "--report", tmp_path / "page.html"
    )
    answer = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    (fault,) = answer["sensors"]
    assert (fault["channel"], fault["fault"], fault["done"]) == ("force", "zero_drift", "corrected")
    # 40 N/s from the middle of the first cycle of five to that of the last, at the 1 Hz of the slow runs
    assert fault["size"] == pytest.approx(160.0, rel=0.1)
    assert answer["verdict"] == "complete"
    lines = [line for line in told.stdout.splitlines() if line.startswith(("Sensors: ", "Complete"))]
    assert [line.split()[0] for line in lines] == ["Sensors:", "Complete:"]
    assert "Sensors: the zero of the force channel drifts" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_every_command_notes_it_and_python_knows_it(pipeclamp, drifting, tmp_path):
    for words in (
        ("metrics", drifting, "--json", tmp_path / "a.json"),
        ("identify", drifting, "-o", tmp_path / "l.json"),
    ):
        assert "note: the zero of the force channel drifts" in pipeclamp(*words).stderr
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["sensors"][0]["fault"] == "zero_drift"
    tests = pc.read_campaign(drifting)
    assert any("the zero of the force channel drifts" in words for words in tests.remarks)
    assert pc.compare("emwm2", tests).to_dict()["sensors"][0]["unit"] == "N"


def test_runs_beyond_the_sensors_range_are_left_out(pipeclamp, tmp_path):
    pipeclamp("rig", "emwm2", "-o", tmp_path / "clip", *PLAN, "--force-range", "1200")
    told = pipeclamp("metrics", tmp_path / "clip", "--json", tmp_path / "a.json")
    assert "left out: clipped sensor: force_N stands at 1200" in " ".join(told.stderr.split())
    (fault,) = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["sensors"]
    assert (fault["fault"], fault["size"], fault["done"]) == ("clipped", pytest.approx(1200.0), "left out")
