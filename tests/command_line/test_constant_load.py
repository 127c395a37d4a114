"""A clamp that carries a weight: errors are told of the force that varies too, and the weight leaves causes causes."""

from __future__ import annotations

import gzip
import json
import shutil
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from few_effects import few_effects

import pipeclamp as pc

WEIGHT = 9810.0


@pytest.fixture(scope="module")
def hung(clamp_a: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundled campaign with a weight in every force."""
    folder = shutil.copytree(clamp_a, tmp_path_factory.mktemp("hung") / "hung")
    for path in (folder / "runs").iterdir():
        table = pl.read_csv(path).with_columns(pl.col("force_N") + WEIGHT)
        path.write_bytes(gzip.compress(table.write_csv().encode()))
    return folder


def answered(pipeclamp, command: str, law: Path, campaign: Path) -> tuple[dict[str, Any], str]:
    """Give a command's answer, and what it printed."""
    path = law.with_suffix(".answer")
    printed = pipeclamp(command, law, campaign, "--json", path).stdout
    return json.loads(path.read_text(encoding="utf-8")), printed


def test_a_constant_load_is_told_and_hides_no_cause(pipeclamp, hung, clamp_a, tmp_path):
    law, held, bare = tmp_path / "law.json", tmp_path / "held.json", tmp_path / "bare.json"
    lacking = pipeclamp("identify", hung, "-o", law).stdout
    assert (
        "most of the force is a constant load, which the law lacks: offset adds one that is the same in every run"
        in lacking
    )
    pipeclamp("add", law, "offset", hung, "--as", "part", "-o", held)

    pipeclamp("identify", clamp_a, "-o", bare)
    without, _ = answered(pipeclamp, "compare", bare, clamp_a)
    found, told = answered(pipeclamp, "compare", held, hung)
    varying = (1 - found["mean_share"]) ** 0.5
    assert without["mean_share"] < 1e-3
    assert found["nrmse"] / varying == pytest.approx(without["nrmse"], rel=0.02)
    assert f"of the rms of the rest the error is {found['nrmse'] / varying:.2%}" in told

    with few_effects(
        "damping_temperature", "contact_growth", "hardening", "loosening", "memory", "offset", "relaxation"
    ):
        answer = pc.diagnose(held, hung)
    assert (answer.verdict, answer.effects, answer.kind) == ("missing", ("damping_temperature",), "cause")
