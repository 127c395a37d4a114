"""What somebody does in a notebook: draw a run, look at tests of several specimens, hand answers on, mistype a name."""

import csv
import shutil

import numpy as np
import pytest
from cantilever import cantilever, shaken

import pipeclamp as pc


@pytest.fixture(scope="module")
def law(tests):
    return pc.identify(tests)


@pytest.fixture(scope="module")
def specimens(pipeclamp, tmp_path_factory):
    """A campaign of two specimens."""
    folder = tmp_path_factory.mktemp("specimens") / "two"
    plan = ("--amplitudes", "0.3,0.6,1", "--frequencies", "1,4", "--temperatures", "20,250", "--cycles", "3")
    pipeclamp("rig", "emwm2", "-o", folder, *plan, "--rate", "200", "--specimens", "2", "--specimen-scatter", "0.1")
    return folder


def test_a_runs_record_is_what_its_file_holds(small, tests):
    run = tests.to_frame()["run"][2]
    record = tests.record(run)
    with (small / "runs" / f"{run}.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert record.columns == list(rows[0])
    for name in record.columns:
        assert np.array_equal(record[name].to_numpy(), [float(row[name]) for row in rows])


def test_a_runs_loop_shows_the_error_of_the_law(tests, law):
    comparison = pc.compare(law, tests)
    worst = comparison.to_frame().sort("nrmse")[-1]
    loop = comparison.loop(worst["run"][0])
    y, force, computed = (loop[name].to_numpy() for name in ("displacement_mm", "force_N", "law_force_N"))
    assert y[0] == pytest.approx(worst["amplitude_mm"][0], rel=0.02)
    assert np.ptp(y) / 2 == pytest.approx(worst["amplitude_mm"][0], rel=0.02)
    error = np.sqrt(np.mean((force - computed) ** 2) / np.mean(force**2))
    assert error == pytest.approx(worst["nrmse"][0], rel=0.2)
    assert loop["velocity_mm_s"].max() == pytest.approx(
        2 * np.pi * worst["frequency_Hz"][0] * worst["amplitude_mm"][0], rel=0.05
    )


def test_a_run_that_there_is_none_of_is_told_with_those_that_there_are(tests, law):
    known = tests.to_frame()["run"][0]
    with pytest.raises(pc.UserError, match=f"'{known}x' is not known; did you mean '{known}'"):
        tests.record(f"{known}x")
    with pytest.raises(pc.UserError, match=f"'{known}x' is not known; did you mean '{known}'"):
        pc.compare(law, tests).loop(f"{known}x")


def test_metrics_have_no_record_and_no_loop():
    tables = pc.read_campaign("emwm2_tables")
    run = tables.to_frame()["run"][0]
    with pytest.raises(pc.UserError, match="metrics without records"):
        tables.record(run)
    with pytest.raises(pc.UserError, match="metrics without records"):
        pc.compare("emwm2", tables).loop(run)


def test_tests_say_of_how_many_specimens_they_are_and_where_temperatures_are_known(specimens, tmp_path):
    assert str(pc.read_campaign(specimens)).startswith("two: 24 runs, 2 specimens, A ")
    folder = shutil.copytree(specimens, tmp_path / "two")
    with (folder / "runs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows[:5]:
        row["temperature_C"] = ""
    with (folder / "runs.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    assert str(pc.read_campaign(folder)).splitlines()[0].endswith(" °C (19 of 24 runs)")


def test_laws_of_specimens_are_compared_as_they_come(specimens):
    laws = pc.identify_per(specimens, "specimen")
    compared = pc.compare_laws(laws, specimens).to_frame()
    assert compared["law"].to_list() == [law.name for law in laws.values()]


def test_all_conditions_that_a_force_needs_are_named_at_once(law):
    with pytest.raises(pc.UserError, match=r"follows A, T, f, which aren't given; expected A=..., T=..., f=..."):
        law.force(0.1, 1.0)
    with pytest.raises(pc.UserError, match=r"follows f, which isn't given; expected f=\.\.\."):
        law.force(0.1, 1.0, A=0.5, T=20.0)


def test_what_is_not_finite_is_told_by_value_and_place(law):
    with pytest.raises(pc.UserError, match="A: got nan; expected"):
        law.force(0.1, 1.0, A=np.nan, f=1.0, T=20.0)
    with pytest.raises(pc.UserError, match="y: got inf at index 1; expected"):
        law.force([0.1, np.inf], 1.0, A=0.5, f=1.0, T=20.0)


def test_an_amplitude_of_no_such_place_is_told_with_those_that_there_are(law, tmp_path):
    law.save(tmp_path / "law.json")
    (tmp_path / "pipe.toml").write_text(cantilever(0.02, 30.0), encoding="utf-8")
    system = shaken(amplitude_mm=0.5, frequency_Hz=3.0, acceleration_m_s2=1.0)
    (tmp_path / "system.toml").write_text(f'name = "shaken"\n{system}', encoding="utf-8")
    with pytest.raises(pc.UserError, match="clamp or probe 'clamp' is not known; did you mean 'clamp1'"):
        pc.cosim(tmp_path / "system.toml").amplitude("clamp")
