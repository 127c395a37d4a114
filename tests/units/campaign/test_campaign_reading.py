"""Campaigns as docs/reference/campaign.md describes them, good and bad."""

from __future__ import annotations

import dataclasses
import gzip
import io
import itertools
import math
import re
import shutil
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.loops.one_condition import variations_of
from pipeclamp_models.base.errors import UserError

TABLE = "run,file,amplitude_mm,frequency_Hz,temperature_C\nA,runs/A.csv,0.8,3,20\n"


def _frame(record: Record, names=("time_s", "displacement_mm", "force_N")) -> pl.DataFrame:
    return pl.DataFrame(dict(zip(names, (record.time_s, record.displacement_mm, record.force_N), strict=True)))


def test_one_run_is_read_whole(campaign_folder):
    campaign = read_campaign(campaign_folder())
    (run,) = campaign.runs
    assert (campaign.name, run.name, run.amplitude_mm, run.setup.temperature_C) == ("small", "A", 0.8, 20.0)
    assert run.setup.specimen is None
    assert run.cycles.count == 5
    assert campaign.left_out == ()


def test_csv_gzip_and_parquet_hold_the_same(campaign_folder, harmonic_record, csv_text):
    text = csv_text(harmonic_record())
    parquet = io.BytesIO()
    pl.read_csv(text.encode()).write_parquet(parquet)
    table = "run,file\nA,runs/A.csv\nB,runs/B.csv.gz\nC,runs/C.parquet\n"
    records = {"runs/A.csv": text, "runs/B.csv.gz": gzip.compress(text.encode()), "runs/C.parquet": parquet.getvalue()}
    plain, zipped, columnar = read_campaign(campaign_folder(table=table, records=records)).runs
    for other in (zipped, columnar):
        np.testing.assert_array_equal(other.record.force_N, plain.record.force_N)
        np.testing.assert_array_equal(other.record.time_s, plain.record.time_s)


def test_a_test_machines_export_is_read_as_it_came(campaign_folder, harmonic_record):
    record = harmonic_record()
    export = _frame(record, ("Time [ms]", "Position [um]", "Load [kN]")) / pl.Series([1e-3, 1e-3, 1e3]).first()
    export = export.with_columns(pl.col("Load [kN]") * 1e-6, Operator=pl.lit("Smith"))
    description = (
        'name = "export"\n[columns]\ntime_s = { from = "Time [ms]", factor = 0.001 }\n'
        'displacement_mm = { from = "Position [um]", factor = 0.001 }\n'
        'force_N = { from = "Load [kN]", factor = 1000 }\n'
    )
    (run,) = read_campaign(campaign_folder(description, records={"runs/A.csv": export.write_csv()})).runs
    np.testing.assert_allclose(run.record.time_s, record.time_s, atol=1e-12)
    np.testing.assert_allclose(run.record.displacement_mm, record.displacement_mm, atol=1e-12)
    np.testing.assert_allclose(run.record.force_N, record.force_N, atol=1e-9)


def test_windows_line_ends_byte_order_mark_and_blanks_do_no_harm(campaign_folder, harmonic_record, csv_text):
    text = csv_text(harmonic_record())
    odd = b"\xef\xbb\xbf" + text.replace("s,displacement", "s, displacement").replace("\n", "\r\n").encode()
    table = "\ufeffrun,file\r\nA,runs\\A.csv\r\n\r\n"
    plain = read_campaign(campaign_folder(folder="plain")).runs[0]
    other = read_campaign(campaign_folder(table=table, records={"runs/A.csv": odd + b"\r\n\r\n"})).runs[0]
    np.testing.assert_array_equal(other.record.displacement_mm, plain.record.displacement_mm)


def test_defaults_fill_what_the_table_leaves_open(campaign_folder):
    description = 'name = "d"\n[defaults]\ntemperature_C = 80\nspecimen = "S1"\nbolt_torque_Nm = 5.5\n'
    (run,) = read_campaign(campaign_folder(description, TABLE.replace(",20\n", ",\n"))).runs
    assert (run.setup.temperature_C, run.setup.specimen, run.setup.conditions["bolt_torque_Nm"]) == (80.0, "S1", 5.5)
    (run,) = read_campaign(campaign_folder(description, folder="filled")).runs
    assert run.setup.temperature_C == 20.0


def test_further_numbers_are_conditions_and_further_texts_remarks(campaign_folder, harmonic_record, csv_text):
    table = "run,file,current_A,remark,empty,temperature_oil_C\nA,runs/A.csv,0.5,calm,,\nB,runs/B.csv,,windy,,\n"
    text = csv_text(harmonic_record())
    campaign = read_campaign(campaign_folder(table=table, records={"runs/A.csv": text, "runs/B.csv": text}))
    assert campaign.condition_columns == ("current_A",)
    assert campaign.runs[0].setup.conditions["current_A"] == 0.5
    assert math.isnan(campaign.runs[1].setup.conditions["current_A"])


def test_a_measured_temperature_goes_before_the_tables(campaign_folder, harmonic_record):
    record = harmonic_record()
    temperature = np.where(np.arange(len(record.time_s)) % 7 == 0, np.nan, 31.0)
    export = _frame(record).with_columns(temperature_C=temperature).write_csv()
    loops = loops_of(read_campaign(campaign_folder(records={"runs/A.csv": export})))
    assert loops.temperature_K[0] == pytest.approx(31.0 + 273.15)


def test_the_fingerprint_knows_the_content_not_the_place(campaign_folder, tmp_path):
    folder = campaign_folder()
    shutil.copytree(folder, tmp_path / "elsewhere")
    fingerprint = read_campaign(folder).fingerprint
    assert fingerprint.startswith("sha256:")
    assert len(fingerprint) == len("sha256:") + 64
    assert read_campaign(tmp_path / "elsewhere").fingerprint == fingerprint
    record = tmp_path / "elsewhere" / "runs" / "A.csv"
    record.write_bytes(record.read_bytes().replace(b"0.800000", b"0.800001"))
    assert read_campaign(tmp_path / "elsewhere").fingerprint != fingerprint


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ("", ["runs.csv", "is empty"]),
        ("run,file\n", ["runs.csv", "no row"]),
        ("file\nruns/A.csv\n", ["row 1", "'run'"]),
        ("run\nA\n", ["row 1", "'file'"]),
        ("run,file,file\nA,runs/A.csv,x\n", ["row 1", "'file'", "more than once"]),
        ("run,,file\nA,,runs/A.csv\n", ["row 1", "column 2"]),
        ("run,file\n,runs/A.csv\n", ["row 2", "'run'", "blank"]),
        ("run,file\nA,\n", ["row 2", "'file'", "blank"]),
        ("run,file\nA,runs/A.csv,3\n", ["row 2", "3 cells", "expected 2"]),
        ("run,file\nA,runs/A.csv\nA,runs/B.csv\n", ["row 3", "'run'", "'A'", "row 2"]),
        ("run,file\nA,runs/A.csv\nB,runs/A.csv\n", ["row 3", "'file'", "row 2"]),
        ("run,file\nA,../A.csv\n", ["row 2", "'../A.csv'", "inside the campaign's folder"]),
        ("run,file\nA,/tmp/A.csv\n", ["row 2", "inside the campaign's folder"]),
        ("run,file\nA,C:\\data\\A.csv\n", ["row 2", "inside the campaign's folder"]),
        ("run,file\nA,runs/A.xlsx\n", ["row 2", ".csv, .csv.gz, .parquet"]),
        ("run,file\nA,runs/missing.csv\n", ["row 2", "runs/missing.csv", "run 'A'"]),
        ("run,file,frequency_Hz\nA,runs/A.csv,fast\n", ["row 2", "'frequency_Hz'", "'fast'", "above 0 Hz"]),
        ("run,file,frequency_Hz\nA,runs/A.csv,0\n", ["row 2", "'frequency_Hz'", "'0'", "above 0 Hz"]),
        ("run,file,amplitude_mm\nA,runs/A.csv,-0.5\n", ["row 2", "'amplitude_mm'", "'-0.5'"]),
        ("run,file,amplitude_mm\nA,runs/A.csv,nan\n", ["row 2", "'amplitude_mm'", "'nan'", "blank"]),
        ("run,file,temperature_C\nA,runs/A.csv,-273.15\n", ["row 2", "'temperature_C'", "above -273.15 °C"]),
        ("run,file,first_cycle\nA,runs/A.csv,-1\n", ["row 2", "'first_cycle'", "0 or more"]),
        ("run,file,density_g_cm3\nA,runs/A.csv,1e999\n", ["row 2", "'density_g_cm3'", "'1e999'"]),
        ("run,file,current_A\nA,runs/A.csv,1\nB,runs/B.csv,one\n", ["row 3", "'current_A'", "'one'"]),
        ("run,file,Temperature_C\nA,runs/A.csv,20\n", ["'Temperature_C'", "'temperature_C'"]),
        ("run,file,temperature_K\nA,runs/A.csv,293\n", ["'temperature_K'", "'temperature_C'"]),
        ("run,file,temperature\nA,runs/A.csv,20\n", ["'temperature'", "'temperature_C'"]),
        ("run,file,Temperature [K]\nA,runs/A.csv,293\n", ["'Temperature [K]'", "'temperature_C'"]),
        ("run,file,density_kg_m3\nA,runs/A.csv,2286\n", ["'density_kg_m3'", "'density_g_cm3'"]),
        ("run,file,freq_Hz\nA,runs/A.csv,3\n", ["'freq_Hz'", "'frequency_Hz'"]),
        ("run,file,temprature_C\nA,runs/A.csv,3\n", ["'temprature_C'", "'temperature_C'"]),
        ('run,file\nA,"runs/A.csv\n', ["runs.csv", "no valid CSV"]),
    ],
)
def test_a_bad_table_is_one_error_that_names_the_place(campaign_folder, table, told):
    with pytest.raises(UserError) as error:
        read_campaign(campaign_folder(table=table))
    for words in told:
        assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("description", "told"),
    [
        ('notes = "x"\n', ["campaign.toml", "name"]),
        ('name = ""\n', ["campaign.toml", "name", "not blank"]),
        ('name = "x"\nnames = 1\n', ["'names'", "'name'"]),
        ('name = "x\n', ["campaign.toml", "TOML"]),
        ('name = "x"\n[defaults]\ntemperature_C = true\n', ["defaults.temperature_C", "True"]),
        ('name = "x"\n[defaults]\ntemperature_C = inf\n', ["defaults.temperature_C", "finite"]),
        ('name = "x"\n[defaults]\ndensity_gcm3 = 2.2\n', ["campaign.toml, [defaults]", "'density_gcm3'"]),
        ('name = "x"\n[columns]\nforce = { from = "F" }\n', ["columns", "'force'", "'force_N'"]),
        ('name = "x"\n[columns]\nforce_N = { from = "F", faktor = 2 }\n', ["columns.force_N", "'faktor'", "'factor'"]),
        ('name = "x"\n[columns]\nforce_N = { from = "F", factor = 0 }\n', ["columns.force_N.factor", "other than 0"]),
        ('name = "x"\n[columns]\nforce_N = "F"\n', ["columns.force_N", "from ="]),
        ('name = "x"\n[columns]\nforce_N = { from = "Load" }\n', ["A.csv", "'Load'", "force_N", "'displacement_mm'"]),
    ],
)
def test_a_bad_description_is_one_error_that_names_the_place(campaign_folder, description, told):
    with pytest.raises(UserError) as error:
        read_campaign(campaign_folder(description))
    for words in told:
        assert words in str(error.value)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", ["A.csv", "'time_s'", "its first row is empty"]),
        (b"time_s;displacement_mm;force_N\n0;1;2\n", ["'time_s;displacement_mm;force_N'", "comma-separated"]),
        (b"time_s,displacement_mm,force_N\n0,1,2\n0.1,zero,2\n", ["row 3", "'displacement_mm'", "'zero'", "number"]),
        (b"time_s,displacement_mm,force_N\ns,mm,N\n0,1,2\n", ["row 2", "'time_s'", "'s'", "number"]),
        (b"time_s,displacement_mm,force_N\n0,1,2\n0,1,1,5\n", ["row 3", "4 cells", "expected 3"]),
        (b"time_s,displacement_mm,force_N,force_N\n0,1,2,3\n", ["2 columns 'force_N'"]),
        ("time_s,displacement_mm,Kraft_\xe4\n".encode("latin-1"), ["row 1", "UTF-8"]),
    ],
)
def test_a_bad_record_is_one_error_that_names_the_place(campaign_folder, content, told):
    with pytest.raises(UserError) as error:
        read_campaign(campaign_folder(records={"runs/A.csv": content}))
    for words in ["A.csv", *told]:
        assert words in str(error.value)


@pytest.mark.parametrize(("name", "words"), [("A.csv.gz", "gzip"), ("A.parquet", "Parquet")])
def test_a_broken_file_is_an_error_that_names_it(campaign_folder, harmonic_record, csv_text, name, words):
    whole = gzip.compress(csv_text(harmonic_record()).encode())
    table = f"run,file\nA,runs/{name}\n"
    with pytest.raises(UserError, match=f"{name}.*{words}"):
        read_campaign(campaign_folder(table=table, records={f"runs/{name}": whole[: len(whole) // 2]}))


def test_a_parquet_column_of_texts_is_an_error(campaign_folder):
    content = io.BytesIO()
    pl.DataFrame({"time_s": ["a"], "displacement_mm": [1.0], "force_N": [1.0]}).write_parquet(content)
    table, records = "run,file\nA,runs/A.parquet\n", {"runs/A.parquet": content.getvalue()}
    with pytest.raises(UserError, match=r"'time_s'.*numbers"):
        read_campaign(campaign_folder(table=table, records=records))


@pytest.mark.parametrize("missing", ["campaign.toml", "runs.csv"])
def test_a_missing_file_is_an_error_that_names_it(campaign_folder, missing):
    folder = campaign_folder()
    (folder / missing).unlink()
    with pytest.raises(UserError, match=missing):
        read_campaign(folder)


def test_the_folder_that_one_is_in_may_be_no_campaign(tmp_path, monkeypatch):
    (tmp_path / "exports").mkdir()
    (tmp_path / "exports" / "a.csv").write_text("", encoding="utf-8")
    monkeypatch.chdir(tmp_path / "exports")
    with pytest.raises(UserError) as failure:
        read_campaign(Path())
    assert "no campaign.toml" in str(failure.value)
    assert str(failure.value).endswith(f"pipeclamp import . -o {Path('../exports_campaign')}")


def test_a_missing_folder_is_an_error_that_names_it(tmp_path):
    with pytest.raises(UserError, match="nowhere"):
        read_campaign(tmp_path / "nowhere")


def _faulty(record: Record, fault: str) -> Record:
    t, y, force = record.time_s.copy(), record.displacement_mm.copy(), record.force_N.copy()
    match fault:
        case "no full cycle":
            return Record(t[:150], y[:150], force[:150])
        case "constant displacement":
            return Record(t, np.full_like(y, 0.25), force)
        case "constant displacement but for noise":
            return Record(t, 1e-4 * np.random.default_rng(0).normal(size=len(y)), force)
        case "non-finite samples: 1 in force_N, the first in row 12":
            force[10] = np.nan
        case "non-finite samples: 2 in displacement_mm, the first in row 22":
            y[20:22] = np.inf
        case "clipped sensor: force_N":
            force = np.minimum(force, 0.9 * np.max(force))
        case "clipped sensor: displacement_mm":
            y = np.maximum(y, 0.97 * np.min(y))
        case "its force has the wrong sign: stiffness -2500 N/mm":
            force = -force
        case "time goes back in row 103":
            t[101:] -= 0.05
        case "too few samples":
            return Record(t[::30], y[::30], force[::30])
        case "a gap of":
            keep = np.r_[0:200, 320 : len(t)]
            return Record(t[keep], y[keep], force[keep])
        case "no full cycle: the record has no samples":
            return Record(t[:0], y[:0], force[:0])
    return Record(t, y, force)


FAULTS = [
    "no full cycle",
    "constant displacement",
    "constant displacement but for noise",
    "non-finite samples: 1 in force_N, the first in row 12",
    "non-finite samples: 2 in displacement_mm, the first in row 22",
    "clipped sensor: force_N",
    "clipped sensor: displacement_mm",
    "its force has the wrong sign: stiffness -2500 N/mm",
    "time goes back in row 103",
    "too few samples",
    "a gap of",
    "no full cycle: the record has no samples",
]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_run_that_cannot_be_used_is_left_out_with_its_reason(campaign_folder, harmonic_record, csv_text, fault):
    record = harmonic_record()
    table = "run,file\ngood,runs/A.csv\nbad,runs/B.csv\n"
    records = {"runs/A.csv": csv_text(record), "runs/B.csv": csv_text(_faulty(record, fault))}
    folder = campaign_folder(table=table, records=records)
    campaign = read_campaign(folder)
    assert [run.name for run in campaign.runs] == ["good"]
    (left_out,) = campaign.left_out
    assert left_out.run == "bad"
    assert left_out.reason.startswith(fault)
    assert "'bad'" in str(left_out)
    with pytest.raises(UserError) as error:
        read_campaign(folder, strict=True)
    assert "'bad'" in str(error.value)
    assert fault in str(error.value)


@pytest.mark.parametrize("force", [2000.0 - 40.0j, -2000.0 + 400.0j], ids=["late", "inertia"])
def test_a_delay_or_inertia_is_no_reversed_sign(campaign_folder, harmonic_record, csv_text, force):
    folder = campaign_folder(records={"runs/A.csv": csv_text(harmonic_record(force=(0.0, force)))})
    assert len(read_campaign(folder).runs) == 1


@pytest.fixture
def campaign_of_forces(campaign_folder, harmonic_record, csv_text):
    """Give a function that writes a campaign of runs whose force is the usual one times a factor each."""

    def write(*factors, amplitudes=None):
        names = [f"r{number}" for number in range(len(factors))]
        record = harmonic_record()
        scaled = [Record(record.time_s, record.displacement_mm, factor * record.force_N) for factor in factors]
        stated = amplitudes or [0.8] * len(factors)
        rows = [f"{name},runs/{name}.csv,{A}\n" for name, A in zip(names, stated, strict=True)]
        records = {f"runs/{name}.csv": csv_text(one) for name, one in zip(names, scaled, strict=True)}
        return campaign_folder(table="run,file,amplitude_mm\n" + "".join(rows), records=records)

    return write


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_run_in_other_units_is_left_out_with_its_reason(campaign_of_forces, factor):
    campaign = read_campaign(campaign_of_forces(1.0, 1.3, factor, 0.7))
    (left_out,) = campaign.left_out
    shown, usual = re.findall(r"([0-9.e+]+) N/mm", left_out.reason)
    assert left_out.run == "r2"
    assert (float(shown), float(usual)) == pytest.approx((2549.5 * factor, 2549.5), rel=1e-3)
    assert "check the units" in left_out.reason


@pytest.mark.parametrize("factors", [(1.0, 0.2, 0.04, 0.008, 0.002), (1.0, 1e-3), (1.0, 1.3, 0.03)])
def test_a_wide_range_of_stiffness_is_no_mistake_of_units(campaign_of_forces, factors):
    assert read_campaign(campaign_of_forces(*factors)).left_out == ()


def test_what_the_records_show_goes_before_the_table(campaign_of_forces):
    campaign = read_campaign(campaign_of_forces(1.0, 1.3, 0.7, amplitudes=[1.6, 0.78, 1.6]))
    assert [run.amplitude_mm for run in campaign.runs] == [None, 0.78, None]
    (remark,) = campaign.remarks
    for words in ("amplitude_mm in runs.csv is 1.6", "show 0.8", "2 of 3 runs (r0, r2)", "peak to peak?"):
        assert words in remark


def test_a_blank_cell_is_a_missing_sample(campaign_folder, harmonic_record, csv_text):
    lines = csv_text(harmonic_record()).splitlines()
    lines[40] = lines[40].rsplit(",", 1)[0] + ","
    table = "run,file\ngood,runs/A.csv\nbad,runs/B.csv\n"
    records = {"runs/A.csv": csv_text(harmonic_record()), "runs/B.csv": "\n".join(lines)}
    campaign = read_campaign(campaign_folder(table=table, records=records))
    assert campaign.left_out[0].reason == "non-finite samples: 1 in force_N, the first in row 41"


def test_no_usable_run_at_all_is_an_error(campaign_folder, harmonic_record, csv_text):
    with pytest.raises(UserError, match="1 of 1 runs can't be used"):
        read_campaign(campaign_folder(records={"runs/A.csv": csv_text(_faulty(harmonic_record(), FAULTS[0]))}))


@pytest.mark.parametrize("quantum", [0.002, 0.01, 0.05])
@pytest.mark.parametrize("phase", [0.0, 0.4, 1.1])
def test_coarse_quantisation_is_no_clipping(harmonic_record, run_of, quantum, phase):
    record = harmonic_record(frequency=0.5, rate=2500.0, phase=phase)
    y, force = record.displacement_mm, record.force_N
    coarse = Record(record.time_s, quantum * np.round(y / quantum), 2000 * quantum * np.round(force / (2000 * quantum)))
    assert run_of(coarse).cycles.count == 5


def test_a_temperature_that_records_alone_tell_counts_as_a_stated_one(campaign_folder, harmonic_record):
    """Stiffness and damping that fell with it, from run to run, had passed for the gain of a sensor that drifts."""
    stated, measured, records = "run,file,temperature_C\n", "run,file\n", {}
    for number, (T, A) in enumerate(itertools.product((20.0, 60.0, 100.0, 140.0), (0.2, 0.5, 1.0))):
        force = (293.15 / (T + 273.15)) ** 1.2 * (1500 + 300j) * A
        record = harmonic_record((0.0, A), (0.0, force), frequency=2.0, rate=400.0)
        noise = np.random.default_rng(number).standard_normal(len(record.time_s))
        channels = record.time_s, record.displacement_mm, record.force_N + 0.1 * noise
        rows = "".join(
            f"{t:.6f},{y:.6f},{F:.4f},{T + 0.2 * np.sin(t):.3f}\n" for t, y, F in zip(*channels, strict=True)
        )
        records[f"runs/{number}.csv"] = f"time_s,displacement_mm,force_N,temperature_C\n{rows}"
        stated += f"{number},runs/{number}.csv,{T:g}\n"
        measured += f"{number},runs/{number}.csv\n"
    both = [
        read_campaign(campaign_folder(table=table, records=records, folder=name))
        for name, table in (("stated", stated), ("measured", measured))
    ]
    assert [campaign.faults for campaign in both] == [(), ()]
    studies = [variations_of(campaign, loops_of(campaign)) for campaign in both]
    assert [(one.quantity, one.rows) for one in studies[0]] == [(one.quantity, one.rows) for one in studies[1]]
    assert both[1].runs[4].setup.temperature_C == pytest.approx(60.0, abs=0.2)


def test_a_time_in_milliseconds_from_1970_is_told_as_such(campaign_folder, harmonic_record, csv_text):
    """Such a record had been called impossible."""
    record = harmonic_record(start=1_770_000_000.0)
    made = dataclasses.replace(record, time_s=1000 * record.time_s)
    (doubt,) = read_campaign(
        campaign_folder(records={"runs/A.csv": csv_text(made)}, table="run,file\nA,runs/A.csv\n")
    ).doubts
    assert doubt.startswith("the time may be in ms, not s (factor 0.001)")
