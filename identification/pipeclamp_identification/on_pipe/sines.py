"""Hold a coupled model against what was measured on the pipe: how much it errs, and where."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pipeclamp_identification.comparison.conditions import Condition
from pipeclamp_identification.comparison.densest_region import Factor, Region, condition_factors, densest, is_scatter
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.on_pipe.measurement import PipeMeasurement, read_measurement
from pipeclamp_identification.on_pipe.model import CoupledModel, read_model
from pipeclamp_identification.on_pipe.prediction import (
    SAME_LEVEL,
    Prediction,
    predict,
    temperatures,
    true_operation,
)
from pipeclamp_identification.signals.levels import name_levels, number_levels
from pipeclamp_models.base.arrays import Array, BoolArray, ComplexArray, IntArray
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.units import CELSIUS
from pipeclamp_system.description.measured_table import DRIVES
from pipeclamp_system.description.system import SystemDescription
from pipeclamp_system.steady.truncation import truncated_at

ERROR_KINDS = ("amplitude", "phase")
"""The two parts of an error: along the measured phasor, and across it."""
SAME_FREQUENCY = 1e-3
SAME_DRIVE = 0.02
SAME_TEMPERATURE = 1.0
"""Sines that differ by less (as a share, as a share, in K) are repeats of each other."""


@dataclass(frozen=True, eq=False)
class PipeComparison:
    """A coupled model held against a measurement of P sines at some probes.

    Attributes:
        system: as described.
        model: pipe and clamps.
        measurement: what was measured.
        prediction: what the model says.
    """

    system: SystemDescription
    model: CoupledModel
    measurement: PipeMeasurement
    prediction: Prediction

    @property
    def probes(self) -> tuple[str, ...]:
        """Names of the probes."""
        return tuple(probe.name for probe in self.measurement.description.probes)

    @property
    def compared(self) -> BoolArray:
        """Where there is both a measured and a computed value, (P, probes)."""
        return np.isfinite(self.measurement.steady.response) & np.isfinite(self.prediction.response)

    @property
    def phased(self) -> bool:
        """Whether any phase was measured: else nothing can be said of phases."""
        return bool(self.measurement.steady.phased.any())

    @cached_property
    def truncated(self) -> Array:
        """What the computed motions are off by because harmonics are left out, as a share of each; nan: none, (P,)."""
        found = np.full(self.measurement.steady.frequency.size, np.nan)
        for group in self.prediction.groups:
            system = self.model.system(group.temperature, lambda frequency: 1.0, group.harmonics)
            true = true_operation(self.model, self.measurement, group.rows)
            for place in np.flatnonzero(group.solved.found):
                drive, frequency = float(true.drive[place]), float(true.frequency[place])
                found[group.rows[place]] = truncated_at(system, group.solved.unknowns[place], frequency, drive)
        return found

    @cached_property
    def measured(self) -> ComplexArray:
        """What was measured, in SI; 0 where nothing is compared, (P, probes)."""
        steady = self.measurement.steady
        return np.where(self.compared, steady.response * steady.drive[:, None], 0.0)

    @cached_property
    def error(self) -> ComplexArray:
        """Measured less computed, turned so that its real part is that of the amplitude, SI, (P, probes)."""
        steady = self.measurement.steady
        return np.where(
            self.compared, turned_error(self.measurement, self.prediction.response) * steady.drive[:, None], 0.0
        )

    @cached_property
    def scales(self) -> Array:
        """Rms of what was measured of each probe's quantity, SI, by which errors of several add up, (probes,)."""
        orders = np.array([probe.order for probe in self.measurement.description.probes])
        found = np.ones(orders.size)
        for order in np.unique(orders):
            own = orders == order
            number = np.count_nonzero(self.compared[:, own])
            if number:
                found[own] = math.sqrt(float(np.sum(np.abs(self.measured[:, own]) ** 2)) / number)
        return found

    @cached_property
    def squared_error(self) -> Array:
        """Squared error by amplitude and phase, over the squared scales, (P, probes, 2)."""
        return np.asarray(np.stack([self.error.real**2, self.error.imag**2], axis=2) / self.scales[:, None] ** 2)

    @cached_property
    def squared_measured(self) -> Array:
        """What was measured, squared, over the squared scales, (P, probes)."""
        return np.asarray(np.abs(self.measured) ** 2 / self.scales**2)

    @cached_property
    def squared_scatter(self) -> Array:
        """What of the squared error no model can explain, likewise; nan where it isn't known, (P, probes)."""
        deviation = sine_scatter_of(self.measurement) * self.measurement.steady.drive[:, None] / self.scales
        return np.where(self.compared, np.where(self.measurement.steady.phased, 2, 1) * deviation**2, 0.0)

    @property
    def nrmse(self) -> float:
        """Rms of the difference over rms of what was measured."""
        return math.sqrt(float(np.sum(self.squared_error)) / float(np.sum(self.squared_measured)))

    @property
    def noise_nrmse(self) -> float | None:
        """The part of it that is scatter; None where it isn't known."""
        return self._whole("").noise_nrmse

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """The conditions of the sines that vary."""
        steady = self.measurement.steady
        own = {clamp.temperature_C for clamp in self.system.clamps}
        stated = steady.temperature
        if len(own) == 1:
            stated = np.where(np.isnan(stated), own.pop(), stated)
        names = {1: "up", -1: "down", 0: None}
        unit = DRIVES[steady.drive_unit].unit
        frequency = number_levels(steady.frequency, relative=1e-3)
        conditions = [
            Condition("frequency_Hz", "f", "Hz", frequency),
            Condition(steady.drive_unit, "excitation", unit, number_levels(steady.level, relative=SAME_LEVEL)),
            Condition("sweep", "sweep", "", name_levels([names[int(way)] for way in steady.sweep]), ordered=False),
        ]
        if np.isfinite(stated).any():
            conditions.insert(2, Condition("temperature_C", "T", "°C", number_levels(stated, absolute=3.0)))
        return tuple(condition for condition in conditions if condition.varies)

    def part(self, label: str, rows: IntArray | slice, columns: IntArray | slice = slice(None)) -> ErrorPart:
        """Give the part of the error that some sines have at some probes."""
        scatter = self.squared_scatter[rows][:, columns]
        number = self.squared_error[rows].shape[0]
        return ErrorPart(
            label,
            float(np.sum(self.squared_error[rows][:, columns])),
            float(np.nansum(scatter)) if np.isfinite(scatter).all() else None,
            float(np.sum(self.squared_measured[rows][:, columns])),
            number,
        )

    def _whole(self, label: str) -> ErrorPart:
        return self.part(label, slice(None))

    def by_condition(self, condition: Condition) -> Breakdown:
        """Break the error down by the levels of a condition."""
        return Breakdown(condition.title, tuple(self.part(level.label, level.rows) for level in condition.levels))

    def by_probe(self) -> Breakdown:
        """Break the error down by probe."""
        parts = [self.part(name, slice(None), np.array([index])) for index, name in enumerate(self.probes)]
        return Breakdown("probe", tuple(parts))

    def by_kind(self) -> Breakdown:
        """Break the error down into what is wrong in amplitude and what in phase, of the whole each."""
        whole = self._whole("")
        half = None if whole.squared_scatter is None else whole.squared_scatter / 2
        errors = self.squared_error.sum(axis=(0, 1)).tolist()
        parts = [
            ErrorPart(kind, error, half, whole.squared_force, whole.runs)
            for kind, error in zip(ERROR_KINDS, errors, strict=True)
        ]
        return Breakdown("amplitude and phase", tuple(parts))

    def region(self) -> Region | None:
        """Find the conditions, probes and kinds in which the error is densest."""
        if is_scatter(self.by_probe()):
            return None
        count, probes = self.squared_measured.shape
        scatter = np.where(np.isfinite(self.squared_scatter).all(), self.squared_scatter, 0.0)[:, :, None] / 2
        excess = (self.squared_error - scatter).reshape(count, 2 * probes)
        even = np.repeat(self.squared_measured, 2, axis=1)
        return densest(excess, even, [*self._factors(), *condition_factors(self.conditions, count, 2 * probes)])

    def _factors(self) -> Iterator[Factor]:
        count, probes = self.squared_measured.shape
        everywhere, parts = np.ones(count), np.arange(2 * probes)
        if probes > 1:
            for index, name in enumerate(self.probes):
                yield Factor("probe", f"at probe {name}", everywhere, (parts // 2 == index).astype(np.float64))
        for index, kind in enumerate(ERROR_KINDS if self.phased else ()):
            yield Factor("kind", f"in {kind}", everywhere, (parts % 2 == index).astype(np.float64))


def turned_error(measurement: PipeMeasurement, computed: ComplexArray) -> ComplexArray:
    """Give measured less computed response, its real part along the measured one; without phase, that of amplitudes."""
    steady = measurement.steady
    size = np.abs(steady.response)
    turn = np.conj(steady.response) / np.where(size > 0, size, 1.0)
    whole = (steady.response - computed) * np.where(size > 0, turn, 1.0)
    return np.asarray(np.where(steady.phased, whole, size - np.abs(computed)), dtype=np.complex128)


def sine_scatter_of(measurement: PipeMeasurement) -> Array:
    """Give the standard deviation of real and of imaginary parts, of repeated sines too; nan where unknown."""
    steady = measurement.steady
    found = steady.scatter.copy()
    columns = (
        _settings(np.log(steady.frequency), SAME_FREQUENCY),
        _settings(np.log(steady.drive), SAME_DRIVE),
        _settings(np.nan_to_num(steady.temperature, nan=-CELSIUS), SAME_TEMPERATURE),
        steady.sweep,
    )
    groups = np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1]
    squares, freedoms = np.zeros(steady.response.shape[1]), np.zeros(steady.response.shape[1])
    scale = np.abs(steady.response)
    for group in range(int(groups.max()) + 1):
        rows = np.flatnonzero(groups == group)
        if rows.size > 1:
            values = steady.response[rows] / np.nanmean(scale[rows], axis=0)
            each = np.where(steady.phased[rows], 2, 1)
            squares += np.nansum(np.abs(values - np.nanmean(values, axis=0)) ** 2 / each, axis=0)
            freedoms += np.maximum(np.count_nonzero(np.isfinite(values), axis=0) - 1, 0)
    known = freedoms > 0
    share = np.sqrt(squares / np.where(known, freedoms, 1.0))
    # Repeats show more than cycles do: what changes from test to test.
    found[:, known] = (share * scale)[:, known]
    return found


def _settings(values: Array, width: float) -> IntArray:
    """Number the settings that values are at: those of one lie within a width, from its lowest on."""
    numbers, number, begin = np.zeros(len(values), dtype=np.intp), 0, -math.inf
    for row in np.argsort(values, kind="stable").tolist():
        if values[row] > begin + width:
            number, begin = number + 1, float(values[row])
        numbers[row] = number
    return numbers


def compare_pipe(system: Path, measured: Path) -> PipeComparison:
    """Hold the coupled model of a system's file against a measurement.

    Raises:
        UserError: a file can't serve, they don't belong together, or no steady state is found anywhere.
    """
    measurement = read_measurement(measured)
    steady = measurement.steady
    levels = [temperature for temperature, _ in temperatures(steady)]
    described, model = read_model(system, measurement.description, {steady.drive_unit}, levels)
    highest = float(steady.frequency.max())
    if highest > model.pipe.modes.up_to_Hz:
        raise UserError(
            f"{system}: its pipe has modes.up_to_Hz = {model.pipe.modes.up_to_Hz:g}, but the measurement goes up to "
            f"{highest:g} Hz; expected more modes than that; raise it"
        )
    prediction = predict(model, measurement)
    comparison = PipeComparison(described, model, measurement, prediction)
    if not np.any(comparison.squared_measured > 0):
        raise UserError(
            f"{measured}: nothing can be compared: the measurement holds no value other than 0 where the model has a "
            "steady state; check the excitation's level and unit, and the clamps' laws"
        )
    return comparison
