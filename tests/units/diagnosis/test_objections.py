"""What speaks against a fitted effect: a magnitude at a bound, unless it changes nothing there; a shape to a degree."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.diagnosis.objections import objections, reservations, without_essence
from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.least_squares import unfitted
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure


def fit_with(at_bound: str, effects: tuple[str, ...] = ("bouc_wen",), bound: float = 0.0) -> Fit:
    structure = Structure("power", effects)
    observations = loop_observations(loops_of(read_campaign(campaign_folder(Path("clamp_a")))))
    start = starting_points(structure, observations, {})[0]
    fitted = tuple(name for name in structure.equations.names if name != at_bound)
    return replace(
        unfitted(structure, observations, start),
        fitted=fitted,
        covariance=np.eye(len(fitted)),
        at_bound={at_bound: bound},
    )


def with_values(fit: Fit, values: dict[str, float]) -> Fit:
    return replace(fit, law=replace(fit.law, values=values))


def test_a_bouc_wen_element_without_pinching_is_one():
    fit = fit_with("p_b")
    assert objections(("bouc_wen",), fit) == reservations(("bouc_wen",), fit) == ()


def test_a_magnitude_at_its_bound_speaks_against_an_effect():
    fit = fit_with("k_b")
    (words,) = objections(("bouc_wen",), fit)
    assert words.startswith("k_b ran into its bound")
    assert reservations(("bouc_wen",), fit) == ()


def test_only_the_bound_at_which_it_changes_nothing_is_none():
    """A contact next to another was called the cause of damping v y^2, with as short a travel as there could be."""
    assert objections(("pressed_slip",), fit_with("mu_p", ("pressed_slip",))) == ()
    assert objections(("pressed_slip",), fit_with("mu_p", ("pressed_slip",), bound=2.5)) == (
        "mu_p ran into its bound (2.5)",
    )


@pytest.mark.parametrize(("effect", "shape"), [("bouc_wen", "n_b"), ("pressed_slip", "x_n"), ("relaxation", "tau")])
def test_a_shape_at_the_end_of_its_range_is_no_cause_but_may_take_a_part(effect, shape):
    """A wire rope's friction, which only pulling presses, sticks over no way that its tests show: nothing was named."""
    fit = fit_with(shape, (effect,))
    (words,) = reservations((effect,), fit)
    assert words.startswith(f"{shape} ran into its bound")
    assert objections((effect,), fit) == ()


def test_what_acts_like_an_effect_of_the_law_is_no_cause_beside_it():
    fit = fit_with("", ("bouc_wen", "slip_spread", "coulomb"))
    assert reservations(("slip_spread",), fit) == ("the law has bouc_wen, which acts like slip_spread",)
    fit = fit_with("", ("bouc_wen", "directional_slip"))  # of which an elastic-slip element is a special case
    assert reservations(("directional_slip",), fit) == ("the law has bouc_wen, which acts like directional_slip",)


def test_two_that_act_alike_are_no_cause_together():
    """A device that degrades in a form of its own was taken for two elements, of which one mended the other's form."""
    fit = fit_with("", ("bouc_wen", "directional_slip", "coulomb"))
    assert reservations(("bouc_wen", "directional_slip"), fit) == ("bouc_wen and directional_slip act alike",)


def test_what_has_the_other_as_a_special_case_is_no_cause_beside_it():
    fit = fit_with("", ("memory", "pressed_slip", "coulomb"))
    assert reservations(("pressed_slip",), fit) == ("the law has memory, which acts like pressed_slip",)


def test_what_acts_otherwise_may_be_a_cause():
    fit = fit_with("", ("bouc_wen", "slip_spread", "coulomb"))
    assert reservations(("coulomb",), fit) == ()
    fit = fit_with("", ("bouc_wen", "coulomb"))
    assert reservations(("bouc_wen", "coulomb"), fit) == ()


def test_an_effect_without_what_sets_it_apart_is_another_one_of_its_form():
    """A sliding bearing, whose slip force nothing presses, was told as pressed slip: both growths were nought."""
    fit = fit_with("mu_n", ("pressed_slip", "slip_speed"))
    values = fit.law.values | {"mu_p": 1.0, "mu_n": 0.0}
    assert without_essence("pressed_slip", with_values(fit, values)).startswith(
        "what sets pressed_slip apart, mu_p and mu_n, can't be told from nothing"
    )
    assert without_essence("pressed_slip", with_values(fit, values | {"mu_p": 10.0})) == ""
    assert without_essence("pressed_slip", with_values(fit, values | {"mu_n": 2.0})) == ""  # held there
    assert without_essence("slip_speed", with_values(fit, values)) == ""
