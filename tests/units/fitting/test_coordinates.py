"""Coordinates of a fit: coefficients in the middle of the tests, from which the parameters come back exactly."""

import numpy as np
import pytest
import scipy.optimize

from pipeclamp_identification.campaign.reading import read_campaign
from pipeclamp_identification.campaign.records import Record
from pipeclamp_identification.campaign.writing import WrittenRun, write_campaign
from pipeclamp_identification.fitting.joint import coordinates
from pipeclamp_identification.fitting.joint.beforehand import parameter_bounds, priors_of
from pipeclamp_identification.fitting.joint.coordinates import Coordinates, coordinates_at
from pipeclamp_identification.fitting.joint.evaluator import Evaluator, Remembered, smoothing_of
from pipeclamp_identification.fitting.joint.points import starting_points
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import data_scales, loop_observations
from pipeclamp_identification.loops.loops import loops_of
from pipeclamp_models.law.law import Structure

POWER = Structure("power", frozen=(("k1_T", 0.0), ("k3_T", 0.0)))
FAR = (0.02, 0.03, 0.045)
"""Amplitudes far from A0, in mm."""


@pytest.fixture(scope="module")
def observations(tmp_path_factory):
    """A stiffness and a friction that fall with the amplitude, far from 1 mm."""
    folder, t, runs = tmp_path_factory.mktemp("tests") / "c", np.arange(400) / 100, []
    random = np.random.default_rng(3)
    for amplitude in FAR:
        for f in (1.0, 2.0):
            y, v = amplitude * np.sin(2 * np.pi * f * t), np.cos(2 * np.pi * f * t)
            force = (
                20 * (amplitude / 0.03) ** -0.4 * y + 0.2 * (amplitude / 0.03) ** 0.5 * np.sign(v) * np.abs(v) ** 0.4
            )
            record = Record(t, y, force + 0.002 * random.standard_normal(len(t)))
            runs.append(WrittenRun({"run": f"a{amplitude:g}f{f:g}", "temperature_C": 20.0}, record))
    write_campaign(folder, iter(runs), name="c", notes="")
    return loop_observations(loops_of(read_campaign(folder)))


@pytest.fixture(scope="module")
def beginning(observations):
    """Give where a fit begins, and what evaluates the law there, of all parameters but those over T."""
    equations = POWER.equations
    values = starting_points(POWER, observations, {})[0]
    free = np.array([place for place, name in enumerate(equations.names) if not name.endswith("_T")])
    begin = np.array([values[name] for name in equations.names])
    evaluator = Evaluator(Remembered(observations, equations, smoothing_of(observations)), begin, free)
    return evaluator, begin[free]


def made_at(beginning, observations):
    evaluator, at = beginning
    equations, scales = evaluator.law.equations, data_scales(observations)
    bounds = tuple(bound[evaluator.free] for bound in parameter_bounds(equations, scales))
    return coordinates_at(evaluator, at, bounds, priors_of(equations, scales).of(evaluator.free))


def test_sizes_stand_in_the_middle_of_the_tests(beginning, observations):
    found = made_at(beginning, observations)
    names = np.array(POWER.equations.names)[beginning[0].free]
    assert list(names[found.sizes]) == ["k10", "k30", "c0"]  # alpha0 has an upper bound
    assert list(names[found.shapes]) == ["k1_A", "k3_A", "c_A", "c_f"]
    rate = found.rates[0, 0]
    assert np.log(FAR[0]) < rate < np.log(FAR[-1])
    np.testing.assert_array_equal(found.rates[0, 1:], 0.0)


def test_parameters_come_back_and_derivatives_are_exact(beginning, observations):
    evaluator, at = beginning
    found = made_at(beginning, observations)
    np.testing.assert_array_equal(found.of(at), at)
    moved = at + 0.1 * np.random.default_rng(0).uniform(0.5, 1.0, len(at))
    there = found.of(moved)
    np.testing.assert_allclose(found.parameters(there), moved, rtol=1e-14)
    slopes = found.slopes(evaluator.jacobian(moved), moved)
    for place, size in enumerate(1e-6 * np.maximum(np.abs(there), 0.1)):
        sides = [evaluator.residual(found.parameters(there + sign * size * np.eye(len(at))[place])) for sign in (1, -1)]
        expected = (sides[0] - sides[1]) / (2 * size)
        np.testing.assert_allclose(slopes[:, place], expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


def test_a_fit_ends_where_it_did_in_fewer_evaluations(observations, monkeypatch):
    counts, minimise = [], scipy.optimize.least_squares

    def counting(residual, start, **how):
        found = minimise(residual, start, **how)
        counts.append(found.nfev)
        return found

    monkeypatch.setattr(scipy.optimize, "least_squares", counting)
    ours = fit(POWER, observations)
    own = Coordinates(np.array([], dtype=np.intp), np.array([], dtype=np.intp), np.zeros((0, 0)), np.zeros(0))
    with monkeypatch.context() as plain:
        plain.setattr("pipeclamp_identification.fitting.least_squares.coordinates_at", lambda *_: own)
        theirs = fit(POWER, observations)
    assert ours.cost <= theirs.cost * (1 + 1e-6)
    assert counts[0] < counts[1]
    errors = theirs.standard_errors()
    for name, error in ours.standard_errors().items():
        assert error == pytest.approx(errors[name], rel=1e-2)
        assert ours.law.values[name] == pytest.approx(theirs.law.values[name], abs=1e-2 * error)


def test_a_size_of_any_size_stays_a_number():
    far = Coordinates(np.array([0]), np.array([1]), np.array([[1e4]]), np.array([0.0]))
    for shape in (-1.0, 1.0):
        values = np.array([2.0, shape])
        assert np.isfinite(far.of(values)).all()
        np.testing.assert_allclose(far.parameters(far.of(values)), values)
    assert np.log(np.finfo(float).max) > coordinates.LARGEST_LOG
