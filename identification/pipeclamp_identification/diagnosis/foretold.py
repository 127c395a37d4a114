"""How laws do on conditions that were left out: what one errs beyond scatter, what of it another one takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import (
    BEYOND_DOUBT_DRAWS_SHARE,
    MATERIAL_PART_SHARE,
    SAME_ERROR_SHARE,
)
from pipeclamp_identification.fitting.heldout import is_foretold, signal_of_groups
from pipeclamp_identification.fitting.resampling import draws, share_of_gains
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_models.base.arrays import Array, IntArray
from pipeclamp_models.law.outline import levels_taken


@dataclass(frozen=True)
class ErrorBeyondScatter:
    """A law's error on left-out groups.

    Attributes:
        rms: N, scatter taken off.
        share: the same as a share of the force noise per sample.
        sure_share: what it is above in all but few draws of the groups with replacement.
    """

    rms: float
    share: float
    sure_share: float


def foretold(judged: Judged, problem: Problem) -> ErrorBeyondScatter:
    """Say how much a law errs on left-out (A, f) groups beyond scatter."""
    return beyond_scatter(problem.excess_squares(judged.score), problem.groups, problem.loops.scatter_rms_N)


def beyond_scatter(excess: Array, groups: IntArray, noise_rms: Array) -> ErrorBeyondScatter:
    """Say how large an error is of which each run shows this much.

    Args:
        excess: mean square of each run's error less what scatter makes of it, N2, shape (R,).
        groups: the group of each run, shape (R,); -1 for those that were never left out.
        noise_rms: force noise per sample of each run, N, shape (R,).
    """
    left_out = groups >= 0
    if not left_out.any():
        return ErrorBeyondScatter(0.0, 0.0, 0.0)
    total = np.bincount(groups[left_out], weights=excess[left_out])
    runs = np.bincount(groups[left_out]).astype(np.float64)
    drawn = draws(len(total))
    least = np.quantile((drawn @ total) / (drawn @ runs), 1 - BEYOND_DOUBT_DRAWS_SHARE)
    mean = total.sum() / runs.sum()
    noise = float(np.mean(noise_rms[left_out] ** 2))
    rms, share, sure_share = (
        float(np.sqrt(max(square, 0.0))) for square in (mean, mean / noise, min(least, mean) / noise)
    )
    return ErrorBeyondScatter(rms, share, sure_share)


MEASURE_OF_SHARES = "mean square beyond scatter, estimated for left-out conditions"
"""Of what `explained_share` is a share, in words."""


def explained_share(judged: Judged, law: Judged) -> float:
    """Give the share that a law takes of what the law as it is misses on left-out conditions (mean square).

    What scatter from run to run can have made of either error counts for little.
    """
    rows = np.count_nonzero(law.score.mean_squares)
    if law.score.axes is None or not rows:
        return _as_share(law.score.mean_squares - judged.score.mean_squares, law.missing)
    axes, size = law.score.axes, law.missing / rows
    before, after = (axes.beside(each.score.errors, size) for each in (law, judged))
    left_out = law.score.mean_squares > 0
    beyond = float(np.sum((before - axes.by_chance(size))[left_out]))
    least = law.missing * float(before.sum() / law.score.mean_squares.sum())
    return _as_share(before - after, max(beyond, least))


def refitted_share(law: Judged, before: float, after: float) -> float:
    """Give the share that an effect takes of what a law misses there by refits without the left-out conditions.

    Args:
        law: as it is, judged.
        before: its error on left-out conditions, of fits without them, as a share of the force.
        after: the same of the law with the effect.
    """
    whole = float(law.score.mean_squares.sum())
    missing = min(law.missing / whole, 1.0) * before**2 if whole > 0 else 0.0
    return float(np.clip((before**2 - after**2) / missing, 0.0, 1.0)) if missing > 0 else 0.0


def share_of_error(judged: Judged, other: Judged) -> float:
    """Give the share of another law's mean-square error, on left-out conditions and scatter included, that a law takes.

    What a law errs beyond scatter is no measure where that may be nothing.
    """
    error = other.score.mean_squares
    return _as_share(error - judged.score.mean_squares, float(error.sum()))


def _as_share(gain: Array, whole: float) -> float:
    return float(np.clip(gain.sum() / whole, 0.0, 1.0)) if whole > 0 else 0.0


def gains(candidate: Judged, law: Judged, problem: Problem) -> Array:
    """Give the squares that a law gains over another on each left-out group, shape (G,)."""
    return np.bincount(problem.groups, weights=law.score.squares - candidate.score.squares).astype(np.float64)


class BothErrors(NamedTuple):
    """Errors on left-out groups of another kind, as shares of the force: the law's, and the candidate's."""

    law: float
    candidate: float

    @property
    def rises(self) -> bool:
        """Whether the candidate's is larger by more than a fit to fewer tests comes out otherwise by itself."""
        return self.candidate > (1 + SAME_ERROR_SHARE) * self.law


def held_against(candidate: Judged, law: Judged, loops: Loops) -> dict[str, BothErrors]:
    """Give the errors by which a candidate is held against a law on other left-out groups, by their name.

    Where the law follows a condition by a curve that the levels that are left don't determine, what it errs on the one
    left out says nothing, and with a candidate that leaves that curve as it is no more.

    A candidate that follows a further condition is held against all levels of it, those at its ends, which are never
    left out, by groups. A law that doesn't follow it is right in the middle if anywhere: by the levels between alone
    it would seem to foretell better than a curve that is off there, and is off by far more at the ends.

    Args:
        candidate: the law with more, or with something in its place.
        law: the law.
        loops: the tests.
    """
    if not law.heldout_by:
        return {}
    of_the_law = law.result.fitted_parameters
    brought = [each for each in candidate.result.fitted_parameters if each.name not in law.result.equations.names]
    found = {}
    for name, error in law.heldout_by.items():
        follows = levels_taken(signal_of_groups(name), brought) > 0
        if follows and name in law.over_range:
            found[name] = BothErrors(law.over_range[name], candidate.over_range[name])
        elif follows or is_foretold(name, loops, of_the_law):
            found[name] = BothErrors(error, candidate.heldout_by[name])
    return found


def worse_between_levels(candidate: Judged, law: Judged, loops: Loops) -> dict[str, BothErrors]:
    """Give the further conditions that a candidate follows, and whose levels it foretells worse from the others."""
    held = held_against(candidate, law, loops)
    between = {name: BothErrors(law.heldout_by[name], candidate.heldout_by[name]) for name in held}
    return {name: errors for name, errors in between.items() if errors.rises and not held[name].rises}


def takes_part(candidate: Judged, law: Judged, problem: Problem) -> bool:
    """Tell whether a law takes a material share on left-out A and f beyond doubt, loses none elsewhere, fits better."""
    gain = gains(candidate, law, problem)
    elsewhere = not any(error.rises for error in held_against(candidate, law, problem.loops).values())
    material = explained_share(candidate, law) >= MATERIAL_PART_SHARE and candidate.akaike < law.akaike
    return bool(material and elsewhere and len(gain) > 1 and share_of_gains(gain) > BEYOND_DOUBT_DRAWS_SHARE)
