"""Studies found in a campaign, and the published values beside them."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest

from pipeclamp.show.metrics import study_title
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.loops.one_condition import loops_to_draw, principal_variations, variations_of
from pipeclamp_identification.loops.published_rows import matching_row, published_rows


@pytest.fixture
def factorial(harmonic_record, run_of, campaign_of):
    """A campaign of 2 x 3 x 2 conditions with scattered settings, in no order, one temperature unknown."""
    plan = list(itertools.product((0.5, 0.8), (1.0, 3.0, 5.0), (20.0, 200.0)))
    order = np.random.default_rng(1).permutation(len(plan))
    runs = []
    for number in order:
        A, f, T = plan[number]
        record = harmonic_record(displacement=(0.0, A * (1 + 0.002 * number)), frequency=f)
        scattered = T + 0.3 * number - 1.5
        known = {"amplitude_mm": A, "frequency_Hz": f, "density_g_cm3": 2.286, "specimen": "EMWM2"}
        runs.append(run_of(record, f"{A:g}_{f:g}_{T:g}", temperature_C=scattered, **known))
    return campaign_of(*runs)


def test_each_quantity_is_studied_at_each_setting_of_the_others(factorial):
    studies = variations_of(factorial, loops_of(factorial))
    assert Counter(study.quantity for study in studies) == {"frequency_Hz": 4, "amplitude_mm": 6, "temperature_C": 6}
    for study in studies:
        assert list(study.values) == sorted(study.values)
        assert dict(study.held)["specimen"] == "EMWM2"
        if study.quantity == "frequency_Hz":
            assert study.values == (1.0, 3.0, 5.0)
            names = [factorial.runs[row].name.split("_") for row in study.rows]
            assert len({(A, T) for A, _, T in names}) == 1


def test_the_principal_studies_are_those_with_published_values(factorial):
    chosen = {study.quantity: study for study in principal_variations(variations_of(factorial, loops_of(factorial)))}
    assert dict(chosen["frequency_Hz"].held)["amplitude_mm"] == 0.8
    assert dict(chosen["temperature_C"].held)["frequency_Hz"] == 3.0
    assert [row.dissipated_energy_J for row in chosen["frequency_Hz"].published] == [0.9813, 0.9696, 0.9790]
    assert [row.max_elastic_energy_J for row in chosen["temperature_C"].published] == [0.6318, 0.5964]
    assert "density_g_cm3" not in chosen


def test_the_loops_of_a_study_are_drawn_from_its_runs(factorial):
    loops = loops_of(factorial)
    study = principal_variations(variations_of(factorial, loops))[0]
    drawn = loops_to_draw(loops, study, points=100)
    assert len(drawn) == 3
    for (y, force), row in zip(drawn, study.rows, strict=True):
        assert y.shape == force.shape == (100,)
        assert np.max(y) == pytest.approx(loops.amplitude_mm[row], rel=1e-3)


def test_a_density_study_lets_the_specimen_differ(harmonic_record, run_of, campaign_of):
    conditions = {"temperature_C": 20.0, "amplitude_mm": 0.8, "frequency_Hz": 3.0}
    runs = [
        run_of(harmonic_record(), name, specimen=name, density_g_cm3=density, **conditions)
        for name, density in (("EMWM3", 2.571), ("EMWM1", 2.0), ("EMWM2", 2.286))
    ]
    campaign = campaign_of(*runs)
    (study,) = variations_of(campaign, loops_of(campaign))
    assert study.quantity == "density_g_cm3"
    assert study.rows == (1, 2, 0)
    assert [row.dissipated_energy_J for row in study.published] == [0.4938, 0.9696, 1.2217]


def test_a_further_condition_is_studied_too(harmonic_record, run_of, campaign_of):
    runs = [run_of(harmonic_record(), f"{current}", conditions={"current_A": current}) for current in (1.0, 0.0, 0.5)]
    campaign = campaign_of(*runs)
    (study,) = variations_of(campaign, loops_of(campaign))
    assert (study.quantity, study.values) == ("current_A", (0.0, 0.5, 1.0))
    assert study_title(study) == "against current_A, at f 3 Hz, A 0.8 mm"


def test_other_clamps_are_not_compared_with_the_published_one(harmonic_record, run_of):
    conditions = {"amplitude_mm": 0.8, "frequency_Hz": 3.0, "temperature_C": 20.0}
    assert matching_row(run_of(harmonic_record(), specimen="mine", **conditions)) is None
    assert matching_row(run_of(harmonic_record(), specimen="mine", density_g_cm3=2.4, **conditions)) is None
    assert matching_row(run_of(harmonic_record(), specimen="EMWM2", **conditions)) is not None
    without = conditions | {"temperature_C": None}
    assert matching_row(run_of(harmonic_record(), specimen="EMWM2", **without)) is None


def test_the_published_rows_are_all_there():
    assert len(published_rows()) == 16
    assert {row.table for row in published_rows()} == {2, 3, 4, 5}
