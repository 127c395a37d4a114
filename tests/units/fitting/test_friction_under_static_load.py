"""Friction of what a preloaded spring presses, by its own stepping: stronger to one side, weaker to the other."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.diagnosis.objections import reservations
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Structure

STIFFNESS, LOAD, GROWTH, WAY = 100.0, 60.0, 12.0, 0.2
"""N/mm, slip force in the middle in N, its growth in N/mm, way until it slips in mm."""
NOISE = 0.005
POINTS, CYCLES = 400, 4


def loops_of(folder, force_of, amplitudes=(0.5, 1.0, 2.0, 4.0)):
    """Write and read loops of a device whose force along a displacement force_of gives."""
    rng = np.random.default_rng(7)
    runs = []
    for amplitude in amplitudes:
        for frequency in (0.5, 2.0):
            phase = np.arange(POINTS * (CYCLES + 1)) / POINTS
            y = amplitude * np.sin(2 * np.pi * phase)
            force = force_of(y)
            force = force + rng.normal(0, NOISE * np.std(force), y.size)
            row = {"run": f"{amplitude:g}_{frequency:g}", "amplitude_mm": amplitude, "frequency_Hz": frequency}
            settled = phase >= 1.0
            runs.append(WrittenRun(row, Record(phase[settled] / frequency, y[settled], force[settled])))
    write_campaign(folder / "tests", iter(runs), name="friction", notes="")
    return read_campaign(folder / "tests")


def wedge(y):
    share = np.zeros(y.size)
    for place, move in enumerate(np.diff(y), 1):
        share[place] = np.clip(share[place - 1] + move / WAY, -1.0, 1.0)
    return STIFFNESS * y + (LOAD + GROWTH * y) * share


def test_the_pressing_force_may_fall_to_one_side(tmp_path):
    loops = loops_of(tmp_path, wedge)
    identified = identify(loops, Structure("power", ("pressed_slip",)))
    file = law_file(identified, loops, name="law", provenance=Provenance("test"))
    assert file.fit.nrmse < 1.1 * file.fit.noise_nrmse
    assert file.coefficients["mu_p"].value == pytest.approx(GROWTH, rel=0.05)
    assert file.coefficients["mu_n"].value == pytest.approx(-GROWTH, rel=0.05)


def test_what_never_slips_is_no_slip(tmp_path):
    """A spring that is stiffer on one side acts as pressed friction that sticks, which had been called its cause."""
    loops = loops_of(tmp_path, lambda y: STIFFNESS * y + GROWTH * y**2, (1.0, 1.3, 1.6, 2.0))
    identified = identify(loops, Structure("power", ("pressed_slip",)))
    file = law_file(identified, loops, name="law", provenance=Provenance("test"))
    assert file.fit.nrmse > 2 * file.fit.noise_nrmse
    assert any(words.startswith("x_n ran into its bound") for words in reservations(("pressed_slip",), identified.fit))
