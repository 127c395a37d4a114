"""Who betters the law, and who can't be told from the best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import RIVAL_DRAWS_SHARE, RIVAL_LIKELIHOOD
from pipeclamp_identification.fitting.resampling import DRAWS, draws
from pipeclamp_models.base.arrays import Array

BEYOND_COMPARISON = 1e200
"""Squares that count as infinite, but none of them as nothing."""


def bettering(candidates: Sequence[Judged], law: Judged) -> list[Judged]:
    """Give the candidates that nothing speaks against and that better the law."""
    return [each for each in candidates if not each.objections and _betters(each, law)]


def _betters(candidate: Judged, law: Judged) -> bool:
    """Tell whether an effect betters the law: on left-out conditions, or by the fit to all data beyond doubt."""
    return candidate.squares < law.squares or candidate.akaike + RIVAL_LIKELIHOOD < law.akaike


def rivals_of(best: Judged, others: Sequence[Judged], problem: Problem) -> list[Judged]:
    """Find who can't be told from the best: by left-out conditions, resampled ones, or the fit to all data."""
    others = [each for each in others if each is not best]
    if not others:
        return []
    squares: Array = np.stack([each.squares_by_run(problem.loops) for each in (best, *others)], axis=1)
    squares = np.minimum(squares, BEYOND_COMPARISON)
    count = len(squares)
    wins = np.bincount(np.argmin(draws(count) @ squares, axis=1), minlength=1 + len(others)) / DRAWS
    near = []
    for place, candidate in enumerate(others, 1):
        difference = squares[:, place] - squares[:, 0]
        error = np.sqrt(count * np.var(difference, ddof=1)) if count > 1 else np.inf
        as_likely = candidate.akaike - best.akaike < RIVAL_LIKELIHOOD
        if difference.sum() <= error or wins[place] >= RIVAL_DRAWS_SHARE or as_likely:
            near.append(candidate)
    return near
