"""One run as the page draws it: the measured loop, what laws give, the difference, the harmonics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeclamp.studio.bench import OneRun
from pipeclamp_identification.comparison.breakdown import squared_harmonics
from pipeclamp_identification.comparison.sums import error_sums
from pipeclamp_identification.fitting.misfit import DRAWN_SAMPLES, force_of_rows, loop_of_run
from pipeclamp_identification.loops.loops import displacement_on_grid
from pipeclamp_identification.loops.scatter import PHASE_BINS
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.law import Law

POINTS = DRAWN_SAMPLES // 2
"""Points of a loop that is drawn."""
ORDERS = 9
"""Harmonics that are shown: of most loops all that stand out of the scatter."""
DIGITS = 6


def run_picture(run: OneRun, laws: Mapping[str, Law]) -> dict[str, Any]:
    """Give a run, and what laws give on it.

    Args:
        run: one run.
        laws: by the name that each is drawn under.

    Returns:
        displacement (mm), velocity (mm/s), measured force (N) over the cycle from the largest displacement on; the
        scatter's standard deviation (N) by phase, null where it isn't known; errors as shares of the rms force.
    """
    loops = run.loops
    loop = loops.rows[0]
    y, measured = loop_of_run(loops, 0, POINTS)
    _, v, _ = displacement_on_grid(loops, POINTS)
    deviation = loop.scatter_rms_N * np.sqrt(PHASE_BINS * loop.scatter_by_phase) if loop.shows_scatter else None
    return {
        "run": loop.run,
        "conditions": _conditions(run),
        "cycles": len(loop.cycles),
        "y": _numbers(y),
        "v": _numbers(v[0]),
        "measured": _numbers(measured),
        "scatter": None if deviation is None else _numbers(deviation),
        "laws": {name: law_on(run, law) for name, law in laws.items()},
    }


def law_on(run: OneRun, law: Law) -> dict[str, Any]:
    """Give what a law gives on a run: its force over the cycle, its error, its harmonics beside the measured ones."""
    misfit = run.misfit(law)
    sums = error_sums(run.tests.campaign, run.loops, (misfit,))
    measured, computed = (_amplitudes(squares, len(misfit.measured)) for squares in squared_harmonics(sums, run.loops))
    return {
        "force": _numbers(force_on(run, law)),
        "nrmse": misfit.nrmse,
        "noise_nrmse": misfit.noise_nrmse if run.loops.rows[0].shows_scatter else None,
        "harmonics": {"measured": measured, "computed": computed},
    }


def force_on(run: OneRun, law: Law) -> Array:
    """Give a law's force over a run's cycle, N, shape (POINTS,)."""
    return force_of_rows(law, run.loops, DRAWN_SAMPLES)[0, :: DRAWN_SAMPLES // POINTS]


def _amplitudes(squares: Array, samples: int) -> list[float]:
    """Give the amplitude of each harmonic's force, N, from sums of its squares over the samples."""
    return _numbers(np.sqrt(2 * np.sum(squares[1 : ORDERS + 1], axis=1) / samples))


def _conditions(run: OneRun) -> dict[str, Any]:
    loop = run.loops.rows[0]
    known = {
        "A / mm": loop.amplitude_mm,
        "f / Hz": loop.frequency_Hz,
        "T / °C": loop.temperature_K - CELSIUS,
        "density / g/cm³": loop.density_g_cm3,
        **loop.conditions,
    }
    shown: dict[str, Any] = {name: float(f"{value:.4g}") for name, value in known.items() if math.isfinite(value)}
    return {**shown, **{name: text for name, text in loop.labels.items() if text}}


def _numbers(values: Array) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values.tolist()]
