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
