"""Every command end to end, on the bundled campaign: exit status, files, and the fields that stay."""

from __future__ import annotations

import json
import math
import re
import shutil
import sys
import zipfile
from importlib import resources
from xml.etree import ElementTree

import numpy as np
import polars as pl
import pytest

from pipeclamp.__main__ import main
from pipeclamp_fmu.native import compiler
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_models.law.catalogue import entries


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def test_identify_writes_a_law(law):
    file = read(law)
    assert file["schema"] == "pipeclamp-law-1"
    assert file["base"] == "power"
    assert file["data"]["runs_used"] == 48
    assert file["data"]["fingerprint"].startswith("sha256:")
    assert file["command"].startswith("pipeclamp identify clamp_a -o law.json")
    assert len(file["fit"]["runs"]) == 48
    assert 0.02 < file["fit"]["nrmse"] < 0.035, "clamp_a holds more than a base law"
    assert 0.0045 < file["fit"]["noise_nrmse"] < 0.0052
    for entry in file["coefficients"].values():
        assert entry["unit"]
        assert entry["standard_error"] > 0
    names = file["covariance"]["names"]
    diagonal = np.sqrt(np.diag(file["covariance"]["matrix"]))
    errors = [file["coefficients"][name]["standard_error"] for name in names]
    np.testing.assert_allclose(diagonal, errors, rtol=1e-6)
    assert file["range"]["T"]["minimum"] == pytest.approx(293, abs=3)


def test_identify_is_reproducible_byte_for_byte(pipeclamp, clamp_a, law, tmp_path):
    """But for the date, and in the command the option that leaves it out."""
    dated = tmp_path / "law.json"
    pipeclamp("identify", clamp_a, "-o", dated)
    assert b'"date"' not in law.read_bytes()
    assert law.read_bytes().count(b" --reproducible") == 1
    without = law.read_bytes().replace(b" --reproducible", b"")
    assert re.sub(rb',\n *"date": ".+"', b"", dated.read_bytes()) == without


def test_an_fmu_of_a_law_without_a_time_says_what_its_damping_follows(pipeclamp, law, tmp_path):
    told = "no time was measured in the tests of law"
    assert told not in pipeclamp("build-fmu", law, "-o", tmp_path / "a.fmu").stderr
    file = read(law)
    file["data"]["time_measured"] = False
    (tmp_path / "untimed.json").write_text(json.dumps(file), encoding="utf-8")
    done = pipeclamp("build-fmu", tmp_path / "untimed.json", "-o", tmp_path / "b.fmu")
    assert told in " ".join(done.stderr.split())


def test_an_fmu_of_a_law_that_follows_a_column_says_at_which_value_it_stands(pipeclamp, small, tmp_path):
    """It had stood at the middle of the tests, without a word."""
    folder, path = tmp_path / "coil", tmp_path / "law.json"
    shutil.copytree(small, folder)
    runs = pl.read_csv(folder / "runs.csv")
    runs.with_columns(pl.Series("current_A", np.resize([0.0, 1.0, 2.0], len(runs)))).write_csv(folder / "runs.csv")
    pipeclamp("identify", folder, "-o", path, "--effects", "condition:current_A")
    done = pipeclamp("build-fmu", path, "-o", tmp_path / "a.fmu")
    told = "parameters of the FMU: condition.current_A is 1 until it is set (the law's tests: 0 to 2)"
    assert told in " ".join(done.stderr.split())


def test_a_law_says_what_was_held_by_wish_and_what_was_fitted(pipeclamp, small, tmp_path):
    path = tmp_path / "law.json"
    pipeclamp("identify", small, "-o", path, "--base", "memory", "--freeze", "c_A=0.1")
    entries = read(path)["coefficients"]
    assert (entries["c_A"]["state"], entries["c_A"]["reason"]) == ("held", "held by wish")
    assert (entries["alpha0"]["state"], entries["alpha0"]["reason"]) == ("held", "held by the law's structure")
    pipeclamp("identify", small, "-o", path, "--method", "surfaces", "--freeze", "alpha0=0.4")
    entries = read(path)["coefficients"]
    assert entries["alpha0"]["state"] == "held"
    assert {entry["state"] for name, entry in entries.items() if name != "alpha0"} == {"fitted"}


def test_a_temperature_that_nobody_knows_is_not_made_up(pipeclamp, small, tmp_path):
    tests, path, fmu = tmp_path / "tests", tmp_path / "law.json", tmp_path / "clamp.fmu"
    shutil.copytree(small, tests)
    pl.read_csv(tests / "runs.csv").drop("temperature_C").write_csv(tests / "runs.csv")
    pipeclamp("identify", tests, "-o", path, "--report", tmp_path / "law.html")
    file = read(path)
    assert set(file["range"]) == {"A", "f"}
    assert {file["coefficients"][name]["reason"] for name in ("k1_T", "k3_T")} == {"T isn't known"}
    pipeclamp("compare", path, small)
    pipeclamp("build-fmu", path, "-o", fmu)
    description = zipfile.ZipFile(fmu).read("modelDescription.xml").decode()
    assert "temperature of the clamp (its law was identified without)" in description


def test_compare_has_the_contracts_fields(pipeclamp, law, clamp_a, tmp_path):
    path = tmp_path / "compare.json"
    done = pipeclamp("compare", law, clamp_a, "--json", path)
    assert "the 8 worst of 48 runs" in " ".join(done.stdout.split())
    answer = read(path)
    assert set(answer) >= {"nrmse", "noise_nrmse", "runs"}
    assert len(answer["runs"]) == 48
    assert answer["nrmse"] == pytest.approx(read(law)["fit"]["nrmse"], rel=1e-9)
    assert f"{answer['nrmse']:.2%}" in done.stdout
    assert all(run["nrmse"] > 0 for run in answer["runs"])


def test_the_nrmse_is_the_contracts(pipeclamp, small, tmp_path):
    """sqrt(sum of squared error / sum of squared force) over all samples: runs pool by their squared force."""
    path = tmp_path / "compare.json"
    pipeclamp("compare", "emwm2", small, "--json", path)
    answer = read(path)
    tests = read_campaign(small)
    squares = {run.name: float(np.sum(run.record.force_N[run.cycles.steady] ** 2)) for run in tests.runs}
    pooled = sum(run["nrmse"] ** 2 * squares[run["run"]] for run in answer["runs"]) / sum(squares.values())
    assert answer["nrmse"] == pytest.approx(math.sqrt(pooled), rel=1e-9)
    # the truth leaves nothing but the errors of the rig: 3 N of noise, 0.5 % of amplitude, 1 K
    assert answer["nrmse"] < 1.3 * answer["noise_nrmse"] + 1e-3


def test_a_law_with_its_true_effects_foretells_tests_never_seen(pipeclamp, clamp_a, heldout, tmp_path):
    law, path = tmp_path / "law.json", tmp_path / "compare.json"
    pipeclamp("identify", clamp_a, "-o", law, "--effects", "damping_temperature,memory:2")
    pipeclamp("compare", law, heldout, "--json", path)
    answer = read(path)
    assert answer["nrmse"] < 1.1 * answer["noise_nrmse"]


def test_metrics_has_the_contracts_fields(pipeclamp, clamp_a, tmp_path):
    path, report = tmp_path / "metrics.json", tmp_path / "metrics.html"
    done = pipeclamp("metrics", clamp_a, "--json", path, "--report", report)
    runs = read(path)["runs"]
    assert len(runs) == 48
    needed = {
        "run", "dissipated_energy_J", "max_elastic_energy_J", "loss_factor", "stiffness_N_mm", "amplitude_mm",
        "frequency_Hz",
    }  # fmt: skip
    for run in runs:
        assert needed <= set(run)
        eta = run["dissipated_energy_J"] / (2 * math.pi * run["max_elastic_energy_J"])
        assert run["loss_factor"] == pytest.approx(eta, rel=1e-9)
    assert "dW / J" in done.stdout
    assert report.stat().st_size > 1e6


def test_add_says_what_the_error_did(pipeclamp, law, clamp_a, tmp_path):
    path = tmp_path / "law2.json"
    done = pipeclamp("add", law, "damping_temperature", clamp_a, "-o", path, "--reproducible")
    before, after = read(law), read(path)
    assert after["effects"] == ["damping_temperature"]
    assert after["fit"]["nrmse"] < 0.6 * before["fit"]["nrmse"]
    assert "error on left-out conditions" in done.stdout
    assert [step["step"] for step in after["history"]] == ["power", "+ damping_temperature"]
    assert after["history"][-1]["refitted_nrmse"] < after["history"][0]["refitted_nrmse"]


def test_effects_lists_the_whole_catalogue(pipeclamp):
    text = pipeclamp("effects").stdout
    for name in entries():
        assert name in text
    assert max(map(len, text.splitlines())) <= 80


def test_an_effect_is_shown_whole(pipeclamp, tmp_path):
    text = pipeclamp("effects", "relaxation").stdout
    for words in (
        "q after a step",
        "exp(-h/tau_m)",
        "k_m",
        "N/mm",
        "relaxation time",
        "Ferry",
        "1980",
        "viscous",
        "typical",
    ):
        assert words in text
    assert max(map(len, text.splitlines())) <= 80
    wide = pipeclamp("effects", "play").stdout
    assert "  in place of y\n    y - e_p\n" in wide, "beside its long headings it had a column of one letter"
    assert "40 to 1000" in pipeclamp("effects", "relaxation_temperature").stdout, "plain figures"
    assert "1/[column]" in pipeclamp("effects", "condition").stdout
    assert "z2" in pipeclamp("effects", "memory:2").stdout
    assert "did you mean 'memory'" in pipeclamp("effects", "memroy", status=1).stderr
    path = tmp_path / "effects.json"
    pipeclamp("effects", "--json", path)
    found = {effect["id"]: effect for effect in read(path)["effects"]}
    assert set(found) == set(entries())
    memory = found["memory"]
    assert memory["equations"][0] == {"says": "force added, N", "equation": "z", "latex": r"\Delta F = z"}
    assert [(one["symbol"], one["unit"]) for one in memory["parameters"]] == [("k_s", "N/mm"), ("z_s", "N")]
    assert all(one["lower"] < one["typical"] < one["upper"] for one in memory["parameters"])
    assert found["relaxation"]["parameters"][0]["upper"] is None


def test_the_rig_says_which_sizes_it_took(pipeclamp, tmp_path):
    plan = ("--amplitudes", "0.5", "--frequencies", "2", "--temperatures", "20")
    done = pipeclamp("rig", "emwm2", "-o", tmp_path / "v", "--effects", "memory,offset", "--set", "F_o=7", *plan)
    lines = {line.split()[1]: line for line in done.stdout.splitlines() if line.startswith("│")}
    assert "N/mm" in lines["k_s"] and "typical size" in lines["k_s"]
    assert "--set" in lines["F_o"] and " 7 " in lines["F_o"]
    assert "k10" not in lines
    done = pipeclamp("rig", "emwm2", "-o", tmp_path / "w", "--effects", "memory", "--set", "k_S=7", *plan, status=1)
    assert "did you mean 'k_s'? it has" in done.stderr and "z_s (N)" in done.stderr
    assert not (tmp_path / "w").exists()


def test_rig_writes_a_campaign_that_is_read(pipeclamp, small):
    tests = read_campaign(small, strict=True)
    assert len(tests.runs) == 8
    assert tests.notes.startswith("Virtual rig: pipeclamp rig emwm2")


@pytest.mark.parametrize("form", ["csv.gz", "parquet"])
def test_rig_writes_other_formats_and_the_same_numbers(pipeclamp, small, tmp_path, form):
    path = tmp_path / "virtual"
    plan = ("--amplitudes", "0.3,0.9", "--frequencies", "1,4", "--temperatures", "20,250", "--rate", "300")
    pipeclamp("rig", "emwm2", "-o", path, *plan, "--format", form)
    for one, other in zip(read_campaign(small).runs, read_campaign(path).runs, strict=True):
        np.testing.assert_array_equal(one.record.force_N, other.record.force_N)


def test_rig_adds_effects_that_identify_finds(pipeclamp, tmp_path):
    truth, path = tmp_path / "virtual", tmp_path / "law.json"
    pipeclamp("rig", "emwm2", "-o", truth, "--effects", "viscous", "--set", "c1=2.5", "--rate", "250", "--cycles", "4")
    effects = "damping_temperature,contact_growth,stiffness_frequency,viscous"
    pipeclamp("identify", truth, "-o", path, "--effects", effects)
    entry = read(path)["coefficients"]["c1"]
    assert entry["value"] == pytest.approx(2.5, abs=4 * entry["standard_error"])


def test_the_rig_says_where_its_law_has_no_data(pipeclamp, tmp_path):
    few = ("--frequencies", "3", "--temperatures", "20", "--cycles", "2")
    assert "warning" not in pipeclamp("rig", "emwm2", "-o", tmp_path / "in", "--amplitudes", "0.5", *few).stderr
    said = pipeclamp("rig", "emwm2", "-o", tmp_path / "out", "--amplitudes", "0.5,5", *few).stderr
    assert "beyond the law's data: A = 5 mm, law:" in said


def test_schema_is_the_files(pipeclamp, law):
    schema = json.loads(pipeclamp("schema").stdout)
    file = read(law)
    assert set(schema["required"]) <= set(file) <= set(schema["properties"])


def test_pipe_and_clamp_are_built_and_coupled(pipeclamp, law, tmp_path):
    examples = resources.files("pipeclamp_identification").joinpath("data", "examples")
    (tmp_path / "pipe.toml").write_text(examples.joinpath("pipe.toml").read_text(encoding="utf-8"), encoding="utf-8")
    system = examples.joinpath("system.toml").read_text(encoding="utf-8").replace("stop_s = 30.0", "stop_s = 0.3")
    system = system.replace('law = "clamp_a.json"', 'fmu = "clamp.fmu"').replace('file = "pipe.toml"', 'fmu = "p.fmu"')
    (tmp_path / "system.toml").write_text(system, encoding="utf-8")
    pipeclamp("build-fmu", law, "-o", "clamp.fmu", cwd=tmp_path)
    pipeclamp("build-pipe", "pipe.toml", "-o", "p.fmu", cwd=tmp_path)
    for name in ("clamp.fmu", "p.fmu"):
        assert "modelDescription.xml" in zipfile.ZipFile(tmp_path / name).namelist()
    done = pipeclamp("cosim", "system.toml", "-o", "result.csv", "--report", "result.html", cwd=tmp_path)
    result = pl.read_csv(tmp_path / "result.csv", comment_prefix="#")
    assert len(result) == 101
    assert all(result[name].is_finite().all() for name in result.columns if result[name].dtype == pl.Float64)
    assert "result.csv" in done.stdout
    assert (tmp_path / "result.html").exists()


def test_a_frequency_response_is_drawn_with_co_simulations_on_it(pipeclamp, tmp_path):
    examples = resources.files("pipeclamp_identification").joinpath("data", "examples")
    (tmp_path / "pipe.toml").write_text(examples.joinpath("pipe.toml").read_text(encoding="utf-8"), encoding="utf-8")
    system = examples.joinpath("system.toml").read_text(encoding="utf-8").replace('"clamp_a.json"', '"emwm2"')
    table = "[response]\nfrom_Hz = 3.0\nto_Hz = 4.0\nlevels = [1.0]\ntemperatures_C = [300.0]\ndots = 1\n"
    (tmp_path / "system.toml").write_text(f"{system}\n{table}", encoding="utf-8")
    done = pipeclamp("response", "system.toml", "-o", "response.csv", "--report", "response.html", cwd=tmp_path)
    frame = pl.read_csv(tmp_path / "response.csv")
    curves = frame.filter(pl.col("kind") == "curve")
    assert set(curves["temperature [degC]"]) == {300.0}
    assert curves.group_by("level").agg(pl.col("frequency [Hz]").max())["frequency [Hz]"].to_list() == [4.0]
    assert frame.filter(pl.col("kind") == "co-simulation").height == 1
    said = " ".join(done.stdout.split())
    assert "1 co-simulation in steps of" in said
    assert "those that settled and can be trusted (1) differ by at most 0." in said
    assert (tmp_path / "response.html").stat().st_size > 1e5
    outside = curves.filter(pl.col("clamp1.inRange [1 yes, 0 no]") == 0.0)
    assert outside.height > 0
    assert (
        f"clamp1: its law is used beyond the range of its data in {outside.height / curves.height:.0%}" in done.stdout
    )


def test_an_fmu_is_native_where_a_compiler_is_found(pipeclamp, law, tmp_path):
    done = pipeclamp("build-fmu", law, "-o", "c.fmu", cwd=tmp_path)
    assert "native (" in " ".join(done.stdout.split())
    assert any(name.endswith((".so", ".dll", ".dylib")) for name in zipfile.ZipFile(tmp_path / "c.fmu").namelist())


def test_an_fmu_is_of_python_where_no_compiler_is_found(law, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(compiler, "default_platforms", lambda fmi: ())
    monkeypatch.setattr(sys, "argv", ["pipeclamp", "build-fmu", str(law), "-o", str(tmp_path / "c.fmu")])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "no C compiler was found: FMI 2.0 co-simulation, run by Python" in said
    assert any(name.endswith(".py") for name in zipfile.ZipFile(tmp_path / "c.fmu").namelist())


def test_a_native_clamp_is_built(pipeclamp, law, tmp_path):
    done = pipeclamp("build-fmu", law, "-o", "c.fmu", "--kind", "native", "--fmi", "3", "--platforms", "", cwd=tmp_path)
    assert "FMI 3.0 co-simulation and model exchange, native (sources alone" in done.stdout.replace("\n", " ")
    assert "sources/fmi3.c" in zipfile.ZipFile(tmp_path / "c.fmu").namelist()


@pytest.mark.parametrize("kind", [("--kind", "python"), ("--kind", "native", "--platforms", "")])
def test_a_clamp_starts_with_what_it_is_told(pipeclamp, tmp_path, kind):
    told = ("--amplitude", "0.3", "--frequency", "4", "--temperature", "150", "--track")
    pipeclamp("build-fmu", "emwm2", "-o", "c.fmu", *told, *kind, cwd=tmp_path)
    archive = zipfile.ZipFile(tmp_path / "c.fmu")
    variables = ElementTree.fromstring(archive.read("modelDescription.xml")).iter("ScalarVariable")
    starts = {variable.get("name"): variable[0].get("start") for variable in variables}
    assert [float(starts[name]) for name in ("A", "f", "T")] == pytest.approx([3e-4, 4.0, 423.15])
    assert starts["track"] == "true"
    pipeclamp("set-parameters", "c.fmu", "emwm2", cwd=tmp_path)
    assert zipfile.ZipFile(tmp_path / "c.fmu").read("modelDescription.xml") == archive.read("modelDescription.xml")


@pytest.mark.parametrize(
    ("told", "status", "words"),
    [
        (("--amplitude", "3"), 1, "amplitude A = 3 mm; expected 0.2 to 1 mm"),
        (("--amplitude", "0"), 2, "got 0 mm; expected a number above 0 mm"),
        (("--frequency", "nan"), 2, "got nan Hz; expected a number above 0 Hz"),
        (("--temperature", "-300"), 2, "expected a number above -273.15 °C"),
        (("--temperature", "400"), 1, "temperature T = 400 °C; expected 20 to 300 °C"),
    ],
)
def test_what_a_clamp_cannot_start_with_is_refused(pipeclamp, tmp_path, told, status, words):
    done = pipeclamp("build-fmu", "emwm2", "-o", "c.fmu", *told, cwd=tmp_path, status=status)
    assert words in " ".join(done.stderr.replace("│", " ").split())
    assert not (tmp_path / "c.fmu").exists()


def test_a_native_pipe_is_built(pipeclamp, tmp_path):
    examples = resources.files("pipeclamp_identification").joinpath("data", "examples")
    (tmp_path / "pipe.toml").write_text(examples.joinpath("pipe.toml").read_text(encoding="utf-8"), encoding="utf-8")
    done = pipeclamp("build-pipe", "pipe.toml", "-o", "p.fmu", "--kind", "native", "--platforms", "", cwd=tmp_path)
    assert "FMI 2.0 co-simulation and model exchange, native (sources alone" in done.stdout.replace("\n", " ")
    assert "sources/pipe.c" in zipfile.ZipFile(tmp_path / "p.fmu").namelist()
