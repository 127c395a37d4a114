"""The range of conditions that a law's data cover, rounded as a parameter file states it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.signals import OWN_SIGNALS, signal_in_range
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_models.law.file import Interval, LawFile

LAW_DIGITS = 10
"""Significant digits of the file's numbers: more than any test supports, fewer than the last bits of a solver."""


def intervals_of(columns: Mapping[str, Array]) -> dict[str, Interval]:
    """Give the range of each condition that is known throughout; A, f, T, rho and further ones by their columns."""
    units = {"A": "mm", "f": "Hz", "T": "K", "rho": "g/cm3", "N": "cycles"}
    return {
        name: Interval(
            minimum=_outward(values.min(), math.floor),
            maximum=_outward(values.max(), math.ceil),
            unit=units.get(name, "in its name"),
        )
        for name, values in columns.items()
        if np.all(np.isfinite(values))
    }


def _outward(value: float, towards: Callable[[float], int]) -> float:
    """Round an end of a range outward to three significant digits: drives miss their set points by that much."""
    if value == 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2)
    return rounded(towards(round(value / step, 6)) * step)


def celsius_tested(interval: Interval) -> tuple[float, float]:
    """Give the whole degrees Celsius that a range of temperatures reaches from and to.

    Its ends are kelvins, rounded outward: 20 and 60 degC are 293 to 334 K there, and nobody sets a chamber to 19.85 and
    60.85 degC. Of a range that holds no whole degree, its ends.
    """
    ends = interval.minimum - CELSIUS, interval.maximum - CELSIUS
    low, high = math.ceil(round(ends[0], 6)), math.floor(round(ends[1], 6))
    return (float(low), float(high)) if low <= high else ends


def rounded(value: float) -> float:
    """Give the number with ten significant digits, so that the same data give the same file."""
    return float(f"{value:.{LAW_DIGITS}g}")


def as_in_range(file: LawFile, conditions: Mapping[str, float]) -> dict[str, float]:
    """Give conditions by the names that a law's range has for them, which are columns; equations have signals."""
    names = {signal_in_range(name): name for name in file.range}
    return {names.get(name, name): value for name, value in conditions.items()}


def conditions_beyond(file: LawFile, conditions: Mapping[str, float]) -> dict[str, float]:
    """Give those conditions that lie beyond a law's range, by its names and in its units."""
    return {
        name: value
        for name, value in conditions.items()
        if name in file.range and not file.range[name].minimum <= value <= file.range[name].maximum
    }


def conditions_inside(known: Mapping[str, Interval], conditions: Mapping[str, float]) -> dict[str, float]:
    """Give conditions, by the names and in the units of a law's range; those that it holds moved inside it."""
    return {
        name: min(max(value, known[name].minimum), known[name].maximum) if name in known else value
        for name, value in conditions.items()
    }


def beyond_tests(file: LawFile, given: Mapping[str, npt.ArrayLike]) -> tuple[str, ...]:
    """Say which conditions lie outside the law's range, by more than 2 % of it.

    Args:
        file: the law.
        given: conditions by name, A in mm, f in Hz, T in degC, further ones by their columns in runs.csv.
    """
    found = []
    for name, values in given.items():
        interval = file.range.get(OWN_SIGNALS.get(name, name))
        if interval is None or not np.size(values):
            continue
        zero, unit = (CELSIUS, " °C") if name == "T" else (0.0, f" {interval.unit}" if name in ("A", "f") else "")
        low, high = interval.minimum - zero, interval.maximum - zero
        least, most = float(np.min(values)), float(np.max(values))
        margin = _margin(interval)
        farthest = least if low - least > most - high else most
        if max(low - least, most - high) > margin:
            found.append(f"{name} = {farthest:.4g}{unit} lies beyond the law's tests, {low:.4g} to {high:.4g}{unit}")
    return tuple(found)


def _margin(interval: Interval) -> float:
    """Give how far outside a range still counts as inside."""
    return 0.02 * max(interval.maximum - interval.minimum, 0.02 * abs(interval.maximum))


def outside_range(file: LawFile, runs: Sequence[str], columns: Mapping[str, Array]) -> dict[str, str]:
    """Find the runs outside the law's range, by more than 2 % of it, and say what is outside; temperatures in °C.

    Args:
        file: the law.
        runs: names of the runs, R.
        columns: conditions by name, shape (R,) each.
    """
    found: dict[str, list[str]] = {}
    for name, interval in file.range.items():
        margin = _margin(interval)
        zero, unit = (CELSIUS, "°C") if name == "T" else (0.0, interval.unit)
        law = f"{interval.minimum - zero:.4g} to {interval.maximum - zero:.4g}"
        for run, value in zip(runs, columns.get(name, ()), strict=False):
            if not interval.minimum - margin <= value <= interval.maximum + margin and math.isfinite(value):
                found.setdefault(run, []).append(f"{name} = {value - zero:.4g} {unit}, law: {law}")
    return {run: "; ".join(texts) for run, texts in found.items()}
