"""Series of sines of a measurement: one level, temperature and sweep each, by rising frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeclamp_identification.on_pipe.measurement import SWEEPS, SteadyMeasurement
from pipeclamp_identification.on_pipe.prediction import SAME_LEVEL, temperatures
from pipeclamp_identification.signals.levels import number_levels
from pipeclamp_models.base.arrays import IntArray
from pipeclamp_system.description.measured_table import DRIVES


@dataclass(frozen=True, eq=False)
class Series:
    """Sines of one level, temperature and sweep, by rising frequency."""

    label: str
    rows: IntArray


def series_of(steady: SteadyMeasurement) -> list[Series]:
    """Give the sines of a measurement as series."""
    levels = number_levels(steady.level, relative=SAME_LEVEL)
    found = []
    for temperature, at_temperature in temperatures(steady):
        for level in levels:
            for word, way in SWEEPS.items():
                rows = np.intersect1d(np.intersect1d(at_temperature, level.rows), np.flatnonzero(steady.sweep == way))
                if rows.size:
                    words = [f"{level.label} {DRIVES[steady.drive_unit].unit}"]
                    words += [f"{temperature:g} °C"] if temperature is not None else []
                    words += [word] if word else []
                    rows = rows[np.argsort(steady.frequency[rows], kind="stable")]
                    found.append(Series(", ".join(words), rows))
    return found
