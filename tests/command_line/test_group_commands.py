"""Specimens that differ, made by the virtual rig: as diagnose tells them, and a law for each."""

import json
import shutil

import pytest

import pipeclamp as pc

PLAN = (
    "--amplitudes", "0.3,0.6,0.9", "--frequencies", "1,4", "--temperatures", "20,250", "--rate", "300",
    "--specimens", "3", "--specimen-scatter", "0.08",
)  # fmt: skip


@pytest.fixture(scope="module")
def specimens(pipeclamp, tmp_path_factory):
    path = tmp_path_factory.mktemp("specimens") / "campaign"
    pipeclamp("rig", "emwm2", "-o", path, *PLAN)
    return path


def test_a_diagnosis_tells_the_specimens_before_physics(pipeclamp, specimens, tmp_path):
    told = pipeclamp(
        "diagnose", "emwm2", specimens, "--json", tmp_path / "answer.json", "--report", tmp_path / "page.html"
    )
    answer = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    (column,) = answer["groups"]
    assert (column["column"], column["differ"]) == ("specimen", ["stiffness", "damping"])
    assert [group["runs"] for group in column["groups"]] == [12, 12, 12]
    assert answer["verdict"] == "complete"
    assert answer["nrmse"]["best"] == answer["nrmse"]["law"]  # nothing better was found
    lines = [line.split()[0] for line in told.stdout.splitlines() if line.startswith(("Groups: ", "Complete"))]
    assert lines == ["Groups:", "Complete:"]
    assert "Groups: the runs differ by specimen" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_law_says_how_its_specimens_differ_and_its_fmu_doesnt(pipeclamp, specimens, tmp_path):
    told = pipeclamp("identify", specimens, "-o", tmp_path / "law.json", "--effects", "damping_temperature")
    law = json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))
    assert [entry["name"] for entry in law["groups"]] == ["S1", "S2", "S3"]
    assert "specimen S1 (12 runs) against the law: stiffness" in told.stdout
    assert told.stdout.count("Errors on left-out conditions are told without these differences") == 1
    pipeclamp("build-fmu", tmp_path / "law.json", "-o", tmp_path / "clamp.fmu")
    pipeclamp("add", tmp_path / "law.json", "contact_growth", specimens, "-o", tmp_path / "law2.json")


def test_a_law_for_each_specimen(pipeclamp, specimens, tmp_path):
    told = pipeclamp("identify", specimens, "-o", tmp_path / "laws", "--per", "specimen", "--reproducible")
    assert sorted(path.name for path in (tmp_path / "laws").iterdir()) == ["S1.json", "S2.json", "S3.json"]
    assert "A law for each specimen" in told.stdout
    own = pc.identify_per(specimens, "specimen")
    assert list(own) == ["S1", "S2", "S3"]
    file = json.loads((tmp_path / "laws" / "S2.json").read_text(encoding="utf-8"))
    assert file["coefficients"]["k10"]["value"] == own["S2"].file.coefficients["k10"].value
    assert file["data"]["runs_used"] == 12
    prints = {law.file.data.fingerprint for law in (*own.values(), pc.identify(specimens))}
    assert len(prints) == 4
    assert file["data"]["fingerprint"] == own["S2"].file.data.fingerprint


def test_what_cant_be_parted_is_refused_whole(refused, specimens, tmp_path):
    table = (specimens / "runs.csv").read_text(encoding="utf-8").splitlines()
    few = tmp_path / "few"
    shutil.copytree(specimens, few)
    (few / "runs.csv").write_text("\n".join(table[:28]) + "\n", encoding="utf-8")
    told = refused("identify", few, "-o", tmp_path / "laws", "--per", "specimen")
    assert "too few runs of S3 (3); expected at least 4 of each" in told
    assert not (tmp_path / "laws").exists()
    assert "column: got 'valve'" in refused("identify", specimens, "-o", tmp_path / "laws", "--per", "valve")
    (tmp_path / "there").mkdir()
    assert "exists already" in refused("identify", specimens, "-o", tmp_path / "there", "--per", "specimen")
