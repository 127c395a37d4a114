"""What is drawn of runs: the mean cycle as measured and as each law gives it, with the scatter along the cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.comparison.laws import ComparedLaw
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.loops.scatter import PHASE_BINS
from pipeclamp_models.base.arrays import Array, ComplexArray

MOST_POINTS = 256
"""Points of a cycle at most."""


@dataclass(frozen=True)
class DrawnRun:
    """A run's mean cycle from its largest displacement on, at N phases where it has samples.

    What is measured and what the laws give are means over the same samples, so that their difference shows neither
    cut-off harmonics nor a shift in time.

    Attributes:
        run: its name.
        phase: deg after the largest displacement, rising, shape (N,).
        y, v: displacement in mm and velocity in mm/s, same shape.
        measured: force in N, same shape.
        laws: force that each law gives, in the laws' order, same shape each.
        scatter: standard deviation from cycle to cycle in N, in PHASE_BINS parts of the cycle; None where it isn't
            known.
        squared_force, squared_error: sums over the run's samples, N2; the error of each law.
        squared_scatter: what of the error no law can explain, N2; None where it isn't known.
    """

    run: str
    phase: Array
    y: Array
    v: Array
    measured: Array
    laws: tuple[Array, ...]
    scatter: Array | None
    squared_force: float
    squared_error: tuple[float, ...]
    squared_scatter: float | None


def drawn_runs(loops: Loops, laws: Sequence[ComparedLaw], points: int = MOST_POINTS) -> tuple[DrawnRun, ...]:
    """Give what is drawn of each run.

    Args:
        loops: the tests.
        laws: each held against them, one at least.
        points: N at most; a run with fewer samples a cycle has as many as those.
    """
    return tuple(drawn_run(loops, laws, row, points) for row in range(len(loops.run)))


def drawn_run(loops: Loops, laws: Sequence[ComparedLaw], row: int, points: int = MOST_POINTS) -> DrawnRun:
    """Give what is drawn of one run, by its row; see `drawn_runs`."""
    misfits = [law.runs[row] for law in laws]
    phase, measured = misfits[0].phase, misfits[0].measured
    parts = max(min(points, len(phase) // len(loops.cycles[row])), 1)
    part = np.minimum((phase * (parts / (2 * np.pi))).astype(np.intp), parts - 1)
    counts = np.bincount(part, minlength=parts)
    filled = counts > 0

    def mean(samples: Array) -> Array:
        return np.asarray(np.bincount(part, samples, parts)[filled] / counts[filled])

    at = mean(phase)
    y, rate = _motion(loops.displacement[row], at)
    known = loops.shows_scatter[row]
    scatter = float(loops.scatter_rms_N[row])
    return DrawnRun(
        run=loops.run[row],
        phase=np.degrees(at),
        y=y,
        v=rate * (2 * np.pi * float(loops.frequency_Hz[row])),
        measured=mean(measured),
        laws=tuple(mean(misfit.computed) for misfit in misfits),
        scatter=scatter * np.sqrt(PHASE_BINS * loops.scatter_by_phase[row]) if known else None,
        squared_force=misfits[0].squared_force,
        squared_error=tuple(misfit.squared_error for misfit in misfits),
        squared_scatter=len(measured) * scatter**2 if known else None,
    )


def _motion(harmonics: ComplexArray, phase: Array) -> tuple[Array, Array]:
    """Give the displacement and its derivative by phase, mm and mm/rad, at phases in rad."""
    orders = np.arange(len(harmonics))
    turned = harmonics * np.exp(1j * phase[:, None] * orders)
    return turned.real.sum(axis=1), -(turned * orders).imag.sum(axis=1)
