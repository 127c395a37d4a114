"""The loop test that narrows a pipe's band: what a test tells is Bayes' rule, and bands are those of the response."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from banded import SPREAD, banded

from pipeclamp.show.narrowing import beyond_words
from pipeclamp_identification.diagnosis.further_test.limits import parse_limits
from pipeclamp_identification.diagnosis.further_test.outlook import RUNS_OF_A_TEST
from pipeclamp_identification.planning import narrowing
from pipeclamp_identification.planning.band_plan import Map
from pipeclamp_identification.planning.loop_tests import LoopTests, with_tests
from pipeclamp_identification.planning.narrowing import plan_tests
from pipeclamp_identification.planning.narrowing_search import WORTH_SHARE
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import Interval, KrigedShare, LocalForm, read_law
from pipeclamp_models.law.range import conditions_beyond
from pipeclamp_system.bands.quantities import unknown_of_clamps
from pipeclamp_system.bands.response import response_bands
from pipeclamp_system.bands.varied import varied
from pipeclamp_system.response.run import run_response


def test_a_test_leaves_what_bayes_rule_says():
    random = np.random.default_rng(1)
    parameters, rows, harmonics = 3, 4, 5
    slopes = random.standard_normal((parameters, rows, harmonics))
    roots = random.standard_normal((rows, harmonics, harmonics))
    error = roots @ np.swapaxes(roots, 1, 2)
    root = random.standard_normal((parameters, parameters))
    before, wanted = root @ root.T, random.standard_normal(parameters)
    tests = LoopTests(varied(open_law("emwm2")), {"A": np.ones(rows)}, slopes, error, np.zeros((2, rows, harmonics)))
    for row in range(rows):
        own = slopes[:, row]
        after = np.linalg.inv(np.linalg.inv(before) + own @ np.linalg.inv(error[row]) @ own.T)
        assert tests.after(before, row) == pytest.approx(after, rel=1e-6)
        less = wanted @ (before - after) @ wanted
        assert tests.less(before, wanted)[row] == pytest.approx(less, rel=1e-6)


def kriged_law():
    """A law whose form is known near eight tests."""
    at = {"A": (0.1, 0.2, 0.4, 0.8) * 2, "f": (2.0,) * 4 + (8.0,) * 4}
    share = KrigedShare(deviation=0.05, lengths={"A": 0.5, "f": 1.0}, shares=(0.01,) * 8, variances=(1e-4,) * 8)
    local = LocalForm(at=at, stiffness=share, damping=share)
    interval = {name: Interval(minimum=min(one), maximum=max(one), unit="") for name, one in at.items()}
    spread = SPREAD.model_copy(update={"local": local})
    return varied(open_law("emwm2").model_copy(update={"spread": spread, "range": interval}))


@pytest.mark.parametrize("tested", [{"A": 0.3, "f": 4.0}, {"A": 0.2, "f": 8.0}, {"A": 0.7, "f": 2.0}])
def test_a_test_tells_of_the_form_elsewhere_what_kriging_makes_of_it(tested):
    """Where the law's parameters are known, the two ways to reckon it agree: Bayes' rule, and one more kriged test."""
    law, used = kriged_law(), {"A": 0.3, "f": 4.0}
    off = np.random.default_rng(2).standard_normal((2, 1, 6))
    scatter = 1e-4 / RUNS_OF_A_TEST
    error = 1e-12 * np.eye(6) + sum(scatter * np.outer(one[0], one[0]) for one in off)
    grid = {name: np.array([value]) for name, value in tested.items()}
    field = LoopTests(law, grid, np.zeros((0, 1, 6)), error[None], off)
    left = field.with_form(law, [used], np.ones((1, 2))).after(np.eye(2), 0)
    after = replace(law, file=with_tests(law.file, [tested]))
    share = after.form({}, used).stiffness / law.form({}, used).stiffness
    assert share < 1
    assert np.sqrt(np.diag(left)) == pytest.approx([share, share], rel=1e-3)


@pytest.mark.parametrize(("tested", "left"), [(1.6, 0.0), (1.2, np.log(1.6 / 1.2)), (0.8, np.log(2.0))])
def test_beyond_the_range_a_test_leaves_the_way_from_it(tested, left):
    law = kriged_law()
    used = {"A": 1.6, "f": 2.0}
    whole, beyond = law.form(conditions_beyond(law.file, used), {"A": 0.8, "f": 2.0}), SPREAD.beyond["A"]
    _, alike = law.form_told({"A": tested, "f": 2.0}, used)["damping"]
    inside = law.form({}, {"A": 0.8, "f": 2.0}).damping
    assert whole.damping**2 == pytest.approx(inside**2 + (np.log(2.0) / beyond.step * beyond.error.damping) ** 2)
    expected = (left / beyond.step * beyond.error.damping) ** 2
    assert whole.damping**2 * (1 - alike**2) == pytest.approx(expected, abs=1e-12)


def test_the_form_of_clamps_by_themselves_is_that_of_one_law():
    law = varied(open_law("emwm2").model_copy(update={"spread": SPREAD}))
    what = unknown_of_clamps([law, law], ["one", "other"], solved=True)
    apart = what.by_clamp()
    assert len(apart.quantities) == len(what.quantities) + 2
    both = [np.sum([one.sizes(clamp, {}) for clamp in (0, 1)], axis=0) for one in (what, apart)]
    variances = [size @ one.covariance @ size for size, one in zip(both, (what, apart), strict=True)]
    assert variances[0] == pytest.approx(variances[1])


@pytest.mark.parametrize("spread", [SPREAD, None])
def test_the_band_is_the_responses_and_narrows(tmp_path, monkeypatch, spread):
    """With tests beyond the range that the motion leaves, and where the law's parameters alone count."""
    path = banded(tmp_path, 1.0, spread=spread)
    law = read_law(tmp_path / "law.json")
    limits = parse_limits("A=0.02..1,f=1..30,T=20..60")
    responses = []
    monkeypatch.setattr(
        narrowing, "run_response", lambda *_, **__: responses.append(run_response(path)) or responses[0]
    )
    plan = plan_tests(path, limits, at="clamp1", noise_N=1.0)
    told = response_bands(path, responses[0], 95.0).curves[0].peaks[0].amplitude
    assert (plan.before.amplitude.low, plan.before.amplitude.high) == pytest.approx((told.low, told.high), rel=1e-9)
    widths = [band.high - band.low for band in (plan.before.amplitude, *(test.amplitude for test in plan.tests))]
    assert plan.tests
    assert all(after < (1 - WORTH_SHARE) * before for before, after in pairwise(widths))
    assert plan.floor.high - plan.floor.low <= widths[-1] * (1 + 1e-9)
    for test in plan.tests:
        assert 0.02 <= test.amplitude_mm <= 1
        assert 1 <= test.frequency_Hz <= 30
    first, motion = plan.tests[0], plan.maps[0].motion
    assert not law.range["f"].minimum <= motion["f"] <= law.range["f"].maximum
    if spread is None:
        assert plan.floor.shares["parameters"] == 0.0
        assert plan.floor.deviation < 0.1 * told.deviation
    else:
        assert first.amplitude.shares["form"] > 0.5


@pytest.mark.parametrize(
    ("limits", "at", "said"),
    [
        ("A=1..2,f=5..6,v=..1", None, "no sine test keeps all of A=1..2,f=5..6"),
        ("F=..0.001", None, "no sine test keeps all of"),
        ("A=0.02..1", "top", "--at: clamp or probe 'top' is not known"),
    ],
)
def test_what_cannot_serve_is_refused_before_the_response_is_computed(tmp_path, limits, at, said):
    told = []
    with pytest.raises(UsageError, match=said):
        plan_tests(banded(tmp_path, 1.0), parse_limits(limits), at=at, progress=told.append)
    assert told == []


def test_a_peak_beyond_the_tests_is_said():
    here = Map("c", {}, np.zeros(0), {"A": 0.5, "f": 2.0, "T": 293.15}, {"A": (0.2, 1.0), "f": (1.0, 5.0)})
    assert beyond_words(here) == ""
    words = beyond_words(replace(here, motion={"A": 3.97, "f": 4.36}))
    assert "A = 3.97 mm (tests: 0.2 to 1)" in words and "f =" not in words
