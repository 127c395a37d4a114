"""Sums of a law's squared error over a run's samples: by phase, by cycle, by harmonic; each sample is seen once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.fitting.misfit import RunMisfit
from pipeclamp_identification.loops.loops import HIGHEST_HARMONIC, Loops
from pipeclamp_identification.loops.scatter import PHASE_BINS, phase_bin
from pipeclamp_identification.signals.harmonics import carried_harmonics, cycle_harmonics
from pipeclamp_models.base.arrays import Array, ComplexArray


@dataclass(frozen=True)
class RunSums:
    """The squared error of one run, split up; C cycles, H harmonics that its sampling carries.

    Attributes:
        samples: number of steady samples.
        squared_force: sum over them, N2.
        squared_scatter: what of the squared error no law can explain, N2.
        by_phase: sums of squared error in N2 over parts of the cycle, from the largest displacement on, shape
            (PHASE_BINS,).
        scatter_by_phase: of them, what no law can explain, same shape.
        samples_by_phase: number of samples, same shape.
        by_cycle, samples_by_cycle: likewise for each cycle, shape (C,).
        harmonics: of the error, measured less law, in N, for each cycle; real parts are in phase with the displacement,
            imaginary parts in quadrature, shape (C, H + 1).
        fundamental_N: amplitude of the measured force's first harmonic.
    """

    samples: int
    squared_force: float
    squared_scatter: float
    by_phase: Array
    scatter_by_phase: Array
    samples_by_phase: Array
    by_cycle: Array
    samples_by_cycle: Array
    harmonics: ComplexArray
    fundamental_N: float

    @property
    def squared_error(self) -> float:
        """Sum of squared errors, N2."""
        return float(np.sum(self.by_cycle))

    @property
    def scatter_known(self) -> bool:
        """Whether there are cycles to scatter: a single one shows the noise between its samples, and no more."""
        return len(self.by_cycle) > 1


def error_sums(campaign: Campaign, loops: Loops, misfits: tuple[RunMisfit, ...]) -> tuple[RunSums, ...]:
    """Sum up a law's squared error on every run.

    Args:
        campaign: the tests.
        loops: `loops_of(campaign)`.
        misfits: `misfits(law, campaign, loops)`.
    """
    return tuple(
        _run_sums(run, misfit, loops.scatter_by_phase[row], float(abs(loops.force[row, 1])))
        for row, (run, misfit) in enumerate(zip(campaign.runs, misfits, strict=True))
    )


def _run_sums(run: Run, misfit: RunMisfit, scatter_shares: Array, fundamental: float) -> RunSums:
    bounds = run.cycles.bounds - run.cycles.bounds[0]
    starts = bounds[:-1]
    error = misfit.measured - misfit.computed
    squared = error**2
    part = phase_bin(misfit.phase)
    phase = run.cycles.phase(run.record)
    count = min(HIGHEST_HARMONIC, carried_harmonics(phase, bounds))
    lag = misfit.phase[starts] - phase[starts]
    turned = np.exp(-1j * lag[:, None] * np.arange(count + 1))
    scatter = len(error) * misfit.noise_rms_N**2
    return RunSums(
        samples=len(error),
        squared_force=misfit.squared_force,
        squared_scatter=scatter,
        by_phase=np.bincount(part, squared, PHASE_BINS).astype(np.float64),
        scatter_by_phase=scatter * scatter_shares,
        samples_by_phase=np.bincount(part, minlength=PHASE_BINS).astype(np.float64),
        by_cycle=np.add.reduceat(squared, starts),
        samples_by_cycle=np.diff(bounds).astype(np.float64),
        harmonics=cycle_harmonics(phase, bounds, [error], count)[0] * turned,
        fundamental_N=fundamental,
    )
