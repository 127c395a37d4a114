"""Refits of a model that has several stable motions: on those that were measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeclamp_identification.attribution.refit import Refit, RefitStart, changed, refit
from pipeclamp_identification.attribution.task import RefitTask
from pipeclamp_identification.on_pipe.prediction import predict
from pipeclamp_identification.on_pipe.sines import PipeComparison
from pipeclamp_models.base.progress import Progress

MUCH_LESS_RMS_SHARE = 0.8
"""What takes a refit's place, on another branch or with more parameters, must leave less than this share of its rms."""
NEAR_ENOUGH = 2.0
"""Rms in units of the first guess of the noise up to which a refit is on the branches that were measured."""
MOST_FOLLOWED = 8e6
"""Work, as of `Work`, spent at most to follow responses of refitted models anew: some minutes."""
NEXT_BEST = 3
"""Rivals of such a refit that may be on another branch."""


def on_the_nearest_branches(
    task: RefitTask, refits: Sequence[Refit], comparison: PipeComparison, tell: Progress
) -> tuple[list[Refit], int]:
    """Refit once more where a refitted model has stable motions nearer to the measured ones than those it is on.

    It takes following the response: all refits (best first) are looked at where none comes near, else those that come
    next to it, and those only where the model as stated has several stable motions. Where it has one each, or sweeps
    tell which is met, a refit that moves as stated, and is but seen otherwise, has no other.

    Returns:
        the refits, and how many were left out of it, the worst ones, when no more work was to be spent.
    """
    near = refits[0].squared < NEAR_ENOUGH**2 * refits[0].residual.size
    several = bool(np.any(comparison.prediction.branches > 1))
    looked_at = (NEXT_BEST if several else 0) if near else len(refits)
    told = bool(np.all(comparison.measurement.steady.sweep != 0))
    found, work = list(refits), 0.0
    stated = replace(comparison.prediction, model=task.model)  # its mounts change nothing
    looked_for = range(1 if near else 0, min(looked_at + 1, len(refits)))
    for index in looked_for:
        tell(f"look for other branches, {index - looked_for.start + 1} of {len(looked_for)}")
        if work > MOST_FOLLOWED:
            return found, looked_for.stop - index
        one = refits[index]
        model = changed(task.model, one.suspects, one.values)
        if (told or not several) and model.moves_as(task.model):
            continue
        fresh = predict(model, comparison.measurement, followed=stated)
        work += fresh.work
        computed = replace(one.computed, sines=fresh)
        residual = task.residual(computed)
        if float(residual @ residual) < MUCH_LESS_RMS_SHARE**2 * one.squared:
            (found[index],) = refit(task, [RefitStart(one.suspects, one.values, computed)])
    return found, 0
