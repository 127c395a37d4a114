"""Form passes only where it is small on left-out conditions too."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.evidence import LackOfFit
from pipeclamp_identification.diagnosis.foretold import beyond_scatter, explained_share
from pipeclamp_identification.diagnosis.left_out import LeftOutScore
from pipeclamp_identification.diagnosis.noise import NoiseModel
from pipeclamp_identification.diagnosis.problem import Problem
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.diagnosis.weighing.scales import Scales
from pipeclamp_identification.diagnosis.weighing.tolerance import Tolerance
from pipeclamp_identification.diagnosis.weighing.weigh import weigh
from pipeclamp_models.base.processes import ALONE

RUNS, CHANNELS, NOISE, SCATTER = 16, 7, 0.3, 0.02
GROUPS = np.repeat(np.arange(8), 2)


def test_an_error_on_each_group_is_told_in_newtons_and_in_noise():
    found = beyond_scatter(np.full(RUNS, 0.36), GROUPS, np.full(RUNS, NOISE))
    assert (found.rms, found.share, found.sure_share) == pytest.approx((0.6, 2.0, 2.0))


def test_an_error_on_one_group_alone_is_not_sure():
    found = beyond_scatter(np.where(GROUPS == 3, 8 * 0.36, 0.0), GROUPS, np.full(RUNS, NOISE))
    assert found.share == pytest.approx(2.0)
    assert found.sure_share < 0.01


def test_runs_that_are_never_left_out_say_nothing():
    groups = np.where(GROUPS == 0, -1, GROUPS - 1)
    found = beyond_scatter(np.where(groups < 0, 1e6, 0.09), groups, np.full(RUNS, NOISE))
    assert found.share == pytest.approx(1.0)


@pytest.mark.parametrize(("missing", "share"), [(0.4, 0.75), (0.2, 1.0), (0.0, 0.0)])
def test_a_share_is_of_what_is_missing_beyond_scatter(missing, share):
    law = SimpleNamespace(score=LeftOutScore(np.ones(2), np.array([1.0, 0.5])), missing=missing)
    other = SimpleNamespace(score=LeftOutScore(np.ones(2), np.array([0.8, 0.4])))
    assert explained_share(other, law) == pytest.approx(share)


def weighed_for_form(errors, proved=True):
    """Weigh a law that leaves 0.6 times the noise over at tested conditions, which scatter can't hide."""
    none = np.zeros((RUNS, CHANNELS))
    noise = NoiseModel(np.full((RUNS, CHANNELS), SCATTER**2), Directions(none, none, none), RunScatter(), 0.0)
    scatter = SCATTER**2 * (1 + (CHANNELS - 1) / 2)
    loops = SimpleNamespace(scatter_rms_N=np.full(RUNS, NOISE), run=np.arange(RUNS))
    problem = Problem(loops, None, None, noise, None, GROUPS, {})
    lack = LackOfFit(1e-9, 0.6, 0.55, 0.65, np.array([(0.6 * NOISE) ** 2]))
    score = LeftOutScore(np.ones(RUNS), (errors * NOISE) ** 2 + scatter)
    law = SimpleNamespace(lack=lack, score=score)
    return weigh(Scales(None, problem, law, [], Tolerance(0.1, 0.75, 0.75, proved), ALONE))


@pytest.mark.parametrize(("error", "verdict"), [(0.4, "complete"), (1.2, "unknown")])
def test_what_passes_for_form_is_asked_on_left_out_conditions(error, verdict):
    found = weighed_for_form(np.full(RUNS, error))
    assert found.verdict == verdict
    assert f"{error * NOISE:.3g} N beyond scatter" in found.reasons[0]


@pytest.mark.parametrize(("proved", "verdict"), [(True, "complete"), (False, "unknown")])
def test_doubt_counts_against_a_law_with_parts(proved, verdict):
    """An error on one group of eight isn't sure; but the form of what may stand for something else isn't known."""
    found = weighed_for_form(np.where(GROUPS == 3, 3.0, 0.0), proved)
    assert found.verdict == verdict
