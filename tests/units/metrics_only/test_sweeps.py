"""What was varied in a campaign of metrics, and the curves that are drawn over it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeclamp.pages.sweeps import of_energy, of_energy_and_law, of_phase, sweep_picture, sweep_sections
from pipeclamp_identification.campaign.runs_table import Setup
from pipeclamp_identification.metrics_only.campaign import MetricCampaign, MetricRun
from pipeclamp_identification.metrics_only.law import MetricComparison
from pipeclamp_identification.metrics_only.sweeps import sweeps_of

SCATTER = np.random.default_rng(3)


def campaign(settings) -> MetricCampaign:
    """Tests at (amplitude, frequency, temperature), each set with half a per cent of scatter."""
    runs = tuple(
        MetricRun(
            f"r{place}", Setup(temperature_C=T), A * (1 + 0.005 * SCATTER.uniform(-1, 1)), f, 0.1 * A**2, 0.5 * A**2,
            (0.0, 0.0),
        )
        for place, (A, f, T) in enumerate(settings)
    )  # fmt: skip
    return MetricCampaign("c", "", "", runs, (), ())


def test_settings_that_come_again_make_curves():
    found = sweeps_of(campaign([(A, f, 20.0) for A in (0.1, 1.0) for f in (1, 10, 100)]))
    assert [one.quantity for one in found] == ["frequency_Hz", "amplitude_mm"]
    over_f, over_A = found
    assert [curve.rows for curve in over_f.curves] == [(0, 1, 2), (3, 4, 5)]
    assert [round(dict(curve.held)["amplitude_mm"], 1) for curve in over_f.curves] == [0.1, 1.0]
    assert [curve.rows for curve in over_A.curves] == [(0, 3), (1, 4), (2, 5)]
    assert over_f.drifting == ()


def test_a_temperature_that_rises_all_along_has_no_settings():
    settings = [(0.02, f, T + f / 10) for T in np.arange(-60.0, 100.0, 2.0) for f in (1, 10)]
    over_f, over_T = sweeps_of(campaign(settings))
    assert (over_T.quantity, over_T.drifting, len(over_T.curves)) == ("temperature_C", (), 2)
    assert [len(curve.rows) for curve in over_T.curves] == [80, 80]
    assert over_f.drifting == ("temperature_C",)
    figure = sweep_picture(campaign(settings), of_phase(campaign(settings)), over_f)
    assert {trace.mode for trace in figure.data} == {"markers"}
    assert figure.layout.coloraxis.colorbar.title.text == "T / °C"


def test_many_curves_are_told_by_a_scale_of_colours_and_few_by_names():
    tests = campaign([(A, f, T) for A in (0.1, 1.0) for f in (1, 3, 10, 30, 100, 300, 1000) for T in (20.0, 60.0)])
    over_f, over_A, _ = (sweep_picture(tests, of_energy(tests), one) for one in sweeps_of(tests))
    assert sum(bool(trace.showlegend) for trace in over_f.data) == 4
    assert over_f.layout.coloraxis.cmin is None
    assert not any(trace.showlegend for trace in over_A.data)
    assert list(over_A.layout.coloraxis.colorbar.ticktext)[:3] == ["1", "2", "5"]
    assert ["Curves of one colour differ in T."] in [one.paragraphs for one in sweep_sections(tests, of_energy(tests))]


@pytest.mark.parametrize("few", [True, False])
def test_a_law_is_drawn_beside_what_was_measured(few):
    temperatures = (20.0,) if few else np.arange(20.0, 160.0, 10.0)
    tests = campaign([(A, f, T) for A in (0.1, 1.0) for f in (1, 10, 100) for T in temperatures])
    too_much, too_little = np.log(1.25), np.log(0.5)  # of dW and W, measured over computed
    logs = np.tile([too_much, too_little], (len(tests.runs), 1))
    sections = sweep_sections(tests, of_energy_and_law(MetricComparison(tests, logs, {})))
    assert all("Dots are measured, crosses the law's." in one.paragraphs for one in sections)
    drawn = sections[0].figures[0].data
    measured = [one for one in drawn if one.mode == "markers"]
    law = [one for one in drawn if one.mode == "lines+markers"]
    assert len(law) == len(measured) == len(drawn) / 2
    assert not any(one.showlegend for one in law)
    factors = [np.asarray(b.y) / np.asarray(a.y) for a, b in zip(measured, law, strict=True)]
    assert {round(float(one), 6) for row in factors for one in row} == {2.0, 0.4}  # k as W, eta as dW/W


def test_one_setting_has_no_picture():
    assert sweeps_of(campaign([(0.5, 10.0, 20.0)] * 3)) == ()
    assert sweeps_of(campaign([(0.5, 10.0, None)])) == ()


@pytest.mark.parametrize("eta", [0.01, 0.5, 1.0])
def test_a_loss_angle_is_that_of_a_sine(eta):
    run = MetricRun("r", Setup(), 1.0, 1.0, 2 * math.pi * eta, 1.0, (0.0, 0.0))
    assert math.sin(run.loss_angle) == pytest.approx(eta)


def test_a_loop_that_is_fuller_than_a_sines_has_no_loss_angle():
    run = MetricRun("r", Setup(), 1.0, 1.0, 7.0, 1.0, (0.0, 0.0))
    assert math.isnan(run.loss_angle)
