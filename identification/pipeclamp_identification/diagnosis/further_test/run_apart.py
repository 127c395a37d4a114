"""One run that stands apart: it holds most of what a law leaves over, at conditions that other runs share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from pipeclamp_identification.diagnosis.noise import MOST_SCATTER
from pipeclamp_identification.diagnosis.problem import CLOSELY, Judged, Problem
from pipeclamp_identification.diagnosis.repeats import stated_set_points
from pipeclamp_identification.diagnosis.thresholds import (
    HALF_LEFT_SHARE,
    MATERIAL_NOISE_SHARE,
    REAL_LACK_CHANCE,
    RUN_APART_SHARE,
)
from pipeclamp_identification.fitting.least_squares import fit
from pipeclamp_identification.fitting.observations import mean_squares_of
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.realise.force import LawForce, force_of_law

IN_PHASE, IN_QUADRATURE = 1, 2
"""Places of the first harmonic's parts among a run's real harmonics."""


@dataclass(frozen=True)
class RunApart:
    """A run that stands apart, beside the law fitted to the others.

    Attributes:
        run: its name.
        share: of what the law leaves over, beyond scatter (mean square).
        left: what the law that is fitted to the others leaves over on these, as a share of the force noise (rms).
        stiffness, damping: by which share the force in step with the displacement, and with the velocity, is larger
            than that law has it; of the first harmonic.
    """

    run: str
    share: float
    left: float
    stiffness: float
    damping: float

    def words(self) -> str:
        """Say it, and which test tells what it is."""
        left = f"{self.left:.2g} times the noise" if self.left >= MATERIAL_NOISE_SHARE else "next to nothing"
        return (
            f"run {self.run} stands apart: it holds {self.share:.0%} of what the law leaves beyond scatter, and none "
            f"of its conditions is its own; fitted without it, the law leaves {left} on the others, and the run's "
            f"stiffness is {self.stiffness:+.0%} and its damping {self.damping:+.0%} off. Measured again, another "
            "specimen or mounting would come out otherwise, the device itself would not"
        )


def run_apart(judged: Judged, problem: Problem) -> RunApart | None:
    """Find one run that holds most of what a law leaves over, and without which it fits the others; None if none does.

    Not one that rigs' scatter may make. Nor one that is alone at its amplitude, frequency, temperature or another
    condition: what a law lacks there, it shows nowhere else.

    Args:
        judged: the law.
        problem: the tests.
    """
    loops = problem.loops
    before = _excess(problem, judged.result.law_force)
    whole = float(np.maximum(before, 0.0).sum())
    names, first, members = np.unique(loops.run, return_index=True, return_inverse=True)
    of_runs = np.bincount(members, weights=before)
    place = int(np.argmax(of_runs))
    own = members == place
    off = float(np.mean(before[own]) / np.mean(loops.force_rms_N[own] ** 2))
    beyond_rigs = off > MOST_SCATTER**2 * chdtri(1, REAL_LACK_CHANCE / len(names))  # in any of so many runs
    most = of_runs[place] > RUN_APART_SHARE * whole and beyond_rigs
    if not most or any(np.sum(numbers == numbers[place]) < 2 for numbers in stated_set_points(loops, first)):
        return None
    others = np.flatnonzero(~own)
    structure, values = judged.result.law.structure, judged.result.law.values
    refitted = fit(structure, problem.observations.rows(others), start=values, tolerance=CLOSELY)
    law_force = force_of_law(refitted.law, problem.harmonics.motion)
    after = float(np.maximum(np.mean(_excess(problem, law_force)[others]), 0.0))
    if after > HALF_LEFT_SHARE**2 * np.mean(before):
        return None
    measured = np.mean(problem.harmonics.harmonics[own], axis=0)
    computed = np.mean(problem.harmonics.transformed(law_force.force)[own], axis=0)
    more = measured / np.where(computed == 0, np.nan, computed) - 1
    noise = float(np.mean(loops.scatter_rms_N[others] ** 2))
    return RunApart(
        str(names[place]), float(of_runs[place]) / whole, float(np.sqrt(after / noise)),
        float(more[IN_PHASE]), float(more[IN_QUADRATURE]),
    )  # fmt: skip


def _excess(problem: Problem, law_force: LawForce) -> Array:
    """Give the mean square of each run's error beyond scatter, N2, shape (R,)."""
    return np.asarray(mean_squares_of(problem.plain_residual(law_force)) - problem.scatter_squares)
