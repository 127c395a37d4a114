"""`compare` with a system in the law's place: what was measured on the pipe against pipe and clamps."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from banded import SPREAD
from cantilever import cantilever, shaken
from project import EXAMPLES

from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of, read_law, write_law
from pipeclamp_models.pipe.description import parse_pipe
from pipeclamp_models.pipe.modes import reduce
from pipeclamp_system.transient.monolithic import clamp_equations, solve_monolithic

MEASUREMENT = '[[probes]]\nname = "midspan"\nunit = "mm"\n[[responses]]\nfile = "sines.csv"\n'
SINES = "frequency_Hz,acceleration_m_s2,midspan_amplitude\n" + "".join(
    f"{f},0.5,{amplitude}\n" for f, amplitude in ((3.0, 2.2), (3.4, 3.6), (3.8, 8.1), (4.2, 10.2), (4.6, 4.0))
)


@pytest.fixture
def bench(tmp_path):
    """The example's pipe with a bundled law, and five amplitudes at its probe."""
    for name in ("pipe.toml", "system.toml"):
        text = (EXAMPLES / name).read_text(encoding="utf-8").replace("clamp_a.json", "emwm2")
        (tmp_path / name).write_text(text, encoding="utf-8")
    measured = tmp_path / "measured"
    measured.mkdir()
    (measured / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    (measured / "sines.csv").write_text(SINES, encoding="utf-8")
    return tmp_path


def test_the_answer_the_words_and_the_report(pipeclamp, bench):
    answer, report = bench / "compare.json", bench / "compare.html"
    done = pipeclamp("compare", bench / "system.toml", bench / "measured", "--json", answer, "--report", report)
    found = json.loads(answer.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert 0 < found["nrmse"] < 1
    assert found["noise_nrmse"] is None
    assert [probe["probe"] for probe in found["probes"]] == ["midspan"]
    assert len(found["sines"]) == 5
    assert f"errs by {found['nrmse']:.2%}" in done.stdout
    assert "phase" not in done.stdout, "none was measured"
    assert done.stdout.splitlines()[-1].startswith("Next"), "every verdict ends with what to do"
    assert "Response at midspan" in report.read_text(encoding="utf-8")


def test_bands_are_told_drawn_and_refused(pipeclamp, refused, bench):
    options = ["--bands", "95"]
    told = refused("compare", bench / "system.toml", bench / "measured", *options)
    assert "no clamp has a law that tells how sure it is" in told
    text = (bench / "system.toml").read_text(encoding="utf-8").replace('"emwm2"', '"law.json"')
    (bench / "system.toml").write_text(text, encoding="utf-8")
    law = open_law("emwm2").model_copy(update={"spread": SPREAD})
    write_law(law, bench / "law.json")
    answer, report = bench / "compare.json", bench / "compare.html"
    files = ["--json", answer, "--report", report]
    done = pipeclamp("compare", bench / "system.toml", bench / "measured", *options, *files)
    bands = json.loads(answer.read_text(encoding="utf-8"))["bands"]
    assert bands["compared"] == 5
    share = f"{bands['outside']} of 5 measured amplitudes ({bands['share_outside']:.0%}) lie outside the model's 95%"
    assert share in " ".join(done.stdout.split())
    assert "95% band" in report.read_text(encoding="utf-8")
    assert "expected SYSTEM.toml and MEASURED" in refused("compare", "emwm2", "clamp_a", *options, status=2)


def test_a_mistake_is_one_message(refused, bench):
    assert "nowhere.toml" in refused("compare", bench / "nowhere.toml", bench / "measured")
    (bench / "measured" / "sines.csv").write_text(SINES.replace("8.1", "eight"), encoding="utf-8")
    assert "row 4, column 'midspan_amplitude'" in refused("compare", bench / "system.toml", bench / "measured")
    assert "measurement.toml" in refused("compare", bench / "system.toml", bench)


def test_a_record_of_any_motion_is_compared_over_time(pipeclamp, bench):
    folder = bench / "record"
    folder.mkdir()
    description = MEASUREMENT.replace("[[responses]]", "[[records]]").replace("sines.csv", "burst.csv")
    (folder / "measurement.toml").write_text(description, encoding="utf-8")
    rows = "".join(f"{0.02 * i:.2f},{1.0 if 5 <= i < 10 else 0.0},{0.1 * (i % 7)}\n" for i in range(60))
    (folder / "burst.csv").write_text("time_s,acceleration_m_s2,midspan\n" + rows, encoding="utf-8")
    answer, report = bench / "compare.json", bench / "compare.html"
    done = pipeclamp("compare", bench / "system.toml", folder, "--json", answer, "--report", report)
    found = json.loads(answer.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert f"errs by {found['nrmse']:.2%}" in done.stdout
    assert "Record burst.csv" in report.read_text(encoding="utf-8")


def test_what_is_wrong_is_named_from_a_record_alone(pipeclamp, tmp_path, write_law):
    """A sweep of a pipe with twice the stated damping, integrated by SciPy: the answer names damping and its size."""
    write_law(tmp_path / "law.json", {"k10": 8.0, "k30": 1.0, "c0": 0.7, "alpha0": 0.7}, v_r=1.0)
    (tmp_path / "pipe.toml").write_text(described(ratio=0.02), encoding="utf-8")
    (tmp_path / "system.toml").write_text(shaken(amplitude_mm=0.5, frequency_Hz=8.0), encoding="utf-8")
    folder = tmp_path / "measured"
    folder.mkdir()
    probes = "".join(f'[[probes]]\nname = "{name}"\nunit = "mm"\n' for name in ("tip", "middle"))
    (folder / "measurement.toml").write_text(f'{probes}[[records]]\nfile = "sweep.csv"\n', encoding="utf-8")
    time = np.arange(1201) / 200
    equations = clamp_equations(law_of(read_law(tmp_path / "law.json")), 0.5, 8.0, 293.15)
    true = reduce(parse_pipe(described(ratio=0.04)))
    moved = solve_monolithic(true, [equations], lambda t: float(swept(t)), time, 1e-5).probes
    noise = 0.01 * np.std(moved, axis=0) * np.random.default_rng(1).standard_normal(moved.shape)
    rows = np.column_stack([time, swept(time), 1e3 * (moved + noise)])
    head = "time_s,acceleration_m_s2,tip,middle"
    np.savetxt(folder / "sweep.csv", rows, delimiter=",", header=head, comments="")
    answer = tmp_path / "compare.json"
    done = pipeclamp("compare", tmp_path / "system.toml", folder, "--json", answer)
    found = json.loads(answer.read_text(encoding="utf-8"), parse_constant=pytest.fail)["attribution"]
    assert found["verdict"] in ("wrong", "ambiguous")
    assert "damping" in found["parameters"]
    damping = next(entry for entry in found["candidates"] if entry["parameters"] == ["damping"])
    assert damping["nrmse"] < 0.2 * found["nrmse"]["stated"]
    (size,) = re.findall(r"([\d.]+) ± [\d.]+ % of critical instead of 2 % of critical", damping["values"])
    assert float(size) == pytest.approx(4.0, rel=0.05)
    assert f"{size} ± " in done.stdout


def described(ratio):
    return cantilever(ratio, up_to_Hz=50, probes={"tip": 3.0, "middle": 1.5}, modes="error = 0.001")


def swept(t):
    return 2.0 * np.sin(2 * np.pi * (5.0 * t + 0.6 * t**2))
