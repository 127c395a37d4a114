"""A displacement that is made of other channels: integrated, or the difference, sum or mean of several."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.importing.samples.integrated import integrated
from pipeclamp_models.base.errors import UserError

K, C = 80.0, 0.05
"""N/mm, Ns/mm."""
HEADINGS = {
    "Beschleunigung [m/s²]": (2, 1e-3),
    "Acc [g]": (2, 1 / 9806.65),
    "Accel (m/s2)": (2, 1e-3),
    "Vibrometer [mm/s]": (1, 1.0),
    "Velocity [in/s]": (1, 1 / 25.4),
}
"""What a channel is called, how often its displacement was differentiated, and what makes its unit of mm/s or mm/s2."""
TIME = np.arange(0, 2, 2e-3)
Y = 0.8 * np.sin(2 * np.pi * 5 * TIME)
TILT = 0.3 * np.sin(2 * np.pi * 5 * TIME + 1)


def file_of(
    folder: Path, heading: str, motion: Callable[[np.ndarray], tuple[np.ndarray, ...]], time: np.ndarray, name: str
) -> Path:
    """Write what a test machine logs: with noise, and a zero of the rate that is off."""
    rng = np.random.default_rng(3)
    derivatives = motion(time)
    y, v = derivatives[:2]
    times, per_unit = HEADINGS[heading]
    rate = derivatives[times]
    rate = rate + np.std(rate) * (0.05 + 2e-3 * rng.standard_normal(len(time)))
    force = K * y + C * v + 0.1 * rng.standard_normal(len(time))
    folder.mkdir(exist_ok=True)
    table = pl.DataFrame({"Time [s]": time, heading: rate * per_unit, "Force [N]": force})
    table.write_csv(folder / f"{name}.csv")
    return folder


def sine(A: float, f: float) -> Callable[[np.ndarray], tuple[np.ndarray, ...]]:
    w = 2 * np.pi * f
    parts = ((A, 1, 0.4), (0.03 * A, 3, 1.0))

    def motion(t: np.ndarray) -> tuple[np.ndarray, ...]:
        return tuple(
            sum((size * (n * w) ** order * np.cos(n * w * t + lag + order * np.pi / 2) for size, n, lag in parts))
            for order in range(3)
        )

    return motion


def sweep(t: np.ndarray) -> tuple[np.ndarray, ...]:
    """Give a sine that becomes faster, from 3 to 20 Hz, and its derivatives."""
    w, dw = 2 * np.pi * (3 + 17 * t / t[-1]), 2 * np.pi * 17 / t[-1]
    phase = 2 * np.pi * (3 * t + 17 * t**2 / (2 * t[-1]))
    return np.sin(phase), w * np.cos(phase), dw * np.cos(phase) - w**2 * np.sin(phase)


@pytest.mark.parametrize("heading", HEADINGS)
def test_sines_are_integrated(tmp_path, heading):
    for A, f in ((0.2, 5.0), (0.5, 20.0), (1.0, 10.0)):
        file_of(tmp_path / "files", heading, sine(A, f), np.arange(0, 8.3 / f, 1 / (120 * f)), f"A{A}_f{f}")
    pc.import_files(tmp_path / "files", tmp_path / "tests", columns={"displacement": heading})
    amplitudes = sorted(run.amplitude_mm for run in read_campaign(tmp_path / "tests").runs)
    assert amplitudes == pytest.approx([0.2, 0.5, 1.0], rel=1e-3)
    law = pc.identify(tmp_path / "tests")
    assert law.values["k10"] == pytest.approx(K, rel=2e-3)


def test_another_motion_is_integrated():
    time = np.arange(0, 12, 1 / 500)
    y, v, a = sweep(time)
    noise = np.random.default_rng(3).standard_normal(len(time))
    for times, rate in ((1, v), (2, a)):
        found = integrated(Record(time, rate + np.std(rate) * (0.05 + 2e-3 * noise), K * y + C * v), times)
        assert np.array_equal(found.time_s, time)
        assert np.std((found.displacement_mm - y)[500:-500]) < 0.02 * np.std(y)


def test_what_can_be_integrated_is_said(tmp_path):
    folder = file_of(tmp_path / "files", "Acc [g]", sine(1.0, 5.0), np.arange(0, 2, 1e-3), "test")
    with pytest.raises(UserError, match=r"but 'Acc \[g\]' can be integrated to one; .*\n.*displacement=Acc \[g\]"):
        pc.import_files(folder, tmp_path / "tests")


def test_samples_of_an_acceleration_need_no_channel_of_time_to_be_integrated(tmp_path):
    (tmp_path / "a.csv").write_text("Acc [g];Load (N)\n" + "\n".join(f"{n % 7};{n % 5}" for n in range(50)))
    with pytest.raises(UserError, match=r"but 'Acc \[g\]' can be integrated to one"):
        pc.import_files(tmp_path / "a.csv", tmp_path / "tests", rate=100.0)


def test_without_a_time_nothing_is_integrated(tmp_path):
    folder = file_of(tmp_path / "files", "Acc [g]", sine(1.0, 5.0), np.arange(0, 2, 1e-3), "test")
    with pytest.raises(UserError, match="can't be integrated where time was not measured"):
        pc.import_files([folder], tmp_path / "tests", columns={"displacement": "Acc [g]", "time": "none"}, rate="none")


def write_table(folder, channels):
    table = {"Time [s]": TIME, **channels, "Load (N)": 40 * Y + 3 * np.cos(2 * np.pi * 5 * TIME)}
    rows = zip(*table.values(), strict=True)
    lines = [";".join(table), *(";".join(f"{value:.7f}" for value in row) for row in rows)]
    (folder / "test.csv").write_text("\n".join(lines), encoding="utf-8")
    return folder / "test.csv"


@pytest.mark.parametrize(
    ("channels", "stated"),
    [
        ({"Top [mm]": Y + TILT, "Base [mm]": TILT}, "Top - Base"),
        ({"Top [mm]": Y + TILT, "Base [mm]": TILT}, "Top [mm] - Base [mm]"),
        ({"Top": Y + TILT, "Base": TILT}, "Top - Base [mm]"),
        ({"Top": TILT, "Base": Y + TILT}, "-Top - Base [mm]"),
        ({"Top - left": Y + TILT, "Base": TILT}, "Top - left - Base [mm]"),
        ({"LVDT 1 (mm)": Y + TILT, "LVDT 2 (mm)": Y - TILT}, "mean(LVDT 1, LVDT 2)"),
        ({"LVDT 1 (in)": (Y + TILT) / 25.4, "LVDT 2 (in)": (Y - TILT) / 25.4}, "mean(LVDT 1 (in), LVDT 2 (in))"),
        ({"Top - Base [mm]": Y}, "Top - Base"),
        ({"a [mm]": Y, "b [mm]": 2 * TILT, "c [mm]": TILT, "d [mm]": TILT}, "a + b - c - d"),
    ],
)
def test_they_are_the_displacement(tmp_path, channels, stated):
    file = write_table(tmp_path, channels)
    found = pc.import_files(file, tmp_path / "tests", columns={"displacement": stated})
    (run,) = read_campaign(tmp_path / "tests").runs
    assert run.amplitude_mm == pytest.approx(0.8, rel=1e-3)
    assert not any("not used" in note for note in found.to_dict()["notes"])


@pytest.mark.parametrize(
    ("stated", "told"),
    [
        ("Top - Bottom", r"there is no channel 'Top - Bottom' .*there are 'Time \[s\]', 'Top \[mm\]', 'Base \[m\]'"),
        ("Top - Base", r"'Top \[mm\]' and 'Base \[m\]' are in different units; expected channels of one unit"),
    ],
)
def test_what_cant_be_made_is_told(tmp_path, stated, told):
    file = write_table(tmp_path, {"Top [mm]": Y, "Base [m]": TILT})
    with pytest.raises(UserError, match=told):
        pc.import_files(file, tmp_path / "tests", columns={"displacement": stated})
