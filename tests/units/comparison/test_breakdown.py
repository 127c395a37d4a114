"""An error that is put into one place comes out there, and in no other."""

from __future__ import annotations

import numpy as np
import pytest

from pipeclamp_identification.comparison import breakdown
from pipeclamp_identification.comparison.concentration import (
    cycles_sentence,
    drift_sentence,
    farthest_off,
    harmonic_sentence,
    region,
)
from pipeclamp_identification.comparison.conditions import conditions_of
from pipeclamp_identification.comparison.densest_region import region_sentence
from pipeclamp_identification.comparison.sums import error_sums
from pipeclamp_identification.loops.loops import loops_of


def none(phase, cycle):
    return np.zeros_like(phase)


def in_loading(phase, cycle):
    return np.where(phase > np.pi, 10.0, 0.0)


def in_harmonic(order, part):
    return lambda phase, cycle: (10.0 * part * np.exp(1j * order * phase)).real


@pytest.fixture
def sums_of(harmonic_record, run_of, campaign_of, misfit_of):
    """Give a function that sums up known errors: one (record's options, run's options, error) a run."""

    def build(*cases, noise=0.0):
        runs = [run_of(harmonic_record(**record), f"run{row}", **run) for row, (record, run, _) in enumerate(cases)]
        campaign = campaign_of(*runs)
        loops = loops_of(campaign)
        misfits = tuple(misfit_of(run, error, noise) for run, (*_, error) in zip(runs, cases, strict=True))
        return error_sums(campaign, loops, misfits), conditions_of(campaign, loops)

    return build


def shares(parts):
    return {part.label: parts.share(part) for part in parts.parts if abs(parts.share(part)) > 1e-9}


@pytest.mark.parametrize("per_cycle", [40, 83.3, 500, 2000])
def test_an_error_in_loading_alone(sums_of, per_cycle):
    sums, _ = sums_of(({"rate": 3.0 * per_cycle}, {}, in_loading))
    assert shares(breakdown.by_branch(sums)) == {"loading": pytest.approx(1.0)}
    assert all(label.endswith("loading") and "unloading" not in label for label in shares(breakdown.by_place(sums)))
    phases = breakdown.along_loop(sums)
    assert [phases.share(part) > 0 for part in phases.parts] == [False] * 12 + [True] * 12
    # evenly spread over half the loop, the error there is 10 N of the run's rms force
    assert phases.parts[-1].nrmse == pytest.approx(10.0 / np.sqrt(sums[0].squared_force / sums[0].samples))


@pytest.mark.parametrize("start", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("per_cycle", [40, 500])
@pytest.mark.parametrize(
    ("order", "part", "label"),
    [(0, 1.0, "mean force"), (1, 1.0, "harmonic 1 in phase"), (3, 1j, "harmonic 3 in quadrature"),
     (4, -1.0, "harmonic 4 in phase")],
)  # fmt: skip
def test_an_error_in_one_harmonic_alone(
    harmonic_record, run_of, campaign_of, misfit_of, start, per_cycle, order, part, label
):
    """Wherever in the cycle the record starts."""
    run = run_of(harmonic_record(rate=3.0 * per_cycle, phase=start))
    misfit = misfit_of(run, lambda phase, cycle: in_harmonic(order, part)((phase + start) % (2 * np.pi), cycle))
    moved = type(misfit)(misfit.run, (misfit.phase + start) % (2 * np.pi), misfit.measured, misfit.computed, 0.0)
    campaign = campaign_of(run)
    parts = breakdown.by_harmonic(error_sums(campaign, loops_of(campaign), (moved,)))
    assert shares(parts)[label] == pytest.approx(1.0, abs=1e-6)


def test_an_error_in_late_cycles_alone(sums_of):
    sums, _ = sums_of(({"cycles": 8}, {}, lambda phase, cycle: np.where(cycle >= 6, 5.0, 0.0)))
    assert shares(breakdown.along_cycles(sums)) == {
        "cycle 7": pytest.approx(0.5, abs=0.01),
        "cycle 8": pytest.approx(0.5, abs=0.01),
    }
    assert (
        cycles_sentence(sums)
        == "By cycle, 100% of it lies from cycle 7 of the records on; spread evenly, it would be 25%."
    )


def test_many_cycles_are_grouped(sums_of):
    sums, _ = sums_of(({"cycles": 60, "rate": 120.0}, {}, in_loading))
    parts = breakdown.along_cycles(sums).parts
    assert len(parts) == breakdown.MOST_CYCLES_SINGLY
    assert parts[0].label == "cycles 1 to 5"
    assert cycles_sentence(sums) is None


def test_an_error_in_the_first_cycle_alone(sums_of):
    def settling(phase, cycle):
        return np.where(cycle == 0, 5.0, 0.0)

    sums, _ = sums_of(({"cycles": 4}, {}, settling), ({"cycles": 6}, {}, settling))
    assert cycles_sentence(sums) == (
        "By cycle, 100% of it lies up to cycle 1 of the records; spread evenly, it would be 20%."
    )


def test_an_error_in_one_specimen_alone(sums_of):
    cases = [({}, {"specimen": name}, in_loading if name == "S2" else none) for name in ("S1", "S2", "S3")]
    sums, conditions = sums_of(*cases)
    (specimen,) = [condition for condition in conditions if condition.varies]
    assert shares(breakdown.by_condition(sums, specimen)) == {"S2": pytest.approx(1.0)}
    found = region(sums, [specimen])
    assert found.words == ("on loading", "on specimen S2")
    assert found.share == pytest.approx(1.0)
    assert found.even == pytest.approx(1 / 6, rel=0.01)


def test_further_columns_are_conditions_and_those_that_stay_the_same_are_none(sums_of):
    cases = [
        ({}, {"conditions": {"current_A": current, "torque_Nm": 5.0}, "density_g_cm3": density}, none)
        for current, density in ((0.0, 2.2), (0.25, 2.2), (0.5, None))
    ]
    _, conditions = sums_of(*cases)
    varied = {
        condition.key: [level.label for level in condition.levels] for condition in conditions if condition.varies
    }
    assert varied == {"current_A": ["0", "0.25", "0.5"], "density_g_cm3": ["2.2", "not known"]}


def test_one_sentence_says_where_it_sits(sums_of):
    """Just after the reversals, on unloading, at the larger amplitudes; a little of it everywhere."""

    def just_after(phase, cycle):
        return np.where(phase < np.radians(30), 20.0, 0.0) + np.sin(40 * phase)

    cases = [
        ({"displacement": (0.0, A)}, {}, just_after if A > 0.7 else lambda phase, cycle: np.sin(40 * phase))
        for A in (0.2, 0.4, 0.8, 1.0)
    ]
    sums, conditions = sums_of(*cases)
    found = region(sums, [condition for condition in conditions if condition.varies])
    assert found.words == ("just after the reversals", "on unloading", "at A from 0.8 mm up")
    sentence = region_sentence(found, breakdown.along_loop(sums))
    assert sentence.endswith(
        "sits just after the reversals, on unloading, at A from 0.8 mm up; spread evenly, it would be 4%."
    )
    assert found.share > 0.9


def test_where_the_law_is_farthest_off_for_the_force_there_is_told(sums_of):
    """A law with a clearance had no force at all in the smallest loops, and the error of all runs said 8 %."""
    error = {0.2: 30.0, 0.4: 1.0, 0.8: 1.0, 1.0: 1.0}
    sums, conditions = sums_of(
        *(
            ({"displacement": (0.0, A)}, {}, lambda phase, cycle, off=off: off * np.cos(phase))
            for A, off in error.items()
        )
    )
    (at,) = [run for run in sums if run.squared_error == max(one.squared_error for one in sums)]
    worst = float(np.sqrt(at.squared_error / at.squared_force))
    told = farthest_off(sums, conditions, worst / 3)
    assert told.startswith(f"at A = 0.2 mm the law errs by {worst:.2%} of the force there (1 run)")
    assert farthest_off(sums, conditions, worst / 1.9) == ""
    assert farthest_off(sums, [], 0.0) == ""


def test_an_error_that_is_everywhere_alike_has_no_place(sums_of):
    sums, _ = sums_of(*[({}, {}, lambda phase, cycle: np.cos(40 * phase))] * 2)
    assert region(sums, ()) is None
    assert "No place or condition" in region_sentence(None, breakdown.along_loop(sums))


def test_an_error_that_is_scatter_is_said_to_be(sums_of):
    rng = np.random.default_rng(1)
    sums, _ = sums_of(({"cycles": 20}, {}, lambda phase, cycle: rng.standard_normal(len(phase))), noise=1.0)
    assert region(sums, ()) is None
    assert "is scatter" in region_sentence(None, breakdown.along_loop(sums))
    assert harmonic_sentence(breakdown.by_harmonic(sums)) is None


def test_scatter_stands_where_it_is(harmonic_record, run_of, campaign_of, misfit_of):
    """Three times the noise in the force while loading: so is the scatter along the loop."""
    rng = np.random.default_rng(2)
    record = harmonic_record(cycles=40)
    sigma = np.where(np.sin(2 * np.pi * 3.0 * record.time_s) < 0, 6.0, 2.0)
    record.force_N[:] += sigma * rng.standard_normal(len(sigma))
    campaign = campaign_of(run_of(record))
    loops = loops_of(campaign)
    misfit = misfit_of(campaign.runs[0], none, float(loops.noise_rms_N[0]))
    unloading, loading = breakdown.by_branch(error_sums(campaign, loops, (misfit,))).parts
    # half of 6667 samples, each in three differences: the variance is known to 4 % (one standard deviation)
    assert loading.squared_scatter == pytest.approx(36.0 * len(sigma) / 2, rel=0.12)
    assert unloading.squared_scatter == pytest.approx(4.0 * len(sigma) / 2, rel=0.12)


def test_scatter_of_harmonics_is_that_of_white_noise(harmonic_record, run_of, campaign_of, misfit_of):
    rng = np.random.default_rng(3)
    run = run_of(harmonic_record(cycles=60))
    sigma = 3.0
    misfit = misfit_of(run, lambda phase, cycle: sigma * rng.standard_normal(len(phase)), sigma)
    campaign = campaign_of(run)
    parts = breakdown.by_harmonic(error_sums(campaign, loops_of(campaign), (misfit,))).parts
    # each degree of freedom of each cycle holds one sample's variance
    assert np.mean([part.squared_scatter for part in parts[1:-1]]) == pytest.approx(60 * sigma**2, rel=0.1)


def test_drift_within_records_is_found_with_its_sign(sums_of):
    def softening(phase, cycle):
        return -0.02 * 2000.0 * (cycle / 4 - 0.5) * np.cos(phase)

    sums, _ = sums_of(({}, {}, softening), ({"frequency": 2.0}, {}, softening))
    found = breakdown.drift(sums)
    fundamental = abs(2000.0 + 400.0j)
    assert found.in_phase == pytest.approx(-0.02 * 2000.0 / fundamental, rel=1e-3)
    assert abs(found.in_quadrature) < 1e-5
    assert "in phase (stiffness)" in drift_sentence(found, 0.01)
    assert "damping" not in drift_sentence(found, 0.01)


def test_no_drift_is_no_sentence(sums_of):
    rng = np.random.default_rng(4)
    sums, _ = sums_of(({"cycles": 10}, {}, lambda phase, cycle: rng.standard_normal(len(phase))))
    assert drift_sentence(breakdown.drift(sums), 1e-3) is None


def test_a_single_cycle_has_no_scatter_that_could_be_known(sums_of):
    sums, _ = sums_of(({"cycles": 1}, {}, in_loading), noise=1.0)
    for parts in (breakdown.along_loop(sums), breakdown.by_harmonic(sums), breakdown.along_cycles(sums)):
        assert all(part.squared_scatter is None and part.noise_nrmse is None for part in parts.parts)
    assert breakdown.drift(sums) is None
    sentence = region_sentence(region(sums, ()), breakdown.along_loop(sums))
    assert sentence.startswith("100% of the squared error sits on loading")


def test_a_part_without_samples_has_no_error(sums_of):
    """Nine samples a cycle leave most of the cycle's 24 parts empty."""
    sums, _ = sums_of(({"rate": 27.0}, {}, in_loading))
    parts = breakdown.along_loop(sums).parts
    assert [part.nrmse is None for part in parts].count(False) == 9
    assert sum(part.squared_error for part in parts) == pytest.approx(sums[0].squared_error)
