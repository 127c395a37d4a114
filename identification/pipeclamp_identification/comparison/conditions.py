"""Conditions of the tests by levels: runs whose conditions differ by next to nothing are at one set point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.campaign.reading import Campaign
from pipeclamp_identification.loops.loops import Loops
from pipeclamp_identification.signals.levels import Level, name_levels, number_levels
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.units import CELSIUS

SAME_LEVEL_SHARE = 0.06
SAME_TEMPERATURE_K = 3.0
SAME_OF_RANGE = 0.02
"""Conditions that differ by less, as a share, in K, or as a share of their range, are one set point."""


@dataclass(frozen=True)
class Condition:
    """A condition of the tests, by levels.

    Attributes:
        key: its name in JSON.
        name: its name in words.
        unit: empty where the name holds it.
        levels: the runs at each of its levels.
        ordered: whether levels have an order.
    """

    key: str
    name: str
    unit: str
    levels: tuple[Level, ...]
    ordered: bool = True

    @property
    def varies(self) -> bool:
        """Whether there is more than one level."""
        return len(self.levels) > 1

    @property
    def sorts(self) -> bool:
        """Whether it varies and a level holds several runs: otherwise it tells runs apart, and puts none together."""
        return self.varies and any(len(level.rows) > 1 for level in self.levels)

    def level_of(self, row: int) -> Level:
        """Give the level of a run."""
        return next(level for level in self.levels if row in level.rows)

    def words(self, level: Level) -> str:
        """Give a level with the condition's unit, or else its name."""
        if not level.known:
            return f"{self.name} {level.label}"
        return f"{level.label} {self.unit}" if self.unit else f"{self.name} {level.label}"

    @property
    def title(self) -> str:
        """Name and unit, as an axis has them."""
        return f"{self.name} / {self.unit}" if self.unit else self.name


def conditions_of(campaign: Campaign, loops: Loops) -> tuple[Condition, ...]:
    """Give the conditions of the tests: A, f, T, density, first cycle, further columns, specimen."""
    stated = {
        "density_g_cm3": loops.density_g_cm3,
        "first_cycle": np.array([run.setup.first_cycle for run in campaign.runs]),
        **loops.conditions,
    }
    return (
        Condition("amplitude_mm", "A", "mm", number_levels(loops.amplitude_mm, relative=SAME_LEVEL_SHARE)),
        Condition("frequency_Hz", "f", "Hz", number_levels(loops.frequency_Hz, relative=SAME_LEVEL_SHARE)),
        *stated_conditions(loops.temperature_K, stated, loops.specimen),
    )


def stated_conditions(
    temperature: Array, stated: Mapping[str, Array], specimen: Sequence[str | None]
) -> tuple[Condition, ...]:
    """Give the conditions besides the motion's: of temperatures in K, columns by name, specimens, of each run."""
    T = number_levels(temperature - CELSIUS, absolute=SAME_TEMPERATURE_K)
    return (
        Condition("temperature_C", "T", "°C", T),
        *(Condition(column, column, "", _stated_levels(values)) for column, values in stated.items()),
        Condition("specimen", "specimen", "", name_levels(specimen), ordered=False),
    )


def _stated_levels(values: Array) -> tuple[Level, ...]:
    known = values[np.isfinite(values)]
    step = SAME_OF_RANGE * float(np.ptp(known)) if len(known) else 0.0
    return number_levels(values, relative=SAME_LEVEL_SHARE, absolute=step)
