"""Drive signals: what a test machine is made to do over time, and the file that carries it.

A file has two columns, `time_s` and `displacement_mm`, equal steps, one row a sample. It holds one run: the motion
grows from rest, keeps its full amplitude for whole cycles, and fades, so that a machine can run it as it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pipeclamp_identification.campaign.description import RecordColumn
from pipeclamp_identification.campaign.records import read_channels
from pipeclamp_identification.campaign.writing import encoded
from pipeclamp_models.base.arrays import Array
from pipeclamp_models.base.digits import plain
from pipeclamp_models.base.errors import UsageError, UserError
from pipeclamp_models.base.files import read_content, write_whole
from pipeclamp_models.base.tables import pl

DRIVE_COLUMNS: tuple[RecordColumn, ...] = ("time_s", "displacement_mm")
FORMATS = (".csv", ".parquet")
RAMP_CYCLES = 2
"""In which the motion grows to its full amplitude, and again in which it fades."""
FULL_CYCLES = 6
"""At full amplitude: one in which the clamp settles, and five to measure."""
SAMPLES_PER_TONE = 128
"""Samples in a cycle of the fastest tone: straight lines between them miss its peak by 0.03 %."""
TIMES_POINTS = 8
"""Times as many points, at which peaks of a motion are sought; every sample is one of them."""
REST_SHARE = 0.01
"""A drive begins at most this share of its largest displacement away from 0: clamps begin at rest."""
WEAKEST_TONE = 0.02
"""Lines of a drive's spectrum below this share of its strongest line are no tones."""


class Kinematics(NamedTuple):
    """Displacement mm, velocity mm/s and acceleration mm/s2, of one shape."""

    y: Array
    v: Array
    a: Array


def tones_motion(
    tones: tuple[tuple[int, float], ...], amplitude: Array, frequency: Array | float, angle: Array
) -> Kinematics:
    """Give the motion y = sum of share A cos(order angle), its velocity and its acceleration, shape (R, n).

    Args:
        tones: (order, share of the amplitude) each.
        amplitude: A in mm, shape (R, 1).
        frequency: of the fundamental in Hz, shape (R, 1) or one.
        angle: of the fundamental in rad, which grows by 2 pi f a second; shape (R, n) or (n,).
    """
    omega = 2 * np.pi * frequency
    y, v, a = np.zeros((3, *np.broadcast_shapes(amplitude.shape, angle.shape)))
    for order, share in tones:
        y += share * amplitude * np.cos(order * angle)
        v -= share * amplitude * order * omega * np.sin(order * angle)
        a -= share * amplitude * (order * omega) ** 2 * np.cos(order * angle)
    return Kinematics(y, v, a)


def ramped(motion: Kinematics, progress: Array, speed: Array | float) -> Kinematics:
    """Give a motion that grows from rest as half a cosine does.

    Args:
        motion: at full amplitude, shape (..., n).
        progress: of the ramp, from 0, at rest, to 1, at full amplitude; shape (n,).
        speed: of the progress where it is below 1, 1/s; shape (n,) or one.
    """
    y, v, a = motion
    share = (1 - np.cos(np.pi * progress)) / 2
    rate = np.pi / 2 * speed * np.sin(np.pi * progress)
    bend = np.where(progress < 1, (np.pi * speed) ** 2 / 2 * np.cos(np.pi * progress), 0.0)
    return Kinematics(share * y, share * v + rate * y, share * a + 2 * rate * v + bend * y)


@dataclass(frozen=True)
class Profile:
    """A shape of motion: tones on one fundamental.

    Attributes:
        words: what it is called.
        tones: (order, share of the amplitude) each, the fundamental, (1, 1.0), among them.
    """

    words: str
    tones: tuple[tuple[int, float], ...]

    @property
    def highest_order(self) -> int:
        """The highest frequency in the motion over that of the fundamental."""
        return max(order for order, _ in self.tones)

    @property
    def samples_per_cycle(self) -> int:
        """Samples of a drive signal in one cycle of the fundamental."""
        return SAMPLES_PER_TONE * self.highest_order

    @cached_property
    def peak_displacement(self) -> float:
        """The largest displacement of a whole drive over the amplitude of its fundamental."""
        return float(np.max(np.abs(self.unit_drive(TIMES_POINTS).y)))

    @cached_property
    def peak_velocity(self) -> float:
        """The largest velocity of a whole drive, its growing and fading included, over A f."""
        return float(np.max(np.abs(self.unit_drive(TIMES_POINTS).v)))

    def unit_drive(self, finer: int = 1) -> Kinematics:
        """Give the whole drive of 1 mm and 1 Hz, at so many times the samples of its signal, shape (n,)."""
        cycles = FULL_CYCLES + 2 * RAMP_CYCLES
        # begun where the displacement is 0
        time = np.arange(cycles * self.samples_per_cycle * finer + 1) / (self.samples_per_cycle * finer)
        y, v, a = tones_motion(self.tones, np.ones((1, 1)), 1.0, 2 * np.pi * time - np.pi / 2)
        progress = np.clip(np.minimum(time, cycles - time) / RAMP_CYCLES, 0.0, 1.0)
        return ramped(Kinematics(y[0], v[0], a[0]), progress, np.where(time < cycles / 2, 1.0, -1.0) / RAMP_CYCLES)


@dataclass(frozen=True)
class DrivePlan:
    """What a machine is asked to do in one run.

    Attributes:
        profile: the shape of the motion.
        amplitude_mm, frequency_Hz: of its fundamental.
    """

    profile: Profile
    amplitude_mm: float
    frequency_Hz: float

    @property
    def peak_displacement(self) -> float:
        """The largest displacement of the whole motion, mm."""
        return self.profile.peak_displacement * self.amplitude_mm

    @property
    def peak_velocity(self) -> float:
        """The largest velocity of the whole motion, mm/s."""
        return self.profile.peak_velocity * self.amplitude_mm * self.frequency_Hz

    @property
    def highest_frequency(self) -> float:
        """The highest frequency of its tones, Hz."""
        return self.profile.highest_order * self.frequency_Hz

    def signal(self) -> Drive:
        """Give the drive signal of one run."""
        y = self.amplitude_mm * self.profile.unit_drive().y
        time = np.arange(len(y)) / (self.profile.samples_per_cycle * self.frequency_Hz)
        # no digits that no machine resolves, no -0.0
        return Drive(np.round(time, 12), np.round(y, 9) + 0.0)

    def words(self) -> str:
        """Say what the machine does, and what that asks of it."""
        duration = (FULL_CYCLES + 2 * RAMP_CYCLES) / self.frequency_Hz
        return (
            f"{duration:.3g} s: {RAMP_CYCLES} cycles to grow, {FULL_CYCLES} at full amplitude, {RAMP_CYCLES} to fade; "
            f"at most {self.peak_displacement:.3g} mm, {self.highest_frequency:.3g} Hz, "
            f"{plain(self.peak_velocity, 3)} mm/s"
        )


@dataclass(frozen=True)
class Drive:
    """The displacement that a machine follows in one run.

    Attributes:
        time_s: equal steps from 0, shape (n,).
        displacement_mm: shape (n,).
    """

    time_s: Array
    displacement_mm: Array

    @property
    def duration_s(self) -> float:
        """How long the run takes."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def rate(self) -> float:
        """Samples per second."""
        return (len(self.time_s) - 1) / self.duration_s

    def highest_frequency(self) -> float:
        """Give the frequency in Hz of its highest tone."""
        level = np.abs(np.fft.rfft(self.displacement_mm))
        return float(np.flatnonzero(level > WEAKEST_TONE * np.max(level))[-1] / self.duration_s)


def refuse_drive_name(path: Path) -> None:
    """Refuse a file whose suffix says no format of drive signals.

    Raises:
        UsageError: it is neither .csv nor .parquet.
    """
    if path.suffix.lower() not in FORMATS:
        raise UsageError(f"--drive: got {path.name!r}; expected a name that ends in {' or '.join(FORMATS)}")


def write_drive(drive: Drive, path: Path) -> None:
    """Write a drive signal, whole or not at all.

    Raises:
        UsageError: the file's suffix says no format of drive signals.
        UserError: it can't be written there.
    """
    refuse_drive_name(path)
    write_whole(path, drive_content(drive, path))


def drive_content(drive: Drive, path: Path) -> bytes:
    """Give what the file of a drive signal holds: two columns with a header of one row, by the file's suffix.

    Raises:
        UsageError: the suffix says no format of drive signals.
    """
    refuse_drive_name(path)
    table = pl.DataFrame({name: getattr(drive, name) for name in DRIVE_COLUMNS})
    return encoded(table, "parquet" if path.suffix.lower() == ".parquet" else "csv")


def read_drive(path: Path) -> Drive:
    """Read a drive signal.

    Raises:
        UsageError: the suffix says no format of drive signals.
        UserError: it can't be read, holds no such columns, or is nothing that a clamp at rest can be driven by.
    """
    refuse_drive_name(path)
    content = read_content(path, "a drive signal, as `pipeclamp diagnose --drive` writes it")
    channels = read_channels(path, content, DRIVE_COLUMNS)
    time, y = channels["time_s"], channels["displacement_mm"]
    for name, values in channels.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise UserError(f"{path}, row {bad[0] + 2}, column {name!r}: no finite number; expected one in every row")
    if len(time) < SAMPLES_PER_TONE:
        raise UserError(f"{path}: {len(time)} samples; expected at least {SAMPLES_PER_TONE}")
    step = np.diff(time)
    uneven = np.flatnonzero(np.abs(step - np.median(step)) > 0.01 * np.median(step))
    if len(uneven) or step[0] <= 0:
        row = uneven[0] + 3 if len(uneven) else 3
        raise UserError(f"{path}, row {row}: a step of {step[row - 3]:g} s in time; expected equal steps above 0")
    largest = float(np.max(np.abs(y)))
    if largest == 0.0 or abs(y[0]) > REST_SHARE * largest:
        raise UserError(
            f"{path}, row 2: begins at {y[0]:g} mm of {largest:g} mm; expected a drive that begins at "
            "0 mm, as the clamp is at rest then"
        )
    return Drive(time - time[0], y)
