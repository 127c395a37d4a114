"""`compare` with a system in the law's place: what was measured on the pipe against pipe and clamps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "identification" / "pipeclamp_identification" / "data" / "examples"
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
    assert "Response at midspan" in report.read_text(encoding="utf-8")


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
