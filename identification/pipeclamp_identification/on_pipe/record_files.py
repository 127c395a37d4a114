"""Records of any motion of a pipe, as they are read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from pipeclamp_identification.on_pipe.measurement import MeasurementDescription, ProbeTable, RecordTable
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_system.description.measured_table import DRIVES, Drive, ascending_time, csv_frame, drive_column, numbers

EVEN_STEPS = 0.02
"""Share by which time steps may differ."""


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """A record, begun at rest.

    Attributes:
        path: of the file.
        name: of the file, as the measurement has it.
        temperature: of the clamps, degC; None where the system's own hold.
        probes: the sensors.
        time: s, from 0, (n,).
        drive_unit: the excitation's column.
        drive: m/s2 of the base or N, (n,).
        measured: SI, (n, probes).
    """

    path: Path
    name: str
    temperature: float | None
    probes: tuple[ProbeTable, ...]
    time: Array
    drive_unit: Drive
    drive: Array
    measured: Array

    @property
    def step(self) -> float:
        """Time between samples, s."""
        return float(self.time[-1] / (self.time.size - 1))

    @cached_property
    def _smooth(self) -> CubicSpline:
        return CubicSpline(np.arange(self.time.size), self.drive)

    def finer_drive(self, every: int) -> Array:
        """Give the excitation at `every` times as many samples, smooth between those recorded."""
        return np.asarray(self._smooth(np.arange(every * (self.time.size - 1) + 1) / every), dtype=np.float64)

    def absolute(self, relative: Array, level: float = 1.0) -> Array:
        """Turn what probes do relative to the base, at so many times the stated drive, into what they measure, SI."""
        shaken = DRIVES[self.drive_unit].shakes == "base"
        moves = np.array([probe.absolute and probe.order == 2 for probe in self.probes])
        return relative + level * self.drive[:, None] * moves if shaken else relative


def read_motion_records(folder: Path, description: MeasurementDescription) -> tuple[MotionRecord, ...]:
    """Read the records of a measurement.

    Raises:
        UserError: one can't be read, its steps are uneven, or a column can't serve.
    """
    return tuple(_record(folder / entry.file, entry, description.probes) for entry in description.records)


def _record(path: Path, entry: RecordTable, probes: tuple[ProbeTable, ...]) -> MotionRecord:
    frame = csv_frame(path)
    kind = drive_column(frame, path)
    if kind == "displacement_mm":
        raise UserError(
            f"{path}: the base's displacement would have to be differentiated twice, which noise forbids; expected its "
            "acceleration_m_s2"
        )
    time = ascending_time(frame, path)
    steps = np.diff(time)
    if time.size < 16 or np.ptp(steps) > EVEN_STEPS * float(np.mean(steps)):
        raise UserError(f"{path}: time_s has {time.size} uneven steps; expected 16 even ones at least")
    for probe in probes:
        if probe.order < 2 and probe.absolute and DRIVES[kind].shakes == "base":
            raise UserError(
                f"{path}: probe {probe.name!r} measures against the ground, and where the base is isn't recorded; "
                'expected against = "base", or an acceleration'
            )
    values = np.column_stack([probe.scale * numbers(frame, probe.name, path) for probe in probes])
    drive = DRIVES[kind].scale * numbers(frame, kind, path)
    return MotionRecord(path, entry.file, entry.temperature_C, probes, time - time[0], kind, drive, values)
