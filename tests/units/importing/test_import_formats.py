"""Each format, written by its own library: the same ten runs are the same campaign."""

from __future__ import annotations

import datetime
import zipfile
from importlib.util import find_spec

import numpy as np
import pytest
from exports import assert_same_campaign, loop, ten_runs
from format_writers import WRITERS

import pipeclamp as pc
from pipeclamp_identification.importing import reading
from pipeclamp_identification.importing.reading import known_formats, read_file
from pipeclamp_models.base.tables import pl


@pytest.mark.parametrize("kind", WRITERS)
def test_every_format_gives_the_same_campaign(tmp_path, kind):
    writer = WRITERS[kind]
    for module in writer.modules:
        pytest.importorskip(module)
    (tmp_path / "exports").mkdir()
    runs = ten_runs()
    for run in runs:
        writer.write(tmp_path / "exports" / f"{run.name}{writer.ending}", run)
    found = pc.import_files(tmp_path / "exports", tmp_path / "campaign", pattern="T{temperature_C}")
    campaign = assert_same_campaign(
        tmp_path / "campaign", runs, force_step=writer.relative * 1e4, y_step=writer.relative * 10, t_step=1e-9
    )
    assert {run.setup.temperature_C for run in campaign.runs} == {20.0, 150.0}
    assert "Last" in found.to_dict()["columns"][f"{runs[0].name}{writer.ending}"]["force_N"]


@pytest.mark.parametrize("one", [one for one in known_formats() if one.module], ids=lambda one: one.name)
def test_a_missing_package_is_named_with_its_remedy(tmp_path, monkeypatch, one):
    heads = {"NI TDMS": b"TDSm", "ASAM MDF": b"MDF     ", "HDF5": b"\x89HDF\r\n\x1a\n", "MATLAB": b"MATLAB 5.0",
             "spreadsheet": b"PK\x03\x04", "universal file (58)": b"    -1\n    58\n"}  # fmt: skip
    path = tmp_path / f"a{one.suffixes[0]}"
    path.write_bytes(heads[one.name] + bytes(600))
    monkeypatch.setattr(reading, "find_spec", lambda name: None if name == one.module else find_spec(name))
    with pytest.raises(pc.UserError, match=rf"read by the package {one.package}.*pip install 'pipeclamp\[import\]'"):
        read_file(path)


def test_channels_of_different_rates_are_put_on_one_time(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    run = loop(0.5, 2.0, cycles=10)
    signal = asammdf.Signal
    with asammdf.MDF(version="4.10") as file:
        file.append([signal(run.y, run.time, name="Weg", unit="mm")])
        file.append([signal(run.force[::2] / 1e3, run.time[::2], name="Last", unit="kN")])
        file.save(tmp_path / "a.mf4")
    found = pc.import_files(tmp_path / "a.mf4", tmp_path / "c")
    assert "by straight lines: 'Last [kN]'" in found.found.imported.files[0].read_as
    record = found.tests().tests.campaign.runs[0].record
    np.testing.assert_allclose(record.displacement_mm, run.y[: len(record.time_s)], atol=1e-9)
    assert np.std(record.force_N - run.force[: len(record.time_s)]) < 10


def test_content_counts_before_the_ending(tmp_path):
    WRITERS["Parquet"].write(tmp_path / "a.parquet", loop())
    (tmp_path / "a.parquet").rename(tmp_path / "a.csv")
    assert read_file(tmp_path / "a.csv").format == "Parquet"
    (tmp_path / "b.tdms").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(pc.UserError, match="is no NI TDMS file, by its first bytes"):
        read_file(tmp_path / "b.tdms")


def test_a_stamp_that_is_missing_at_the_beginning_takes_no_other_along(tmp_path):
    run = loop(0.5, 2.0, cycles=10)
    stamps = [datetime.datetime(2024, 1, 1, 12) + datetime.timedelta(seconds=time) for time in run.time.tolist()]
    columns = {"time": [None, *stamps[1:]], "Weg [mm]": run.y, "Last [N]": run.force}
    pl.DataFrame(columns).write_parquet(tmp_path / "a.parquet")
    found = read_file(tmp_path / "a.parquet").tables[0].channels[0].values
    assert np.isnan(found[0])
    np.testing.assert_allclose(found[1:], run.time[1:] - run.time[1], atol=1e-5)


def test_a_tdms_file_that_breaks_off_is_told(tmp_path):
    """Of a half copy the force had half of its samples, the temperature none, and nothing was said."""
    pytest.importorskip("nptdms")
    run = loop(0.5, 2.0, cycles=8)
    WRITERS["TDMS"].write(tmp_path / "whole.tdms", run)
    whole = (tmp_path / "whole.tdms").read_bytes()
    samples = len(run.time)
    (tmp_path / "most.tdms").write_bytes(whole[: -8 * (samples // 4)])
    found = pc.import_files(tmp_path / "most.tdms", tmp_path / "c")
    assert f"most.tdms: the file breaks off: {samples - samples // 4} of {samples} samples are taken" in found.notes
    record = found.tests().tests.campaign.runs[0].record
    assert len(record.time_s) <= samples - samples // 4
    (tmp_path / "half.tdms").write_bytes(whole[: -8 * (samples + samples // 2)])
    with pytest.raises(pc.UserError, match=rf"breaks off: of 'Last' it holds none of {samples} samples; copy it again"):
        pc.import_files(tmp_path / "half.tdms", tmp_path / "d")
    assert not (tmp_path / "d").exists()


def test_a_universal_file_that_breaks_off_is_told(tmp_path):
    """A data set without its end isn't found: the file had been said to hold no channel of numbers."""
    pytest.importorskip("pyuff")
    WRITERS["UFF 58"].write(tmp_path / "a.uff", loop())
    whole = (tmp_path / "a.uff").read_bytes()
    for share in (0.2, 0.9):
        (tmp_path / "half.uff").write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(
            pc.UserError, match=r"half\.uff: breaks off within its last data set; export or copy it again"
        ):
            read_file(tmp_path / "half.uff")
    (tmp_path / "half.uff").write_bytes(whole + b"\r\n\x1a\0\0")
    assert read_file(tmp_path / "half.uff").tables


def test_an_archive_of_exports_is_to_be_unpacked(tmp_path):
    """It had been "no whole spreadsheet file (Cannot detect file format)"."""
    pytest.importorskip("python_calamine")
    with zipfile.ZipFile(tmp_path / "exports.zip", "w") as packed:
        packed.writestr("a.csv", "time_s,displacement_mm,force_N\n0,0,0\n")
    with pytest.raises(pc.UserError, match=r"is a ZIP archive of 'a\.csv', no spreadsheet; .* unpack it"):
        read_file(tmp_path / "exports.zip")
