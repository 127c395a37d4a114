"""Standard errors of fitted parameters: as wide as estimates really scatter, however few the runs are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeclamp_identification.fitting.joint.covariance import covariance_of, moved_by_runs

VALUES, PARAMETERS = 40, 12
SHAPES = np.linalg.qr(np.random.default_rng(1).normal(size=(VALUES, 4)))[0] * (30, 10, 3, 1)
"""Four shapes of a loop, in units of its noise: stiffness and damping, linear and cubic."""


def jacobian_of(runs):
    """Give the Jacobian of a law whose four coefficients each follow two conditions, (R, m, P)."""
    A = np.log(np.resize([0.1, 0.2, 0.4, 0.8], runs))
    further = np.stack([np.log(np.resize([1.0, 3.0, 9.0], runs)), np.resize([0, 0, 0, 1, 1, 1, 2, 2], runs)])
    at = [np.column_stack([np.ones(runs), A - A.mean(), each - each.mean()]) for each in further]
    return np.concatenate(
        [np.einsum("m,rq->rmq", shape, at[order % 2]) for order, shape in enumerate(SHAPES.T)], axis=2
    )


def fitted(jacobian, force):
    """Give estimates and their covariance."""
    flat = jacobian.reshape(-1, PARAMETERS)
    norms = np.linalg.norm(flat, axis=0)
    estimate = np.linalg.lstsq(flat, force.ravel(), rcond=None)[0]
    residual = force - jacobian @ estimate
    return estimate, covariance_of(flat / norms, norms, residual, force.size, np.zeros(PARAMETERS))


@pytest.mark.parametrize("scatter", [0.0, 0.05])
@pytest.mark.parametrize("runs", [8, 16, 24, 27, 48])
def test_95_percent_hold_the_truth_however_many_runs_there_are(runs, scatter):
    """Runs whose stiffness and damping scatter by 5 %, and such that don't."""
    jacobian, drawn, held = jacobian_of(runs), np.random.default_rng(runs), []
    for _ in range(200):
        off = scatter * drawn.normal(size=(runs, 4))
        estimate, covariance = fitted(jacobian, off @ SHAPES.T + drawn.normal(size=(runs, VALUES)))
        held.append(np.abs(estimate) < 1.96 * np.sqrt(np.diag(covariance)))
    assert np.mean(held) > 0.93
    assert np.min(np.mean(held, axis=0)) > 0.88
    assert np.mean(held) < 0.99


def test_it_is_how_far_the_fit_moves_without_each_run():
    jacobian, drawn = jacobian_of(12), np.random.default_rng(2)
    force = drawn.normal(size=jacobian.shape[:2])
    flat = jacobian.reshape(-1, PARAMETERS)
    whole, _ = fitted(jacobian, force)
    without = [fitted(np.delete(jacobian, run, axis=0), np.delete(force, run, axis=0))[0] for run in range(12)]
    moved = moved_by_runs(jacobian, np.linalg.inv(flat.T @ flat), force - jacobian @ whole)
    assert moved == pytest.approx(np.sum((np.array(without) - whole) ** 2, axis=0), rel=1e-8)


@settings(max_examples=30, deadline=None)
@given(st.integers(8, 60), st.randoms(use_true_random=False), st.floats(1e-3, 1e3))
def test_neither_the_order_of_runs_nor_units_of_parameters_count(runs, random, unit):
    jacobian, drawn = jacobian_of(runs), np.random.default_rng(runs)
    force = drawn.normal(size=(runs, VALUES)) + 0.05 * drawn.normal(size=(runs, 4)) @ SHAPES.T
    order = random.sample(range(runs), runs)
    covariance = fitted(jacobian, force)[1]
    assert fitted(jacobian[order], force[order])[1] == pytest.approx(covariance, rel=1e-6, abs=1e-12)
    assert fitted(unit * jacobian, force)[1] * unit**2 == pytest.approx(covariance, rel=1e-6, abs=1e-12)


def test_a_parameter_that_one_run_alone_determines_keeps_its_stated_error():
    jacobian = jacobian_of(12)
    jacobian[1:, :, -1] = 0.0
    force = np.random.default_rng(3).normal(size=jacobian.shape[:2])
    covariance = fitted(jacobian, force)[1]
    assert np.all(np.isfinite(covariance))
    assert 0 < covariance[-1, -1] < 100 / np.sum(jacobian[0, :, -1] ** 2)


def test_a_parameter_that_hardly_moves_the_force_has_a_standard_error_that_is_a_number():
    jacobian = jacobian_of(8).reshape(-1, PARAMETERS)
    norms = np.linalg.norm(jacobian, axis=0) * np.resize([1.0, 1e-200], PARAMETERS)
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        covariance = covariance_of(
            jacobian / np.linalg.norm(jacobian, axis=0), norms, np.ones((8, VALUES)), 8 * VALUES, np.zeros(PARAMETERS)
        )
    assert np.all(np.isfinite(covariance))


def test_stretches_of_one_run_tell_no_more_of_it_than_the_run():
    """A law that ages is fitted to stretches of records: three of one run had counted as three runs."""
    jacobian, drawn = jacobian_of(12), np.random.default_rng(4)
    force = drawn.normal(size=(12, VALUES)) + 0.05 * drawn.normal(size=(12, 4)) @ SHAPES.T
    flat = jacobian.reshape(-1, PARAMETERS)
    norms = np.linalg.norm(flat, axis=0)
    estimate, whole = fitted(jacobian, force)
    residual = force - jacobian @ estimate
    order = drawn.permutation(36)
    runs = np.repeat(np.arange(12), 3)[order]
    parted = [np.repeat(one, 3, axis=0)[order] / np.sqrt(3) for one in (jacobian, residual)]
    scaled = parted[0].reshape(-1, PARAMETERS) / norms
    covariance = covariance_of(scaled, norms, parted[1], force.size, np.zeros(PARAMETERS), runs)
    assert covariance == pytest.approx(whole, rel=1e-8)
    apart = covariance_of(scaled, norms, parted[1], force.size, np.zeros(PARAMETERS))
    assert np.all(np.diag(apart)[:4] < 0.5 * np.diag(whole)[:4])
