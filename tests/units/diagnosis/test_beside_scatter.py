"""What of errors on left-out conditions scatter from run to run can't have made."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.foretold import explained_share
from pipeclamp_identification.diagnosis.left_out import LeftOutScore
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter, ScatterAxes
from pipeclamp_identification.signals.real_harmonics import by_mean_square, mean_squares_of
from pipeclamp_models.base.arrays import Array

RUNS, CHANNELS, NOISE, MISSING = 48, 7, 0.02, 0.5


def rig(scatter: RunScatter) -> tuple[ScatterAxes, Array]:
    """Give how the runs of a rig scatter, and the elastic force, N."""
    elastic, none = np.zeros((RUNS, CHANNELS)), np.zeros((RUNS, CHANNELS))
    elastic[:, 1] = np.linspace(100.0, 1000.0, RUNS)
    noise = mean_squares_of(np.full((RUNS, CHANNELS), NOISE))
    return scatter.axes(Directions(elastic, none, none), 1.0, noise), elastic


def shares(scatter: RunScatter, draws: int = 40) -> list[float]:
    """Draw errors in which an even harmonic is missing; give what a law takes that has it, its mean off by as much."""
    random = np.random.default_rng(3)
    axes, elastic = rig(scatter)
    found = []
    for _ in range(draws):
        errors = NOISE * random.standard_normal((RUNS, CHANNELS))
        errors[:, 0] += scatter.mean_N * random.standard_normal(RUNS)
        errors += scatter.stiffness * random.standard_normal((RUNS, 1)) * elastic
        missing, mean = np.zeros_like(errors), np.zeros_like(errors)
        missing[:, 4] = MISSING * np.sqrt(2)
        mean[:, 0] = MISSING
        before, after = (LeftOutScore(np.ones(RUNS), each, axes) for each in (errors + missing, errors - mean))
        law = SimpleNamespace(score=before, missing=RUNS * MISSING**2)
        found.append(explained_share(SimpleNamespace(score=after), law))
    return found


@pytest.mark.parametrize("scatter", [RunScatter(mean_N=9.0), RunScatter(stiffness=0.01, mean_N=9.0)])
def test_what_no_run_can_differ_by_is_taken_whatever_scatters(scatter):
    """Of a weak asymmetry beneath zeros that scatter, what it is itself had taken nothing: nothing was named."""
    assert min(shares(scatter)) > 0.9


def test_a_mean_that_is_foretold_wrongly_counts_where_none_scatters():
    assert max(shares(RunScatter())) < 0.1


def test_a_mean_that_lies_beneath_scatter_tells_little():
    """A weak drift of damping went second to an offset, which took two thirds of what zeros had made by chance."""
    axes, _ = rig(RunScatter(mean_N=5.0))
    random = np.random.default_rng(5)
    errors = np.zeros((RUNS, CHANNELS))
    errors[:, 0] = 2.0 + 5.0 * random.standard_normal(RUNS)
    errors[:, 2] = 2.0 * np.sqrt(2)
    without_mean, without_damping = errors.copy(), errors.copy()
    without_mean[:, 0] -= np.mean(errors[:, 0])
    without_damping[:, 2] = 0.0
    before, offset, drift = (
        SimpleNamespace(score=LeftOutScore(np.ones(RUNS), each, axes), missing=RUNS * 8.0)
        for each in (errors, without_mean, without_damping)
    )
    assert explained_share(offset, before) < 0.3
    assert explained_share(drift, before) > 0.7


def test_what_is_clearly_more_than_scatter_counts_in_full():
    axes, _ = rig(RunScatter(stiffness=0.001, mean_N=1.0))
    errors = 100.0 * np.random.default_rng(1).standard_normal((RUNS, CHANNELS))
    assert axes.beside(errors, 1e4) == pytest.approx(mean_squares_of(errors), rel=2e-3)
    assert np.sum(by_mean_square(errors) ** 2, axis=1) == pytest.approx(mean_squares_of(errors))
    assert axes.by_chance(1e12) == pytest.approx(axes.noise + np.sum(axes.variance, axis=1))
