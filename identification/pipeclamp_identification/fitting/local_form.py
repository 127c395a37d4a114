"""How what a law's form is off follows the conditions of its tests."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import varies
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.file import KrigedShare, LocalForm
from pipeclamp_models.law.local_form import coordinate, likeness, squares
from pipeclamp_models.law.range import rounded

FEWEST_RUNS = 8
"""Runs, to see how far one tells of another."""
MOST_RUNS = 400
"""Runs beyond which that takes too long."""
NEAR_LENGTH, FAR_LENGTH = 0.6, 1.7
"""Lengths, in standard deviations of the tested conditions, from which the likeliest ones are sought."""
RUNS_SEEN_ROUGHLY = 80
"""Runs that show roughly how far one tells of another: where there are more, these lead near."""
FARTHEST_LOG = 4.0
"""Of the logarithms of lengths and deviation, from where they are likely beforehand."""
GOLDEN = (5**0.5 - 1) / 2
"""Its multiples less their whole parts are spread evenly, however many there are."""
EASY = 1e-8
"""Share of the variance that is added for the numbers' sake."""


def local_form(loops: Loops, shares: Array, variances: Array, whole: Array) -> LocalForm | None:
    """Give how shares follow the conditions; None where there are too few runs, too many, or nothing varies.

    Args:
        loops: the tests, R of them.
        shares: by which stiffness and damping of each are off, (2, R).
        variances: of what scatters in them, (2, R).
        whole: standard deviation of the law's form over all conditions, (2,); 0 where it isn't off.
    """
    known = {"A": loops.amplitude_mm, "f": loops.frequency_Hz, "T": loops.temperature_K}
    further = {"rho": loops.density_g_cm3, **loops.conditions}
    at = {
        name: values
        for name, values in {**known, **further}.items()
        if np.all(np.isfinite(values)) and varies(name, values)
    }
    if not FEWEST_RUNS <= len(loops.run) <= MOST_RUNS or not at:
        return None
    tested = np.column_stack([coordinate(name, values) for name, values in at.items()])
    spread = tested.std(axis=0)
    stiffness, damping = (
        _kriged(list(at), likeliest_form(tested / spread, *of_both), spread)
        for of_both in zip(shares, variances, whole.tolist(), strict=True)
    )
    return LocalForm(
        at={name: tuple(map(rounded, values.tolist())) for name, values in at.items()},
        stiffness=stiffness,
        damping=damping,
    )


_Found = tuple[float, Array, Array, Array]
"""Deviation, lengths in standard deviations of the conditions, shares and their variances."""


def _kriged(names: Sequence[str], found: _Found, spread: Array) -> KrigedShare:
    deviation, lengths, shares, variances = found
    return KrigedShare(
        deviation=rounded(deviation),
        lengths={name: rounded(float(length)) for name, length in zip(names, lengths * spread, strict=True)},
        shares=tuple(map(rounded, shares.tolist())),
        variances=tuple(map(rounded, variances.tolist())),
    )


def likeliest_form(tested: Array, shares: Array, variances: Array, whole: float) -> _Found:
    """Give the likeliest deviation and lengths; that a length is as the tests are spread is likely beforehand.

    Args:
        tested: coordinates of R tests along c conditions, in standard deviations of each, (R, c).
        shares: in the tests, (R,).
        variances: of what scatters in them, (R,).
        whole: standard deviation over all conditions; 0 where nothing is off.
    """
    # fits alone need it, not every command that reads a law
    from scipy.optimize import minimize

    count = tested.shape[1]
    if whole == 0.0:
        return 0.0, np.ones(count), shares, variances
    expected = np.append(np.zeros(count), np.log(whole))
    bounds = [(at - FARTHEST_LOG, at + FARTHEST_LOG) for at in expected]

    def likeliest_from(starts: Sequence[Array], runs: IntArray) -> Array:
        known = squares(tested[runs], tested[runs]), shares[runs], variances[runs], expected
        tried = [minimize(unlikeliness, start, known, method="L-BFGS-B", jac=True, bounds=bounds) for start in starts]
        return np.asarray(min(tried, key=lambda one: float(one.fun)).x)

    starts = [np.append(np.full(count, np.log(length)), np.log(whole)) for length in (NEAR_LENGTH, FAR_LENGTH)]
    every = np.arange(len(tested))
    if len(every) > RUNS_SEEN_ROUGHLY:
        # spread over the tests without their plan's rhythm
        some = np.argsort(every * GOLDEN % 1.0)[:RUNS_SEEN_ROUGHLY]
        starts = [likeliest_from(starts, some)]
    best = likeliest_from(starts, every)
    deviation = float(np.exp(best[-1]))
    return deviation, np.exp(best[:-1]), shares, variances + EASY * deviation**2


def unlikeliness(
    logarithms: Array, apart: Array, shares: Array, variances: Array, expected: Array
) -> tuple[float, Array]:
    """Give the negative logarithm of how likely lengths and a deviation are, but for a constant, and its slopes.

    C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, Eqs. 5.8 and 5.9.

    Args:
        logarithms: of the lengths and, last, of the deviation, (c + 1,).
        apart: squared distances of the tests along each condition, (R, R, c).
        shares: in the tests, (R,).
        variances: of what scatters in them, (R,).
        expected: `logarithms` that are likeliest beforehand, (c + 1,); each errs by 1.
    """
    from scipy.linalg.lapack import dpotrf, dpotri

    lengths, variance = np.exp(logarithms[:-1]), float(np.exp(2 * logarithms[-1]))
    alike = variance * likeness(apart, lengths)
    root, failed = dpotrf(alike + np.diag(variances + EASY * variance), lower=True)
    if failed:
        return 1e12, np.zeros_like(logarithms)
    below, _ = dpotri(root, lower=True)  # and zeros above
    inverse = below + below.T
    np.fill_diagonal(inverse, np.diag(below))
    weights, off = inverse @ shares, logarithms - expected
    value = 0.5 * float(shares @ weights + off @ off) + float(np.log(np.diag(root)).sum())
    moved = (inverse - np.outer(weights, weights)) * alike
    by_lengths = 0.5 * np.tensordot(moved, apart, 2) / lengths**2
    by_deviation = moved.sum() + EASY * variance * (np.trace(inverse) - float(weights @ weights))
    return value, np.append(by_lengths, by_deviation) + off
