"""What scatter a measured response has: from repeats where there are some, else from how rough a misfit is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from pipeclamp_identification.on_pipe.measurement import PipeMeasurement
from pipeclamp_identification.on_pipe.series import series_of
from pipeclamp_identification.on_pipe.sines import sine_scatter_of, turned_error
from pipeclamp_models.base.arrays import Array, ComplexArray

MODEL_ERROR = 3e-3
"""Share of a response by which harmonic balance and the pipe's reduction may err by themselves."""
TRUSTED_SHARE = 1e-3
"""Share of a series' largest response below which no sensor is trusted."""
FIRST_GUESS = (0.01, 0.01)
"""Noise before any is known: shares of the series' largest response, and of the response itself."""
FEWEST_TRIPLES = 8
"""Triples of neighbouring sines that tell how rough a misfit is."""
OUTLIER = 9.0
"""Times its variance: a squared roughness beyond it is a resonance's flank, not noise."""


def first_guess(measurement: PipeMeasurement) -> Array:
    """Give a standard deviation of real and of imaginary parts before any is known, (P, probes)."""
    return _noise(measurement, *FIRST_GUESS)


def misfit_noise(measurement: PipeMeasurement, computed: ComplexArray) -> Array | None:
    """Give the standard deviation of real and of imaginary parts; None where nothing tells it, (P, probes).

    Neighbouring frequencies have one misfit nearly, but each its own noise: what a misfit departs from the line through
    its neighbours is noise, of variance floor^2 + (share response)^2.

    Args:
        measurement: the sines.
        computed: response of a model that comes near, (P, probes).
    """
    if np.isfinite(sine_scatter_of(measurement)).all():
        return _beside_scatter(measurement, 0.0, 0.0)
    roughness = _roughness(measurement, computed)
    if len(roughness) < FEWEST_TRIPLES:
        return None
    squares, highest, sizes = np.array(roughness).T
    for _ in range(2):
        floor, share = _shares(squares, highest, sizes)
        inside = squares <= OUTLIER * ((floor * highest) ** 2 + (share * sizes) ** 2)
        squares, highest, sizes = squares[inside], highest[inside], sizes[inside]
    return _beside_scatter(measurement, floor, share)


def likeliest_noise(measurement: PipeMeasurement, computed: ComplexArray, parameters: int) -> Array:
    """Give the likeliest standard deviation where a model leaves nothing but noise, (P, probes).

    All that it leaves tells the noise then, twice as much as its roughness does: of variance floor^2 +
    (share response)^2, over the degrees of freedom.

    Args:
        measurement: the sines.
        computed: the model's response, (P, probes).
        parameters: how many were fitted.
    """
    steady = measurement.steady
    size = np.abs(steady.response)
    highest = _noise(measurement, 1.0, 0.0)
    parts = np.where(steady.phased, 2, 1)
    squares = np.abs(turned_error(measurement, computed)) ** 2 / parts
    known = np.isfinite(squares)
    floor, share = _shares(squares[known], highest[known], size[known])
    values = float(np.sum(parts[known]))
    freed = np.sqrt(values / max(1.0, values - parameters))
    return _beside_scatter(measurement, freed * floor, freed * share)


def _beside_scatter(measurement: PipeMeasurement, floor: float, share: float) -> Array:
    """Give the noise of repeats where there are any, else that of these shares; with the model's own error."""
    scatter = sine_scatter_of(measurement)
    noise = np.where(np.isfinite(scatter), scatter, _noise(measurement, floor, share))
    return np.asarray(np.hypot(noise, _noise(measurement, TRUSTED_SHARE, MODEL_ERROR)))


def _noise(measurement: PipeMeasurement, floor: float, share: float) -> Array:
    """Give the noise of shares of each series' largest response and of each response, (P, probes)."""
    size = np.nan_to_num(np.abs(measurement.steady.response))
    found = share * size
    for one in series_of(measurement.steady):
        found[one.rows] = np.hypot(found[one.rows], floor * size[one.rows].max(axis=0))
    return np.asarray(found)


def _roughness(measurement: PipeMeasurement, computed: ComplexArray) -> Sequence[tuple[float, float, float]]:
    """Give squared departures from the line through the neighbours, with the series' largest response and the own."""
    steady = measurement.steady
    error = turned_error(measurement, computed)
    found = []
    for one in series_of(steady):
        for column in range(steady.response.shape[1]):
            rows = one.rows[np.isfinite(error[one.rows, column])]
            highest = float(np.abs(steady.response[rows, column]).max(initial=0.0))
            for before, at, after in zip(rows, rows[1:], rows[2:], strict=False):
                reach = steady.frequency[after] - steady.frequency[before]
                if reach <= 0:
                    continue
                weight = (steady.frequency[at] - steady.frequency[before]) / reach
                # The error was turned by the measured phase, each by its own: neighbours are compared unturned.
                turn = np.exp(1j * np.angle(steady.response[[before, at, after], column]))
                first, middle, last = error[[before, at, after], column] * turn
                departure = middle - (1 - weight) * first - weight * last
                parts = 2 if steady.phased[at, column] else 1
                spread = parts * (1 + (1 - weight) ** 2 + weight**2)
                found.append((abs(departure) ** 2 / spread, highest, float(np.abs(steady.response[at, column]))))
    return found


def _shares(squares: Array, highest: Array, sizes: Array) -> tuple[float, float]:
    """Give floor and share of the likeliest variance (floor highest)^2 + (share size)^2 of normal departures."""

    def unlikelihood(logs: Array) -> float:
        floor, share = np.exp(2 * logs)
        variance = floor * highest**2 + share * sizes**2
        return float(np.sum(np.log(variance) + squares / variance))

    begin = np.log(np.array(FIRST_GUESS))
    found = minimize(unlikelihood, begin, method="Nelder-Mead", bounds=[(-14.0, 2.0)] * 2, options={"xatol": 0.01})
    floor, share = np.exp(found.x).tolist()
    return floor, share
