"""`response` and `cosim` with bands, as a user calls them."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest
from banded import banded


def test_the_command_and_its_columns(tmp_path, pipeclamp):
    path = banded(tmp_path, 4.0, hard=200.0)
    output, report = tmp_path / "r.csv", tmp_path / "r.html"
    done = pipeclamp("response", path, "-o", output, "--bands", "95", "--limit", "tip=0.01", "--report", report)
    assert "turns back, and a sweep jumps, at" in done.stdout
    assert "above 0.01 mm with a probability of more than 99.9%" in " ".join(done.stdout.split())
    table = pl.read_csv(output)
    told = table.filter(pl.col("clamp1.s_low [mm]").is_not_nan())
    assert len(told) > 0.8 * len(table)
    assert (told["clamp1.s_low [mm]"] <= told["clamp1.s_high [mm]"]).all()
    assert "95% bands" in report.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--bands", "0"], "expected a number from 1 to 99.9"),
        (["--bands", "nan"], "expected a number from 1 to 99.9"),
        (["--bands", "95", "--limit", "tip"], "expected a clamp or probe and mm"),
        (["--bands", "95", "--limit", "tip=-1"], "above 0 mm"),
        (["--bands", "95", "--limit", "top=1"], "clamp1, tip"),
        (["--limit", "tip=1"], "--bands 95"),
    ],
)
def test_what_cannot_serve_is_refused(tmp_path, refused, options, said):
    path = banded(tmp_path, 1.0)
    assert said in refused("response", path, "-o", tmp_path / "r.csv", *options, status=2)
    assert not (tmp_path / "r.csv").exists()


def test_a_law_that_tells_nothing_has_no_bands(tmp_path, refused):
    path = banded(tmp_path, 1.0)
    path.write_text(path.read_text(encoding="utf-8").replace("law.json", "emwm2"), encoding="utf-8")
    for command in ("cosim", "response"):
        told = refused(command, path, "-o", tmp_path / "c.csv", "--bands", "95")
        assert "no clamp has a law that tells how sure it is" in told


def test_a_run_in_time_has_bands(tmp_path, pipeclamp):
    path = banded(tmp_path, 1.0)
    output = tmp_path / "c.csv"
    done = pipeclamp("cosim", path, "-o", output, "--bands", "95")
    assert "bands of 32 runs with other laws" in done.stdout
    table = pl.read_csv(output)
    low, value, high = (table[f"clamp1.s{end} [m]"].to_numpy() for end in ("_low", "", "_high"))
    assert np.all(low <= value)
    assert np.all(value <= high)
    assert np.ptp(high - low) > 0
