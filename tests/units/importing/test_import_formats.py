"""Each format, written by its own library: the same ten runs are the same campaign."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest
from exports import assert_same_campaign, loop, ten_runs
from format_writers import WRITERS

import pipeclamp as pc
from pipeclamp_identification.importing import reading
from pipeclamp_identification.importing.reading import known_formats, read_file


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
