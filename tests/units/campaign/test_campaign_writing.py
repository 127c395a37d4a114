"""Campaigns that are written: any run's name, and all that its record holds, comes back."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, joined_runs, write_campaign
from pipeclamp_models.base.errors import UserError


def _row(name):
    return {"run": name, "amplitude_mm": 0.8, "frequency_Hz": 3.0, "temperature_C": 20.0}


@pytest.mark.parametrize("names", [("../../evil", "a/b"), ("con", "NUL"), ("a", "A"), ("0002", "a b"), ("µm: 夹",)])
def test_a_runs_name_may_be_anything(tmp_path, harmonic_record, names):
    records = [harmonic_record(phase=0.1 * number) for number in range(len(names))]
    runs = (WrittenRun(_row(name), record) for name, record in zip(names, records, strict=True))
    write_campaign(tmp_path / "c", runs, name="c", notes="")
    assert {path.name for path in tmp_path.iterdir()} == {"c"}
    read = {run.name: run.record for run in read_campaign(tmp_path / "c").runs}
    files = [path.name.casefold() for path in (tmp_path / "c" / "runs").iterdir()]
    assert len(set(files)) == len(names) and not {"con.csv", "nul.csv"} & set(files)
    for name, record in zip(names, records, strict=True):
        np.testing.assert_array_equal(read[name].force_N, record.force_N)


def test_the_temperature_of_a_record_is_kept_by_join(tmp_path, harmonic_record):
    plain = harmonic_record()
    warm = np.linspace(150.0, 160.0, len(plain.time_s))
    record = Record(plain.time_s, plain.displacement_mm, plain.force_N, warm)
    for name, shift in (("one", 0.0), ("two", 0.1)):
        shifted = Record(record.time_s, record.displacement_mm, record.force_N + shift, warm)
        write_campaign(tmp_path / name, iter([WrittenRun(_row("A"), shifted)]), name=name, notes="")
    both = [read_campaign(tmp_path / name) for name in ("one", "two")]
    write_campaign(tmp_path / "all", joined_runs(both), name="all", notes="")
    for run in read_campaign(tmp_path / "all").runs:
        np.testing.assert_array_equal(run.record.temperature_C, warm)


def test_a_condition_that_isn_t_known_of_a_run_stays_so_in_join(tmp_path, harmonic_record):
    for number, name in enumerate(("one", "two")):
        runs = [
            WrittenRun({**_row(run), "current_A": current}, harmonic_record(phase=number + 0.1 * place))
            for place, (run, current) in enumerate({"A": 1.5, "B": None}.items())
        ]
        write_campaign(tmp_path / name, iter(runs), name=name, notes="")
    both = [read_campaign(tmp_path / name) for name in ("one", "two")]
    write_campaign(tmp_path / "all", joined_runs(both), name="all", notes="")
    found = [run.setup.conditions["current_A"] for run in read_campaign(tmp_path / "all").runs]
    np.testing.assert_array_equal(found, [1.5, np.nan, 1.5, np.nan])


def test_a_record_that_is_there_twice_is_refused_by_join(tmp_path, harmonic_record):
    for name, run in (("one", "A"), ("two", "B")):
        write_campaign(tmp_path / name, iter([WrittenRun(_row(run), harmonic_record())]), name=name, notes="")
    both = [read_campaign(tmp_path / name) for name in ("one", "two")]
    with pytest.raises(UserError, match="run 'B' of two has the same record as run 'A' of one"):
        list(joined_runs(both))


def test_where_a_zero_drifted_the_mean_counts_for_nothing_in_joined_tests_either(tmp_path):
    """The drift is taken off what is written; nobody had been told, and the mean that it left counted as measured."""
    time = np.arange(0.0, 6.0, 0.005)
    y = 0.8 * np.sin(2 * np.pi * 1.0 * time)
    noise = np.random.default_rng(3)
    for name, drift in (("one", 80.0), ("two", 0.0)):
        force = (
            400.0 * y + 60.0 * np.cos(2 * np.pi * time) + drift * time / time[-1] + noise.normal(0.0, 1.0, len(time))
        )
        record = Record(time, y, force)
        write_campaign(
            tmp_path / name, iter([WrittenRun({"run": name, "amplitude_mm": 0.8}, record)]), name=name, notes=""
        )
    both = [read_campaign(tmp_path / name) for name in ("one", "two")]
    assert [run.mean_known for campaign in both for run in campaign.runs] == [False, True]
    write_campaign(tmp_path / "all", joined_runs(both), name="all", notes="")
    joined = read_campaign(tmp_path / "all")
    assert [run.mean_known for run in joined.runs] == [False, True]
    assert any("the mean force of 1 run isn't known, as is stated (one)" in remark for remark in joined.remarks)
