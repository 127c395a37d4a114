"""Commands of systems and of metrics end with the next one, on the page too, and it runs as it is printed."""

from __future__ import annotations

import html
import json
import shlex

from banded import banded


def next_of(done):
    """Give what has to be done first, and the words of the line."""
    first, _, line = done.stdout.splitlines()[-1].partition(": ")
    assert first.startswith("Next")
    return first.removeprefix("Next").strip(", "), shlex.split(line)[1:]


def test_metrics_lead_to_a_law(pipeclamp, tmp_path):
    for campaign in ("clamp_a_heldout", "emwm2_tables"):
        first, words = next_of(done := pipeclamp("metrics", campaign, "--report", "m.html", cwd=tmp_path))
        assert not first
        assert html.escape(shlex.join(["pipeclamp", *words])) in (tmp_path / "m.html").read_text(encoding="utf-8"), done
        pipeclamp(*words, cwd=tmp_path)
        assert (tmp_path / "law.json").is_file()


def test_a_run_leads_to_a_longer_one_and_to_the_response(pipeclamp, tmp_path):
    path = banded(tmp_path, 1.0)
    first, words = next_of(pipeclamp("cosim", "system.toml", "-o", "c.csv", "--report", "c.html", cwd=tmp_path))
    assert first == "with a larger stop_s"
    page = (tmp_path / "c.html").read_text(encoding="utf-8")
    assert "Next, with a larger stop_s, run the command below." in page
    assert "pipeclamp cosim system.toml -o c.csv --report c.html" in page
    path.write_text(path.read_text(encoding="utf-8").replace("stop_s = 0.2", "stop_s = 2.0"), encoding="utf-8")
    law = json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))
    law["range"] |= {
        "A": {"minimum": 0.001, "maximum": 5, "unit": "mm"},
        "f": {"minimum": 1, "maximum": 50, "unit": "Hz"},
    }
    (tmp_path / "law.json").write_text(json.dumps(law), encoding="utf-8")
    (tmp_path / "c.csv").unlink()
    first, words = next_of(pipeclamp(*words, cwd=tmp_path))
    assert (tmp_path / "c.csv").is_file()
    assert not first
    assert words[:2] == ["response", "system.toml"]
    first, words = next_of(pipeclamp(*words, cwd=tmp_path))
    assert (tmp_path / "response.csv").is_file()
    assert shlex.join(["pipeclamp", *words]) in (tmp_path / "response.html").read_text(encoding="utf-8")


def test_what_is_built_leads_to_a_system_that_has_it(pipeclamp, tmp_path):
    banded(tmp_path, 1.0)
    built = (
        ("build-fmu", "law.json", "clamp 1.fmu", 'law = "law.json"', "at a clamp of system.toml"),
        ("build-pipe", "pipe.toml", "pipe 1.fmu", 'file = "pipe.toml"', "as the pipe of system.toml"),
    )
    system = tmp_path / "system.toml"
    for command, source, fmu, old, where in built:
        first, words = next_of(pipeclamp(command, source, "-o", fmu, cwd=tmp_path))
        stated, _, place = first.removeprefix("with ").partition("' ")
        assert place == where
        text = system.read_text(encoding="utf-8")
        system.write_text(text.replace(old, f"{stated}'").replace("stop_s = 0.2", "stop_s = 2.0"), encoding="utf-8")
    pipeclamp(*words, cwd=tmp_path)
    assert (tmp_path / "cosim.csv").is_file()
    done = pipeclamp("set-parameters", "clamp 1.fmu", "law.json", cwd=tmp_path)
    assert next_of(done) == ("with fmu = 'clamp 1.fmu' at a clamp of system.toml", words)


def test_tests_put_together_and_laws_of_groups_lead_on(pipeclamp, tmp_path):
    rig = ("--amplitudes", "0.3,0.6,1", "--frequencies", "2,4", "--temperatures", "20", "--rate", "240")
    _, words = next_of(pipeclamp("rig", "emwm2", "-o", "a", *rig, "--specimens", "2", cwd=tmp_path))
    assert words == ["identify", "a", "-o", "law.json"]
    pipeclamp("rig", "emwm2", "-o", "b", *rig, "--specimens", "2", "--seed", "1", cwd=tmp_path)
    _, words = next_of(pipeclamp("join", "a", "b", "-o", "all tests", cwd=tmp_path))
    assert words == ["identify", "all tests", "-o", "law.json"]
    _, words = next_of(pipeclamp("identify", "all tests", "--per", "specimen", "-o", "laws", cwd=tmp_path))
    pipeclamp(*words, cwd=tmp_path)
    assert "2 laws against" in (tmp_path / "compare.html").read_text(encoding="utf-8")


def test_the_page_of_a_law_leads_to_what_it_lacks(pipeclamp, tmp_path):
    """It had ended with the advice to diagnose, and no command."""
    rig = ["--amplitudes", "0.3,0.9", "--frequencies", "1,4", "--temperatures", "20,150", "--rate", "100"]
    pipeclamp("rig", "emwm2", "-o", "a", *rig, cwd=tmp_path)
    _, words = next_of(pipeclamp("identify", "a", "-o", "law.json", "--report", "law.html", cwd=tmp_path))
    assert words[:2] == ["compare", "law.json"]
    page = (tmp_path / "law.html").read_text(encoding="utf-8")
    assert "<code>pipeclamp diagnose law.json a --report diagnosis.html</code>" in page


def test_a_study_leads_to_its_system(pipeclamp, tmp_path):
    banded(tmp_path, 1.0)
    (tmp_path / "study.toml").write_text(
        'system = "system.toml"\nmeasure = "steady"\n[vary]\n"system.clamps.clamp1.temperature_C" = [20.0, 60.0]\n',
        encoding="utf-8",
    )
    first, words = next_of(pipeclamp("sweep", "study.toml", "-o", "s.parquet", "--report", "s.html", cwd=tmp_path))
    assert words[:2] == ["response", "system.toml"]
    page = (tmp_path / "s.html").read_text(encoding="utf-8")
    assert f"Next, {first}, run the command below." in page
    assert shlex.join(["pipeclamp", *words]) in page
