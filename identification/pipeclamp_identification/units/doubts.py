"""Units that contradict what was stated, which is refused, and those that are only unlikely, which is told.

What is stated of a run and what its record shows are two measurements of one thing. Where all runs differ by the one
factor that two units differ by, one of the two units is wrong: that is sure. That numbers are far from what clamps do
isn't: of forces, displacements and times such words say "may be", for what is tested may be softer, slower or smaller
than clamps are, and of temperatures, which several round numbers tell, "likely".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import newtons, plain
from pipeclamp_models.base.units import CELSIUS

FEWEST = 2
"""Runs that must agree on a factor."""
WITHIN = 0.1
"""Share by which each run's ratio may differ from the factor: drives miss by some percent."""
LENGTHS = {
    1e-3: "m for mm", 0.1: "cm for mm", 1 / 25.4: "in for mm", 1e3: "µm for mm", 1e6: "nm for mm", 25.4: "mm for in",
    10.0: "mm for cm", 1 / 25400: "mil for µm",
}  # fmt: skip
"""What the displacement's unit is taken for, by the ratio of shown to stated amplitudes."""
TIMES = {1e-3: "ms for s", 1e-6: "µs for s", 60.0: "min for s", 3600.0: "h for s", 1e3: "s for ms"}
"""Likewise of the time's, by the ratio of shown to stated frequencies."""
RATES = {1 / 60: "rpm for Hz", 1 / (2 * math.pi): "rad/s for Hz"}
"""And of the stated frequency's."""
KELVINS_APART = 5.0
"""K within which a temperature that is shown agrees with the stated one in another unit."""
SOFTEST, WEAKEST = 20.0, 20.0
"""N/mm and N below which, both at once, no clamp was ever tested: kN may be meant."""
STIFFEST = 1e6
"""N/mm above which m for mm, or mN for N, may be meant."""
SMALLEST, LARGEST = 1e-3, 200.0
"""Amplitudes in mm beyond which another unit may be meant."""
SLOWEST, SLOW_STEP = 0.05, 0.5
"""Hz and s: a test that is slower, with stamps of time farther apart, may count milliseconds."""
FASTEST = 2000.0
"""Hz above which time may be in another unit."""
ROOM = (285.0, 300.0)
"""K that a room has, as the lowest of several temperatures in °C hardly is."""
ROUND = 5.0
"""Set points are multiples of so many degrees, in the unit in which they were set."""
NEARLY = 0.3


class StatedAndShown(NamedTuple):
    """A setting as it was stated, None where it wasn't, and as the record shows it; nan without a channel that does."""

    stated: float | None
    shown: float


@dataclass(frozen=True)
class ShownRun:
    """What is stated of a run, and what its record shows.

    Attributes:
        amplitude_mm, frequency_Hz, temperature_C: its settings.
        stiffness: dynamic, N/mm.
        load: largest force of a cycle about, N: with its mean.
        step_s: usual step of the record's time.
    """

    run: str
    amplitude_mm: StatedAndShown
    frequency_Hz: StatedAndShown
    temperature_C: StatedAndShown
    stiffness: float
    load: float
    step_s: float


def contradicted_units(runs: Sequence[ShownRun]) -> str:
    """Say which unit is wrong, with its factor, where that is sure; empty where nothing is."""
    amplitudes = _ratio([run.amplitude_mm for run in runs], LENGTHS)
    if amplitudes:
        ratio, meant, count = amplitudes
        return (
            f"the records show {ratio:.3g} times the amplitudes of runs.csv, in all {count} runs: {meant}; expected mm "
            "in both: mend amplitude_mm, or the displacement's unit (import: --columns; campaign.toml: [columns] "
            f"displacement_mm, factor = {1 / ratio:.6g})"
        )
    frequencies = _ratio([run.frequency_Hz for run in runs], TIMES | RATES)
    if frequencies:
        ratio, meant, count = frequencies
        remedy = (
            f", or the time's unit (import: --columns; campaign.toml: [columns] time_s, factor = {ratio:.6g})"
            if meant in TIMES.values()
            else " in runs.csv"
        )
        return (
            f"the records show {ratio:.3g} times the frequencies of runs.csv, in all {count} runs: {meant}; expected s "
            f"and Hz: mend frequency_Hz{remedy}"
        )
    return _contradicted_temperatures([run.temperature_C for run in runs])


def _ratio(settings: Sequence[StatedAndShown], meant: dict[float, str]) -> tuple[float, str, int] | None:
    """Give the factor between units that all settings show; None where there is none."""
    ratios = np.array([shown / stated for stated, shown in settings if stated])
    if len(ratios) < FEWEST:
        return None
    for factor, words in meant.items():
        if np.all(np.abs(ratios / factor - 1) <= WITHIN):
            return factor, words, len(ratios)
    return None


def _contradicted_temperatures(settings: Sequence[StatedAndShown]) -> str:
    pairs = np.array([(stated, shown) for stated, shown in settings if stated is not None and math.isfinite(shown)])
    if not len(pairs):
        return ""
    stated, shown = pairs.T
    ways = {
        "K for °C in the record": (stated + CELSIUS, shown), "K for °C in runs.csv": (shown + CELSIUS, stated),
        "°F for °C in the record": (1.8 * stated + 32, shown), "°F for °C in runs.csv": (1.8 * shown + 32, stated),
    }  # fmt: skip
    for words, (expected, got) in ways.items():
        # near -40 degrees both scales say the same
        if np.all(np.abs(expected - got) <= KELVINS_APART) and np.all(np.abs(stated - shown) > 2 * KELVINS_APART):
            return (
                f"temperatures: the records show {_span(shown)} where runs.csv states {_span(stated)}, in all "
                f"{len(pairs)} runs: {words}; expected °C in both: convert that column"
            )
    return ""


def unlikely_units(runs: Sequence[ShownRun]) -> tuple[str, ...]:
    """Say which units may be wrong, each with its factor: nothing contradicts them, but clamps hardly are so."""
    if not runs:
        return ()
    stiffness = float(np.median([run.stiffness for run in runs]))
    amplitude = float(np.median([run.amplitude_mm.shown for run in runs]))
    frequency = float(np.median([run.frequency_Hz.shown for run in runs]))
    step = float(np.median([run.step_s for run in runs]))
    found = []
    if stiffness < SOFTEST and float(np.median([run.load for run in runs])) < WEAKEST:
        found.append(
            f"the force may be in kN, not N (factor 1000): {newtons(stiffness * amplitude)} of amplitude, "
            f"{plain(stiffness, 3)} N/mm of stiffness"
        )
    if stiffness > STIFFEST or amplitude < SMALLEST:
        found.append(
            f"the displacement may be in m, not mm (factor 1000): {amplitude:.3g} mm of amplitude, "
            f"{plain(stiffness, 3)} N/mm of stiffness"
        )
    elif amplitude > LARGEST:
        found.append(f"the displacement may be in µm, not mm (factor 0.001): {amplitude:.4g} mm of amplitude")
    if frequency < SLOWEST and step > SLOW_STEP:
        found.append(f"the time may be in ms, not s (factor 0.001): {frequency:.3g} Hz, a sample every {step:.3g} s")
    elif frequency > FASTEST:
        found.append(f"the time may not be in s: {frequency:.4g} Hz")
    known = np.array(
        [run.temperature_C.stated for run in runs if run.temperature_C.stated is not None], dtype=np.float64
    )
    return (*found, *_unlikely_temperatures(np.unique(known)))


def _unlikely_temperatures(levels: Array) -> tuple[str, ...]:
    """Say that temperatures are likely in K or °F: set points are round numbers in the unit in which they were set."""
    if not len(levels) or _round(levels):
        return ()
    # one set point that is round in another unit is round by chance: 23 °C is -5 °C in °F
    set_points = 1 + np.count_nonzero(np.diff(levels) > ROUND / 2)
    if set_points < FEWEST and not ROOM[0] <= levels[0] <= ROOM[1]:
        return ()
    words = f"temperature_C in runs.csv, {_span(levels)}, is likely in"
    if ROOM[0] <= levels[0] <= ROOM[1] or _round(levels - CELSIUS):
        return (f"{words} K: {_span(levels - CELSIUS)} °C",) if levels[0] > ROOM[0] - 40 else ()
    if _round((levels - 32) / 1.8):
        return (f"{words} °F: {_span((levels - 32) / 1.8)} °C",)
    return ()


def _round(levels: Array) -> bool:
    return bool(np.all(np.abs(levels / ROUND - np.round(levels / ROUND)) * ROUND <= NEARLY))


def _span(values: Array) -> str:
    low, high = f"{np.min(values):.4g}", f"{np.max(values):.4g}"
    return low if low == high else f"{low} to {high}"
