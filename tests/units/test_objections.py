"""What speaks against a fitted effect: a parameter at a bound, unless it changes nothing there."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeclamp_identification.campaign.bundled import campaign_folder
from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.diagnosis.problem import objections
from pipeclamp_identification.fitting.least_squares import starting_points, unfitted
from pipeclamp_identification.fitting.observations import loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure


@pytest.mark.parametrize(("parameter", "words"), [("p_b", ""), ("n_b", "n_b ran into its bound")])
def test_a_bouc_wen_element_without_pinching_is_one(parameter, words):
    structure = Structure("power", ("bouc_wen",))
    observations = loop_observations(loops_of(read_campaign(campaign_folder(Path("clamp_a")))))
    start = starting_points(structure, observations, {})[0]
    fitted = tuple(name for name in structure.equations.names if name != parameter)
    fit = replace(
        unfitted(structure, observations, start),
        fitted=fitted,
        covariance=np.eye(len(fitted)),
        at_bound=frozenset({parameter}),
    )
    against = objections(("bouc_wen",), fit)
    assert [reason.startswith(words) for reason in against] == ([True] if words else [])
