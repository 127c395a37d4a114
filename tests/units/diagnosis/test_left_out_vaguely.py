"""What a law foretells vaguely of runs left out speaks against it less than what it foretells wrongly."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.left_out import Whitened, WithoutGroups

RUNS, SAMPLES, EDGE = 12, 8, 3
"""Runs of so many samples each, of which the last are left out."""


class LinearLaw(WithoutGroups):
    """A law that is where the linear formula says, however far that is."""

    def _evaluated(self, step, own, plain):
        return self.fitted.residual[own] + self.fitted.jacobian[own] @ step, plain


def line(places, powers, truth, *, precision=0.01, seed=7):
    """A linear law fitted to noise of unit size about a truth at places, shape (R, m), with a prior about zero."""
    slopes = np.stack([places**power for power in powers], axis=-1)
    flat = slopes.reshape(-1, len(powers))
    measured = truth(places) + np.random.default_rng(seed).standard_normal(places.shape)
    known = flat.T @ flat + precision * np.eye(len(powers))
    residual = measured - slopes @ np.linalg.solve(known, flat.T @ measured.ravel())
    count = len(powers)
    result = SimpleNamespace(
        fitted=tuple(map(str, powers)), room=np.array([[-np.inf], [np.inf]]) + np.zeros(count),
        precision=np.full(count, precision), law_force=None, places=np.arange(count),
    )  # fmt: skip
    loops = SimpleNamespace(
        seen=np.ones(places.shape, dtype=bool), plain_residual=lambda force: residual,
        plain_slopes=lambda force, at: -np.moveaxis(slopes, -1, 0),
    )  # fmt: skip
    observations = SimpleNamespace(loops=loops, factors=None)
    return LinearLaw(result, observations, observations, Whitened(residual, -slopes, np.zeros(0))), slopes, measured


def edge_of(places):
    return np.arange(len(places)) >= len(places) - EDGE


def test_of_a_linear_law_it_is_the_likelihood_of_the_rest_foretelling_the_group():
    places = np.random.default_rng(1).uniform(-1, 1, (RUNS, SAMPLES))
    law, slopes, measured = line(places, (0, 1, 2), lambda x: 1 + 2 * x)
    own = edge_of(places)
    there, rest = slopes[own].reshape(-1, 3), slopes[~own].reshape(-1, 3)
    known = rest.T @ rest + 0.01 * np.eye(3)
    off = measured[own].ravel() - there @ np.linalg.solve(known, rest.T @ measured[~own].ravel())
    spread = np.eye(len(there)) + there @ np.linalg.solve(known, there.T)
    expected = off @ np.linalg.solve(spread, off) + np.linalg.slogdet(spread)[1]
    assert law.unlikelihood(own) == pytest.approx(expected, rel=1e-6)


def test_what_the_others_hardly_determine_is_no_error():
    """By squares a true law was foretold worse beyond than one that lacks a term, for less was known of it there."""
    places = np.sort(np.random.default_rng(2).uniform(0, 1, (RUNS, SAMPLES)).ravel()).reshape(RUNS, SAMPLES)
    own = edge_of(places)

    def truth(x):
        return 5 + 3 * x + 4 * x**4

    short, right = (line(places, powers, truth)[0] for powers in ((0, 1), (0, 1, 2, 4, 6)))
    squares = [law.score(np.where(own, 0, -1)).squares.sum() for law in (short, right)]
    assert squares[1] > squares[0]
    assert right.unlikelihood(own) < short.unlikelihood(own)
