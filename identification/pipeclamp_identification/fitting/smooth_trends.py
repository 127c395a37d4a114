"""What follows the conditions of tests smoothly: physics does, scatter from run to run doesn't."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import varies
from pipeclamp_identification.signals.orthonormal import orthonormal
from pipeclamp_models.base.arrays import Array

DEGREE = 3
"""Highest total degree of the polynomials over the conditions that count as smooth."""
FREE_RUNS = 0.35
"""At least this share of the runs must stay free of the polynomials, to show the scatter between runs."""
LEVELS_SCATTER = 1e-2
"""Share of the largest direction that drives scatter about their levels by."""


def smooth_basis(loops: Loops) -> Array:
    """Give the functions of the loops' conditions that count as smooth, one a column, shape (R, q).

    Stretches of one run show no more of what differs between runs than one of them.
    """
    main = (loops.amplitude_mm, loops.frequency_Hz, loops.temperature_K)
    further = (loops.density_g_cm3, loops.cycle, *loops.conditions.values())
    return smooth_functions(*main, further, loops.specimen, runs=len(np.unique(loops.run)))


def trends(loops: Loops) -> Array:
    """Give each condition that varies, centred and scaled, and each specimen, one a column, shape (R, c)."""
    columns = _main(loops.amplitude_mm, loops.frequency_Hz, loops.temperature_K)
    columns += _varied((loops.density_g_cm3, loops.cycle, *loops.conditions.values()))
    columns += _specimens(loops.specimen)
    return np.stack(columns, axis=1) if columns else np.zeros((len(loops.run), 0))


def smooth_functions(
    amplitude: Array,
    frequency: Array,
    temperature: Array,
    further: Sequence[Array],
    specimen: Sequence[str | None],
    *,
    runs: int | None = None,
) -> Array:
    """Give the functions of conditions that count as smooth, one a column, shape (R, q).

    Polynomials in log A, log f and T, lines and parabolas in further conditions, one constant a specimen; of as high a
    degree as leaves enough runs free.

    Args:
        amplitude: mm, frequency: Hz, temperature: K; shape (R,) each.
        further: further conditions, shape (R,) each.
        specimen: label of each run's specimen.
        runs: how many runs these are of; as many as rows, if not stated.
    """
    main = _main(amplitude, frequency, temperature)
    specimens = _specimens(specimen)
    rows = len(amplitude)
    for degree in range(DEGREE, 0, -1):
        functions = [*_monomials(main, degree, rows), *_powers(_varied(further), min(degree, 2)), *specimens]
        columns = _independent(functions)
        if columns.shape[1] <= (1 - FREE_RUNS) * (runs or rows):
            return columns
    return np.full((rows, 1), 1 / np.sqrt(rows))


def _specimens(specimen: Sequence[str | None]) -> list[Array]:
    """Give which runs are of each specimen but the first."""
    names = sorted({name or "" for name in specimen})[1:]
    return [np.array([float((name or "") == label) for name in specimen]) for label in names]


def _main(amplitude: Array, frequency: Array, temperature: Array) -> list[Array]:
    """Give log A, log f and T, those that vary, centred and scaled; what is meant to be alike scatters."""
    known = (np.log(amplitude), varies("A", amplitude)), (np.log(frequency), varies("f", frequency))
    chosen = [value for value, varied in known if varied]
    if np.all(np.isfinite(temperature)) and varies("T", temperature):
        chosen.append(temperature)
    return [_scaled(value) for value in chosen]


def _varied(values: Sequence[Array]) -> list[Array]:
    """Give those quantities that are known and vary, centred and scaled."""
    usable = [value for value in values if np.all(np.isfinite(value)) and np.ptp(value) > 1e-3 * np.max(np.abs(value))]
    return [_scaled(value) for value in usable]


def _scaled(values: Array) -> Array:
    return np.asarray((values - values.mean()) / values.std())


def _monomials(values: Sequence[Array], degree: int, runs: int) -> list[Array]:
    columns = [np.ones(runs)]
    for order in range(1, degree + 1):
        columns += [np.prod(chosen, axis=0) for chosen in itertools.combinations_with_replacement(values, order)]
    return columns


def _powers(values: Sequence[Array], degree: int) -> list[Array]:
    return [value**power for value in values for power in range(1, degree + 1)]


def _independent(columns: Sequence[Array]) -> Array:
    """Give an orthonormal basis of what the columns span; levels that repeat make some of them equal.

    Amplitudes scatter about their levels by design error; what spans only that scatter is no smooth function.
    """
    matrix = np.stack(list(columns), axis=1)
    return orthonormal(matrix / np.linalg.norm(matrix, axis=0), LEVELS_SCATTER)
