"""Relaxation that only the coldest tests show, by its complex stiffness; over T as Williams, Landel and Ferry's."""

import numpy as np
import pytest
from few_effects import few_effects

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.diagnosis.diagnosed import diagnosed
from pipeclamp_identification.fitting.identify import identify, law_file
from pipeclamp_identification.fitting.joint.starts import kept
from pipeclamp_identification.workflow.change import add_effects
from pipeclamp_identification.workflow.on_records import RecordTests
from pipeclamp_models.law.file import Provenance
from pipeclamp_models.law.law import Structure

TEMPERATURES = (-40.0, -25.0, -10.0, 5.0, 20.0, 35.0)
FREQUENCIES = (0.1, 0.6, 4.0)
STIFFNESS, ARM, TIME = 200.0, 2000.0, 1e-4
"""N/mm, N/mm, s at 20 degC: a twentieth of the time below which no test at 20 degC tells an arm from a dashpot."""
C1, C2 = 8.86, 101.6
NOISE = 0.002


@pytest.fixture
def cold_tests(tmp_path):
    rng = np.random.default_rng(3)
    runs = []
    for temperature in TEMPERATURES:
        shift = 10 ** (-C1 * (temperature - 20) / (C2 + temperature - 20))
        for frequency in FREQUENCIES:
            turn = 2j * np.pi * frequency
            complex_stiffness = STIFFNESS + ARM * turn * TIME * shift / (1 + turn * TIME * shift)
            time = np.arange(600) / (150 * frequency)
            motion = np.exp(turn * time)
            force = (complex_stiffness * motion).imag
            force += rng.normal(0, NOISE * abs(complex_stiffness), time.size)
            row = {"run": f"{temperature:g}_{frequency:g}", "amplitude_mm": 1.0, "frequency_Hz": frequency}
            runs.append(WrittenRun(row | {"temperature_C": temperature}, Record(time, motion.imag, force)))
    write_campaign(tmp_path / "tests", iter(runs), name="cold", notes="")
    return read_campaign(tmp_path / "tests")


def test_the_arm_that_was_fitted_at_all_temperatures_is_found_at_its_own(cold_tests):
    file = law_file(identify(cold_tests), cold_tests, name="law", provenance=Provenance("test"))
    effects = ("relaxation", "relaxation_temperature")
    beside, found = add_effects(file, effects, RecordTests(cold_tests), provenance=Provenance("test"))
    assert beside.nrmse.after > 0.05
    assert found.nrmse.after < 1.2 * found.noise_nrmse
    assert found.after.coefficients["tau"].value == pytest.approx(TIME, rel=0.1)


def test_relaxation_that_takes_nothing_alone_is_named_with_what_moves_it(cold_tests):
    file = law_file(identify(cold_tests), cold_tests, name="law", provenance=Provenance("test"))
    with few_effects(
        "relaxation", "relaxation_temperature", "relaxation_spread", "damping_temperature", "stiffness_frequency",
        "memory", "hardening",
    ):  # fmt: skip
        found = diagnosed(file, cold_tests)
    assert (found.verdict, found.kind, found.effects) == ("missing", "cause", ("relaxation",)), found.headline()
    assert found.together == ("relaxation", "relaxation_temperature")


def test_one_motion_without_noise_at_all_temperatures_is_no_clipped_sensor(cold_tests):
    assert not cold_tests.left_out


def test_times_reach_further_where_the_temperature_brings_them_into_view():
    alone, warm = (
        {entry.name: entry for entry in Structure("power", effects).equations.parameters}["tau"]
        for effects in (("relaxation",), ("relaxation", "relaxation_temperature"))
    )
    assert warm.starts[: len(alone.starts)] == alone.starts
    assert len(warm.starts) == 3 * len(alone.starts)


def test_what_a_start_keeps_of_given_values():
    assert kept({"k": 1.0, "tau": 2.0}, {"k": 1.0, "tau": 3.0, "of_another_effect": 4.0}) == {"k"}
