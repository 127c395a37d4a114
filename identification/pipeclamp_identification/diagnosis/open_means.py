"""Mean forces that an element which never slips leaves open: no evidence against a law, nor foretold by it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeclamp_identification.diagnosis.problem import Judged, Problem
from pipeclamp_identification.diagnosis.thresholds import (
    FORM_NOISE_SHARE,
    HALF_TAKEN_SHARE,
    MOSTLY_STUCK_SHARE,
    REAL_LACK_CHANCE,
)
from pipeclamp_identification.signals.chances import of_larger_ratio
from pipeclamp_identification.signals.real_harmonics import mean_squares_of
from pipeclamp_models.base.digits import newtons


@dataclass(frozen=True)
class OpenMeans:
    """Mean forces that a law leaves open.

    Attributes:
        runs: loops whose mean it leaves open, of so many in all.
        of_runs: so many.
        rms: by which these means are off the law, over all loops, N; zero where most loops show by their slip how much
            the others can hold, or where noise and scatter of the mean force from run to run make as much by chance.
        share: the same as a share of the force noise per sample.
    """

    runs: int
    of_runs: int
    rms: float
    share: float

    @property
    def are_material(self) -> bool:
        """Whether they are more than passes for form."""
        return self.share > FORM_NOISE_SHARE

    def words(self) -> str:
        """Say what no law foretells."""
        return (
            f"in {self.runs} of {self.of_runs} loops an element of the law never slips, and leaves their mean force "
            f"open: {newtons(self.rms)} rms ({self.share:.2g} times the force noise) that nothing foretells"
        )


def means_left_open(law: Judged, problem: Problem) -> OpenMeans:
    """Tell which mean forces a law leaves open, and how large they are."""
    force = law.result.law_force
    left_open = problem.harmonics.open_means(force)
    squares = problem.harmonics.off_in_mean(force)[left_open] ** 2
    scatter = problem.noise.noise_and_mean()[left_open, 0]
    runs, of_runs = len(squares), len(left_open)
    beyond = float(np.sum(squares - scatter)) / of_runs
    told_by = max(of_runs - problem.smooth.shape[1], 1)
    known = runs < MOSTLY_STUCK_SHARE * of_runs
    by_chance = runs == 0 or of_larger_ratio(np.mean(squares / scatter), runs, told_by) > REAL_LACK_CHANCE
    rms = 0.0 if known or by_chance else float(np.sqrt(max(beyond, 0.0)))
    noise = float(np.sqrt(np.mean(problem.loops.scatter_rms_N**2)))
    return OpenMeans(runs, of_runs, rms, rms / noise)


def with_means_counted(judged: Judged, law: Judged, problem: Problem) -> Judged:
    """Object to an effect if it takes little but mean forces, which it leaves open: it foretells none of them.

    So it does where most of what it takes are such means, and of what else is missing it takes less than half. Slip
    that shows in loops takes that, whatever mean it leaves open.
    """
    left_open = problem.harmonics.open_means(judged.result.law_force)
    before, after = (problem.plain_residual(each.result.law_force) for each in (law, judged))
    let_go = float(np.sum(before[left_open, 0] ** 2))
    noise = np.sqrt(problem.noise.total_variance())
    for part in (before, after, noise):
        part[left_open, 0] = 0.0
    rest, left, scatter = (float(np.sum(mean_squares_of(part))) for part in (before, after, noise))
    taken = rest - left
    if not 0.0 < HALF_TAKEN_SHARE * (taken + let_go) < let_go or taken >= HALF_TAKEN_SHARE * (rest - scatter):
        return judged
    words = "most of what it takes are mean forces, which an element that never slips leaves open"
    return replace(judged, objections=(*judged.objections, words))
