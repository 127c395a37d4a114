"""Declared effects that have no value on the tests, or no room for a parameter: told, not fitted."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import write_campaign
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.declaration import Declaration
from pipeclamp_models.law.file import law_of
from pipeclamp_models.law.law import Structure


@pytest.fixture(scope="module")
def observations(tmp_path_factory):
    folder = tmp_path_factory.mktemp("no_force") / "campaign"
    plan = Plan((0.3, 0.6, 1.0), (1.0, 4.0), (20.0,), cycles=3, rate=200)
    write_campaign(folder, virtual_runs(law_of(open_law("emwm2")), plan), name="c", notes="")
    return loop_observations(loops_of(read_campaign(folder)))


def declared(force, **stated):
    parameter = {"symbol": "q_1", "unit": "-", "meaning": "an exponent", "start": 1.0, **stated}
    phrases = {"title": "An effect", "looks_like": "a bend"}
    return Declaration.model_validate({"id": "mine", **phrases, "force": force, "parameters": [parameter]})


def with_effect(declaration):
    return Structure("power", (declaration.id,), declared=(declaration,))


def test_an_effect_without_a_value_where_the_clamp_moves_is_told(observations):
    with pytest.raises(UserError, match=r"effect 'mine': has no finite force on these tests .* y = -"):
        fit(with_effect(declared("q_1 * y**0.5")), observations)


def test_a_start_with_a_value_is_enough(observations):
    structure = with_effect(declared("y**q_1", start=[0.5, 1.0]))  # fractions of a power have no value below 0
    assert fit(structure, observations).law.values["q_1"] == pytest.approx(1.0)


@pytest.mark.parametrize("sampled", ["finely", "coarsely"])
def test_a_force_beyond_all_numbers_is_no_warning_to_users(observations, sampled):
    force = np.full(observations.motion.y.shape, np.inf)
    transforms = None if sampled == "finely" else np.ones((*observations.harmonics.shape, force.shape[1]))
    with warnings.catch_warnings(action="error"):
        assert not np.isfinite(replace(observations, transforms=transforms).transformed(force)).all()


def test_bounds_that_cross_for_the_tests_are_told(observations):
    crossed = declared("q_1 * y", lower="F_typical", upper="-F_typical")
    with pytest.raises(
        UserError, match=r"parameter q_1: for these tests its bounds are .*; expected a lower one below"
    ):
        fit(with_effect(crossed), observations)


def test_a_condition_that_the_tests_dont_state_is_told(observations):
    with pytest.raises(UserError, match="depends on density_g_cm3, which not all tests state"):
        fit(with_effect(declared("q_1 * y * rho")), observations)


def test_the_smallest_of_a_motion_and_several_conditions_is_fitted(observations):
    """Conditions are a number a run and a motion one a sample: their comparisons, in derivatives, had no one shape."""
    structure = with_effect(declared("q_1 * max(min(y, v, A, f, 1), -1)", unit="N/mm"))
    assert "q_1" in fit(structure, observations).fitted
