"""Tests of a linear damper that thins when warm and whose spring softens, by its complex stiffness."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Structure

TEMPERATURES = (-10.0, 20.0, 50.0)
FREQUENCIES = (0.3, 1.5, 7.0)
AMPLITUDES = (0.5, 2.0)
BESIDE, SPRING, DASHPOT = 50.0, 400.0, 30.0
"""N/mm, N/mm, N s/mm at 20 degC."""
SOFTER, THINNER = -0.7, -1.5
"""Log changes of the spring and of the dashpot in 100 K."""
NOISE = 0.003


@pytest.fixture
def damper(tmp_path):
    rng = np.random.default_rng(3)
    runs = []
    for temperature in TEMPERATURES:
        warmer = (temperature - 20) / 100
        spring, dashpot = SPRING * np.exp(SOFTER * warmer), DASHPOT * np.exp(THINNER * warmer)
        for frequency in FREQUENCIES:
            turn = 2j * np.pi * frequency
            stiffness = BESIDE + 1 / (1 / spring + 1 / (turn * dashpot))
            for amplitude in AMPLITUDES:
                time = np.arange(600) / (150 * frequency)
                motion = amplitude * np.exp(turn * time)
                force = (stiffness * motion).imag + rng.normal(0, NOISE * abs(stiffness * amplitude), time.size)
                row = {"run": f"{amplitude:g}_{temperature:g}_{frequency:g}", "amplitude_mm": amplitude}
                row |= {"frequency_Hz": frequency, "temperature_C": temperature}
                runs.append(WrittenRun(row, Record(time, motion.imag, force)))
    write_campaign(tmp_path / "tests", iter(runs), name="damper", notes="")
    return read_campaign(tmp_path / "tests")


def test_a_damper_whose_spring_softens_is_followed(damper):
    identified = identify(damper, Structure("power", ("oil_damper", "damping_temperature")))
    file = law_file(identified, damper, name="law", provenance=Provenance("test"))
    assert file.fit.nrmse < 1.1 * file.fit.noise_nrmse
    assert file.coefficients["k_cT"].value == pytest.approx(SOFTER, abs=0.05)
    assert file.coefficients["c_T1"].value == pytest.approx(THINNER, abs=0.05)
