"""A delay of the force behind the displacement that all runs of a rig share, told from how loss depends on frequency.

A force that is read late by tau turns F1/Y1 by -2 pi f tau: the loss angle falls in proportion to the frequency, by the
same time at every amplitude and temperature. A dashpot turns it the other way, and by a time that changes with the
stiffness. What falls could in part be the clamp's own; so the delay is told and not taken off.
"""

from __future__ import annotations

import math

import numpy as np

from pipeclamp_identification.campaign.imported import ImportedDelay
from pipeclamp_identification.campaign.plausibility import fundamental_of
from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.units import CELSIUS

SURE = 4.0
"""Standard errors from which on a delay is told."""
SAME, SAME_K = 0.1, 8.0
"""Share of the amplitude, and kelvins, within which runs are at one condition."""
FREQUENCIES_APART = 1.5
"""Factor between the lowest and the highest frequency that a condition's runs must span."""
FEWEST_CONDITIONS = 2
"""Conditions that must agree on it, so that it is the rig's and no clamp's."""
ALIKE = 0.25
"""Scatter from condition to condition, as a share of the delay, above which it isn't constant."""
OF_ANGLE = 0.01
"""rad at the highest frequency below which a delay does no harm."""


def common_delay(campaign: Campaign) -> ImportedDelay | None:
    """Measure the delay of the force that all conditions of a campaign share; None where none is seen.

    Only a falling loss angle is told: a rising one is what dashpots do.
    """
    runs = [run for run in campaign.runs if run.cycles.count > 1]
    slopes = []
    highest = 0.0
    for members in _conditions(runs):
        f = np.array([run.cycles.frequency_Hz for run in members])
        if np.max(f) < FREQUENCIES_APART * np.min(f):
            continue
        shown = [fundamental_of(run.record, run.cycles) for run in members]
        angle = np.array([math.atan2(one.stiffness.imag, one.stiffness.real) for one in shown])
        slopes.append(float(np.polyfit(2 * np.pi * f, angle, 1)[0]))
        highest = max(highest, float(np.max(f)))
    if len(slopes) < FEWEST_CONDITIONS:
        return None
    delay = -float(np.median(slopes))
    scatter = float(np.std(slopes, ddof=1))
    error = scatter / math.sqrt(len(slopes))
    if delay * 2 * math.pi * highest < OF_ANGLE or delay < SURE * error or scatter > ALIKE * delay:
        return None
    words = (
        f"the force is {1e3 * delay:.3g} ms (standard error {1e3 * error:.1g} ms) behind the displacement, alike in "
        f"{len(slopes)} conditions: the loss angle falls with the frequency as filters of unequal delay make it; it is "
        "not taken off; to do: use one filter for both channels, or measure their delay with a rigid specimen"
    )
    return ImportedDelay(
        delay_ms=float(f"{1e3 * delay:.4g}"), standard_error_ms=float(f"{max(1e3 * error, 1e-9):.2g}"), words=words
    )


def _conditions(runs: list[Run]) -> list[list[Run]]:
    """Give the runs that differ in frequency alone, condition by condition."""
    if not runs:
        return []
    amplitude = number_levels(
        np.array([fundamental_of(run.record, run.cycles).amplitude_mm for run in runs]), relative=SAME
    )
    kelvin = [math.nan if run.temperature_C is None else run.temperature_C + CELSIUS for run in runs]
    temperature = number_levels(np.array(kelvin), absolute=SAME_K)
    found = []
    for one in amplitude:
        for other in temperature:
            rows = sorted(set(one.rows.tolist()) & set(other.rows.tolist()))
            if len(rows) > 1:
                found.append([runs[row] for row in rows])
    return found
