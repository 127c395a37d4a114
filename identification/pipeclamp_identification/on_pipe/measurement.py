"""measurement.toml and its tables: what was measured at probes along a pipe, as frequency responses or over time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pipeclamp_identification.campaign.cycles import find_cycles
from pipeclamp_identification.campaign.records import Record, UnusableRecord, check_samples
from pipeclamp_identification.signals.harmonics import cycle_harmonics
from pipeclamp_models.base.arrays import Array, BoolArray, ComplexArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.tables import pl
from pipeclamp_models.base.toml_file import Celsius, NotNegative, ShortName, TomlTable, read_table
from pipeclamp_system.description.measured_table import DRIVES, Drive, ascending_time, csv_frame, drive_column, numbers

FILE_NAME = "measurement.toml"

Unit = Literal["mm", "um", "m", "mm/s", "m/s", "m/s2", "mm/s2", "g"]
MOTION_UNITS: dict[Unit, tuple[int, float]] = {
    "mm": (0, 1e-3),
    "um": (0, 1e-6),
    "m": (0, 1.0),
    "mm/s": (1, 1e-3),
    "m/s": (1, 1.0),
    "m/s2": (2, 1.0),
    "mm/s2": (2, 1e-3),
    "g": (2, 9.80665),
}
"""How often the displacement is differentiated by time, and the unit's size in SI."""

QUANTITIES = ("displacement", "velocity", "acceleration")

SWEEPS = {"up": 1, "down": -1, None: 0}


class ProbeTable(TomlTable):
    """A sensor: its column, where it sits, its unit, and what its motion is measured against.

    `position_m` may be left out for a probe that the pipe's description names. Displacements and velocities are
    relative to the base unless told, as a laser on the floor of the shaken frame has them; accelerations are absolute.
    """

    name: ShortName
    position_m: NotNegative | None = None
    unit: Unit
    against: Literal["base", "ground"] | None = None

    @property
    def order(self) -> int:
        """How often the displacement is differentiated by time."""
        return MOTION_UNITS[self.unit][0]

    @property
    def scale(self) -> float:
        """The unit's size in SI."""
        return MOTION_UNITS[self.unit][1]

    @property
    def absolute(self) -> bool:
        """Whether the motion is measured against the ground, not the base."""
        return self.against == "ground" if self.against else self.order == 2


class MeasuredResponseTable(TomlTable):
    """A frequency response, a row a sine; `ratio` says that the probes' columns are divided by the excitation."""

    file: str
    temperature_C: Celsius | None = None
    sweep: Literal["up", "down"] | None = None
    ratio: bool = False


class SineTable(TomlTable):
    """A record of a steady sine; what comes before `from_s` isn't settled yet."""

    file: str
    temperature_C: Celsius | None = None
    sweep: Literal["up", "down"] | None = None
    from_s: NotNegative = 0.0


class RecordTable(TomlTable):
    """A record of any motion, begun at rest: a sweep, a burst, random excitation."""

    file: str
    temperature_C: Celsius | None = None


class MeasurementDescription(TomlTable):
    """What was measured on a pipe: sines, records of any motion, or both; paths are relative to the file."""

    name: str = "measurement"
    notes: str = ""
    probes: Annotated[tuple[ProbeTable, ...], Field(min_length=1)]
    responses: tuple[MeasuredResponseTable, ...] = ()
    sines: tuple[SineTable, ...] = ()
    records: tuple[RecordTable, ...] = ()

    @property
    def has_sines(self) -> bool:
        """Whether sines were measured."""
        return bool(self.responses or self.sines)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [probe.name for probe in self.probes]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"probes: the name {name!r} is there twice; expected a name of its own for each")
        if not self.responses and not self.sines and not self.records:
            raise ValueError("nothing was measured; expected [[responses]], [[sines]] or [[records]], with their files")
        return self


@dataclass(frozen=True, eq=False)
class SteadyMeasurement:
    """Sines at which a pipe's response was measured, P of them, at probes.

    Attributes:
        frequency: Hz, (P,).
        drive: amplitude of the excitation, m/s2 of the base or N, (P,).
        level: the same in the unit that was measured in, (P,).
        drive_unit: that unit, as the excitation's column names it.
        temperature: of the clamps, degC, nan where the system's own hold, (P,).
        sweep: 1 up, -1 down, 0 where it isn't said, (P,).
        source: the file, (P,).
        response: fundamental at each probe over that of the excitation, SI, nan where it wasn't measured; without a
            phase it is the amplitude, (P, probes).
        phased: whether the phase was measured, (P, probes).
        scatter: standard deviation of real and of imaginary part, nan where it isn't known, (P, probes).
    """

    frequency: Array
    drive: Array
    level: Array
    drive_unit: Drive
    temperature: Array
    sweep: IntArray
    source: tuple[str, ...]
    response: ComplexArray
    phased: BoolArray
    scatter: Array

    @property
    def values(self) -> int:
        """How many values were measured; an amplitude and a phase are two."""
        there = np.isfinite(self.response)
        return int(np.count_nonzero(there) + np.count_nonzero(there & self.phased))


@dataclass(frozen=True, eq=False)
class PipeMeasurement:
    """What was measured on a pipe: its description, and all of its sines together."""

    description: MeasurementDescription
    steady: SteadyMeasurement


@dataclass(frozen=True, eq=False)
class _Rows:
    """The sines of one file."""

    frequency: Array
    level: Array
    drive_unit: Drive
    response: ComplexArray
    phased: BoolArray
    scatter: Array


def read_measurement_description(path: Path) -> tuple[Path, MeasurementDescription]:
    """Read the description of a measurement, a folder with measurement.toml or that file; give the file, too.

    Raises:
        UserError: it is missing or can't serve.
    """
    file = path / FILE_NAME if path.is_dir() else path
    return file, read_table(file, MeasurementDescription, "what was measured on the pipe")


def read_measurement(path: Path) -> PipeMeasurement:
    """Read the sines that were measured on a pipe: a folder with measurement.toml, or that file.

    Raises:
        UserError: a file is missing or can't serve; the message names file, row and column.
    """
    file, description = read_measurement_description(path)
    parts: list[tuple[MeasuredResponseTable | SineTable, _Rows]] = [
        *((entry, _response_rows(file.parent / entry.file, entry, description)) for entry in description.responses),
        *((entry, _sine_rows(file.parent / entry.file, entry, description)) for entry in description.sines),
    ]
    units = sorted({rows.drive_unit for _, rows in parts})
    if len(units) > 1:
        raise UserError(f"{file}: the excitation is given as {' and as '.join(units)}; expected one of them in all")
    frequency = np.concatenate([rows.frequency for _, rows in parts])
    level = np.concatenate([rows.level for _, rows in parts])
    unit = units[0]
    temperatures = [
        np.full(rows.level.size, np.nan if entry.temperature_C is None else entry.temperature_C)
        for entry, rows in parts
    ]
    response = np.concatenate([rows.response for _, rows in parts])
    scatter = np.concatenate([rows.scatter for _, rows in parts])
    drive = DRIVES[unit].scale * level
    if unit == "displacement_mm":
        # The base's acceleration is opposite to its displacement.
        squared = (2 * np.pi * frequency) ** 2
        drive, response, scatter = drive * squared, -response / squared[:, None], scatter / squared[:, None]
    phased = np.concatenate([rows.phased for _, rows in parts])
    return PipeMeasurement(
        description,
        SteadyMeasurement(
            frequency=frequency,
            drive=drive,
            level=level,
            drive_unit=unit,
            temperature=np.concatenate(temperatures),
            sweep=np.concatenate([np.full(rows.level.size, SWEEPS[entry.sweep]) for entry, rows in parts]),
            source=tuple(entry.file for entry, rows in parts for _ in rows.level),
            response=np.where(phased, response, np.abs(response)),
            phased=phased,
            scatter=scatter,
        ),
    )


def _response_rows(path: Path, entry: MeasuredResponseTable, description: MeasurementDescription) -> _Rows:
    """Read a frequency response: frequency_Hz, the excitation's amplitude, and one or two columns a probe."""
    frame = csv_frame(path)
    unit = drive_column(frame, path)
    frequency, level = numbers(frame, "frequency_Hz", path), numbers(frame, unit, path)
    for name, values in (("frequency_Hz", frequency), (unit, level)):
        bad = np.flatnonzero(~(values > 0))
        if bad.size:
            raise UserError(f"{path}, row {bad[0] + 2}, column {name!r}: got {values[bad[0]]:g}; expected more than 0")
    columns, phased = [], []
    for probe in description.probes:
        shown, has_phase = _probe_columns(frame, probe, path)
        columns.append(probe.scale * shown)
        phased.append(has_phase)
    drive = DRIVES[unit].scale * (np.ones(level.size) if entry.ratio else level)
    response = np.asarray(np.column_stack(columns) / drive[:, None], dtype=np.complex128)
    shape = response.shape
    return _Rows(frequency, level, unit, response, np.broadcast_to(phased, shape), np.full(shape, np.nan))


def _probe_columns(frame: pl.DataFrame, probe: ProbeTable, path: Path) -> tuple[ComplexArray, bool]:
    """Give a probe's values and whether their phase is known; blank cells are nan."""
    amplitude, phase = f"{probe.name}_amplitude", f"{probe.name}_phase_deg"
    real, imaginary = f"{probe.name}_real", f"{probe.name}_imag"
    present = set(frame.columns)
    if {real, imaginary} <= present:
        parts = [numbers(frame, name, path, blank=True) for name in (real, imaginary)]
        return np.asarray(parts[0] + 1j * parts[1], dtype=np.complex128), True
    if amplitude not in present:
        missing = f"{path}: no column for probe {probe.name!r}; it has {', '.join(frame.columns)}"
        raise UserError(f"{missing}; expected {amplitude} and {phase}, or {real} and {imaginary}, or {amplitude} alone")
    values = numbers(frame, amplitude, path, blank=True)
    if np.any(values < 0):
        row = int(np.flatnonzero(values < 0)[0])
        raise UserError(f"{path}, row {row + 2}, column {amplitude!r}: got {values[row]:g}; expected no less than 0")
    if phase not in present:
        return values.astype(np.complex128), False
    turned = np.exp(1j * np.radians(numbers(frame, phase, path, blank=True)))
    return np.asarray(values * turned, dtype=np.complex128), True


def _sine_rows(path: Path, entry: SineTable, description: MeasurementDescription) -> _Rows:
    """Read a record of a steady sine: time_s, the excitation and a column a probe, and give its fundamental.

    Each cycle gives the response once; what they scatter by is the scatter of their mean.
    """
    frame = csv_frame(path)
    unit = drive_column(frame, path)
    time = ascending_time(frame, path)
    chosen = time >= entry.from_s
    if np.count_nonzero(chosen) < 2:
        raise UserError(f"{path}: no sample lies after from_s = {entry.from_s:g} s; it ends at {time[-1]:g} s")
    columns = [numbers(frame, name, path)[chosen] for name in (unit, *(probe.name for probe in description.probes))]
    try:
        record = Record(time[chosen], columns[0], columns[0])
        check_samples(record)
        cycles = find_cycles(record)
    except UnusableRecord as error:
        raise UserError(f"{path}, column {unit!r}: {error}; expected a steady sine of some cycles") from error
    samples = [column[cycles.steady] for column in columns]
    lines = cycle_harmonics(cycles.phase(record), cycles.bounds - cycles.bounds[0], samples, 1)[:, :, 1]
    drive = np.abs(lines[0])
    scales = np.array([probe.scale for probe in description.probes])
    ratios = scales[:, None] * lines[1:] / (DRIVES[unit].scale * lines[0])
    response = ratios.mean(axis=1)[None]
    scatter = np.full(response.shape, np.nan)
    if cycles.count > 1:
        # Half of the squared deviation lies in the real part, half in the imaginary one.
        squares = np.sum(np.abs(ratios - response.T) ** 2, axis=1)
        scatter = np.sqrt(squares / (2 * (cycles.count - 1) * cycles.count))[None]
    level = np.array([float(np.mean(drive))])
    return _Rows(
        np.array([cycles.frequency_Hz]), level, unit, response, np.ones(response.shape, dtype=np.bool_), scatter
    )
