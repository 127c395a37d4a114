"""Units can't be silently wrong: refused where something stated contradicts them, told where they are only unlikely."""

from __future__ import annotations

import csv
import json

import numpy as np
import polars as pl
import pytest
from exports import loop

import pipeclamp as pc
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign

TEMPERATURES = (20.0, 150.0)


@pytest.fixture
def campaign(tmp_path):
    """Give a function that writes a campaign by hand: record columns and factors, and what runs.csv states."""

    def write(channels=None, stated=None, columns="", temperature=None):
        folder = tmp_path / "c"
        (folder / "runs").mkdir(parents=True)
        names, factors = channels or (("time_s", "displacement_mm", "force_N"), (1, 1, 1))
        rows = []
        for number, (A, f, T) in enumerate((A, f, T) for A in (0.3, 0.9) for f in (1.0, 4.0) for T in TEMPERATURES):
            run = loop(A, f, T, seed=number)
            samples = (run.time, run.y, run.force)
            held = {name: values * factor for name, values, factor in zip(names, samples, factors, strict=True)}
            if temperature:
                held["temperature_C"] = np.full(len(run.time), temperature(T))
            pl.DataFrame(held).write_csv(folder / "runs" / f"r{number}.csv")
            row = {
                "run": f"r{number}",
                "file": f"runs/r{number}.csv",
                "amplitude_mm": A,
                "frequency_Hz": f,
                "temperature_C": T,
            }
            rows.append(row | {name: turn(row[name]) for name, turn in (stated or {}).items()})
        with (folder / "runs.csv").open("w", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0])
            writer.writeheader()
            writer.writerows(rows)
        (folder / "campaign.toml").write_text(f'name = "by hand"\n{columns}', encoding="utf-8")
        return folder

    return write


OWN = ("time_s", "displacement_mm", "force_N")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"channels": (OWN, (1, 1e-3, 1))}, "0.001 times the amplitudes.*m for mm.*factor = 1000"),
        ({"channels": (OWN, (1, 1e3, 1))}, "µm for mm.*factor = 0.001"),
        ({"channels": (OWN, (1, 1 / 25.4, 1))}, "in for mm.*factor = 25.4"),
        ({"channels": (OWN, (1, 25.4, 1))}, "mm for in"),
        ({"channels": (OWN, (1e3, 1, 1))}, "ms for s.*factor = 0.001"),
        ({"channels": (OWN, (1 / 60, 1, 1))}, "min for s.*factor = 60"),
        ({"stated": {"frequency_Hz": lambda f: 60 * f}}, "rpm for Hz.*mend frequency_Hz"),
        ({"stated": {"amplitude_mm": lambda A: A / 1000}}, "1e\\+03 times the amplitudes"),
        ({"temperature": lambda T: T + 273.15}, "K for °C in the record"),
        ({"temperature": lambda T: 1.8 * T + 32}, "°F for °C in the record"),
        ({"temperature": lambda T: T, "stated": {"temperature_C": lambda T: T + 273.15}}, "K for °C in runs.csv"),
        ({"temperature": lambda T: -300.0}, r"-300 °C in row 2; expected above -273\.15"),
    ],
)
def test_a_unit_that_contradicts_what_is_stated_is_refused(campaign, changes, told):
    with pytest.raises(pc.UserError, match=told):
        pc.read_campaign(campaign(**changes))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"channels": (OWN, (1, 1, 1e-3))}, "the force may be in kN, not N (factor 1000)"),
        ({"channels": (OWN, (1, 1, 1e3))}, "the displacement may be in m"),
        (
            {"channels": (OWN, (1, 1e-3, 1)), "stated": {"amplitude_mm": lambda A: ""}},
            "may be in m, not mm (factor 1000)",
        ),
        (
            {"channels": (OWN, (1e3, 1, 1)), "stated": {"frequency_Hz": lambda f: ""}},
            "may be in ms, not s (factor 0.001)",
        ),
        ({"stated": {"temperature_C": lambda T: T + 273.15}}, "is likely in K: 20 to 150 °C"),
        ({"stated": {"temperature_C": lambda T: 293.15}}, "is likely in K: 20 °C"),
        ({"stated": {"temperature_C": lambda T: 1.8 * T + 32}}, "is likely in °F: 20 to 150 °C"),
    ],
)
def test_a_unit_that_is_only_unlikely_is_told_everywhere(campaign, tmp_path, changes, told):
    tests = pc.read_campaign(campaign(**changes))
    assert any(told in remark for remark in tests.remarks)
    law = pc.identify(tests)
    law.save(tmp_path / "law.json")
    assert told in json.loads((tmp_path / "law.json").read_text(encoding="utf-8"))["data"]["warnings"][0]
    assert told in law.report(tmp_path / "law.html").read_text(encoding="utf-8")


def test_what_is_stated_far_off_is_told_without_powers_of_ten(campaign):
    (remark,) = pc.read_campaign(campaign(stated={"amplitude_mm": lambda A: A / 1900})).remarks
    assert "1900 times as much, in 8 of 8 runs" in remark


@pytest.mark.parametrize(("mean", "doubted"), [(0.0, True), (150.0, False)])
def test_what_bears_a_load_is_not_weak(tmp_path, mean, doubted):
    """A cylinder under pressure, whose seals rub with 10 N, bears 150 N: nothing says kN of it."""
    t = np.arange(300) / 100
    force = mean + 0.5 * np.sin(2 * np.pi * t) + 8 * np.tanh(10 * np.cos(2 * np.pi * t))
    runs = [WrittenRun({"run": "a", "temperature_C": 20.0}, Record(t, 5 * np.sin(2 * np.pi * t), force))]
    write_campaign(tmp_path / "c", iter(runs), name="c", notes="")
    assert any("may be in kN" in one for one in pc.read_campaign(tmp_path / "c").remarks) == doubted


@pytest.mark.parametrize(
    "changes",
    [
        {"temperature": lambda T: T + 1},
        {"stated": {"temperature_C": lambda T: 22.6 + 0.005 * T}},  # one room's, which differs from run to run
    ],
)
def test_what_is_right_is_not_doubted(campaign, changes):
    tests = pc.read_campaign(campaign(**changes))
    assert not tests.remarks
    assert "warnings" not in pc.identify(tests).to_dict()["data"]


@pytest.mark.parametrize(
    ("name", "factor", "columns"),
    [
        ("Load [kN]", 1e-3, 'force_N = { from = "Load [kN]" }'),
        ("Load [kN]", 1e-3, 'force_N = { from = "Load [kN]", factor = 1000 }'),
        ("Load [kN]", -1e-3, 'force_N = { from = "Load [kN]", factor = -1000 }'),
        ("Load (lbf)", 1 / 4.4482216152605, 'force_N = { from = "Load (lbf)" }'),
        ("Load [kgf]", 1 / 9.80665, 'force_N = { from = "Load [kgf]", factor = 9.81 }'),
        ("Load F", 1, 'force_N = { from = "Load F" }'),
        ("Load [V]", 1 / 200, 'force_N = { from = "Load [V]", factor = 200 }'),
    ],
)
def test_a_unit_in_a_columns_name_counts(campaign, name, factor, columns):
    folder = campaign((("time_s", "displacement_mm", name), (1, 1, factor)), columns=f"[columns]\n{columns}\n")
    run = pc.read_campaign(folder).tests.campaign.runs[0]
    np.testing.assert_allclose(run.record.force_N, loop(0.3, 1.0, 20.0).force, atol=2e-3)


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ('force_N = { from = "Load [kN]", factor = 1 }', "by 1000; got factor 1"),
        ('time_s = { from = "Time (ms)", factor = 1000 }', "by 0.001; got factor 1000"),
        ('force_N = { from = "a" }\ntime_s = { from = "a " }', "is taken for both time_s and force_N"),
        ('force_N = { from = "Weg [mm]" }', "is in mm, no unit of force"),
        ('force_N = { from = "Load [V]" }', "is in V, no unit of force"),
    ],
)
def test_a_factor_that_contradicts_a_name_is_refused(campaign, columns, told):
    with pytest.raises(pc.UserError) as refused:
        pc.read_campaign(campaign(columns=f"[columns]\n{columns}\n"))
    assert told in str(refused.value)
