"""Records of any motion of a pipe against the coupled model, integrated in time as one set of equations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from pipeclamp_identification.comparison.densest_region import Factor, Region, densest, region_sentence
from pipeclamp_identification.comparison.error_parts import Breakdown, ErrorPart
from pipeclamp_identification.on_pipe.measurement import MeasurementDescription, read_measurement_description
from pipeclamp_identification.on_pipe.model import CoupledModel, read_model
from pipeclamp_identification.on_pipe.record_files import MotionRecord, read_motion_records
from pipeclamp_identification.on_pipe.record_motion import AmplitudesAndFrequencies, RecordPrediction, steps_between
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.said import counted
from pipeclamp_system.description.system import SystemDescription

BANDS = 8
"""Bands of frequency, each as wide as the others on a logarithmic axis."""
SHARE_BEYOND_BANDS = 5e-3
"""Share of the squared record that must lie beyond the lowest, and beyond the highest band."""


@dataclass(frozen=True, eq=False)
class RecordPair:
    """A record and what the model says of it.

    Attributes:
        record: what was measured.
        every: steps between two samples in which the model was integrated.
        prediction: what it says.
    """

    record: MotionRecord
    every: int
    prediction: RecordPrediction

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.record.name

    @property
    def time(self) -> Array:
        """Time, s, (n,)."""
        return self.record.time

    @property
    def measured(self) -> Array:
        """What was measured, SI, (n, probes)."""
        return self.record.measured

    @property
    def computed(self) -> Array:
        """What the model says, SI, (n, probes)."""
        return self.prediction.computed

    @property
    def conditions(self) -> AmplitudesAndFrequencies:
        """A (mm) and f (Hz) that each clamp's law was taken for."""
        return self.prediction.conditions

    @cached_property
    def spectra(self) -> tuple[Array, Array, Array]:
        """Frequency (Hz, (m,)) and the squares of measured values and of the error over it, which sum up as in time."""
        weight = np.full(self.time.size // 2 + 1, 2.0)
        weight[0] = 1.0
        if self.time.size % 2 == 0:
            weight[-1] = 1.0
        squares = [
            weight[:, None] * np.abs(np.fft.rfft(values, axis=0)) ** 2 / self.time.size
            for values in (self.measured, self.measured - self.computed)
        ]
        frequency = np.asarray(np.fft.rfftfreq(self.time.size, self.record.step), dtype=np.float64)
        return frequency, squares[0], squares[1]


@dataclass(frozen=True, eq=False)
class RecordsComparison:
    """A coupled model held against records.

    Attributes:
        system, description: of the model, and of the measurement.
        model: pipe and clamps.
        pairs: the records.
    """

    system: SystemDescription
    model: CoupledModel
    description: MeasurementDescription
    pairs: tuple[RecordPair, ...]

    def saying(self, predictions: Sequence[RecordPrediction]) -> RecordsComparison:
        """Give the comparison with what another model says."""
        pairs = [replace(pair, prediction=one) for pair, one in zip(self.pairs, predictions, strict=True)]
        return replace(self, pairs=tuple(pairs))

    @cached_property
    def scales(self) -> Array:
        """Rms of what was measured of each probe's quantity, SI, (probes,)."""
        orders = np.array([probe.order for probe in self.description.probes])
        squares = np.concatenate([pair.measured**2 for pair in self.pairs])
        return np.array([math.sqrt(float(np.mean(squares[:, orders == order]))) or 1.0 for order in orders])

    @cached_property
    def edges(self) -> Array:
        """Of the bands, Hz, (BANDS + 1,)."""
        low, high = math.inf, 0.0
        for pair in self.pairs:
            frequency, measured, _ = pair.spectra
            share = np.cumsum((measured / self.scales**2).sum(axis=1))
            inside = (
                (share > SHARE_BEYOND_BANDS * share[-1])
                & (share < (1 - SHARE_BEYOND_BANDS) * share[-1])
                & (frequency > 0)
            )
            if inside.any():
                low, high = min(low, float(frequency[inside][0])), max(high, float(frequency[inside][-1]))
        if not 0 < low < high:
            low, high = 1e-3, 1e3
        return np.asarray(np.geomspace(low, high, BANDS + 1))

    @cached_property
    def squares(self) -> tuple[Array, Array]:
        """Squares of error and of what was measured over the squared scales, (records, probes, BANDS) each.

        What lies beyond the bands' ends counts with the outermost.
        """
        shape = (len(self.pairs), self.scales.size, BANDS)
        error, measured = np.zeros(shape), np.zeros(shape)
        for row, pair in enumerate(self.pairs):
            frequency, *squares = pair.spectra
            band = np.clip(np.searchsorted(self.edges, frequency, side="right") - 1, 0, BANDS - 1)
            for found, values in zip((measured, error), squares, strict=True):
                for column in range(self.scales.size):
                    found[row, column] = np.bincount(band, values[:, column] / self.scales[column] ** 2, BANDS)
        return error, measured

    @property
    def nrmse(self) -> float:
        """Rms of the difference over rms of what was measured."""
        error, measured = self.squares
        return math.sqrt(float(error.sum() / measured.sum()))

    @property
    def band_words(self) -> list[str]:
        """The bands in words, Hz."""
        return [f"{low:.3g} to {high:.3g}" for low, high in zip(self.edges, self.edges[1:], strict=False)]

    def breakdowns(self) -> list[Breakdown]:
        """Break the error down by probe, by band of frequency, and by record where there are several."""
        probes = [probe.name for probe in self.description.probes]
        found = [self._broken("probe", probes, 1), self._broken("f / Hz", self.band_words, 2)]
        if len(self.pairs) > 1:
            found.append(self._broken("record", [pair.name for pair in self.pairs], 0))
        return found

    def _broken(self, by: str, labels: list[str], axis: int) -> Breakdown:
        others = tuple(other for other in range(3) if other != axis)
        error, measured = (squares.sum(axis=others).tolist() for squares in self.squares)
        parts = [
            ErrorPart(label, one, None, even, len(self.pairs))
            for label, one, even in zip(labels, error, measured, strict=True)
        ]
        return Breakdown(by, tuple(parts))

    def region(self) -> Region | None:
        """Find the records, probes and bands in which the error is densest."""
        error, measured = (squares.reshape(len(self.pairs), -1) for squares in self.squares)
        return densest(error, measured, list(self._factors())) if error.sum() > 0 else None

    def _factors(self) -> Iterator[Factor]:
        records, probes = len(self.pairs), self.scales.size
        everywhere, always = np.ones(records), np.ones(probes * BANDS)
        part = np.arange(probes * BANDS)
        if records > 1:
            for row, pair in enumerate(self.pairs):
                yield Factor("record", f"in record {pair.name}", (np.arange(records) == row).astype(np.float64), always)
        if probes > 1:
            for column, probe in enumerate(self.description.probes):
                inside = (part // BANDS == column).astype(np.float64)
                yield Factor("probe", f"at probe {probe.name}", everywhere, inside)
        for first in range(BANDS):
            for last in range(first, BANDS):
                if last - first + 1 < BANDS:
                    inside = ((part % BANDS >= first) & (part % BANDS <= last)).astype(np.float64)
                    words = f"from {self.edges[first]:.3g} to {self.edges[last + 1]:.3g} Hz"
                    yield Factor("band", words, everywhere, inside)


def compare_records(system_path: Path, measured: Path) -> RecordsComparison:
    """Hold the coupled model of a system's file against records.

    Raises:
        UserError: a file can't serve, they don't belong together, or the model can't be integrated.
    """
    file, description = read_measurement_description(measured)
    records = read_motion_records(file.parent, description)
    kinds = {record.drive_unit for record in records}
    system, model = read_model(system_path, description, kinds, {record.temperature for record in records})
    pairs = tuple(RecordPair(record, *steps_between(model, record)) for record in records)
    if not any(pair.measured.any() for pair in pairs):
        raise UserError(f"{file}: the records hold nothing other than 0; expected what the probes measured")
    return RecordsComparison(system, model, description, pairs)


def records_words(comparison: RecordsComparison) -> list[str]:
    """Say how much the model errs on records, and where."""
    count, probes = len(comparison.pairs), comparison.scales.size
    words = [
        f"The coupled model errs by {comparison.nrmse:.2%} of the rms of what was measured, over "
        f"{counted(count, 'record')} and {counted(probes, 'probe')}, started at rest.",
        region_sentence(comparison.region(), comparison.breakdowns()[0], "model"),
    ]
    for pair in comparison.pairs:
        taken = "; ".join(
            f"{clamp.at} at A = {amplitude:.3g} mm, f = {frequency:.3g} Hz"
            for clamp, (amplitude, frequency) in zip(comparison.system.clamps, pair.conditions, strict=True)
        )
        if taken:
            words.append(f"{pair.name}: the laws' A and f are held over the record: {taken}.")
    return words
