"""Friction of what a preloaded spring presses, by its own stepping: stronger to one side, weaker to the other."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Structure

STIFFNESS, LOAD, GROWTH, WAY = 100.0, 60.0, 12.0, 0.2
"""N/mm, slip force in the middle in N, its growth in N/mm, way until it slips in mm."""
NOISE = 0.005
POINTS, CYCLES = 400, 4


@pytest.fixture
def wedge(tmp_path):
    rng = np.random.default_rng(7)
    rows = ["run,file,amplitude_mm,frequency_Hz"]
    for amplitude in (0.5, 1.0, 2.0, 4.0):
        for frequency in (0.5, 2.0):
            phase = np.arange(POINTS * (CYCLES + 1)) / POINTS
            y = amplitude * np.sin(2 * np.pi * phase)
            share = np.zeros(y.size)
            for place, move in enumerate(np.diff(y), 1):
                share[place] = np.clip(share[place - 1] + move / WAY, -1.0, 1.0)
            force = STIFFNESS * y + (LOAD + GROWTH * y) * share
            force += rng.normal(0, NOISE * np.std(force), y.size)
            settled = phase >= 1.0
            name = f"{amplitude:g}_{frequency:g}.csv"
            table = np.column_stack([phase / frequency, y, force])[settled]
            np.savetxt(tmp_path / name, table, delimiter=",", header="time_s,displacement_mm,force_N", comments="")
            rows.append(f"{name},{name},{amplitude},{frequency}")
    (tmp_path / "runs.csv").write_text("\n".join(rows), encoding="utf-8")
    (tmp_path / "campaign.toml").write_text('name = "wedge"', encoding="utf-8")
    return read_campaign(tmp_path)


def test_the_pressing_force_may_fall_to_one_side(wedge):
    identified = identify(wedge, Structure("power", ("pressed_slip",)))
    file = law_file(identified, wedge, name="law", provenance=Provenance("test"))
    assert file.fit.nrmse < 1.1 * file.fit.noise_nrmse
    assert file.coefficients["mu_p"].value == pytest.approx(GROWTH, rel=0.05)
    assert file.coefficients["mu_n"].value == pytest.approx(-GROWTH, rel=0.05)
