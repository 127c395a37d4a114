"""Mean forces that a record doesn't show, as a piezoelectric cell's: stated, or told by the runs together.

The device is plain arithmetic here: a spring that is stiffer on one side, and a dashpot.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from pipeclamp_identification.campaign.reading import Campaign, read_campaign
from pipeclamp_identification.campaign.runs_table import meant_column
from pipeclamp_identification.workflow.change import add_effect
from pipeclamp_identification.workflow.joining import join_campaigns
from pipeclamp_identification.workflow.reading import read_tests
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.file import Provenance

K, C, UNEVEN = 80.0, 0.4, 12.0
"""N/mm, Ns/mm, N/mm2."""
NOISE = 0.15
AMPLITUDES, FREQUENCIES = (0.4, 0.8, 1.2), (1.0, 2.0, 4.0)


def force_of(y: np.ndarray, v: np.ndarray, uneven: float, rng: np.random.Generator) -> np.ndarray:
    return K * y + C * v + uneven * y**2 + NOISE * rng.standard_normal(len(y))


def write_runs(
    folder: Path, passes: Callable[[np.ndarray], np.ndarray], uneven: float = UNEVEN, free: bool = False,
    description: str = "", cell: str = "",
) -> Path:  # fmt: skip
    """Write a campaign whose force channel passes so much of each force; `cell` stands in column mean_force."""
    folder.mkdir()
    rng = np.random.default_rng(7)
    rows = []
    for A in AMPLITUDES:
        for f in FREQUENCIES:
            t = np.arange(0, 6 / f, 1 / (100 * f))
            y = A * (np.sin(2 * np.pi * f * t) + 0.004 * np.sin(4 * np.pi * f * t + 1))
            rows.append((f"A{A}_f{f}", t, y, f"sine,{A},{f}"))
    if free:
        t = np.arange(0, 6, 1 / 400)
        y = np.sin(np.pi * t / 6) ** 2 * (0.7 * np.sin(7 * t) + 0.4 * np.sin(16 * t))
        rows.append(("sway", t, y, "free,,"))
    for name, t, y, _ in rows:
        force = passes(force_of(y, np.gradient(y, t), uneven, rng))
        pl.DataFrame({"time_s": t, "displacement_mm": y, "force_N": force}).write_parquet(folder / f"{name}.parquet")
    table = "".join(f"{name},{name}.parquet,{stated},20,{cell}\n" for name, _, _, stated in rows)
    head = "run,file,motion,amplitude_mm,frequency_Hz,temperature_C,mean_force\n"
    (folder / "runs.csv").write_text(head + table, encoding="utf-8")
    (folder / "campaign.toml").write_text(f'name = "uneven"\n{description}', encoding="utf-8")
    return folder


def all_of(force: np.ndarray) -> np.ndarray:
    return force


def without_mean(force: np.ndarray) -> np.ndarray:
    return force - np.mean(force)


def told(campaign: Campaign) -> list[str]:
    return [words for words in campaign.remarks if "mean" in words]


def test_a_force_channel_that_passes_no_mean_is_told_and_its_means_dont_count(tmp_path):
    folder = write_runs(tmp_path / "tests", without_mean, free=True)
    tests = read_tests(folder)
    (words,) = told(tests.campaign)
    assert words.startswith("the force channel passes no mean, as a piezoelectric cell does: in all 9 runs")
    assert not any(run.mean_known for run in (*tests.campaign.runs, *tests.campaign.free))
    sines, made = tests.of_sines(), Provenance("test")
    law = sines.identify().file(name="law", provenance=made)
    found = sines.diagnose(law)
    assert (found.verdict, found.effects, found.kind) == ("missing", ("asymmetry",), "cause")
    better = add_effect(law, "asymmetry", sines, provenance=made).after
    (sway,) = tests.compare(better).free
    assert sway.adrift
    assert sway.nrmse < 0.01


@pytest.mark.parametrize(
    ("passes", "uneven", "description"),
    [
        (all_of, UNEVEN, ""),
        (without_mean, 0.0, ""),
        (lambda force: without_mean(force) + 25.0, UNEVEN, ""),
        (without_mean, UNEVEN, '[defaults]\nmean_force = "known"\n'),
    ],
    ids=["they are there", "nothing makes any", "a load that no end explains", "they are stated"],
)
def test_other_means_count(tmp_path, passes, uneven, description):
    campaign = read_campaign(write_runs(tmp_path / "tests", passes, uneven, description=description))
    assert told(campaign) == []
    assert all(run.mean_known for run in campaign.runs)


def test_means_that_are_stated_to_be_unknown_are_taken_off(tmp_path):
    campaign = read_campaign(write_runs(tmp_path / "tests", all_of, cell="unknown"))
    (words,) = told(campaign)
    assert words.startswith("the mean force of 9 runs isn't known, as is stated (A0.4_f1.0, ")
    for run in campaign.runs:
        assert not run.mean_known
        assert abs(np.mean(run.record.force_N[run.cycles.steady])) < 1e-9


def test_join_keeps_what_isnt_known(tmp_path):
    known, unknown = (
        write_runs(tmp_path / name, all_of, 2 * UNEVEN if cell else UNEVEN, cell=cell)
        for name, cell in (("one", ""), ("two", "unknown"))
    )
    join_campaigns([known, unknown], tmp_path / "both")
    joined = read_campaign(tmp_path / "both")
    assert [run.mean_known for run in joined.runs] == 9 * [True] + 9 * [False]


def test_another_word_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"column 'mean_force': got 'no'; .*expected one of known, unknown, or a blank"):
        read_campaign(write_runs(tmp_path / "tests", all_of, cell="no"))


def test_a_mean_of_something_else_is_a_condition():
    assert meant_column("mean_load_N") is None
