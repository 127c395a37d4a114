"""Loop metrics, Eq. 1-6 of Symmetry 2020, 12(8), 1283: dissipated and elastic energy, loss factor, stiffness."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

from pipeclamp_identification.loops.loops import Loops, on_grid, per_cycle
from pipeclamp_models.base.arrays import Array

SAMPLES_PER_CYCLE = 512
"""Points of the cycle among which the force's extremes are sought: 20 harmonics change little between two of them."""


@dataclass(frozen=True)
class Metrics:
    """The metrics of loops, arrays (R,), one entry per row."""

    dissipated_energy_J: Array
    max_elastic_energy_J: Array
    loss_factor: Array
    stiffness_N_mm: Array
    force_max_N: Array
    force_min_N: Array


def metrics_of(loops: Loops) -> Metrics:
    """Return the metrics of each loop.

    dW is the loop's area, the integral of F dy, taken from the harmonics; of a sinusoidal displacement it is Eq. 2.
    k = (Fmax - Fmin)/(2 X0) is Eq. 3, with the X0 that the paper's print lacks; W = k X0^2/2 and eta = dW/(2 pi W)
    are Eq. 4-6. X0 is the amplitude of the displacement's fundamental. Fmax and Fmin are those of the force's
    harmonics, not the record's largest and smallest sample: those lie beyond the loop by some three times the
    noise, the more the longer the record is, and so W and k would depend on the sensor and the sampling.

    Args:
        loops: R rows; of `per_cycle`, for metrics per cycle.

    Returns:
        R rows.
    """
    order = np.arange(loops.force.shape[1])
    # N mm is mJ
    dissipated = np.pi * np.sum(order * (loops.force * loops.displacement.conj()).imag, axis=1) / 1e3
    force = on_grid(loops.force, SAMPLES_PER_CYCLE)
    highest, lowest = np.max(force, axis=1), np.min(force, axis=1)
    elastic = (highest - lowest) / 2 * loops.amplitude_mm / 2 / 1e3
    return Metrics(
        dissipated_energy_J=dissipated,
        max_elastic_energy_J=elastic,
        loss_factor=dissipated / (2 * np.pi * elastic),
        stiffness_N_mm=(highest - lowest) / (2 * loops.amplitude_mm),
        force_max_N=highest,
        force_min_N=lowest,
    )


def scatter_of(loops: Loops) -> Metrics:
    """Return the standard deviation of each metric from cycle to cycle.

    The metrics themselves are those of the cycle-averaged loop, as `metrics_of` gives them: a mean of per-cycle
    extremes would keep the noise of single cycles. Over the square root of the number of cycles this is their
    standard error.

    Args:
        loops: one row per run.

    Returns:
        One row per run; nan where a run has one cycle only.
    """
    ends = np.cumsum([len(cycles) for cycles in loops.cycles])[:-1]
    columns = (np.split(values, ends) for values in astuple(metrics_of(per_cycle(loops))))
    return Metrics(*(np.array([np.std(run, ddof=1) if len(run) > 1 else np.nan for run in runs]) for runs in columns))
