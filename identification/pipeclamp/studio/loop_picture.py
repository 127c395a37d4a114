"""One run as the page draws it: the measured loop, what laws give on it, the harmonics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeclamp.studio.bench import OneRun
from pipeclamp_identification.comparison.breakdown import squared_harmonics
from pipeclamp_identification.comparison.drawn import MOST_POINTS, drawn_runs
from pipeclamp_identification.comparison.laws import ComparedLaw
from pipeclamp_identification.comparison.sums import error_sums
from pipeclamp_identification.fitting.misfit import RunMisfit, loop_of_run
from pipeclamp_identification.loops.loops import displacement_on_grid
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import rounded_to
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.law import Law

ORDERS = 9
"""Harmonics that are shown: of most loops all that stand out of the scatter."""
PICTURE_DIGITS = 6


def run_picture(run: OneRun, laws: Mapping[str, Law]) -> dict[str, Any]:
    """Give a run, and what laws give on it.

    Args:
        run: one run.
        laws: by the name that each is drawn under.

    Returns:
        phase (deg), displacement (mm), velocity (mm/s), measured force (N) and each law's over the cycle, as pages
        draw them (`drawn_runs`); of each law its error and that of scatter as shares of the rms force, null where not
        known, and its harmonics.
    """
    loop = run.loops.rows[0]
    held = [ComparedLaw(name, law, (run.misfit(law),)) for name, law in laws.items()]
    shown = {"run": loop.run, "conditions": _conditions(run), "cycles": len(loop.cycles)}
    if not held:
        return {**shown, **_measured(run), "laws": [], "by_law": []}
    (drawn,) = drawn_runs(run.loops, held)
    return {
        **shown,
        "phase": _numbers(drawn.phase),
        "y": _numbers(drawn.y),
        "v": _numbers(drawn.v),
        "measured": _numbers(drawn.measured),
        "scatter": None if drawn.scatter is None else _numbers(drawn.scatter),
        "laws": [_numbers(force) for force in drawn.laws],
        "by_law": [_numbers_of(run, law.label, law.runs[0]) for law in held],
    }


def _measured(run: OneRun) -> dict[str, Any]:
    y, measured = loop_of_run(run.loops, 0, MOST_POINTS)
    _, v, _ = displacement_on_grid(run.loops, MOST_POINTS)
    phase = np.linspace(0.0, 360.0, MOST_POINTS, endpoint=False)
    known = {"phase": phase, "y": y, "v": v[0], "measured": measured}
    return {**{name: _numbers(values) for name, values in known.items()}, "scatter": None}


def _numbers_of(run: OneRun, name: str, misfit: RunMisfit) -> dict[str, Any]:
    sums = error_sums(run.tests.campaign, run.loops, (misfit,))
    measured, computed = (_amplitudes(squares, len(misfit.measured)) for squares in squared_harmonics(sums, run.loops))
    return {
        "name": name,
        "nrmse": misfit.nrmse,
        "noise_nrmse": misfit.noise_nrmse if run.loops.shows_scatter[0] else None,
        "measured": measured,
        "computed": computed,
    }


def _amplitudes(squares: Array, samples: int) -> list[float]:
    """Give the amplitude of each harmonic's force, N, from sums of its squares over the samples."""
    return _numbers(np.sqrt(2 * np.sum(squares[1 : ORDERS + 1], axis=1) / samples))


def _conditions(run: OneRun) -> dict[str, Any]:
    loop = run.loops.rows[0]
    known = {
        "A / mm": loop.amplitude_mm,
        "f / Hz": loop.frequency_Hz,
        "T / °C": round(loop.temperature_K - CELSIUS, 1),
        "density / g/cm³": loop.density_g_cm3,
        **loop.conditions,
    }
    shown: dict[str, Any] = {name: rounded_to(value, 4) for name, value in known.items() if math.isfinite(value)}
    return {**shown, **{name: text for name, text in loop.labels.items() if text}}


def _numbers(values: Array) -> list[float]:
    return [rounded_to(value, PICTURE_DIGITS) for value in values.tolist()]
