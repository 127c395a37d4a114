"""Variations: one quantity varies while the others are held, as in the studies of the paper's Tables 2-5, Fig. 5-8."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign, Run
from pipeclamp_identification.loops.loops import Loops, on_grid
from pipeclamp_identification.loops.published_rows import KELVINS, PublishedRow, matching_row
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import rounded_to

SAME_SETTING_SHARE = 0.03
"""Settings of a test plan that are meant to be the same lie this close together, those that aren't lie further
apart."""

SPECIMEN = "specimen"


@dataclass(frozen=True)
class Variation:
    """Runs between which one quantity varies; `rows` index the campaign's runs, in rising order of the quantity."""

    quantity: str
    """A column of runs.csv: frequency_Hz, amplitude_mm, density_g_cm3, temperature_C or a further condition."""
    held: tuple[tuple[str, float | str], ...]
    """The other quantities that are known, with their nominal values."""
    rows: tuple[int, ...]
    values: tuple[float, ...]
    """The nominal value of the quantity in each row."""
    published: tuple[PublishedRow | None, ...]
    """The published row at the conditions of each row."""


def variations_of(campaign: Campaign, loops: Loops) -> tuple[Variation, ...]:
    """Find the variations in a campaign: every set of runs that differ in one quantity only.

    Nominal values are compared, not measured ones, with the scatter of settings that rigs have; amplitude and
    frequency are measured where runs.csv doesn't say them. A specimen may differ where the density varies.

    Args:
        campaign: with R runs.
        loops: its loops, one row per run.

    Returns:
        The variations of two or more runs, in the order frequency, amplitude, density, temperature, further conditions.
    """
    levels = _levels(campaign, loops)
    specimens = [run.setup.specimen or "" for run in campaign.runs]
    published = [matching_row(run) for run in campaign.runs]
    variations = []
    for quantity, varied in levels.items():
        held = [name for name in levels if name != quantity]
        groups: dict[tuple[float | str, ...], list[int]] = {}
        for row in range(len(campaign.runs)):
            specimen = "" if quantity == "density_g_cm3" else specimens[row]
            # an unknown value is a level of its own; nan would differ from itself
            key = (specimen, *(_known(levels[name][row]) for name in held))
            groups.setdefault(key, []).append(row)
        for key, members in groups.items():
            rows = sorted((row for row in members if math.isfinite(varied[row])), key=lambda row: (varied[row], row))
            if len({varied[row] for row in rows}) > 1:
                named = [pair for pair in zip((SPECIMEN, *held), key, strict=True) if pair[1] != ""]
                variations.append(
                    Variation(
                        quantity=quantity,
                        held=tuple(named),
                        rows=tuple(rows),
                        values=tuple(float(varied[row]) for row in rows),
                        published=tuple(published[row] for row in rows),
                    )
                )
    return tuple(variations)


def principal_variations(variations: Sequence[Variation]) -> tuple[Variation, ...]:
    """Choose one variation per quantity: the one with most published values beside it, then the one with most runs.

    Args:
        variations: as `variations_of` returns them.

    Returns:
        At most one per quantity, in the same order. Of equals it is the middle one in its held values.
    """
    chosen = []
    for quantity in dict.fromkeys(variation.quantity for variation in variations):
        same = [one for one in variations if one.quantity == quantity]
        score = max(_score(one) for one in same)
        best = sorted((one for one in same if _score(one) == score), key=lambda one: str(one.held))
        chosen.append(best[len(best) // 2])
    return tuple(chosen)


def loops_to_draw(loops: Loops, variation: Variation, points: int = 256) -> tuple[tuple[Array, Array], ...]:
    """Return a variation's loops to be laid over one another, as in the paper's Fig. 5-8.

    Args:
        loops: one row per run of the campaign in which it was found.
        variation: which of them.
        points: points per loop.

    Returns:
        For each run the displacement (points,) in mm and the force (points,) in N, from the harmonics of the
        cycle-averaged loop.
    """
    rows = list(variation.rows)
    y, force = on_grid(loops.displacement[rows], points), on_grid(loops.force[rows], points)
    return tuple(zip(y, force, strict=True))


def same_setting(quantity: str, values: Array) -> Array:
    """Give how far settings of a quantity that are meant to be the same lie apart at these values, at most."""
    return np.maximum(SAME_SETTING_SHARE * np.abs(values), KELVINS if quantity == "temperature_C" else 0.0)


def _score(variation: Variation) -> tuple[int, int]:
    return sum(row is not None for row in variation.published), len(variation.rows)


def _known(value: float) -> float | str:
    return float(value) if math.isfinite(value) else ""


def _levels(campaign: Campaign, loops: Loops) -> dict[str, Array]:
    """Return each quantity's nominal value per run: the mean of the settings that lie together; nan if unknown."""

    def of(value: Callable[[Run], float | None]) -> Array:
        return np.array([math.nan if (v := value(run)) is None else v for run in campaign.runs])

    amplitude, frequency = of(lambda run: run.amplitude_mm), of(lambda run: run.frequency_Hz)
    quantities = {
        "frequency_Hz": np.where(np.isfinite(frequency), frequency, loops.frequency_Hz),
        "amplitude_mm": np.where(np.isfinite(amplitude), amplitude, loops.amplitude_mm),
        "density_g_cm3": of(lambda run: run.setup.density_g_cm3),
        "temperature_C": of(lambda run: run.setup.temperature_C),
        **loops.conditions,
    }
    return {name: levels_of(name, values) for name, values in quantities.items()}


def levels_of(quantity: str, values: Array) -> Array:
    """Replace values of a quantity by the mean, to four digits, of those that lie together; nan stays."""
    rising = np.unique(values[np.isfinite(values)])
    if len(rising) == 0:
        return values
    apart = np.diff(rising) > same_setting(quantity, rising[1:])
    level = np.concatenate([[0], np.cumsum(apart)])
    places = np.searchsorted(rising, values[np.isfinite(values)])
    result = values.copy()
    member = level[places]
    for k in range(level[-1] + 1):
        known = np.flatnonzero(np.isfinite(values))[member == k]
        result[known] = rounded_to(np.mean(values[known]), 4)
    return result
