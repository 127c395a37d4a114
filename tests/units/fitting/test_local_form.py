"""What tests show of a law's form between them: kriging, and bands that lie where they show."""

from __future__ import annotations

import numpy as np
import pytest
from banded import SPREAD, banded
from scipy.optimize import approx_fprime, minimize
from scipy.stats import multivariate_normal

from pipeclamp_identification.fitting.local_form import (
    EASY,
    FAR_LENGTH,
    NEAR_LENGTH,
    RUNS_SEEN_ROUGHLY,
    likeliest_form,
    unlikeliness,
)
from pipeclamp_models.law.bundled import open_law
from pipeclamp_models.law.file import KrigedShare, LocalForm, read_law, write_law
from pipeclamp_models.law.local_form import Kriged, likeness, squares
from pipeclamp_system.bands.response import response_bands
from pipeclamp_system.bands.varied import varied
from pipeclamp_system.response.run import run_response
from pipeclamp_system.steady.states import amplitudes_of

AT = {"A": (0.1, 0.2, 0.4, 0.8), "f": (2.0, 8.0, 2.0, 8.0)}


def share(*values, variance=1e-8, deviation=0.05, lengths=(0.5, 1.0)):
    return KrigedShare(
        deviation=deviation, lengths=dict(zip(AT, lengths, strict=True)), shares=values, variances=(variance,) * 4
    )


def local(stiffness, damping):
    return LocalForm(at=AT, stiffness=stiffness, damping=damping)


def test_at_tests_it_is_what_they_show_and_far_away_nothing_is_known():
    one = share(0.03, -0.02, 0.04, 0.01)
    form = local(one, one)
    for place, value in enumerate(one.shares):
        mean, left = Kriged.of(form, one).at({name: AT[name][place] for name in AT})
        assert mean == pytest.approx(value, abs=1e-6)
        assert left < 2e-4
    mean, left = Kriged.of(form, one).at({"A": 1e4, "f": 1e4})
    assert (mean, left) == pytest.approx((0.0, 0.05))
    between = Kriged.of(form, one).at({"A": 0.15, "f": 4.0})[1]
    assert 2e-4 < between < 0.05


def test_how_likely_lengths_and_deviation_are_and_its_slopes():
    drawn = np.random.default_rng(5)
    tested, shares = drawn.normal(size=(30, 2)), 0.05 * drawn.normal(size=30)
    variances = drawn.uniform(1e-4, 1e-3, 30)
    expected, at = np.array([0.0, 0.0, np.log(0.04)]), np.array([-0.3, 0.5, np.log(0.06)])
    apart = squares(tested, tested)

    def unlikely(logarithms):
        return unlikeliness(logarithms, apart, shares, variances, expected)[0]

    among = 0.06**2 * (likeness(apart, np.exp(at[:2])) + EASY * np.eye(30)) + np.diag(variances)
    likely = multivariate_normal(np.zeros(30), among).logpdf(shares) - 0.5 * np.sum((at - expected) ** 2)
    assert unlikely(at) == pytest.approx(-likely - 15 * np.log(2 * np.pi))
    assert unlikeliness(at, apart, shares, variances, expected)[1] == pytest.approx(
        approx_fprime(at, unlikely, 1e-6), rel=1e-4
    )


def test_a_few_of_many_tests_lead_to_what_all_find_likeliest():
    """A plan of 4 x 5 x 8 conditions, in its order: every eighth test alone would show one temperature only."""
    drawn = np.random.default_rng(3)
    plan = np.stack(np.meshgrid(*(np.linspace(-1.5, 1.5, levels) for levels in (4, 5, 8)), indexing="ij"), axis=-1)
    tested = plan.reshape(-1, 3) + 0.01 * drawn.normal(size=(160, 3))
    assert len(tested) > RUNS_SEEN_ROUGHLY
    apart, variances = squares(tested, tested), np.full(160, 1e-4)
    among = 0.05**2 * likeness(apart, np.array([0.7, 2.0, 1.0])) + np.diag(variances)
    shares = drawn.multivariate_normal(np.zeros(160), among)
    expected = np.append(np.zeros(3), np.log(0.04))
    deviation, lengths, *_ = likeliest_form(tested, shares, variances, 0.04)
    given = apart, shares, variances, expected
    found = unlikeliness(np.log(np.append(lengths, deviation)), *given)[0]
    for length in (NEAR_LENGTH, FAR_LENGTH):
        start = np.append(np.full(3, np.log(length)), np.log(0.04))
        by_all = minimize(unlikeliness, start, given, method="L-BFGS-B", jac=True)
        assert found <= by_all.fun + 1e-5
        assert np.append(lengths, deviation) == pytest.approx(np.exp(by_all.x), rel=2e-3)


def test_a_law_is_surer_near_its_tests():
    spread = SPREAD.model_copy(update={"local": local(share(0.0, 0.0, 0.0, 0.0), share(0.1, 0.1, 0.1, 0.1))})
    law = varied(open_law("emwm2").model_copy(update={"spread": spread}))
    near, far = (law.form({}, {"A": A, "f": f}) for A, f in ((0.2, 8.0), (0.2, 1e3)))
    assert near.damping < 0.1 * far.damping
    assert law.lean({"A": 0.2, "f": 8.0}) == pytest.approx({"stiffness": 0.0, "damping": 0.1}, abs=1e-5)
    assert law.form({}) == SPREAD.form


def test_a_band_lies_where_tests_show(tmp_path):
    """Tests that all show 5 % more damping: the band is about the peak of a law with so much more."""
    path = banded(tmp_path, 1.0)
    law = read_law(tmp_path / "law.json")
    alike = {"lengths": (1e3, 1e3), "variance": 1e-12}
    form = local(share(*[0.0] * 4, **alike), share(*[0.05] * 4, **alike))
    write_law(
        law.model_copy(update={"spread": SPREAD.model_copy(update={"local": form, "beyond": {}})}),
        path.parent / "law.json",
    )
    peak = response_bands(path, run_response(path), 95.0).curves[0].peaks[0].amplitude
    entry = law.coefficients["c0"]
    more = entry.model_copy(update={"value": entry.value * float(np.exp(0.05))})
    write_law(law.model_copy(update={"coefficients": {**law.coefficients, "c0": more}}), tmp_path / "law.json")
    states = run_response(path).curves[0].states
    assert peak.middle == pytest.approx(max(amplitudes_of(state)[0] for state in states), rel=2e-3)
    assert peak.middle < peak.value
    assert peak.low < peak.middle < peak.high
