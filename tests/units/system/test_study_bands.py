"""Studies with bands: each case's is that of its response, to first order."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from banded import banded

from pipeclamp.pages.system.study import study_sections
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_system.bands.band import steps_of
from pipeclamp_system.bands.response import response_bands
from pipeclamp_system.response.run import run_response
from pipeclamp_system.study.description import read_study
from pipeclamp_system.study.run import run_study

STUDY = """
system = "system.toml"
measure = "{measure}"
[vary]
"system.excitation.acceleration_m_s2" = [0.5, 1.0]
"""


def study(folder, measure):
    path = folder / "study.toml"
    path.write_text(STUDY.format(measure=measure), encoding="utf-8")
    return path


def test_the_band_of_a_peak_is_the_responses(tmp_path):
    path = banded(tmp_path, 1.0)
    read = read_study(study(tmp_path, "peak"), 95.0)
    frame = run_study(read, tmp_path / "study.parquet", 1)
    bands = response_bands(path, run_response(path), 95.0).curves[0].peaks
    row = frame.row(1, named=True)
    for name, peak in zip(("clamp1", "tip"), bands, strict=True):
        half = steps_of(95.0) * peak.amplitude.deviation
        assert row[f"{name}.s_high [mm]"] - row[f"{name}.s [mm]"] == pytest.approx(half, rel=1e-6)
        assert row[f"{name}.s [mm]"] - row[f"{name}.s_low [mm]"] == pytest.approx(half, rel=1e-6)
    sections = study_sections(read, frame)
    assert any("tip is least sure at" in line for line in sections[0].paragraphs)
    assert any(trace.name == "band" for trace in sections[1].figures[0].data)


def test_the_band_at_one_frequency_is_there(tmp_path):
    banded(tmp_path, 1.0)
    output = tmp_path / "study.parquet"
    frame = run_study(read_study(study(tmp_path, "steady"), 95.0), output, 1)
    half = (frame["tip.s_high [mm]"] - frame["tip.s [mm]"]).to_numpy()
    assert np.all(half > 0)
    assert np.all(half < frame["tip.s [mm]"].to_numpy())
    assert "tip.s_low [mm]" in pl.read_parquet(output).columns


def test_what_has_no_bands_is_refused(tmp_path):
    path = banded(tmp_path, 1.0)
    with pytest.raises(UsageError, match="'cosim', whose bands take an ensemble"):
        read_study(study(tmp_path, "cosim"), 95.0)
    with pytest.raises(UsageError, match=r"expected a number from 1 to 99\.9"):
        read_study(study(tmp_path, "peak"), 0.0)
    assert read_study(study(tmp_path, "peak"), 95.0).fingerprint != read_study(study(tmp_path, "peak")).fingerprint
    path.write_text(path.read_text(encoding="utf-8").replace("law.json", "emwm2"), encoding="utf-8")
    with pytest.raises(UserError, match="no clamp has a law that tells how sure it is"):
        read_study(study(tmp_path, "peak"), 95.0)
