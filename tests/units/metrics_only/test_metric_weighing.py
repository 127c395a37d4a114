"""Two effects that come together, weighed against one alone, where no law explains all."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipeclamp_identification.fitting.joint.fitted import Fit
from pipeclamp_identification.metrics_only import candidates
from pipeclamp_identification.metrics_only.evidence import MetricJudged, Scatter
from pipeclamp_identification.metrics_only.observations import MetricObservations
from pipeclamp_identification.metrics_only.weighing import MetricScales, weigh
from pipeclamp_models.base.processes import ALONE
from pipeclamp_models.law.law import Structure

ROWS = 60
PAIR = ("relaxation", "relaxation_temperature")


def judged(squares: float, *effects: str) -> MetricJudged:
    """A law with these effects whose residuals have this sum of squares."""
    residual = np.full((ROWS, 2), np.sqrt(squares / (2 * ROWS)))
    structure = Structure("power", effects)
    fitted = ("k",) * (5 + 2 * len(effects))
    result = cast(Fit, SimpleNamespace(fitted=fitted, at_bound=(), equations=structure.equations))
    return MetricJudged(effects, structure, result, residual, ())


def weighed(*, law, alone, pair, richest):
    """What is named of laws that leave so many squares, in the fit as on each of 12 left-out conditions."""
    laws = judged(law), judged(alone, "oil_damper"), judged(pair, *PAIR), judged(richest, *PAIR, "memory")
    unequal = 1 + 0.1 * np.cos(np.arange(12))
    scales = MetricScales(
        law=laws[0], richest=laws[3], candidates=laws[1:2], pairs=laws[2:3],
        chances={laws[1].name: 1e-9, laws[2].name: 1e-9}, lack=(0.0, 0.0), scatter=Scatter(np.ones(2), np.full(2, 9.0)),
        heldout=lambda one: one.squares * unequal,
    )  # fmt: skip
    return weigh(scales).laws[0].effects


def test_what_no_law_explains_doesnt_count_against_two_that_come_together():
    """They take most of what any law does; more than half of what one alone leaves, nobody takes."""
    assert weighed(law=1000.0, alone=700.0, pair=420.0, richest=400.0) == PAIR


@pytest.mark.parametrize("pair", [690.0, 600.0])
def test_two_that_take_little_more_than_one_alone_arent_named_for_it(pair):
    assert weighed(law=1000.0, alone=700.0, pair=pair, richest=400.0) == ("oil_damper",)


def test_the_richest_law_is_no_poorer_than_two_that_come_together(monkeypatch):
    """Else what they explain would count as scatter."""
    monkeypatch.setattr(candidates, "_looks", lambda *_: [])
    law, alone, pair = judged(1e4), judged(7000.0, "oil_damper"), judged(4200.0, *PAIR)
    nothing = cast(MetricObservations, None)
    found = candidates._richest(law, [alone], [pair], [], nothing, lambda _: True, ALONE)
    assert found.effects == PAIR


@pytest.mark.parametrize(
    ("reservations", "named"),
    [(("beta_r ran into its bound (1)",), ("relaxation",)), ((), ("relaxation_spread", "relaxation"))],
)
def test_a_general_effect_that_ended_as_a_special_case_of_its_own_gives_way_to_it(reservations, named):
    """A spread of relaxation times that fits best without a spread is one relaxation time."""
    law, special, richest = judged(1000.0), judged(401.0, "relaxation"), judged(400.0, "relaxation", "memory")
    general = replace(judged(400.0, "relaxation_spread"), reservations=reservations)
    found = weigh(
        MetricScales(
            law=law, richest=richest, candidates=[general, special], pairs=[],
            chances={general.name: 1e-9, special.name: 1e-9}, lack=(0.0, 0.0),
            scatter=Scatter(np.ones(2), np.full(2, 9.0)), heldout=lambda one: np.full(12, one.squares),
        )
    )  # fmt: skip
    assert tuple(each.effects[0] for each in found.laws) == named


@pytest.mark.parametrize("rounding", [-1e-9, 1e-9])
def test_of_laws_that_are_as_good_the_simpler_one_comes_first(rounding):
    """Two slip forces that end alike are one: which stood first, and by that how many effects of unlike kinds counted
    as tried, and every chance, had hung on the last digit."""
    law, one, two = judged(1000.0), judged(400.0, "memory"), judged(400.0 + rounding, "directional_slip")
    found = weigh(
        MetricScales(
            law=law, richest=one, candidates=[two, one], pairs=[], chances={"memory": 1e-9, "directional_slip": 1e-9},
            lack=(1e-9, 1.0), scatter=Scatter(np.ones(2), np.full(2, 9.0)), heldout=lambda _: np.ones(12),
        )
    )  # fmt: skip
    assert [each.name for each in found.laws] == ["memory", "directional_slip"]
