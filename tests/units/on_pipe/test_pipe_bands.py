"""Bands of a model at sines that were measured: derivatives against models solved anew, and what lies outside."""

from __future__ import annotations

import numpy as np
import pytest
from banded import banded

from pipeclamp_identification.on_pipe.bands import pipe_bands, refuse_bands
from pipeclamp_identification.on_pipe.sines import compare_pipe
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import Covariance, read_law, write_law
from pipeclamp_system.bands.band import steps_of

FREQUENCIES = np.linspace(13.0, 22.0, 10)
MEASUREMENT = '[[probes]]\nname = "tip"\nposition_m = 3.0\nunit = "mm"\n[[responses]]\nfile = "sines.csv"\n'


def measured(folder, amplitudes):
    """Write a measurement of amplitudes at the tip, mm, under 1 m/s2."""
    folder.mkdir(exist_ok=True)
    (folder / "measurement.toml").write_text(MEASUREMENT, encoding="utf-8")
    rows = "".join(f"{f},1.0,{a}\n" for f, a in zip(FREQUENCIES, amplitudes, strict=True))
    text = "frequency_Hz,acceleration_m_s2,tip_amplitude\n" + rows
    (folder / "sines.csv").write_text(text, encoding="utf-8")
    return folder


def amplitude(path, folder):
    return np.abs(compare_pipe(path, folder).prediction.response[:, 0])


def test_the_band_is_as_wide_as_the_model_moves(tmp_path):
    """Of one parameter alone that isn't known, by its standard deviation."""
    path = banded(tmp_path, 1.0, spread=None)
    text = path.read_text(encoding="utf-8").replace("response = {", "response = { harmonics = 9,")
    path.write_text(text, encoding="utf-8")  # with the law moved their number would change too
    law, deviation = read_law(tmp_path / "law.json"), 0.5
    told = Covariance(names=("k10",), matrix=((deviation**2,),))
    write_law(law.model_copy(update={"covariance": told}), tmp_path / "law.json")
    folder = measured(tmp_path / "measured", np.ones(len(FREQUENCIES)))
    bands = pipe_bands(path, compare_pipe(path, folder), 95.0)
    sides = []
    for sign in (1, -1):
        entry = law.coefficients["k10"]
        moved = entry.model_copy(update={"value": entry.value + sign * deviation})
        changed = law.model_copy(update={"coefficients": {**law.coefficients, "k10": moved}})
        write_law(changed, tmp_path / "law.json")
        sides.append(amplitude(path, folder))
    half = steps_of(95.0) * np.abs(sides[0] - sides[1]) / 2
    told_half = (bands.high - bands.low)[:, 0] / 2
    assert told_half == pytest.approx(half, rel=0.03, abs=0.01 * half.max())


def test_what_lies_outside_is_counted(tmp_path):
    path = banded(tmp_path, 1.0)
    folder = measured(tmp_path / "measured", np.ones(len(FREQUENCIES)))
    own = 1e3 * amplitude(path, folder)
    held = pipe_bands(path, compare_pipe(path, measured(folder, own)), 95.0)
    assert held.share == 0.0
    off = own * np.where(np.arange(len(own)) < 3, 3.0, 1.0)
    bands = pipe_bands(path, compare_pipe(path, measured(folder, off)), 95.0)
    assert int(bands.outside.sum()) == 3
    assert "3 of 10 measured amplitudes (30%) lie outside the model's 95% band" in bands.words()[0]
    assert bands.answer().share_outside == pytest.approx(0.3)


def test_a_law_that_tells_nothing_is_refused_before_the_work(tmp_path):
    path = banded(tmp_path, 1.0)
    folder = measured(tmp_path / "measured", np.ones(len(FREQUENCIES)))
    path.write_text(path.read_text(encoding="utf-8").replace("law.json", "emwm2"), encoding="utf-8")
    with pytest.raises(UserError, match="no clamp has a law that tells how sure it is"):
        refuse_bands(path, folder, 95.0)
