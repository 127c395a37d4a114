"""Where a coupled model fails on the pipe, in an engineer's sentences and for --json."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeclamp_identification.comparison.densest_region import is_scatter, region_sentence
from pipeclamp_identification.on_pipe.prediction import SAME_LEVEL, temperatures
from pipeclamp_identification.on_pipe.sines import PipeComparison
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.arrays import Array, BoolArray, IntArray
from pipeclamp_models.base.said import counted
from pipeclamp_system.description.measured_table import DRIVES
from pipeclamp_system.steady.harmonics import DOUBTFUL_SHARE

PEAK_MOVED, PEAK_OFF = 0.005, 0.05
"""Shares by which a peak must be moved, or be too high, to be worth a sentence."""


def where_words(comparison: PipeComparison) -> list[str]:
    """Say in sentences where the error sits: region, amplitude or phase, resonances, what was left out."""
    kinds = comparison.by_kind()
    words = [region_sentence(comparison.region(), comparison.by_probe(), "model")]
    if comparison.phased and not is_scatter(kinds):
        amplitude, phase = (kinds.share(part) for part in kinds.parts)
        words.append(f"{amplitude:.0%} of it is wrong in amplitude, {phase:.0%} in phase.")
    words += _peak_words(comparison)
    words += _branch_words(comparison)
    words += _truncated_words(comparison)
    words += _range_words(comparison)
    return words


def _peak_words(comparison: PipeComparison) -> Iterator[str]:
    """Say how the highest measured peak of each level stands against the model's."""
    steady = comparison.measurement.steady
    levels = number_levels(steady.level, relative=SAME_LEVEL)
    for temperature, rows in temperatures(steady):
        for level in levels:
            own = np.intersect1d(rows, level.rows)
            own = own[np.argsort(steady.frequency[own], kind="stable")]
            for column, name in enumerate(comparison.probes):
                found = highest_peaks(comparison, own, column)
                if found is None:
                    continue
                (f_measured, measured), (f_model, model) = found
                moved, off = f_model / f_measured - 1, model / measured - 1
                wrong = []
                if abs(moved) > PEAK_MOVED:
                    wrong.append(f"at {f_model:.4g} Hz instead of {f_measured:.4g} Hz ({moved:+.1%})")
                if abs(off) > PEAK_OFF:
                    wrong.append(f"{abs(off):.0%} too {'high' if off > 0 else 'low'}")
                if wrong:
                    at = "" if temperature is None else f", {temperature:g} °C"
                    of = f"{level.label} {DRIVES[steady.drive_unit].unit}{at}"
                    yield f"At {name}, {of}: the model peaks {', '.join(wrong)}."


def highest_peaks(
    comparison: PipeComparison, rows: IntArray, column: int
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Give frequency (Hz) and height of the measured and of the computed peak; None where one lies at an end.

    Of the computed ones it is the nearest to the highest measured one: of two modes that are about as high, either may
    be the highest.
    """
    rows = rows[comparison.compared[rows, column]]
    if rows.size < 5:
        return None
    steady = comparison.measurement.steady
    frequency = steady.frequency[rows]
    measured, model = (
        np.abs(response[rows, column]) * steady.drive[rows]
        for response in (steady.response, comparison.prediction.response)
    )
    highest = int(measured.argmax())
    tops = 1 + np.flatnonzero((model[1:-1] >= model[:-2]) & (model[1:-1] > model[2:]))
    if highest in (0, rows.size - 1) or not tops.size:
        return None
    nearest = int(tops[np.argmin(np.abs(np.log(frequency[tops] / frequency[highest])))])
    peaks = ((highest, measured), (nearest, model))
    of_measured, of_model = ((float(frequency[place]), float(heights[place])) for place, heights in peaks)
    return of_measured, of_model


def _branch_words(comparison: PipeComparison) -> Iterator[str]:
    steady, prediction = comparison.measurement.steady, comparison.prediction
    several = np.flatnonzero(prediction.branches > 1)
    if several.size:
        said = np.count_nonzero(steady.sweep[several])
        taken = "the one that the sweep's direction leads to" if said else "the one nearest to what was measured"
        if 0 < said < several.size:
            taken = "the one that the sweep's direction leads to, else the one nearest to what was measured"
        f = steady.frequency[several]
        yield (f"At {sines(several.size)} ({_span(f)} Hz) the model has several stable motions; compared is {taken}.")
    lost = np.flatnonzero(~np.isfinite(prediction.response).any(axis=1))
    if lost.size:
        led = ", or none that the sweep leads to" if steady.sweep[lost].any() else ""
        yield f"At {sines(lost.size)} no stable steady motion of the model was found{led}: left out."


def _truncated_words(comparison: PipeComparison) -> Iterator[str]:
    """Say where the model's own motions lack harmonics."""
    doubtful = np.flatnonzero(comparison.truncated > DOUBTFUL_SHARE)
    if doubtful.size:
        f, worst = comparison.measurement.steady.frequency[doubtful], comparison.truncated[doubtful].max()
        yield (
            f"At {sines(doubtful.size)} ({_span(f)} Hz) the model's own motion is truncated: harmonics that are left "
            f"out would move up to {worst:.1%} of it; an error of that size there is not the pipe's."
        )


def _span(values: Array) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"


def _range_words(comparison: PipeComparison) -> Iterator[str]:
    """Say where clamps move outside the range of their laws."""
    beyond = beyond_laws(comparison)
    for index, name in enumerate(comparison.model.clamp_names):
        moved = np.abs(comparison.prediction.clamps[:, index])
        low, high = _range_of(comparison, index)
        outside = np.count_nonzero(beyond[:, index])
        if outside:
            yield (
                f"At {outside} of {sines(moved.size)} clamp {name} moves outside the {low:.3g} to {high:.3g} mm in "
                f"which its law was identified: by {np.nanmin(moved):.3g} to {np.nanmax(moved):.3g} mm."
            )


def beyond_laws(comparison: PipeComparison) -> BoolArray:
    """Tell at which sines each clamp moves outside the amplitudes in which its law was identified, (P, clamps)."""
    moved = np.abs(comparison.prediction.clamps)
    low, high = np.array([_range_of(comparison, index) for index in range(moved.shape[1])]).reshape(-1, 2).T
    return (moved < low) | (moved > high)


def _range_of(comparison: PipeComparison, index: int) -> tuple[float, float]:
    """Give the amplitudes in which a clamp's law was identified, mm."""
    return next(iter(comparison.model.clamps.values()))[index][1].range_A


def sines(count: int) -> str:
    """Give a number of sines in words."""
    return counted(count, "sine")


def how_much(comparison: PipeComparison) -> list[str]:
    """Say how much the model errs, and what of it is scatter."""
    count, probes = comparison.squared_measured.shape
    words = (
        f"The coupled model errs by {comparison.nrmse:.2%} of the rms of what was measured, "
        f"over {sines(count)} and {counted(probes, 'probe')}"
    )
    if comparison.noise_nrmse is None:
        return [f"{words}; no scatter is known: no sine was repeated."]
    return [f"{words}; {comparison.noise_nrmse:.2%} is scatter, which no model can explain."]
