"""Excitation over time: sine, sweep, record."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path

from pipeclamp_models.base.errors import UserError
from pipeclamp_system.description.measured_table import ascending_time, csv_frame, numbers
from pipeclamp_system.description.system import ExcitationTable

Signal = Callable[[float], float]

RECORD_COLUMNS = {"base": "acceleration_m_s2", "force": "force_N"}
"""What a record's column is named for each kind of excitation."""


def excitation_signal(table: ExcitationTable, kind: str, stop: float, folder: Path, where: str) -> Signal:
    """Give the excitation over time.

    Args:
        table: its description.
        kind: what the pipe takes: "base" (then in m/s2) or "force" (then in N).
        stop: end of the run, s; a sweep reaches its last frequency there.
        folder: what a record's path is relative to.
        where: the file that is named in errors.

    Raises:
        UserError: the excitation isn't of the pipe's kind, or the record can't serve.
    """
    if table.kind == "record":
        return _record(folder / str(table.file), RECORD_COLUMNS[kind], stop)
    require_kind(table, kind, where)
    amplitude = table.force_N or table.acceleration_m_s2 or 1e-3 * (table.displacement_mm or 0.0)
    first, last = (table.frequency_Hz, table.frequency_Hz) if table.kind == "sine" else (table.from_Hz, table.to_Hz)
    assert first is not None and last is not None, "the description holds this"
    return _sweep(amplitude, first, last, stop, displacement=table.displacement_mm is not None)


def require_kind(table: ExcitationTable, kind: str, where: str) -> None:
    """Require that a sine or a sweep is of what the pipe takes, "base" or "force"; `where` is named.

    Raises:
        UserError: it isn't.
    """
    if (table.force_N is not None) != (kind == "force"):
        expected = "force_N" if kind == "force" else "acceleration_m_s2 or displacement_mm"
        raise UserError(f"{where}: excitation: the pipe is excited by {kind}; expected {expected}")


def sine_amplitude(table: ExcitationTable, frequency: float) -> float:
    """Give the amplitude of a sine's or a sweep's acceleration (m/s2) or force (N) at a frequency in Hz."""
    if table.displacement_mm is not None:
        return 1e-3 * table.displacement_mm * (2 * pi * frequency) ** 2
    return table.force_N or table.acceleration_m_s2 or 0.0


def _sweep(amplitude: float, first: float, last: float, stop: float, displacement: bool) -> Signal:
    """Give a sine whose frequency runs from `first` to `last` Hz, or the acceleration of such a displacement."""
    rate = 2 * pi * (last - first) / stop

    def signal(t: float) -> float:
        omega = 2 * pi * first + rate * t
        phase = (2 * pi * first + rate * t / 2) * t
        if displacement:
            return amplitude * (rate * cos(phase) - omega * omega * sin(phase))
        return amplitude * sin(phase)

    return signal


def _record(path: Path, column: str, stop: float) -> Signal:
    """Give a recorded excitation, linear between its samples.

    Raises:
        UserError: the record can't be read, lacks a column, isn't finite, isn't ascending in time or ends too early.
    """
    frame = csv_frame(path)
    time: list[float] = ascending_time(frame, path).tolist()
    values: list[float] = numbers(frame, column, path).tolist()
    if time[0] > 0 or time[-1] < stop * (1 - 1e-9):
        raise UserError(
            f"{path}: time_s covers {time[0]:g} to {time[-1]:g} s; expected 0 to run.stop_s = {stop:g} s at least"
        )

    def signal(t: float) -> float:
        index = min(max(bisect_right(time, t), 1), len(time) - 1)
        share = (t - time[index - 1]) / (time[index] - time[index - 1])
        return values[index - 1] + share * (values[index] - values[index - 1])

    return signal
