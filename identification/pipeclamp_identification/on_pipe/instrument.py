"""What a measuring chain makes of a motion: gain, phase and delay of sensors and excitation, and the time axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import hilbert

from pipeclamp_models.base.arrays import Array, ComplexArray


@dataclass(frozen=True)
class SensorChannel:
    """A sensor's channel: what is recorded is the truth times a gain, turned by a phase (rad), late by a delay (s)."""

    gain: float = 1.0
    phase: float = 0.0
    delay: float = 0.0

    def factor(self, frequency: Array) -> ComplexArray:
        """Give recorded over true phasors at frequencies, Hz, (P,)."""
        return np.asarray(self.gain * np.exp(1j * (self.phase - 2 * np.pi * frequency * self.delay)))

    def turned(self, values: Array, step: float) -> Array:
        """Give what is recorded of values over time, (n,), in steps of s; what lies beyond their ends is held."""
        if self.phase:
            analytic = hilbert(values, N=2 * values.size)[: values.size]
            values = np.real(analytic * np.exp(1j * self.phase))
        if self.delay:
            at = np.arange(values.size)
            values = np.interp(at - self.delay / step, at, values)
        return np.asarray(self.gain * values, dtype=np.float64)


@dataclass(frozen=True)
class Instrument:
    """How what was recorded stands to what happened; as it is, it records the truth.

    Attributes:
        sensors: the channel of each probe that isn't perfect, by its name.
        excitation: the excitation's channel.
        frequency: true frequencies over stated ones.
    """

    sensors: tuple[tuple[str, SensorChannel], ...] = field(default=())
    excitation: SensorChannel = SensorChannel()
    frequency: float = 1.0

    def sensor(self, name: str) -> SensorChannel:
        """Give the channel of a probe."""
        return dict(self.sensors).get(name, SensorChannel())

    def with_sensor(self, name: str, channel: SensorChannel) -> Instrument:
        """Give it with another channel of a probe."""
        return Instrument(tuple({**dict(self.sensors), name: channel}.items()), self.excitation, self.frequency)

    def true_drive(self, frequency_squared: bool) -> float:
        """Give the true amplitude of the base's acceleration or of the force over the stated one.

        Args:
            frequency_squared: whether the stated one was made from a displacement by its stated frequency.
        """
        return (self.frequency**2 if frequency_squared else 1.0) / self.excitation.gain

    def recorded(
        self, probes: Sequence[str], response: ComplexArray, frequency: Array, frequency_squared: bool
    ) -> ComplexArray:
        """Turn true responses over the excitation, (P, probes), into what is recorded over the recorded excitation.

        Args:
            probes: their names.
            response: motion over the excitation's acceleration or force.
            frequency: true ones, Hz, (P,).
            frequency_squared: as of `true_drive`.
        """
        excitation = np.exp(1j * np.angle(self.excitation.factor(frequency)))
        scale = self.true_drive(frequency_squared) / excitation
        factors = [self.sensor(name).factor(frequency) for name in probes]
        return np.asarray(response * scale[:, None] * np.column_stack(factors))

    def recorded_motion(self, probes: Sequence[str], values: Array, step: float) -> Array:
        """Turn true motion over time, (n, probes), into what is recorded beside the recorded excitation."""
        late = SensorChannel(1.0, -self.excitation.phase, -self.excitation.delay)
        columns = [
            self.sensor(name).turned(late.turned(column, step), step)
            for name, column in zip(probes, values.T, strict=True)
        ]
        return np.column_stack(columns)
