"""The error of a law against a campaign's samples: one number for all, one a run (docs/reference/answers.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.campaign.smoothing import averaged
from pipeclamp_identification.fitting.observations import loop_motion
from pipeclamp_identification.loops.loops import Loops, on_grid, per_cycle
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.law.law import Law
from pipeclamp_models.realise.force import force_of_law

FINE_SAMPLES = 2048
"""Points of the cycle between which a law's loop is interpolated to the record's samples: the step that friction makes
at a reversal costs less than 0.03 % of the force, where 512 points cost up to 0.2 %."""
DRAWN_SAMPLES = 512
"""Points of a loop that is drawn."""


@dataclass(frozen=True)
class RunMisfit:
    """How a law fits one run, over its steady samples.

    Attributes:
        run: its name.
        phase: of each sample within the cycle, rad, 0 at the fundamental's maximum; shape (samples,).
        measured, computed: force in N, shape (samples,).
        noise_rms_N: rms of what no law can explain.
    """

    run: str
    phase: Array
    measured: Array
    computed: Array
    noise_rms_N: float

    @cached_property
    def squared_error(self) -> float:
        """Sum of squared errors, N2."""
        return float(np.sum((self.measured - self.computed) ** 2))

    @cached_property
    def squared_force(self) -> float:
        """Sum of squared measured forces, N2."""
        return float(np.sum(self.measured**2))

    @property
    def nrmse(self) -> float:
        """Error of the run as a share of its force."""
        return math.sqrt(self.squared_error / self.squared_force)

    @property
    def noise_nrmse(self) -> float:
        """Cycle-to-cycle scatter as a share of the run's force."""
        return self.noise_rms_N / math.sqrt(self.squared_force / len(self.measured))


def misfits(law: Law, campaign: Campaign, loops: Loops) -> tuple[RunMisfit, ...]:
    """Compare a law with every steady sample of a campaign.

    The law sees the measured motion as its harmonics say it: noise of the displacement sensor is not taken for force.
    A sample in whose interval the motion reverses errs as its neighbours do, each for its own side: where a law steps,
    its timing decides which side it shows.
    Where the law's force is known up to a constant only (a state that never loses its beginning), or the measured one
    is (a zero that drifted), the run's measured mean is taken for that constant.

    Args:
        law: the law.
        campaign: its runs.
        loops: `loops_of(campaign)`.

    Raises:
        UserError: the law needs a condition that the campaign doesn't state.
    """
    changing = law.equations.ages
    force = force_of_rows(law, per_cycle(loops) if changing else loops)
    _refuse_unknown(law, loops, force)
    edges = np.concatenate([[0], np.cumsum([len(cycles) if changing else 1 for cycles in loops.cycles])])
    return tuple(
        _run_misfit(run, loops, index, force[edges[index] : edges[index + 1]])
        for index, run in enumerate(campaign.runs)
    )


def force_of_rows(law: Law, loops: Loops, samples: int = FINE_SAMPLES) -> Array:
    """Give the law's force on loops as the records would show it, N, shape (R, samples).

    Rows that are adrift are moved towards the measured mean as far as their states can hold it, and those whose zero
    drifted to it; a moving average that the records went
    through is repeated.
    """
    law_force = force_of_law(law, loop_motion(loops, samples))
    shift = loops.force[:, 0].real - np.mean(law_force.force, axis=1)
    known = np.isfinite(loops.force_standard_error[:, 0])
    shift = np.where(known, np.clip(shift, -law_force.held, law_force.held), shift)
    return averaged(law_force.force + shift[:, None], loops.force_average)


def _refuse_unknown(law: Law, loops: Loops, force: Array) -> None:
    """Refuse tests that leave a condition open which the law depends on, or for which the law gives no finite force."""
    if np.all(np.isfinite(force)):
        return
    if "rho" in law.equations.slow_signals and not np.all(np.isfinite(loops.density_g_cm3)):
        blank = [run for run, rho in zip(loops.run, loops.density_g_cm3, strict=True) if not np.isfinite(rho)]
        raise UserError(f"the law depends on density_g_cm3, which isn't known for {blank[0]}; fill it in in runs.csv")
    raise UserError("the law gives a force that is not finite on these tests; expected tests near the law's range")


def _run_misfit(run: Run, loops: Loops, index: int, force: Array) -> RunMisfit:
    """Interpolate a run's computed loops, one for all cycles or one a cycle, shape (1 or cycles, n), to its samples."""
    cycles = run.cycles
    measured = run.record.force_N[cycles.steady]
    turns = loops.phases[index] / (2 * np.pi)
    phase = 2 * np.pi * (turns - np.floor(turns))
    theta = 2 * np.pi * np.arange(force.shape[1] + 1) / force.shape[1]
    closed = np.concatenate([force, force[:, :1]], axis=1)
    bounds = cycles.bounds - cycles.bounds[0] if len(force) > 1 else [0, len(phase)]
    computed = np.concatenate(
        [np.interp(phase[slice(*ends)], theta, own) for own, ends in zip(closed, pairwise(bounds), strict=True)]
    )
    at_reversals = loops.at_reversals[index]
    error = measured - computed
    computed[at_reversals.sample] = measured[at_reversals.sample] - at_reversals.between(error[at_reversals.places])
    return RunMisfit(run.name, phase, measured, computed, float(loops.scatter_rms_N[index]))


class Misfit(Protocol):
    """How a law fits one run, whatever its motion."""

    @property
    def squared_error(self) -> float:
        """Sum of squared errors, N2."""

    @property
    def squared_force(self) -> float:
        """Sum of squared measured forces, N2."""


def overall_nrmse(runs: Sequence[Misfit]) -> float:
    """Give the error over all samples of all runs as a share of their force."""
    return math.sqrt(sum(run.squared_error for run in runs) / sum(run.squared_force for run in runs))


def overall_noise(runs: tuple[RunMisfit, ...]) -> float:
    """Give the scatter over all samples of all runs as a share of their force."""
    noise = sum(len(run.measured) * run.noise_rms_N**2 for run in runs)
    return math.sqrt(noise / sum(run.squared_force for run in runs))


def known_noise(runs: tuple[RunMisfit, ...], loops: Loops) -> float | None:
    """Give `overall_noise`; None where every run holds a single cycle, whose scatter nobody knows."""
    return overall_noise(runs) if any(loops.shows_scatter) else None


def loop_of_run(loops: Loops, row: int, samples: int = DRAWN_SAMPLES) -> tuple[Array, Array]:
    """Give a run's measured loop as (displacement mm, force N) over one cycle, shape (samples,) each."""
    return on_grid(loops.displacement[row : row + 1], samples)[0], on_grid(loops.force[row : row + 1], samples)[0]
