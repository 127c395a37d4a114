"""What of the residuals follows the conditions, and how much of it scatter from run to run may hide."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeclamp_identification.diagnosis.evidence import LackOfFit, lack_of_fit
from pipeclamp_identification.diagnosis.left_out import Whitened
from pipeclamp_identification.diagnosis.noise import NoiseModel
from pipeclamp_identification.diagnosis.run_scatter import Directions, RunScatter
from pipeclamp_identification.diagnosis.weighing.reasons import scatter_words
from pipeclamp_identification.fitting.smooth_trends import smooth_functions

AMPLITUDES, FREQUENCIES = (0.1, 0.2, 0.5, 1.0), (4.0, 8.0, 15.0, 30.0)
CHANNELS, NOISE, SCATTER, HIDDEN = 7, 0.1, 0.3, 0.2
DRAWS = 200


def told(random: np.random.Generator, repeats: int) -> LackOfFit:
    """Draw residuals of which HIDDEN, rms in N, follows log A and each part scatters by SCATTER from run to run."""
    A, f = np.repeat(np.array([(A, f) for A in AMPLITUDES for f in FREQUENCIES]), repeats, axis=0).T
    runs = len(A)
    follows = np.log(A) - np.mean(np.log(A))
    residual = SCATTER * random.standard_normal((runs, CHANNELS))
    residual[:, 1] += np.sqrt(2) * HIDDEN * follows / np.sqrt(np.mean(follows**2))
    none = np.zeros_like(residual)
    model = NoiseModel(np.full_like(residual, SCATTER**2), Directions(none, none, none), RunScatter(), 0.0)
    fitted = Whitened(residual / SCATTER, np.zeros((runs, CHANNELS, 1)), np.zeros(0))
    smooth = smooth_functions(A, f, np.full(runs, 293.15), (), [None] * runs)
    return lack_of_fit(fitted, residual, model, smooth, np.zeros((1, 1, runs, CHANNELS)), np.full(runs, NOISE))


@pytest.mark.parametrize("repeats", [1, 3])
def test_what_scatter_may_hide_bounds_what_is_there(repeats):
    random = np.random.default_rng(7)
    draws = [told(random, repeats) for _ in range(DRAWS)]
    true = HIDDEN / NOISE
    assert all(each.sure_share <= each.share <= each.most_share for each in draws)
    assert np.mean([each.most_share > true for each in draws]) > 0.9
    assert np.mean([each.sure_share < true for each in draws]) > 0.9


def test_repeats_leave_scatter_less_to_hide():
    random = np.random.default_rng(7)
    once, thrice = (np.median([told(random, repeats).most_share for _ in range(DRAWS)]) for repeats in (1, 3))
    assert HIDDEN / NOISE < thrice < 0.85 * once


def beneath_scatter(form: float) -> list[LackOfFit]:
    """Draw damping that scatters from run to run, and of which a form in another harmonic, rms in N, is no part."""
    random = np.random.default_rng(11)
    A, f = np.array([(A, f) for A in AMPLITUDES for f in FREQUENCIES]).T
    shape, runs = (len(A), CHANNELS), len(A)
    damping = np.zeros(shape)
    damping[:, 2] = 60.0 * A
    scatter = RunScatter(damping=0.02)
    follows = np.log(A) - np.mean(np.log(A))
    found = []
    for _ in range(DRAWS):
        residual = 0.02 * NOISE * random.standard_normal(shape) + 0.02 * random.standard_normal((runs, 1)) * damping
        residual[:, 3] += np.sqrt(2) * form * follows / np.sqrt(np.mean(follows**2))
        none = np.zeros(shape)
        model = NoiseModel(np.full(shape, (0.02 * NOISE) ** 2), Directions(none, damping, none), scatter, 0.0)
        white = np.einsum("rij,rj->ri", model.whitener(), residual)
        fitted = Whitened(white, np.zeros((*shape, 1)), np.zeros(0))
        smooth = smooth_functions(A, f, np.full(runs, 293.15), (), [None] * runs)
        found.append(lack_of_fit(fitted, residual, model, smooth, np.zeros((1, 1, *shape)), np.full(runs, NOISE)))
    return found


@pytest.mark.parametrize("form", [0.0, 0.2])
def test_what_no_run_can_differ_by_is_sure_however_much_scatters(form):
    """Damping that scatters by more than what was left had made a wrong form pass for a cause's own."""
    shares = [lack.sure_share for lack in beneath_scatter(form)]
    if form:
        assert min(shares) > 0.95 * form / NOISE
        assert np.mean(np.array(shares) < 1.05 * form / NOISE) > 0.9
    else:
        assert np.mean(np.array(shares) < 0.1) > 0.9


def test_what_is_sure_follows_the_conditions_at_least():
    """Where scatter happened to be small it hid a weak oil damper, 350 squares off the law, which was complete."""
    assert all(lack.sure_share <= lack.share <= lack.most_share for lack in beneath_scatter(0.2))


def test_stretches_of_a_run_are_off_alike_and_tell_of_scatter_once():
    """Stretches had counted as runs: what scatters from run to run followed the conditions of a law that ages."""
    random = np.random.default_rng(5)
    A, f = np.array([(A, f) for A in AMPLITUDES for f in FREQUENCIES]).T
    shape = (3 * len(A), CHANNELS)
    damping = np.zeros(shape)
    damping[:, 2] = 60.0 * np.repeat(A, 3)
    cycle = np.tile([1.0, 2.0, 3.0], len(A)) + np.repeat(10.0 * random.permutation(len(A)), 3)
    temperature, specimen = np.full(len(cycle), 293.15), [None] * len(cycle)
    smooth = smooth_functions(np.repeat(A, 3), np.repeat(f, 3), temperature, (cycle,), specimen, runs=len(A))
    none = np.zeros(shape)
    chances = []
    for _ in range(DRAWS):
        off = np.repeat(0.02 * random.standard_normal((len(A), 1)), 3, axis=0) * damping
        residual = off + 0.02 * NOISE * random.standard_normal(shape)
        variance = np.full(shape, (0.02 * NOISE) ** 2)
        model = NoiseModel(
            variance, Directions(none, damping, none), RunScatter(damping=0.02), 0.0, np.full(len(A) * 3, 3.0)
        )
        assert model.runs == len(A)
        fitted = Whitened(np.einsum("rij,rj->ri", model.whitener(), residual), np.zeros((*shape, 1)), np.zeros(0))
        lack = lack_of_fit(fitted, residual, model, smooth, np.zeros((1, 1, *shape)), np.full(len(cycle), NOISE))
        chances.append(lack.p_value)
    assert np.mean(np.array(chances) < 0.01) < 0.03


@pytest.mark.parametrize("constant", [0.0, 4.0])
def test_of_mean_forces_counts_what_scatter_told_by_few_runs_can_not_have_made(constant):
    """By the normal distribution a tenth of all rigs whose zeros scatter had means that "follow the conditions"."""
    random = np.random.default_rng(3)
    A, f, T = np.array([(A, f, T) for A in AMPLITUDES for f in FREQUENCIES for T in (290.0, 350.0, 400.0)]).T
    runs, of_means = len(A), 5.0
    smooth = smooth_functions(A, f, T, (), [None] * runs)
    free, shape = runs - smooth.shape[1], (runs, CHANNELS)
    standard_error = of_means / np.sqrt(runs)
    none, variance = np.zeros(shape), np.full(shape, NOISE**2)
    left = []
    for _ in range(2 * DRAWS):
        residual = NOISE * random.standard_normal(shape)
        residual[:, 0] += of_means * random.standard_normal(runs) + constant * standard_error
        mean_N = of_means * np.sqrt(random.chisquare(free) / free)
        model = NoiseModel(variance, Directions(none, none, none), RunScatter(mean_N=mean_N), 0.0)
        fitted = Whitened(np.einsum("rij,rj->ri", model.whitener(), residual), np.zeros((*shape, 1)), np.zeros(0))
        lack = lack_of_fit(fitted, residual, model, smooth, (), np.full(runs, NOISE))
        left.append(np.sqrt(max(lack.by_channel[0], 0.0)))
    if constant:
        assert np.mean(np.array(left) > 0.5 * constant * standard_error) > 0.75
    else:
        assert np.mean(np.array(left) > 0.0) < 0.07


@pytest.mark.parametrize(
    ("share", "words"),
    [
        (
            0.02,
            "what follows the conditions is 1.3 N, 2.0% of the force noise; the rest is noise, and 0.20% of stiffness",
        ),
        (
            0.99,
            "what seems to follow the conditions is 1.3 N, 0.99 times the force noise; noise and scatter of 0.20% of "
            "stiffness from run to run make as much by chance",
        ),
    ],
)
def test_what_scatter_may_hide_is_no_share_that_follows_the_conditions(share, words):
    """A complete law's reason had said that 99.9 % of the force noise follow the conditions, "the rest is noise".

    And nowhere how large that is in newtons.
    """
    noise = SimpleNamespace(scatter=RunScatter(stiffness=0.002), mean_shows=False, zero_shows=False)
    problem = SimpleNamespace(noise=noise)
    assert scatter_words(SimpleNamespace(share=share, rms=1.3, p_value=0.5), problem).startswith(words)


def test_what_scatter_makes_is_no_lack_of_form_and_the_rest_is():
    """A residual of the size that scatter may have, but of another form, had counted as scatter: weights ran away."""
    elastic = np.array([[0.0, 300.0, 0.0, 30.0, 0.0], [0.0, 100.0, 0.0, -5.0, 0.0]])
    damping = np.array([[0.0, 0.0, 80.0, 0.0, 9.0], [0.0, 0.0, 0.0, 0.0, 0.0]])
    directions = Directions(elastic, damping, np.zeros_like(elastic))
    noise = NoiseModel(np.full((2, 5), 0.01), directions, RunScatter(0.02, 0.02), 0.0)
    form = np.array([[1.0, -0.3, 0.0, 3.0, 0.0], [0.5, 0.0, 2.0, 0.0, -1.0]])
    scattered = 0.015 * elastic - 0.01 * damping
    assert noise.no_scatter(scattered) == pytest.approx(0.0, abs=1e-12)
    assert noise.no_scatter(form + scattered) == pytest.approx(form)
    assert np.sum(form**2 - noise.total_variance()) < 0 < np.sum(noise.no_scatter(form) ** 2 - noise.variance)
