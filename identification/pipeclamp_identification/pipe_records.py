"""Records of any motion of a pipe against the coupled model, integrated in time as one set of equations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeclamp.errors import UserError
from pipeclamp.pipe import ReducedPipe, reduce
from pipeclamp_identification.breakdown import Breakdown, Part, parts_json
from pipeclamp_identification.concentration import Factor, Region, densest, region_sentence
from pipeclamp_identification.frequency_response import steady_clamps
from pipeclamp_identification.measured_table import DRIVES, Drive, ascending_time, csv_frame, drive_column, numbers
from pipeclamp_identification.monolithic import clamp_equations, solve_monolithic
from pipeclamp_identification.pipe_measurement import MeasurementDescription, ProbeTable, read_description
from pipeclamp_identification.pipe_model import measured_pipe
from pipeclamp_identification.steady_clamp import SteadyClamp
from pipeclamp_identification.system import SystemDescription

Array = NDArray[np.float64]

ACCURACY = 1e-5
"""Relative tolerance of the integration: well below what sensors err by."""
PASSES, SAME = 4, 0.02
"""Runs in which a law's A and f are brought to those of the motion, until they change by less than this share."""
BANDS = 8
"""Bands of frequency, each as wide as the others on a logarithmic axis."""
LEAST = 5e-3
"""Share of the squared record that must lie beyond the lowest, and beyond the highest band."""
EVEN_STEPS = 0.02
"""Share by which time steps may differ."""


@dataclass(frozen=True, eq=False)
class RecordPair:
    """A record and what the model says of it.

    Attributes:
        name: of the file.
        time: s, (n,).
        measured, computed: SI, (n, probes).
        conditions: A (mm) and f (Hz) that each clamp's law was taken for.
    """

    name: str
    time: Array
    measured: Array
    computed: Array
    conditions: tuple[tuple[float, float], ...]

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
        step = (self.time[-1] - self.time[0]) / (self.time.size - 1)
        return np.fft.rfftfreq(self.time.size, step), squares[0], squares[1]


@dataclass(frozen=True, eq=False)
class RecordsComparison:
    """A coupled model held against records.

    Attributes:
        system, description: of the model, and of the measurement.
        pairs: the records.
    """

    system: SystemDescription
    description: MeasurementDescription
    pairs: tuple[RecordPair, ...]

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
            inside = (share > LEAST * share[-1]) & (share < (1 - LEAST) * share[-1]) & (frequency > 0)
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
            Part(label, one, None, even, len(self.pairs))
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


def has_records(path: Path) -> bool:
    """Tell whether a measurement holds records of any motion, not sines.

    Raises:
        UserError: its description is missing or can't serve.
    """
    return bool(read_description(path)[1].records)


def compare_records(system_path: Path, measured: Path) -> RecordsComparison:
    """Hold the coupled model of a system's file against records.

    Raises:
        UserError: a file can't serve, they don't belong together, or the model can't be integrated.
    """
    file, description = read_description(measured)
    pairs = []
    for entry in description.records:
        path = file.parent / entry.file
        time, kind, drive, values = read_record(path, description.probes)
        system, pipe, _ = measured_pipe(system_path, description, kind)
        reduced = reduce(pipe)
        clamps = steady_clamps(system, reduced, system_path.parent, entry.temperature_C, str(system_path))
        moved, conditions = _integrated(reduced, clamps, time, drive, path)
        base = drive if DRIVES[kind].shakes == "base" else np.zeros_like(drive)
        step = float(time[1] - time[0])
        columns = [_as_measured(moved[:, index], base, step, probe) for index, probe in enumerate(description.probes)]
        pairs.append(RecordPair(entry.file, time, values, np.column_stack(columns), conditions))
    if not any(pair.measured.any() for pair in pairs):
        raise UserError(f"{file}: the records hold nothing other than 0; expected what the probes measured")
    return RecordsComparison(system, description, tuple(pairs))


def read_record(path: Path, probes: tuple[ProbeTable, ...]) -> tuple[Array, Drive, Array, Array]:
    """Read a record: time (s, from 0), the excitation's kind, the excitation and the probes' values in SI.

    Raises:
        UserError: it can't be read, its steps are uneven, or a column can't serve.
    """
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
    return time - time[0], kind, DRIVES[kind].scale * numbers(frame, kind, path), values


def _integrated(
    pipe: ReducedPipe, clamps: list[tuple[int, SteadyClamp]], time: Array, drive: Array, path: Path
) -> tuple[Array, tuple[tuple[float, float], ...]]:
    """Give the probes' displacements, m, (n, probes), and the A and f of each law: given, or the motion's own."""
    for _, clamp in clamps:
        if clamp.further:
            names = ", ".join(clamp.further)
            raise UserError(f"{path}: a law follows {names}; records are compared for laws of A, f and T alone")
    held = replace(
        pipe,
        clamp_names=tuple(pipe.clamp_names[index] for index, _ in clamps),
        clamp_shapes=tuple(pipe.clamp_shapes[index] for index, _ in clamps),
    )
    excitation: Callable[[float], float] = lambda t: float(np.interp(t, time, drive))  # noqa: E731
    conditions = [(clamp.amplitude or math.sqrt(math.prod(clamp.range_A)), _given(clamp)) for _, clamp in clamps]
    for _ in range(PASSES):
        equations = [
            clamp_equations(clamp.law, *taken, clamp.temperature)
            for (_, clamp), taken in zip(clamps, conditions, strict=True)
        ]
        try:
            result = solve_monolithic(held, equations, excitation, time, ACCURACY)
        except ArithmeticError as error:
            raise UserError(f"{path}: {error}; check the excitation's unit, and the clamps' laws") from error
        found = [
            taken
            if clamp.amplitude is not None
            else _own(clamp, result.displacement[:, index], result.velocity[:, index])
            for index, ((_, clamp), taken) in enumerate(zip(clamps, conditions, strict=True))
        ]
        changes = [
            abs(a / b - 1) for new, old in zip(found, conditions, strict=True) for a, b in zip(new, old, strict=True)
        ]
        if max(changes, default=0.0) < SAME:
            break
        conditions = found
    return result.probes, tuple(conditions)


def _given(clamp: SteadyClamp) -> float:
    return clamp.frequency or math.sqrt(math.prod(clamp.range_f))


def _own(clamp: SteadyClamp, displacement: Array, velocity: Array) -> tuple[float, float]:
    """Give A (mm) and f (Hz) of a motion in m and m/s, inside the law's range."""
    variance = max(float(np.var(displacement)), 1e-30)
    amplitude, frequency = 1e3 * math.sqrt(2 * variance), math.sqrt(float(np.var(velocity)) / variance) / (2 * math.pi)
    return float(np.clip(amplitude, *clamp.range_A)), float(np.clip(frequency, *clamp.range_f))


def _as_measured(displacement: Array, base: Array, step: float, probe: ProbeTable) -> Array:
    """Turn a displacement relative to the base (m) into what a probe measures, SI."""
    for _ in range(probe.order):
        displacement = np.gradient(displacement, step, edge_order=2)
    return displacement + base if probe.order == 2 and probe.absolute else displacement


def records_words(comparison: RecordsComparison) -> list[str]:
    """Say how much the model errs on records, and where."""
    count, probes = len(comparison.pairs), comparison.scales.size
    words = [
        f"The coupled model errs by {comparison.nrmse:.2%} of the rms of what was measured, over {count} "
        f"record{'s' if count > 1 else ''} and {probes} probe{'s' if probes > 1 else ''}, started at rest.",
        region_sentence(comparison.region(), comparison.breakdowns()[0], "model"),
    ]
    for pair in comparison.pairs:
        taken = ", ".join(
            f"{clamp.at} {amplitude:.3g} mm and {frequency:.3g} Hz"
            for clamp, (amplitude, frequency) in zip(comparison.system.clamps, pair.conditions, strict=True)
        )
        if taken:
            words.append(f"{pair.name}: the laws' A and f are held over the record: {taken}.")
    words.append("Which parameter is wrong is asked of sines, not of records.")
    return words


def records_json(comparison: RecordsComparison) -> dict[str, Any]:
    """Give the answer for --json; scatter isn't known of records."""
    found = comparison.region()
    probes, bands, *_ = comparison.breakdowns()
    return {
        "nrmse": comparison.nrmse,
        "noise_nrmse": None,
        "probes": [{"probe": part.label, "nrmse": part.nrmse, "noise_nrmse": None} for part in probes.parts],
        "records": [
            {"file": pair.name, "nrmse": math.sqrt(float(error / measured)) if measured else None}
            for pair, error, measured in zip(
                comparison.pairs, *(squares.sum(axis=(1, 2)) for squares in comparison.squares), strict=True
            )
        ],
        "where": {
            "words": records_words(comparison)[1:2],
            "region": found and {"words": list(found.words), "share": found.share, "even_share": found.even},
            "probes": parts_json(probes),
            "conditions": {"frequency_Hz": parts_json(bands)},
        },
        "attribution": None,
    }
