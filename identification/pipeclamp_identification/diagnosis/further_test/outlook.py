"""What tests would tell between rivals: what each foretells, against scatter, its form and its own doubt."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from pipeclamp_identification.campaign.drive import Profile, tones_motion
from pipeclamp_identification.diagnosis.problem import Judged
from pipeclamp_identification.diagnosis.run_scatter import Directions, of_a_shift
from pipeclamp_identification.diagnosis.thresholds import FORM_SHARE
from pipeclamp_identification.diagnosis.verdict import Diagnosis
from pipeclamp_identification.fitting.joint.beforehand import parameter_bounds
from pipeclamp_identification.fitting.joint.not_fitted import DENIED, OF_THE_LAW
from pipeclamp_identification.fitting.observations import SAMPLES_PER_CYCLE, data_scales, harmonic_slopes
from pipeclamp_identification.signals.real_harmonics import elastic_and_damping, real_harmonics_of
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.realise.force import LawForce, force_of_equations
from pipeclamp_models.realise.motion import Motion
from pipeclamp_models.realise.sizes import about

HARMONICS_FORETOLD = 12
"""Of the force of a proposed test, in which rivals are told apart."""
CYCLES_OF_A_TEST = 5
"""Cycles of each of its runs, over which noise is averaged."""
RUNS_OF_A_TEST = 3
"""Runs of a proposed test: what scatters from run to run shows in repeats only."""
LEAST_DEVIATIONS = 2.0
"""Standard deviations below which it doesn't tell: one rival would be taken for the other in one case of six."""
TELLING_SHARE = 1e-12
"""Share of what tests tell best below which they tell nothing: rounding."""
RIDING_SHARE = 0.25
"""Amplitude of the small cycles that may ride on a large one, as a share of its."""
RIDING_ORDER = 7
"""So many of them a cycle."""
SINE, RIDDEN = "sine", "small cycles on a large one"
PROFILES = {
    SINE: Profile("a sine test", ((1, 1.0),)),
    RIDDEN: Profile(
        f"small cycles on a large one ({RIDING_SHARE:g} of its amplitude at {RIDING_ORDER} times its frequency)",
        ((1, 1.0), (RIDING_ORDER, RIDING_SHARE)),
    ),
}


@dataclass(frozen=True)
class Foreseer:
    """A rival with what it doesn't know.

    Attributes:
        judged: the rival.
        places: of parameters that are in doubt, those that the tests so far hold open included.
        doubt: what it doesn't know of them as q independent sources of unit variance, shape (places, q).
    """

    judged: Judged
    places: IntArray
    doubt: Array


def foreseer(judged: Judged, diagnosis: Diagnosis) -> Foreseer:
    """Give a rival with its doubt.

    A parameter that was held, as what it follows didn't vary, is fitted once a test varies it: until then all that is
    known of it is its bounds, as an even spread between them.
    """
    result, observations = judged.result, diagnosis.problem.observations
    equations = result.equations
    lower, upper = parameter_bounds(equations, data_scales(observations))
    held = {name for name, reason in result.frozen.items() if reason not in (*OF_THE_LAW, DENIED)}
    opened = [
        place
        for place, name in enumerate(equations.names)
        if name in held and np.isfinite(upper[place] - lower[place]) and equations.parameters[place].follows
    ]
    places = np.array([*result.places, *opened], dtype=np.intp)
    law = result.law
    law_force = force_of_equations(
        equations, law.vector(equations), (law.v_r, law.y_r), observations.motion, derivatives=True
    )
    slopes = np.nan_to_num(observations.residual_slopes(law_force, places).reshape(len(places), -1))
    information = slopes @ slopes.T
    evenly = np.arange(len(result.places), len(places))
    information[evenly, evenly] += 12.0 / (upper - lower)[opened] ** 2
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    known, ways = np.linalg.eigh(information / np.outer(scale, scale))
    told = known > TELLING_SHARE * known.max(initial=0.0)
    return Foreseer(judged, places, ways[:, told] / np.sqrt(known[told]) / scale[:, None])


ConditionArrays = Mapping[str, Array]
"""Slow signals of the conditions that are looked at, each of shape (R,); T in K."""


@dataclass(frozen=True)
class Outlook:
    """What tests of one profile would tell: for R conditions.

    Attributes:
        profile: SINE or RIDDEN.
        grid: the conditions.
        motion: R motions.
        forces: of each rival, N, shape (rivals, R, n).
        mistaken: log of the chance of taking one rival for another, summed over pairs, shape (R,).
        apart: standard deviations between the two rivals, of each pair, shape (pairs, R).
    """

    profile: str
    grid: ConditionArrays
    motion: Motion
    forces: Array
    mistaken: Array
    apart: Array

    @property
    def peak_forces(self) -> Array:
        """The largest force that any rival foretells, N, shape (R,)."""
        return np.asarray(np.max(np.abs(self.forces), axis=(0, 2)))

    @property
    def tells(self) -> BoolArray:
        """Whether at least two rivals are told apart, shape (R,)."""
        return np.asarray(self.apart.max(axis=0) >= LEAST_DEVIATIONS)

    def rows(self, chosen: IntArray) -> Outlook:
        """Give some of the conditions, by their places, shape (n,)."""
        grid = {name: values[chosen] for name, values in self.grid.items()}
        return Outlook(
            self.profile, grid, self.motion.rows(chosen), self.forces[:, chosen], self.mistaken[chosen],
            self.apart[:, chosen],
        )  # fmt: skip


def outlook_of(profile: str, grid: ConditionArrays, rivals: Sequence[Foreseer], diagnosis: Diagnosis) -> Outlook:
    """Tell what tests of a profile at a grid of conditions would tell.

    Args:
        profile: name of the motion.
        grid: conditions of C tests by name, shape (C,) each.
        rivals: laws that are to be told apart.
        diagnosis: that left them.
    """
    motion = _motions(grid, profile, diagnosis)
    without = real_harmonics_of(_law_force(diagnosis.law, motion).force, HARMONICS_FORETOLD)
    law_forces = [_law_force(rival.judged, motion) for rival in rivals]
    noise, form = _noise(motion, without, diagnosis), _form(law_forces, without)
    pairs = list(itertools.combinations(range(len(rivals)), 2))
    known = np.stack([_distance(rivals, law_forces, pair, noise + form) for pair in pairs])
    apart = np.stack([_distance(rivals, law_forces, pair, noise) for pair in pairs])
    forces = np.stack([law_force.force for law_force in law_forces])
    return Outlook(profile, grid, motion, forces, logsumexp(-(known**2) / 8, axis=0), apart)


def _motions(grid: ConditionArrays, profile: str, diagnosis: Diagnosis) -> Motion:
    """Give the motions of a grid of conditions, where the tests move; what it doesn't name as in the middle run."""
    column = {name: values[:, None] for name, values in grid.items()}
    A, f = column["A"], column["f"]
    theta = 2 * np.pi * np.arange(SAMPLES_PER_CYCLE) / SAMPLES_PER_CYCLE
    y, v, a = tones_motion(PROFILES[profile].tones, A, f, theta)
    so_far = diagnosis.problem.observations.motion
    y, tested = y + about(so_far), so_far.slow
    middle = {name: np.full_like(A, float(np.median(values))) for name, values in tested.items()}
    return Motion(y, v, a, {**middle, **column}, 1.0 / (f * SAMPLES_PER_CYCLE))


def _law_force(judged: Judged, motion: Motion) -> LawForce:
    law, equations = judged.result.law, judged.result.equations
    return force_of_equations(equations, law.vector(equations), (law.v_r, law.y_r), motion, derivatives=True)


def _noise(motion: Motion, force: Array, diagnosis: Diagnosis) -> Array:
    """Give the covariance of the mean harmonics of repeated runs: noise and scatter between runs, shape (R, m, m).

    Args:
        motion: R motions.
        force: its harmonics by the law as it is, N, shape (R, m).
        diagnosis: how much noise and scatter there is, at the sampling of the tests so far.
    """
    loops, noise = diagnosis.problem.loops, diagnosis.problem.noise
    rate = float(np.median(loops.samples * loops.frequency_Hz / np.maximum([len(c) for c in loops.cycles], 1)))
    of_sensor = sensor_noise(float(np.median(loops.noise_rms_N)), rate, motion, force.shape[1])
    shifted = of_a_shift(diagnosis.law.result.law, motion, lambda forces: real_harmonics_of(forces, HARMONICS_FORETOLD))
    return (of_sensor + noise.scatter.covariance(Directions(*elastic_and_damping(force), shifted))) / RUNS_OF_A_TEST


def sensor_noise(rms_N: float | Array, rate: float, motion: Motion, count: int) -> Array:
    """Give the covariance of the mean harmonics of one run, which the force sensor's noise makes.

    Args:
        rms_N: of a sample, or of those of each run, shape (R,).
        rate: samples per second.
        motion: R motions.
        count: of the harmonics as real numbers, m.

    Returns:
        N2, shape (R, m, m).
    """
    white = np.broadcast_to(rms_N, len(motion.y)) ** 2 * 2 / CYCLES_OF_A_TEST
    samples = np.maximum(rate / motion.slow["f"][:, 0], 1.0)
    return np.asarray(np.eye(count) * (white / samples)[:, None, None])


def _form(law_forces: Sequence[LawForce], without: Array) -> Array:
    """Give the covariance of harmonics that effects of another form than the catalogue's may leave over, (R, m, m).

    Args:
        law_forces: of the rivals on R motions.
        without: harmonics of the law without any of them, N, shape (R, m).
    """
    beyond = [np.sum((real_harmonics_of(each.force, HARMONICS_FORETOLD) - without) ** 2, axis=1) for each in law_forces]
    return np.asarray(np.eye(without.shape[1]) * (FORM_SHARE**2 * np.max(beyond, axis=0))[:, None, None])


def _distance(
    rivals: Sequence[Foreseer], law_forces: Sequence[LawForce], pair: tuple[int, int], granted: Array
) -> Array:
    """Give the Mahalanobis distance of what two rivals foretell when the other is refitted to either, shape (R,).

    Args:
        rivals: all of them.
        law_forces: of each on R motions.
        pair: the two.
        granted: covariance of harmonics that tells nothing, N2, shape (R, m, m).
    """
    foretold = [real_harmonics_of(law_forces[place].force, HARMONICS_FORETOLD) for place in pair]
    difference = foretold[0] - foretold[1]
    slopes = [harmonic_slopes(law_forces[place], HARMONICS_FORETOLD, rivals[place].places) for place in pair]
    doubts = [np.einsum("prm,pq->rmq", each, rivals[place].doubt) for each, place in zip(slopes, pair, strict=True)]
    finite = np.isfinite(difference).all(axis=1) & np.isfinite(granted).all(axis=(1, 2))
    for doubt in doubts:
        finite &= np.isfinite(doubt).all(axis=(1, 2))
    distance = np.zeros(len(difference))
    lower = np.linalg.cholesky(granted[finite])
    white = np.linalg.solve(lower, difference[finite, :, None])
    distance[finite] = np.min([deviations_of(white, np.linalg.solve(lower, doubt[finite])) for doubt in doubts], axis=0)
    return distance


def deviations_of(difference: Array, doubt: Array) -> Array:
    """Give the length of differences, (R, m, 1), in deviations of unit noise and of doubt, (R, m, q); shape (R,).

    By the doubt's singular values, as doubt that is far larger than noise leaves no sum of the two to be inverted.
    """
    ways, deviations, _ = np.linalg.svd(doubt, full_matrices=False)
    along = (np.swapaxes(ways, 1, 2) @ difference)[..., 0]
    across = difference - ways @ along[..., None]
    return np.asarray(np.sqrt(np.sum(across**2, axis=(1, 2)) + np.sum(along**2 / (1 + deviations**2), axis=1)))
