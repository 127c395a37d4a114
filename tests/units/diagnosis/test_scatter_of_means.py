"""A load that is hung on anew for each run is never quite the same: its scatter is no effect, and hides none."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.rig.plan import TestPlan as Plan
from pipeclamp_identification.campaign.rig.runs import virtual_runs
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.diagnosis.open_means import means_left_open
from pipeclamp_identification.diagnosis.thresholds import FORM_NOISE_SHARE
from pipeclamp_identification.diagnosis.verdict import diagnose
from pipeclamp_models.law.law import Law, Structure

BASE = {
    "k10": 1450.0, "k1_A": -0.22, "k1_T": -0.1, "k30": 250.0, "k3_A": -0.9, "k3_T": -0.1,
    "c0": 80.0, "c_A": 0.05, "c_f": -0.15, "alpha0": 0.45, "alpha_A": 0.2, "alpha_f": 0.01,
}  # fmt: skip
LOAD_N, SCATTER_N = 800.0, 8.0


def off_by_zeros(folder, law, force_N, displacement_mm):
    """Give a virtual campaign of which the zeros of force and displacement are off by so much (rms) in each run."""
    random = np.random.default_rng(5)

    def off(record):
        zeros = random.standard_normal(2)
        return replace(
            record,
            force_N=record.force_N + force_N * zeros[0],
            displacement_mm=record.displacement_mm + displacement_mm * zeros[1],
        )

    runs = virtual_runs(law, Plan(rate=500.0, seed=3))
    write_campaign(folder, (WrittenRun(run.row, off(run.record)) for run in runs), name="off", notes="")
    return read_campaign(folder)


def loaded(folder, effects, **values):
    """Give a virtual campaign under a load that is off by SCATTER_N rms in each run."""
    law = Law(Structure("power", effects), {**BASE, **values, "F_o": LOAD_N}, 0.0126, 0.002)
    return off_by_zeros(folder, law, SCATTER_N, 0.0)


def test_a_load_that_scatters_is_nothing_missing(tmp_path):
    found = diagnose(Structure("power", ("offset",)), loaded(tmp_path / "campaign", ("offset",)))
    assert (found.verdict, found.effects) == ("complete", ())
    assert "N of the mean force from run to run" in found.reasons[0]
    assert found.problem.noise.scatter.mean_N == pytest.approx(SCATTER_N, rel=0.4)


def test_zeros_of_the_displacement_that_scatter_are_nothing_missing(tmp_path):
    """A hardening clamp whose displacement is measured from a place that is off has even harmonics in each run."""
    zero_mm = 0.003
    law = Law(Structure("power"), {**BASE, "k30": 900.0, "k3_A": 0.0}, 0.0126, 0.002)
    tests = off_by_zeros(tmp_path / "campaign", law, 0.0, zero_mm)
    found = diagnose(Structure("power"), tests)
    assert found.verdict == "complete"
    assert found.problem.noise.scatter.zero_mm == pytest.approx(zero_mm, rel=0.4)
    assert "mm of the displacement's zero" in found.reasons[0]


def test_a_constant_force_that_all_means_show_is_missing_though_they_scatter_by_more(tmp_path):
    """Over all functions of the conditions a constant was one of thirteen: 0.7 times the noise had been `complete`."""
    law = Law(Structure("power", ("offset",)), {**BASE, "F_o": 0.8 * SCATTER_N}, 0.0126, 0.002)
    found = diagnose(Structure("power"), off_by_zeros(tmp_path / "campaign", law, SCATTER_N, 0.0))
    assert (found.verdict, found.effects) == ("missing", ("offset",))
    assert found.problem.noise.scatter.mean_N > 0.8 * SCATTER_N


def test_means_that_stuck_elements_leave_open_may_scatter_as_the_load_does(tmp_path):
    """48 runs of a clamp with friction under 800 N had come to six effects, three of them wrong, and to `unknown`."""
    friction = {"k_s": 600.0, "z_s": 0.3}
    tests = loaded(tmp_path / "campaign", ("offset", "memory"), **friction)
    found = diagnose(Structure("power", ("offset", "memory")), tests, proved=False)
    assert found.problem.harmonics.open_means(found.law.result.law_force).any()
    assert found.verdict == "complete"


def test_without_a_load_next_to_nothing_scatters(tmp_path):
    law = Law(Structure("power"), BASE, 0.0126, 0.002)
    write_campaign(tmp_path / "campaign", virtual_runs(law, Plan(rate=500.0, seed=3)), name="v", notes="")
    found = diagnose(Structure("power"), read_campaign(tmp_path / "campaign"))
    assert not found.problem.noise.mean_shows


@pytest.mark.parametrize(
    ("stuck", "off_N", "scatter_N", "counts"),
    [(30, 12.0, 0.1, True), (12, 12.0, 0.1, False), (30, 12.0, 10.0, False), (0, 0.0, 0.1, False)],
)
def test_open_means_count_where_most_loops_show_no_slip_and_no_mean_scatters_as_much(stuck, off_N, scatter_N, counts):
    """A right law of friction had been `unknown` for the means of its 12 smallest loops of 48."""
    runs = 48
    problem = SimpleNamespace(
        harmonics=SimpleNamespace(
            open_means=lambda force: np.arange(runs) < stuck, off_in_mean=lambda force: np.full(runs, off_N)
        ),
        noise=SimpleNamespace(noise_and_mean=lambda: np.full((runs, 3), scatter_N**2)),
        smooth=np.zeros((runs, 13)),
        loops=SimpleNamespace(scatter_rms_N=np.full(runs, 4.0)),
    )
    found = means_left_open(SimpleNamespace(result=SimpleNamespace(law_force=None)), problem)
    assert (found.share > FORM_NOISE_SHARE) == counts
    assert (found.runs, found.of_runs) == (stuck, runs)
