"""Whatever test is proposed keeps the rig's limits over its whole motion; its drive signal comes back from its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeclamp_identification.campaign.drive import Drive, DrivePlan, Profile, drive_content, read_drive
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.plan import driven
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.diagnosis.further_test.limits import (
    Limits,
    drivable,
    limits_words,
    parse_limits,
    stated_levels,
)
from pipeclamp_identification.diagnosis.further_test.next_test import Proposal, next_test
from pipeclamp_identification.diagnosis.further_test.outlook import PROFILES, deviations_of
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Structure

HAIR = 1e-6


def positive(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(np.log(low), np.log(high)).map(lambda value: float(np.exp(value)))


def ranges(low: float, high: float) -> st.SearchStrategy[tuple[float, float]]:
    return st.tuples(positive(low, high), positive(low, high)).map(lambda ends: (min(ends), max(ends)))


PROFILE = st.one_of(
    st.sampled_from(list(PROFILES.values())),
    st.tuples(st.integers(2, 12), st.floats(0.05, 0.6)).map(lambda tone: Profile("two tones", ((1, 1.0), tone))),
)
LIMITS = st.builds(
    Limits, ranges(0.05, 5.0), ranges(0.2, 40.0), st.just((20.0, 20.0)), st.one_of(st.just(np.inf), positive(1.0, 1e3)),
    st.one_of(st.just(np.inf), positive(100.0, 1e4)),
)  # fmt: skip


def breaks(limits: Limits, plan: DrivePlan) -> list[str]:
    """Name the limits that the samples of a plan's drive signal break, a hair apart."""
    drive = plan.signal()
    shown = {
        "displacement": float(np.max(np.abs(drive.displacement_mm))) / limits.amplitude[1],
        "velocity": float(np.max(np.abs(np.gradient(drive.displacement_mm, drive.time_s)))) / limits.velocity,
        "highest frequency": plan.profile.highest_order * plan.frequency_Hz / limits.frequency[1],
        "lowest frequency": limits.frequency[0] / plan.frequency_Hz,
        "amplitude": limits.amplitude[0] / plan.amplitude_mm,
    }
    return [name for name, share in shown.items() if share > 1 + HAIR]


@given(limits=LIMITS, profile=PROFILE, levels=st.lists(positive(1e-3, 1e2), min_size=1, max_size=5))
@settings(max_examples=150, deadline=None)
def test_what_can_be_driven_keeps_all_limits(limits: Limits, profile: Profile, levels: list[float]):
    A, f = drivable(profile, np.array(levels), np.array(levels[::-1]), limits)
    for amplitude, frequency in zip(A[-3:], f[-3:], strict=True):
        assert breaks(limits, DrivePlan(profile, float(amplitude), float(frequency))) == []


@given(
    difference=st.lists(st.floats(-1e3, 1e3), min_size=5, max_size=5),
    doubt=st.lists(st.floats(-1.0, 1.0), min_size=10, max_size=10),
    scale=st.sampled_from([1e-3, 1.0, 1e3]),
)
def test_a_distance_is_that_of_noise_and_doubt(difference: list[float], doubt: list[float], scale: float):
    one, ways = np.array(difference)[None, :, None], scale * np.array(doubt).reshape(1, 5, 2)
    squared = one[0, :, 0] @ np.linalg.solve(np.eye(5) + ways[0] @ ways[0].T, one[0, :, 0])
    assert deviations_of(one, ways)[0] == pytest.approx(np.sqrt(max(squared, 0.0)), rel=1e-6, abs=1e-6)


def test_doubt_beyond_measure_takes_its_direction_alone():
    """1e12 times the noise: summed with it, no matrix that can be inverted in double precision."""
    across, along = np.eye(5)[None, :, :1], np.eye(5)[None, :, 1:2]
    doubt = 1e12 * np.concatenate([along, along], axis=2)
    assert deviations_of(across + along, doubt)[0] == pytest.approx(1.0)


@given(ends=ranges(1e-3, 1e3), level=positive(1e-4, 1e4))
def test_levels_are_what_is_said_and_lie_within(ends: tuple[float, float], level: float):
    (said,) = stated_levels(np.array([level]), *ends)
    assert ends[0] * (1 - 1e-8) <= said <= ends[1] * (1 + 1e-8)
    if ends[1] > 1.02 * ends[0]:
        assert float(f"{said:.3g}") == pytest.approx(said, rel=1e-12)


@pytest.mark.parametrize("celsius", [-40.0, -29.97, -0.001, 0.0, 23.0])
def test_one_temperature_is_a_level_below_zero_too(celsius: float):
    levels = stated_levels(np.linspace(celsius, celsius, 3), celsius, celsius)
    np.testing.assert_allclose(levels, [celsius], rtol=1e-9)
    assert len(stated_levels(np.array([celsius]), celsius + 1.0, celsius)) == 0


@given(limits=LIMITS)
def test_limits_are_read_as_they_are_said(limits: Limits):
    words = limits_words(limits)
    assert limits_words(parse_limits(words)) == words


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    """An ambiguous diagnosis of a campaign at two neighbouring frequencies."""
    folder = tmp_path_factory.mktemp("limits") / "narrow"
    plan = Plan((0.3, 0.6, 1.0), (3.0, 4.0), (20.0,), cycles=3.0, rate=240.0, force_noise=8.0)
    write_campaign(folder, virtual_runs(law_of(open_law("emwm2")), plan), name="narrow", notes="")
    return diagnose(Structure("power"), read_campaign(folder))


@given(limits=LIMITS, choice=st.randoms(use_true_random=False), several=st.integers(2, 3))
@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
def test_whatever_is_proposed_keeps_all_limits(diagnosis, limits, choice, several):
    """Of any candidates, in any rig."""
    names = [candidate.effects[0] for candidate in diagnosis.candidates]
    rivals = tuple(choice.sample(names, several))
    found = next_test(replace(diagnosis, found=replace(diagnosis.found, verdict="ambiguous", effects=rivals)), limits)
    assert found is not None
    if isinstance(found, Proposal):
        assert breaks(limits, found.plan) == []
        assert np.max(np.abs(found.forces)) <= limits.force * (1 + HAIR)
        assert found.temperature_C == pytest.approx(20.0)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("drive")


@given(
    profile=PROFILE,
    amplitude=positive(0.01, 5.0),
    frequency=positive(0.2, 50.0),
    suffix=st.sampled_from([".csv", ".parquet"]),
)
@settings(max_examples=25, deadline=None)
def test_a_drive_signal_comes_back_from_its_file(scratch, profile, amplitude, frequency, suffix):
    path: Path = scratch / f"drive{suffix}"
    drive: Drive = DrivePlan(profile, amplitude, frequency).signal()
    path.write_bytes(drive_content(drive, path))
    again = read_drive(path)
    np.testing.assert_array_equal(again.time_s, drive.time_s)
    np.testing.assert_array_equal(again.displacement_mm, drive.displacement_mm)
    assert (drive.displacement_mm[0], drive.displacement_mm[-1]) == pytest.approx((0.0, 0.0), abs=1e-9)
    # a rig takes its fundamental for what it is, small cycles and ramps or not
    plan = driven(Plan(temperatures=(20.0,)), again)
    assert plan.amplitudes[0] == pytest.approx(amplitude, rel=6e-3)
    assert plan.frequencies[0] == pytest.approx(frequency, rel=6e-3)
