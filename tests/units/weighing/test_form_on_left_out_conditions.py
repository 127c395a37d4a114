"""What left-out conditions say: form passes only where it is small there too; a level must be foretold to tell."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp.show.diagnosis import against
from pipeclamp_identification.diagnosis.evidence import LackOfFit
from pipeclamp_identification.diagnosis.foretold import beyond_scatter, explained_share, takes_part
from pipeclamp_identification.diagnosis.left_out import LeftOutScore
from pipeclamp_identification.diagnosis.noise import NoiseModel
from pipeclamp_identification.diagnosis.problem import Problem
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.diagnosis.verdict import _contradicted
from pipeclamp_identification.diagnosis.weighing import weigh as weighing
from pipeclamp_identification.diagnosis.weighing.scales import Scales, Weighed
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
    law = SimpleNamespace(score=LeftOutScore(np.ones(2), np.sqrt([[1.0], [0.5]])), missing=missing)
    other = SimpleNamespace(score=LeftOutScore(np.ones(2), np.sqrt([[0.8], [0.4]])))
    assert explained_share(other, law) == pytest.approx(share)


def for_form(errors, proved=True):
    """Put a law on the scales that leaves 0.6 times the noise over at tested conditions, which scatter can't hide."""
    none = np.zeros((RUNS, CHANNELS))
    noise = NoiseModel(np.full((RUNS, CHANNELS), SCATTER**2), Directions(none, none, none), RunScatter(), 0.0)
    scatter = SCATTER**2 * (1 + (CHANNELS - 1) / 2)
    loops = SimpleNamespace(scatter_rms_N=np.full(RUNS, NOISE), run=np.arange(RUNS))
    problem = Problem(loops, None, None, noise, None, GROUPS, {})
    lack = LackOfFit(1e-9, 0.6, 0.55, 0.65, np.array([(0.6 * NOISE) ** 2]))
    score = LeftOutScore(np.ones(RUNS), np.sqrt((errors * NOISE) ** 2 + scatter)[:, None])
    law = SimpleNamespace(lack=lack, score=score)
    return Scales(None, problem, law, [], Tolerance(0.1, 0.75, 0.75, proved), ALONE)


@pytest.mark.parametrize(("error", "verdict"), [(0.4, "complete"), (1.2, "unknown")])
def test_what_passes_for_form_is_asked_on_left_out_conditions(error, verdict):
    found = weigh(for_form(np.full(RUNS, error)))
    assert found.verdict == verdict
    assert f"{error * NOISE:.3g} N beyond scatter" in found.reasons[0]


@pytest.mark.parametrize(("proved", "verdict"), [(True, "complete"), (False, "unknown")])
def test_doubt_counts_against_a_law_with_parts(proved, verdict):
    """An error on one group of eight isn't sure; but the form of what may stand for something else isn't known."""
    found = weigh(for_form(np.where(GROUPS == 3, 3.0, 0.0), proved))
    assert found.verdict == verdict


@pytest.mark.parametrize("contradicted", [False, True])
def test_what_is_more_than_form_is_asked_for_a_part(contradicted, monkeypatch):
    """Slip forces that fall with the speed took 89 % beside three elements, and `unknown` was all that was said."""
    part = Weighed("missing", ("slip_speed",), "part", None, None, ("slip_speed takes 89%",))
    monkeypatch.setattr(Scales, "bent", None)
    monkeypatch.setattr(weighing, "able_to_take_a_part", lambda scales: ["slip_speed"])
    monkeypatch.setattr(weighing, "_two_or_a_part", lambda scales, sound: (None if sound else part, None))
    if contradicted:
        scales = for_form(np.full(RUNS, 0.4))
        found = _contradicted(weigh(scales), "it errs more at 3 Hz", scales)
    else:
        found = weigh(for_form(np.full(RUNS, 1.2)))
    assert (found.verdict, found.effects, found.kind) == ("missing", ("slip_speed",), "part")
    assert found.reasons[0] == part.reasons[0]
    assert ("at 3 Hz" if contradicted else "beyond scatter") in found.reasons[1]


def test_a_law_that_is_contradicted_and_gains_by_nothing_is_unknown():
    scales = for_form(np.full(RUNS, 0.4))
    found = _contradicted(weigh(scales), "it errs more at 3 Hz", scales)
    assert (found.verdict, found.effects) == ("unknown", ())
    assert found.reasons[0] == "it errs more at 3 Hz"


SAYS_WORSE = "on left-out temperature"


def parameter(name, follows=(), levels=2):
    return SimpleNamespace(name=name, follows=follows, levels=levels)


K, SLOPE, BEND = parameter("k10"), parameter("c_T1", ("T",)), parameter("c_T2", ("T",), 3)


def judged(names, fitted, squares, on_temperature, akaike):
    score = SimpleNamespace(mean_squares=np.full(8, squares), axes=None, squares=np.full(8, squares))
    return SimpleNamespace(
        effects=("viscous",), result=SimpleNamespace(fitted_parameters=fitted, equations=SimpleNamespace(names=names)),
        score=score, missing=8 * squares, heldout_nrmse=squares, heldout_by={"temperature": on_temperature},
        over_range={}, akaike=akaike, lack=SimpleNamespace(share=2.0, rms=2.0), objections=(), reservations=(),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("temperatures", "curve", "brought", "asked"),
    [
        (3, [SLOPE, BEND], parameter("c1"), False),
        (4, [SLOPE, BEND], parameter("c1"), True),
        (3, [SLOPE], parameter("c1"), True),
        (3, [SLOPE, BEND], parameter("beta", ("T",)), True),
    ],
)
def test_an_effect_is_asked_for_levels_that_are_foretold(temperatures, curve, brought, asked, monkeypatch):
    """Quadratic damping, right to four digits, took 92 % beside damping that follows three temperatures.

    `unknown` had been said: without one of the three, the curve of the latter had foretold it worse.
    """
    kelvin = np.repeat(np.linspace(293.0, 453.0, temperatures), 4)
    loops = SimpleNamespace(temperature_K=kelvin, density_g_cm3=np.full(len(kelvin), np.nan), conditions={})
    names = [K.name, SLOPE.name, BEND.name]
    law = judged(names, [K, *curve[1:]], 10.0, 0.03, 100.0)  # the slope at its bound
    better = judged([*names, brought.name], [K, *curve, brought], 1.0, 0.05, 50.0)
    problem = SimpleNamespace(loops=loops, groups=np.arange(8))
    assert takes_part(better, law, problem) is not asked
    monkeypatch.setattr("pipeclamp.show.diagnosis.simpler_words", lambda *_: ())
    monkeypatch.setattr("pipeclamp.show.diagnosis.left_out_at_once", lambda loops: "A, f")
    said = against(better, SimpleNamespace(law=law, loops=loops, candidates=[better], tolerance=1.0))
    assert any(SAYS_WORSE in words for words in said) is asked


@pytest.mark.parametrize(("after", "taken"), [(0.0301, True), (0.0320, False)])
def test_a_hair_on_left_out_temperatures_is_held_against_no_effect(after, taken):
    """The table had said that nothing speaks against it, and the verdict that it can't be named."""
    loops = SimpleNamespace(
        temperature_K=np.repeat([293.0, 333.0, 373.0, 413.0], 2), density_g_cm3=np.full(8, np.nan), conditions={}
    )
    law = judged([K.name], [K, SLOPE], 10.0, 0.03, 100.0)
    better = judged([K.name, "c1"], [K, SLOPE, parameter("c1")], 1.0, after, 50.0)
    assert takes_part(better, law, SimpleNamespace(loops=loops, groups=np.arange(8))) is taken
