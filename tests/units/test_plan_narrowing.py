"""The loop test that narrows a pipe's band: what a test tells is Bayes' rule, and bands are those of the response."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from banded import SPREAD, banded

from pipeclamp_identification.diagnosis.limits import parse_limits
from pipeclamp_identification.planning.loop_tests import LoopTests
from pipeclamp_identification.planning.narrowing import WORTH, plan_tests
from pipeclamp_models.base.errors import UsageError
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import read_law
from pipeclamp_system.bands.quantities import unknown
from pipeclamp_system.bands.response import response_bands
from pipeclamp_system.bands.varied import varied
from pipeclamp_system.steady.response import run_response


def test_a_test_leaves_what_bayes_rule_says():
    random = np.random.default_rng(1)
    parameters, rows, harmonics = 3, 4, 5
    slopes = random.standard_normal((parameters, rows, harmonics))
    roots = random.standard_normal((rows, harmonics, harmonics))
    error = roots @ np.swapaxes(roots, 1, 2)
    root = random.standard_normal((parameters, parameters))
    before, wanted = root @ root.T, random.standard_normal(parameters)
    tests = LoopTests(varied(open_law("emwm2")), {"A": np.ones(rows)}, slopes, error)
    for row in range(rows):
        own = slopes[:, row]
        after = np.linalg.inv(np.linalg.inv(before) + own @ np.linalg.inv(error[row]) @ own.T)
        assert tests.after(before, row) == pytest.approx(after, rel=1e-6)
        less = wanted @ (before - after) @ wanted
        assert tests.less(before, wanted)[row] == pytest.approx(less, rel=1e-6)


def test_the_form_of_clamps_by_themselves_is_that_of_one_law():
    law = varied(open_law("emwm2").model_copy(update={"spread": SPREAD}))
    what = unknown([law, law], ["one", "other"], solved=True)
    apart = what.by_clamp()
    assert len(apart.quantities) == len(what.quantities) + 2
    both = [np.sum([one.sizes(clamp, {}) for clamp in (0, 1)], axis=0) for one in (what, apart)]
    variances = [size @ one.covariance @ size for size, one in zip(both, (what, apart), strict=True)]
    assert variances[0] == pytest.approx(variances[1])


@pytest.mark.parametrize("spread", [SPREAD, None])
def test_the_band_is_the_responses_and_narrows(tmp_path, spread):
    """With tests beyond the range that the motion leaves, and where the law's parameters alone count."""
    path = banded(tmp_path, 1.0, spread=spread)
    law = read_law(tmp_path / "law.json")
    limits = parse_limits("A=0.02..1,f=1..30,T=20..60")
    plan = plan_tests(path, limits, at="clamp1", noise_N=1.0)
    told = response_bands(path, run_response(path), 95.0).curves[0].peaks[0].amplitude
    assert (plan.before.amplitude.low, plan.before.amplitude.high) == pytest.approx((told.low, told.high), rel=1e-9)
    widths = [band.high - band.low for band in (plan.before.amplitude, *(test.amplitude for test in plan.tests))]
    assert plan.tests
    assert all(after < (1 - WORTH) * before for before, after in pairwise(widths))
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


def test_limits_that_no_test_keeps_are_refused(tmp_path):
    with pytest.raises(UsageError, match="no sine test keeps all of"):
        plan_tests(banded(tmp_path, 1.0), parse_limits("A=1..2,f=5..6,v=..1"))
