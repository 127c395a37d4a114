"""`compare` says where a law fails, on whatever campaign it gets: numbers that add up, sentences, a report."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from project import ROOT


def without_numbers(text):
    return " ".join(re.sub(r"\d+", "#", text.replace("> ", "")).split())


PAGE = without_numbers((ROOT / "docs" / "howto" / "compare.md").read_text(encoding="utf-8"))


def read(path):
    """Numbers that JSON doesn't know are refused."""
    return json.loads(path.read_text(encoding="utf-8"), parse_constant=lambda name: pytest.fail(name))


@pytest.fixture
def compared(pipeclamp, tmp_path):
    """Give a function that compares and returns what was printed, the answer and the report's text."""

    def run(law, campaign):
        answer, report = tmp_path / "compare.json", tmp_path / "compare.html"
        done = pipeclamp("compare", law, campaign, "--json", answer, "--report", report)
        page = report.read_text(encoding="utf-8")
        assert "NaN" not in re.sub(r"<script.*?</script>", "", page, flags=re.S)
        assert ">nan<" not in page
        return done.stdout, read(answer), page

    return run


def whole(parts):
    return sum(part["share"] for part in parts)


def test_every_breakdown_adds_up_and_is_told(compared, law, clamp_a):
    printed, answer, page = compared(law, clamp_a)
    where = answer["where"]
    breakdowns = [where[name] for name in ("phases", "places", "branches", "harmonics", "cycles")]
    for parts in (*breakdowns, *where["conditions"].values()):
        assert whole(parts) == pytest.approx(1.0)
        assert all(0 < part["noise_nrmse"] < answer["nrmse"] for part in parts)
        assert sum(part["noise_share"] for part in parts) == pytest.approx(
            (answer["noise_nrmse"] / answer["nrmse"]) ** 2, rel=0.05
        )
    assert set(where["conditions"]) == {"amplitude_mm", "frequency_Hz", "temperature_C"}
    assert [part["part"] for part in where["conditions"]["temperature_C"]] == ["20", "100", "200", "300"]
    assert {part["runs"] for part in where["conditions"]["amplitude_mm"]} == {12}
    # clamp_a's damping depends on temperature, and the base law's doesn't
    strongest = max(where["harmonics"], key=lambda part: part["share"])
    assert strongest["part"] == "harmonic 1 in quadrature"
    by_temperature = [part["share"] for part in where["conditions"]["temperature_C"]]
    assert min(by_temperature[0], by_temperature[-1]) > max(by_temperature[1:-1])
    for sentence in where["words"]:
        assert sentence in " ".join(printed.split())
        assert sentence in page
        assert without_numbers(sentence) in PAGE, "the page tells of this very law and campaign"
    for title in ("Along the loop", "By harmonic", "Along cycles", "By condition", "All runs"):
        assert f"<h2>{title}</h2>" in page


def test_a_law_that_leaves_scatter_only_is_told_so(compared, small):
    printed, answer, _ = compared("emwm2", small)
    assert answer["nrmse"] < 1.2 * answer["noise_nrmse"] + 1e-3
    assert "harmonic 1" not in printed
    said = " ".join(printed.split())
    assert "no place stands out. A diagnosis, which asks all runs at once, tells whether an effect hides in it." in said
    assert said.partition("hides in it. ")[2].startswith("Next: pipeclamp diagnose emwm2")


@pytest.mark.parametrize(("cycles", "known"), [("1", False), ("3", True)])
def test_records_of_one_cycle_show_no_scatter(pipeclamp, compared, tmp_path, cycles, known):
    campaign = tmp_path / "virtual"
    plan = ("--amplitudes", "0.3,0.9", "--frequencies", "2", "--temperatures", "20", "--rate", "200")
    pipeclamp("rig", "emwm2", "-o", campaign, *plan, "--cycles", cycles)
    printed, answer, page = compared("published_R1", campaign)
    assert ("no scatter from cycle to cycle can be known" in printed) is not known
    assert ("no scatter from cycle to cycle can be known" in page) is not known
    law, metrics = tmp_path / "law.json", tmp_path / "metrics.json"
    fitted = pipeclamp("identify", campaign, "-o", law).stdout
    pipeclamp("metrics", campaign, "--json", metrics)
    assert ("no scatter from cycle to cycle can be known" in fitted) is not known
    assert ("(scatter " in fitted) is known
    for quality in (read(law)["fit"], read(metrics)):
        assert (quality.get("noise_nrmse") is not None) is known
        assert all((run.get("noise_nrmse") is not None) is known for run in quality["runs"])
    assert (answer["noise_nrmse"] is not None) is known
    assert all((run["noise_nrmse"] is not None) is known for run in answer["runs"])
    for parts in (answer["where"]["phases"], answer["where"]["harmonics"], *answer["where"]["conditions"].values()):
        assert all((part["noise_nrmse"] is not None) is known for part in parts if part["nrmse"] is not None)
        assert whole(parts) == pytest.approx(1.0)


def test_one_run_is_enough(compared, campaign_folder):
    printed, answer, page = compared("emwm2", campaign_folder())
    assert "over 1 run;" in printed
    assert answer["where"]["conditions"] == {}
    assert whole(answer["where"]["phases"]) == pytest.approx(1.0)
    assert "A 0.8 mm, f 3 Hz" in page


@pytest.mark.parametrize("per_cycle", [40, 2000])
def test_specimens_density_and_no_temperature(compared, campaign_folder, harmonic_record, csv_text, per_cycle):
    """Two specimens, of which the second is much stiffer than the law has it; densities, one of them not known."""
    table = "run,file,specimen,density_g_cm3,torque_Nm,first_cycle\n"
    records = {}
    for index, (specimen, density) in enumerate((("S1", "2.2"), ("S1", ""), ("S2", "2.4"), ("S2", "2.2"))):
        force = (0.0, 900.0 + 300j) if specimen == "S1" else (0.0, 2400.0 + 300j)
        record = harmonic_record((0.0, 0.8), force, rate=3.0 * per_cycle, cycles=4)
        record.force_N[:] += 2.0 * np.random.default_rng(index).standard_normal(len(record.force_N))
        records[f"runs/{index}.csv"] = csv_text(record)
        table += f"{index},runs/{index}.csv,{specimen},{density},{5 * index},{100 * index}\n"
    _, answer, page = compared("emwm2", campaign_folder(table=table, records=records))
    conditions = answer["where"]["conditions"]
    assert set(conditions) == {"density_g_cm3", "first_cycle", "torque_Nm", "specimen"}
    assert [part["part"] for part in conditions["density_g_cm3"]] == ["2.2", "2.4", "not known"]
    assert [part["runs"] for part in conditions["specimen"]] == [2, 2]
    assert all(whole(parts) == pytest.approx(1.0) for parts in conditions.values())
    assert all(run["temperature_C"] is None for run in answer["runs"])
    assert "specimen S2" in page


def test_the_measured_damper_fails_in_its_damping(compared, pipeclamp, measured_data, tmp_path):
    """Its loops have slopes after the reversals, which a power of the velocity can't draw."""
    law, campaign = tmp_path / "law.json", measured_data / "mr_damper"
    pipeclamp("identify", campaign, "-o", law, "--effects", "condition:current_A")
    _, answer, page = compared(law, campaign)
    where = answer["where"]
    assert max(where["harmonics"], key=lambda part: part["share"])["part"] == "harmonic 1 in quadrature"
    assert [part["part"] for part in where["conditions"]["current_A"]] == ["0", "0.25", "0.5", "0.75", "1"]
    assert "temperature_C" not in where["conditions"]
    assert "current_A 0.25" in page
