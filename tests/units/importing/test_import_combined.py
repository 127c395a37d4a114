"""Channels that are made of several: of two sides the way between them, of two gauges the mean."""

from __future__ import annotations

import numpy as np
import pytest

import pipeclamp as pc
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_models.base.errors import UserError

TIME = np.arange(0, 2, 2e-3)
Y = 0.8 * np.sin(2 * np.pi * 5 * TIME)
TILT = 0.3 * np.sin(2 * np.pi * 5 * TIME + 1)


def write(folder, channels):
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
    file = write(tmp_path, channels)
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
    file = write(tmp_path, {"Top [mm]": Y, "Base [m]": TILT})
    with pytest.raises(UserError, match=told):
        pc.import_files(file, tmp_path / "tests", columns={"displacement": stated})
