"""One run that stands apart: it holds most of what a law leaves over, at conditions that other runs share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
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
from pipeclamp_identification.signals.real_harmonics import mean_squares_of
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
        at_a_corner: whether its conditions lie beyond those of the other runs: what the law lacks may grow to there.
    """

    run: str
    share: float
    left: float
    stiffness: float
    damping: float
    at_a_corner: bool

    def words(self) -> str:
        """Say it, and which test tells what it is."""
        left = f"{self.left:.2g} times the noise" if self.left >= MATERIAL_NOISE_SHARE else "next to nothing"
        where = "it is at a corner of what was tested" if self.at_a_corner else "none of its conditions is its own"
        told = (
            f"run {self.run} stands apart: it holds {self.share:.0%} of what the law leaves beyond scatter, and "
            f"{where}; fitted without it, the law leaves {left} on the others, and the run's stiffness is "
            f"{self.stiffness:+.0%} and its damping {self.damping:+.0%} off. "
        )
        if self.at_a_corner:
            return (
                f"{told}What the law lacks may grow to there, or another specimen or mounting was tested: measure it "
                "again, and one between it and the others"
            )
        return f"{told}Measured again, another specimen or mounting would come out otherwise, the device would not"


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
    conditions = stated_set_points(loops, first)
    alone = any(np.sum(set_points == set_points[place]) < 2 for _, set_points in conditions)
    if not most or alone:
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
        at_a_corner=not _is_between([values[set_points] for values, set_points in conditions], place),
    )  # fmt: skip


def _is_between(conditions: Sequence[Array], place: int) -> bool:
    """Tell whether a run's conditions are a mean of the other runs', with weights from 0 to 1.

    Args:
        conditions: of N runs, nan where not known, shape (N,) each.
        place: of the run.
    """
    varied = [values / np.ptp(values) for values in conditions if np.ptp(values) > 0]
    rows = np.vstack([*varied, np.ones_like(conditions[0])])
    others = np.delete(rows, place, axis=1)
    return bool(linprog(np.zeros(others.shape[1]), A_eq=others, b_eq=rows[:, place]).success)


def _excess(problem: Problem, law_force: LawForce) -> Array:
    """Give the mean square of each run's error beyond scatter, N2, shape (R,)."""
    return np.asarray(mean_squares_of(problem.plain_residual(law_force)) - problem.scatter_squares)
