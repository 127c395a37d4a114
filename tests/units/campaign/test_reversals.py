"""Samples at reversals: their timing decides which sign of friction they show, and mustn't decide the loop."""

import numpy as np
import pytest

from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_identification.signals.real_harmonics import real_harmonics_of
from pipeclamp_identification.signals.reversals import Bridged, bridged
from pipeclamp_identification.signals.sampled_transform import sampled_transform
from pipeclamp_models.law.law import Law, Structure
from pipeclamp_models.realise.force import force_of_law
from pipeclamp_models.realise.motion import sinusoids

FRICTION = Law(
    Structure("power", ("coulomb",)),
    {"k10": 1000.0, "k1_A": 0.0, "k1_T": 0.0, "k30": 0.0, "k3_A": 0.0, "k3_T": 0.0, "c0": 0.0, "c_A": 0.0}
    | {"c_f": 0.0, "alpha0": 1.0, "alpha_A": 0.0, "alpha_f": 0.0, "F_c": 100.0},
    1e-9,
    1e-9,
)


@pytest.mark.parametrize("samples", [64, 256])
def test_a_step_between_samples_has_the_harmonics_of_its_own_place(samples):
    cycle = sinusoids(1.0, 1.0, 293.15, samples)
    shift = 0.37 * 2 * np.pi / samples
    phase = 2 * np.pi * np.arange(samples) / samples + shift
    omega = 2 * np.pi
    late = type(cycle)(
        np.cos(phase)[None], -omega * np.sin(phase)[None], -(omega**2) * np.cos(phase)[None], cycle.slow, cycle.h
    )
    found = real_harmonics_of(force_of_law(FRICTION, late).force, 3)[0]
    first = (1000.0 + 100.0 * 4j / np.pi) * np.exp(1j * shift)
    # A step that is taken for the middle between samples would be off by 0.13 of a step: 1 N at 64 samples.
    assert found[1] == pytest.approx(first.real, abs=0.03 * 64 / samples)
    assert found[2] == pytest.approx(first.imag, abs=0.15 * (64 / samples) ** 2 + 1e-6)


@pytest.mark.parametrize("samples", [80, 100, 500])
@pytest.mark.parametrize("flip", [-1, 1])
def test_the_sign_that_a_sample_at_the_reversal_happens_to_show_changes_nothing(run_of, campaign_of, samples, flip):
    time = np.arange(6 * samples) / samples
    y = np.cos(2 * np.pi * time)
    sign = -np.sign(np.round(np.sin(2 * np.pi * time), 9))
    sign[sign == 0] = flip
    loops = loops_of(campaign_of(run_of(Record(time, y, 1000.0 * y + 100.0 * sign), "locked")))
    observations = loop_observations(loops)
    residual = observations.plain_residual(force_of_law(FRICTION, observations.motion))
    # Taken as it is, the sample would be off by 100 N, and each harmonic by two of its shares in the sum.
    assert np.max(np.abs(residual[observations.seen])) < 0.2 * 2 * 100.0 / samples
    assert loops.noise_rms_N[0] < 0.05


@pytest.mark.parametrize("samples", [50.0, 50.003, 50.37])
def test_a_long_record_of_few_samples_a_cycle_shows_friction_through_its_sampling(run_of, campaign_of, samples):
    time = np.arange(round(400 * samples)) / samples
    y, sign = np.cos(2 * np.pi * time), -np.sign(np.sin(2 * np.pi * time + 1e-9))
    loops = loops_of(campaign_of(run_of(Record(time, y, 1000.0 * y + 100.0 * sign), "long")))
    observations = loop_observations(loops)
    law_force, seen = force_of_law(FRICTION, observations.motion), observations.seen
    unaware = real_harmonics_of(law_force.force, 20) - observations.harmonics
    residual = observations.plain_residual(law_force)
    assert np.max(np.abs(residual[seen])) < 0.12 * np.max(np.abs(unaware[seen]))


@pytest.mark.parametrize(("points", "highest"), [(64, 20), (128, 7), (512, 20)])
def test_a_transform_is_that_of_straight_lines_between_the_points_of_the_grid(points, highest):
    phase = np.sort(np.random.default_rng(4).uniform(0, 2 * np.pi, 300))
    at = bridged(np.array([0.0, 1.0 + 0j]), phase, 300.0, highest)
    none = Bridged(at.places[:, :0], at.before[:0], at.yielding[:0])
    order = np.arange(highest + 1)
    basis = np.hstack([np.cos(np.outer(phase, order)), -np.sin(np.outer(phase, order[1:]))])
    theta = 2 * np.pi * np.arange(points + 1) / points
    lines = [np.interp(phase, theta, np.append(row, row[0])) for row in np.eye(points)]
    solution = np.linalg.lstsq(basis, np.transpose(lines), rcond=None)[0]
    found = sampled_transform(phase, none, points, highest)
    np.testing.assert_allclose(found[:, [0, *range(1, 2 * highest, 2)]], solution[: highest + 1].T, atol=1e-12)
    np.testing.assert_allclose(found[:, 2::2], solution[highest + 1 :].T, atol=1e-12)


def test_what_is_linear_on_both_sides_of_a_step_is_told_where_the_step_is():
    phase = np.arange(200) * (6 * np.pi / 200) - 0.03
    at = bridged(np.array([0.0, 1.0 + 0j]), phase, 200 / 3, 0)
    assert len(at.sample) == 6
    half = np.pi * 3 / 200
    np.testing.assert_allclose((phase[at.sample] + half * (2 * at.before - 1)) / np.pi, np.arange(6), atol=1e-6)
    sides = np.tile([[-1.0], [0.3], [1.0]], 6)
    np.testing.assert_allclose(at.between(sides), 1 - 2 * at.before)
